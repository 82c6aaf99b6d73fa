// Everything that emits, as one list to draw from: point and spot lights, emissive triangles (two that make a
// rectangle are one emitter), directional lights, the environment. Sampling and densities stand side by side;
// both are seen from the same receiver, the offset origin of the shadow ray (a density computed from the true
// hit point loses light at grazing angles).
#pragma once

#include <cstdint>
#include <optional>

#include "light/environment.h"
#include "light/tree.h"
#include "math/spherical.h"
#include "surface/surface.h"

namespace light {

struct Sample {
  math::Vec3 wi;          // world, unit, from the receiver
  math::Vec3 target;      // end of the shadow ray: finite lights only
  bool infinite = false;  // directional or environment: the shadow ray has no end
  math::Vec3 radiance;    // is_delta: irradiance on a plane facing wi
  float pdf = 0;          // 1/sr; is_delta: probability of the choice
  bool is_delta = false;  // no BSDF sample can find this light
};

class Lights {
 public:
  // Keeps references. light_sampling_only: no BSDF samples find light, so all of it is drawn here.
  Lights(const scene::Scene& scene, const surface::Surfaces& surfaces, bool light_sampling_only = false);

  bool empty() const { return tree_.empty(); }
  // Draws a light and a point on it; nullopt if it sends nothing to the receiver. u_choice, u, v in [0,1).
  std::optional<Sample> sample(const Receiver& receiver, double u_choice, float u, float v) const;

  // Density with which sample() would have drawn this point of an emissive triangle; 0 if it is no light.
  float pdf(const Receiver& receiver, const surface::Point& point) const;
  bool has_environment() const { return environment_.has_value(); }
  math::Vec3 environment(const math::Vec3& direction) const {
    return environment_ ? environment_->radiance(direction) : math::Vec3(0);
  }
  // With the density of sample() drawing `wi`.
  Environment::Seen environment(const Receiver& receiver, const math::Vec3& wi) const;
  std::size_t emitters() const { return emitters_.size(); }  // triangles and rectangles

 private:
  struct Emitter {            // an emissive triangle, or two that make a rectangle
    math::Vec3 corner, x, y;  // a rectangle's are perpendicular
    math::Vec3 centre;        // of the rectangle, or of the triangle's largest side
    float near2;              // square of the distance within which it is sampled by solid angle
    double width, height;     // lengths of x and y
    math::DVec3 unit_x, unit_y;
    math::Vec3 normal;
    float area;
    int instance;
    int triangle, second;  // second: -1, a triangle alone
    // Which vertex of each triangle is where: corner, corner + x, corner + y; the far corner, corner + x, +
    // y.
    std::uint8_t vertex[3], vertex_second[3];
    bool two_sided;
    bool even = false;  // it emits `emission` everywhere: no texture, no holes
    math::Vec3 emission{0, 0, 0};
    math::Vec3 error{0, 0, 0};  // bound of the rounding of its points
  };
  std::vector<Emitter> find_emitters(int instance) const;
  static bool is_near(const Emitter& emitter, const math::Vec3& from);
  static math::SphericalRectangle rectangle(const Emitter& emitter, const math::Vec3& from);
  static math::SphericalTriangle triangle(const Emitter& emitter, const math::Vec3& from);
  math::Vec3 radiance(const Emitter& emitter, float a, float b) const;
  std::optional<Sample> sample_punctual(const scene::Light& light, const math::Vec3& from) const;
  std::optional<Sample> sample_emitter(const Emitter& emitter, const math::Vec3& from, float u,
                                       float v) const;

  const scene::Scene& scene_;
  const surface::Surfaces& surfaces_;
  std::vector<const scene::Light*> near_, directional_;
  std::vector<Emitter> emitters_;
  std::vector<std::vector<int>>
      emitter_of_;  // [instance][triangle] -> index into emitters_ or -1; empty if none emits
  std::optional<Environment> environment_;
  Tree tree_;  // near_, emitters_; directional_, environment
  bool samples_environment_ = false;
};

}  // namespace light
