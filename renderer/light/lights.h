// Everything that emits, as one list to draw from: punctual lights, emissive triangles, the environment.
// Sampling and densities stand side by side; both are seen from the same reference point, the offset origin
// of the shadow ray (a density computed from the true hit point loses light at grazing angles).
#pragma once

#include <cstdint>
#include <optional>

#include "light/environment.h"
#include "surface/surface.h"

namespace light {

struct Sample {
  math::Vec3 wi;          // world, unit, from the reference point
  math::Vec3 target;      // end of the shadow ray: finite lights only
  bool infinite = false;  // directional or environment: the shadow ray has no end
  math::Vec3 radiance;    // is_delta: irradiance on a plane facing wi
  float pdf = 0;          // 1/sr; is_delta: probability of the choice
  bool is_delta = false;  // no BSDF sample can find this light
};

class Lights {
 public:
  // Keeps references.
  Lights(const scene::Scene& scene, const surface::Surfaces& surfaces);

  bool empty() const { return count_ == 0; }
  // Draws a light and a point on it; nullopt if it sends nothing to `from`. `u_choice`, u, v in [0,1).
  std::optional<Sample> sample(const math::Vec3& from, float u_choice, float u, float v) const;

  // Density with which sample() at `from` would have drawn this point of an emissive triangle; 0 if it is no
  // light.
  float pdf(const math::Vec3& from, const surface::Point& point) const;
  // The same for the environment in direction `wi`.
  float pdf_environment(const math::Vec3& from, const math::Vec3& wi) const;
  math::Vec3 environment(const math::Vec3& direction) const {
    return environment_ ? environment_->radiance(direction) : math::Vec3(0);
  }
  bool has_environment() const { return environment_.has_value(); }
  std::size_t triangles() const { return emitters_.size(); }

 private:
  struct Emitter {  // one emissive triangle
    int instance, triangle;
    surface::Triangle shape;
    math::Vec3 centre;
    float radius;
    float flux;  // luminance times area
    bool two_sided;
  };
  float probability(const math::Vec3& from, int index) const;
  float importance(const math::Vec3& from, int index) const;
  std::optional<Sample> sample_punctual(const scene::Light& light, const math::Vec3& from) const;
  std::optional<Sample> sample_emitter(const Emitter& emitter, const math::Vec3& from, float u,
                                       float v) const;

  const scene::Scene& scene_;
  const surface::Surfaces& surfaces_;
  std::vector<Emitter> emitters_;
  std::vector<std::vector<int>>
      emitter_of_;  // [instance][triangle] -> index into emitters_ or -1; empty if none emits
  std::optional<Environment> environment_;
  int count_ = 0;  // punctual lights, then emitters, then the environment
  float scene_radius_ = 0;
  math::Distribution1D by_power_;  // many lights: chosen without looking at `from`
};

}  // namespace light
