// Errors of renders, without bias. All renders of a scene have their own seeds, so that their noise is
// independent; C and D are two long renders of the same renderer with fixed samples, together its converged
// picture. A number is the mean over pixels and channels.
//
//   variance         mean |A - B|^2 / 2                          of one render; needs no reference
//   against          mean |A - (C + D)/2|^2 - mean |C - D|^2 / 4  noise of the reference taken out
//   bias_squared     mean (A - C)(B - D)                         b^2: no noise is in it, and it may be
//   negative
//
// A relative error divides each square by reference^2 + metric::relative_mse_epsilon first.
#pragma once

#include <vector>

#include "image/image.h"

namespace speed {

struct Estimate {
  double value = 0, standard_error = 0;
};

struct Errors {
  double mse = 0, relative_mse = 0;
};

struct Reference {
  image::Image c, d, mean;  // mean = (c + d) / 2
  Reference() = default;
  Reference(image::Image first, image::Image second);
};

// Images of one shape; anything else is a base::Error, and so is a pixel that is not finite.
Errors variance(const image::Image& a, const image::Image& b, const image::Image& reference);
Errors against(const image::Image& a, const Reference& reference);

// Over all pairs of different renders, symmetric in C and D; standard error from the pixels, which are
// independent.
Estimate bias_squared(const std::vector<const image::Image*>& renders, const Reference& reference);

// Mean over everything of `group` renders of equal expectation (two at least): its standard error from the
// renders' spread in each pixel.
Estimate image_mean(const std::vector<const image::Image*>& group);

}  // namespace speed
