// Measures how noisy a case is, and writes what follows from it into the case file: the limits of FLIP and
// RMSE, and if asked for the number of samples. A limit is `factor` (at most 3) times the largest difference
// between independent renders of the same case: what a change of noise alone may do.
#pragma once

#include <string>
#include <vector>

#include "image/image.h"
#include "suite/case_file.h"
#include "suite/renderer_command.h"

namespace app {

struct CalibrateOptions {
  suite::Layout layout;
  suite::RendererCommand renderer;
  std::vector<std::string> names;
  int seeds = 4;
  double factor = 2;
  bool set_spp = false, set_margins = false;
  double budget_s = 3;  // the longest a case may render with the samples chosen
  bool dry_run = false;
};

// What a case needs so that its margins can be shown, from one render's mean and variance.
struct SampleNeed {
  double image = 0, tile = 0,
         witness = 0;      // 99 % half-widths now, as shares of what the margins allow; 1 is just enough
  double tile_margin = 0;  // the smallest, in whole percent, that every tile's interval will be inside
  int spp = 0;             // a power of two times replicates that brings all to 1 or below
};
SampleNeed samples_needed(const suite::Case& c, const image::Render& picture);

// `factor` times the largest difference between any two of some independent renders.
suite::Case::Limits calibrated_limits(const std::vector<image::Image>& images, double factor);

// `x` rounded up to two significant digits.
double round_up(double x);

// Prints a line per case; returns the exit code.
int calibrate(const CalibrateOptions& options);

}  // namespace app
