// The environment: radiance from a latitude-longitude map, and directions drawn in proportion to it.
// Mapping: scene.h. The table's cells are texels (or finer), weighted by their bilinear mean times solid
// angle; within a cell directions are uniform in solid angle, so the density is finite at the poles.
#pragma once

#include "math/distribution.h"
#include "scene/scene.h"

namespace light {

class Environment {
 public:
  explicit Environment(const scene::Environment& environment);

  math::Vec3 radiance(const math::Vec3& direction) const;  // direction: world, unit
  float pdf(const math::Vec3& direction) const;            // 1/sr, of sample()
  struct Sample {
    math::Vec3 direction;
    float pdf;
  };
  Sample sample(float u0, float u1) const;
  bool black() const { return table_.empty(); }
  double mean_luminance() const { return mean_luminance_; }  // over the sphere

 private:
  math::Vec3 bilinear(float x, float y) const;  // in texels
  math::Vec2 to_uv(const math::Vec3& direction) const;

  const scene::Bitmap& map_;
  float strength_;
  float sin_rotation_, cos_rotation_;
  int columns_, rows_;           // of the table
  std::vector<float> cos_edge_;  // rows_ + 1: cosine of the polar angle at the upper edge of each row
  math::Distribution1D table_;
  double mean_luminance_ = 0;
};

}  // namespace light
