// Paths of neighbouring pixels share what they meet at their second surfaces (Bekaert, Sbert and Halton 2002,
// "Accelerating Path Tracing by Re-Using Paths", Eurographics Workshop on Rendering).
//
// Pixel k's path goes from its first surface, x_k, to y_k. Any of the pixels' paths could have found a point
// y, pixel k's with density q_k(y) per area, so pixel i takes light from all of the y_j, each over the sum of
// the q_k(y_j) (balance heuristic, Veach 1997, eq. 9.8): a shadow ray from x_i to y_j and three BRDFs stand
// for a path. A pixel from which y_j is hidden has q = 0 there, which that shadow ray tells as well. At y_j
// the light sample and the direction the path went on in serve all: the direction's density is the mean of
// the pixels', weighted by q_k, in its estimate and in the weights against light samples. Noise of a block's
// pixels is then correlated; each pixel's mean is what it was.
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
