// The environment: radiance from a latitude-longitude map, and directions drawn in proportion to it.
// Mapping: scene.h. The tables' cells are texels (or finer), weighted by their bilinear mean times solid
// angle: first a row is chosen, then a column in it. Within a cell directions are uniform in solid angle, so
// the density is finite at the poles.
#pragma once

#include "math/distribution.h"
#include "scene/scene.h"

namespace light {

class Environment {
 public:
  explicit Environment(const scene::Environment& environment);

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
  bool black() const { return rows_.empty(); }
  double mean_luminance() const { return mean_luminance_; }  // over the sphere

 private:
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
  double mean_luminance_ = 0;
};

}  // namespace light
