// The environment: radiance from a latitude-longitude map, and directions drawn in proportion to what it has
// above its mean. BSDF samples find an even sky well; what they miss is left to light samples (Karlik et al.
// 2019, "MIS Compensation", sec. 4: of an environment; under sky and sun x.36 the variance). Mapping:
// scene.h. The tables' cells are texels (or finer), weighted by their bilinear mean less that of the map,
// times solid angle: first a row is chosen, then a column in it. Within a cell directions are uniform in
// solid angle, so the density is finite at the poles.
#pragma once

#include "math/distribution.h"
#include "scene/scene.h"

namespace light {

class Environment {
 public:
  // light_sampling_only: no BSDF sample joins in, so directions are drawn in proportion to all of it.
  Environment(const scene::Environment& environment, bool light_sampling_only);

  // Directions are in world space and unit.
  struct Seen {
    math::Vec3 radiance;
    float pdf;  // 1/sr, of sample()
  };
  math::Vec3 radiance(const math::Vec3& direction) const;
  Seen look(const math::Vec3& direction) const;
  struct Sample {
    math::Vec3 direction;
    Seen seen;
  };
  Sample sample(float u0, float u1) const;
  bool sampled() const { return !rows_.empty(); }  // false: black or even; then sample() must not be called
  double drawn_luminance() const { return drawn_luminance_; }  // what is drawn, its mean over the sphere

 private:
  const math::Vec4& texel(int column, int row) const;
  void fetch(const math::Vec2& uv) const;
  math::Vec3 bilinear(float x, float y) const;  // in texels, [0,width] x [0,height]
  math::Vec3 radiance_at(const math::Vec2& uv) const;
  math::Vec2 to_uv(const math::Vec3& direction) const;
  float cell_pdf(std::uint32_t row, std::uint32_t column) const;

  const scene::Bitmap& map_;
  float strength_;
  float sin_rotation_, cos_rotation_;
  std::vector<float> cos_edge_;  // size of rows_ + 1: cosine of the polar angle at the upper edge of each row
  math::Distribution1D rows_;
  std::vector<math::Distribution1D> columns_;  // of each row
  double drawn_luminance_ = 0;
};

}  // namespace light
