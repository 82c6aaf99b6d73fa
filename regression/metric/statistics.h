// Is the difference of two noisy renders more than noise, and if not, could we have seen it?
//
// A render carries, per pixel, its mean and the variance of that mean, estimated from R replicates (R - 1
// degrees of freedom). Pixels are scrambled independently, so the variance of an image's or tile's mean is
// the sum of its pixels' variances over n^2, with Satterthwaite's degrees of freedom (sum V)^2 / sum(V^2 /
// ) (Welch 1947; Jung et al. 2020, "Detecting Bias in Monte Carlo Renderers using Welch's t-test", JCGT
// 9(2)). Estimated from the variances' own estimates, that number comes out (R-1)/(R+1) too small in equal
// noise, and smaller where few pixels carry the noise: on the careful side.
//
// All tests of one comparison (R, G, B and luminance, of the image and of every tile) share one false-alarm
// budget by Sidak's rule. Every p-value is held up by a bound that no distribution of the noise can break
// (statistics_levels.h): Welch's by exchange_p, the paired test's by symmetric_p.
#pragma once

#include <string>
#include <vector>

#include "image/image.h"
#include "metric/statistics_levels.h"

namespace metric {

// One side of a comparison. `variance` is of the mean, same shape as `mean`: three channels. `samples` per
// pixel (0: unknown) matter where one side has more of them, see compare_welch().
struct Noisy {
  const image::Image& mean;
  const image::Image& variance;
  int replicates;
  double samples = 0;
};

enum Quantity { red, green, blue, luminance, quantity_count };

// Test minus reference, of one quantity over one region.
struct Difference {
  double reference = 0, test = 0;  // means over the region
  double difference = 0;           // test - reference
  double standard_error = 0;
  double degrees_of_freedom = 0;  // infinite if nothing varies
  double t = 0, p = 1;            // two-sided; p is held up by what few pixels or replicates can show at most
  double scale = 0;               // what a relative difference is relative to (see Comparison)
  double relative() const;        // difference / scale; 0 if both are 0
  Interval interval;              // confidence interval of difference / scale, at options.confidence
  double detectable = 0;          // smallest |bias| / scale found 99 times in 100
  bool significant = false;       // p below the Sidak level, and above rounding
  bool within_margin = false;     // interval inside [-margin, margin]
};

struct Tile {
  int x = 0, y = 0, width = 0, height = 0;  // pixels; tiles at the right and lower edge may be smaller
  Difference difference[quantity_count];
  bool significant() const;
  bool within_margin() const;
  double t() const;  // the largest |t| with its sign: the significance map
};

struct WelchOptions {
  double false_alarm = case_false_alarm();  // for this whole comparison
  double confidence = 0.99;                 // of each interval
  double image_margin = 0.005, tile_margin = 0.05;
  int tile = 8;
  // Differences smaller than this, relative to the scale, are rounding and never significant.
  double rounding = 1e-5;
  // A tile darker than this share of the image's mean is held to that share: margins of black tiles mean
  // nothing. No p-value depends on it.
  double tile_scale_floor = 0.25;
};

// Scales: the image's differences are relative to the mean over pixels and channels of the reference, for all
// channels; a tile's to the same mean over the tile, but at least tile_scale_floor times the image's.
// The variance of luminance is bounded by that of fully correlated channels, (sum w_c sigma_c)^2.
struct Comparison {
  std::string failure;  // empty if the numbers mean something; else the data are broken (non-finite, one
                        // replicate...)
  Difference image[quantity_count];
  std::vector<Tile> tiles;  // row by row
  int tile_columns = 0, tile_rows = 0;
  double level = 0;       // of a single test
  double smallest_p = 1;  // over all tests, corrected by Sidak: the p-value of the comparison as a whole
  bool ok() const { return failure.empty(); }
  bool biased() const;      // ok, and any test significant
  bool equivalent() const;  // ok, not biased, and every interval inside its margin, image and tiles
};

// Both sides noisy and independent (different seeds). Shapes that differ are a base::Error.
//
// If one side has more samples (the second look has four times the golden's), the other is taken to be at
// least as noisy as those samples say: a golden that by luck saw none of a caustic's rare bright paths would
// call itself quiet, and the better picture wrong.
Comparison compare_welch(const Noisy& reference, const Noisy& test, const WelchOptions& options = {});

// Means over tiles of an image, one pixel per tile: what a golden keeps of each replicate.
image::Image tile_means(const image::Image& image, int tile = 8);

// Same seed on both sides, so the noise largely cancels: the differences of per-replicate tile means are the
// data, R - 1 degrees of freedom a tile; eight numbers can agree by chance (whole tiles see one sample more
// or less of an edge), so the pixels' differences, absolute or relative, must agree in sign as well
// (symmetric_p).
struct Paired {
  const image::Image& mean;
  const std::vector<image::Image>& tiles;  // tile_means() of each replicate
};
Comparison compare_paired(const Paired& reference, const Paired& test, const WelchOptions& options = {});

// Did the noise change? Ratio of variances test / reference, from the logarithms of the ratios of blocks of
// half a tile, each as likely above 0 as below if nothing changed: no assumption of a normal distribution,
// which fireflies break (symmetric_p). Blocks without noise on either side, or only with that of rounding (a
// millionth of the mean), are left out; fewer than 8 claim nothing.
struct NoiseRatio {
  double ratio = 1;   // geometric mean over blocks
  double pooled = 1;  // ratio of the summed variances
  Interval interval;  // of ratio, at options.confidence
  double p = 1;       // two-sided, of ratio = 1
  int blocks = 0;
};
NoiseRatio noise_ratio(const Noisy& reference, const Noisy& test, const WelchOptions& options = {});

// The cross-renderer rules: |difference of means| + 3.5 standard errors <= margin (relative to the scale),
// and FLIP at most 1.25 times that between two independent renders of the witness, plus 0.005.
bool agrees(const Difference& difference, double margin);
bool flip_agrees(double flip, double noise_floor);

}  // namespace metric
