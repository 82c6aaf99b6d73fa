// The path tracer: radiance along one camera ray.
#pragma once

#include <array>
#include <optional>
#include <vector>

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
  bool blended;                   // whether some surface lets rays pass by chance
  std::vector<bsdf::Bsdf> plain;  // of the scene's materials, where nothing varies them
  int depth;                      // scattering events
  bool hide_environment;          // from camera rays
  bool light_sampling_only;       // path-nomis: no multiple importance sampling
};

// What a camera ray found: where any number of paths may begin.
struct First {
  accel::Ray ray;
  bool found;
  surface::Point point;  // if found
  math::Vec3 light{0};   // seen directly: what the surface emits, or the environment
  // Random numbers for the first direction, of one point with the camera ray's: not if several paths begin
  // here.
  std::optional<math::Vec2> direction;
};
// Sets `first`, but for its direction. `rays` is increased by the ray traced.
void find_first(const World& world, const accel::Ray& ray, const math::Sampler& sampler, std::uint64_t& rays,
                First& first);

// Radiance along a camera ray, taken apart by what the first surface did with the light: emission (of that
// surface, or of the environment behind it all), then for each lobe of bsdf::eval_lobes what it reflects of
// direct light and of light that was reflected before. The parts sum to the radiance.
inline constexpr int part_count = 1 + 2 * bsdf::eval_lobe_count;
using Parts = std::array<math::Vec3, part_count>;

// Radiance by one path from `first`, with the random numbers of `sampler`, but those of group 0, which are
// the camera ray's and first.direction. `rays` is increased by the rays traced; `parts`, if asked for, is
// set.
math::Vec3 radiance(const World& world, const First& first, math::Sampler& sampler, std::uint64_t& rays,
                    Parts* parts = nullptr);

// The simple shaders: eyelight, normal (-1..1), albedo, texcoord (u, v, 0), position; black where nothing is
// hit.
math::Vec3 shade(const World& world, Shader shader, const accel::Ray& ray, const math::Sampler& sampler,
                 std::uint64_t& rays);

}  // namespace integrator
