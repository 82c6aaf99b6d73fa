// How two noisy pictures of one scene differ, told apart. The mean square of their difference is the sum of
//   noise: what the variances of both explain,
//   bias:  the square of the difference of the image means, which every pixel shares,
//   model: the rest, differences in places that cancel in the image's mean.
// All in linear radiance, averaged over pixels and channels; each an unbiased estimate, so model and bias may
// come out slightly negative.
#pragma once

#include <optional>
#include <vector>

#include "image/image.h"

namespace report {

// A mean picture and the variance of that mean, from so many replicates.
struct Estimate {
  image::Image mean, variance;
  int replicates = 0;
};

struct Parts {
  double scale = 0;  // mean absolute value of the reference: what percentages are of
  double total = 0, noise = 0, bias = 0, model = 0;  // mean squares
  double model_error = 0;                            // standard error of `model`, from the noise alone
};

// Nothing if shapes differ, no variance is known or pixels are not finite.
std::optional<Parts> parts(const Estimate& ours, const Estimate& theirs);

// Difference of the means of a tile, in the channel where it stands out most.
struct TileDifference {
  int x, y, width, height;
  double t;          // difference / standard error
  double relative;   // luminance difference, as a share of theirs
  double low, high;  // its 99 % interval
};

// 8 x 8 tiles, row by row; empty where parts() is nothing.
std::vector<TileDifference> tile_differences(const Estimate& ours, const Estimate& theirs);

}  // namespace report
