// The path tracer: radiance along one camera ray.
#pragma once

#include "accel/accel.h"
#include "bsdf/disney.h"
#include "integrator/render.h"
#include "light/lights.h"
#include "math/sampler.h"
#include "surface/surface.h"

namespace integrator {

// What a path needs to know; everything outlives it.
struct World {
  const accel::Accel& accel;
  const surface::Surfaces& surfaces;
  const light::Lights& lights;
  bsdf::Model model;
  bsdf::Gtr gtr;
  int depth;                 // scattering events
  bool hide_environment;     // from camera rays
  bool light_sampling_only;  // path-nomis: no multiple importance sampling
};

// Radiance along `ray`. `rays` is increased by the rays traced.
math::Vec3 radiance(const World& world, accel::Ray ray, const math::Sampler& sampler, std::uint64_t& rays);

// The simple shaders: eyelight, normal (-1..1), albedo, texcoord (u, v, 0), position; black where nothing is
// hit.
math::Vec3 shade(const World& world, Shader shader, const accel::Ray& ray, const math::Sampler& sampler,
                 std::uint64_t& rays);

}  // namespace integrator
