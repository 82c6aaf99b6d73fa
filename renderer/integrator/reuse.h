// Paths of neighbouring pixels share what they meet.
#pragma once

#include <span>

#include "integrator/path.h"

namespace integrator {

struct Reused {
  math::Vec3 own{0};     // what no other pixel has a part in
  math::Vec3 shared{0};  // the rest: from what all of the block's paths met, ...
  math::Vec3 alone{0};   // ... and as it would be from the pixel's own path alone
};

// What radiance() is for one pixel, for a block of them, paths[k] being of first[k] with the random numbers
// of samplers[k]. Returns how many of the rays were there to share. Nothing in the world may be blended;
// `parts` is empty or one for each.
std::uint64_t radiance(const World& world, std::span<const First> first, std::span<math::Sampler> samplers,
                       std::uint64_t& rays, std::span<Reused> paths, std::span<Parts> parts = {});

}  // namespace integrator
