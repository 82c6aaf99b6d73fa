// Plain pixel differences over all samples (pixels times channels), summed in double precision. A NaN or
// infinity on either side makes the result non-finite, so that no limit holds. Images of different shape are
// a base::Error.
#pragma once

#include "image/image.h"

namespace metric {

struct Rmse {
  double rmse = 0;          // sqrt(mean((test - reference)^2))
  double relative_mse = 0;  // mean((test - reference)^2 / (reference^2 + epsilon))
  double max_difference = 0;
  std::size_t non_finite = 0;  // samples that are NaN or infinite on either side
};

inline constexpr double relative_mse_epsilon = 1e-2;

Rmse rmse(const image::Image& reference, const image::Image& test, double epsilon = relative_mse_epsilon);

}  // namespace metric
