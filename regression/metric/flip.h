// FLIP, the perceived difference when two pictures are flipped in place: 0 the same, 1 as different as can
// be. LDR-FLIP after Andersson et al. 2020, "FLIP: A Difference Evaluator for Alternating Images"; HDR-FLIP
// after Andersson et al. 2021, "Visualizing Errors in Rendered High Dynamic Range Images". Our own code,
// tested against NVIDIA's FLIP 1.6 (flip-vectors/). Differences on purpose, all where the original reports a
// perfect match for pictures it could not compare:
//   - a NaN or infinity fails: `failure` says so, the pooled numbers are NaN, so that no limit holds, the map
//   is 1 there;
//   - negative values count as 0 before tone mapping, and are counted;
//   - pixels of luminance 0 do not take part in the median that ends the automatic exposures; a reference
//   without any
//     light fails unless exposures are given;
//   - one exposure is allowed: it is `start`; pooling is in double precision.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "image/image.h"

namespace metric {

// 0.7 m from a screen 0.7 m and 3840 pixels wide, as the original program rounds it.
inline constexpr double default_pixels_per_degree = 67.0206451;

enum class ToneMapper { aces, hable, reinhard };

// From 2^start to 2^stop in `count` even steps of the exponent; with count 1 only 2^start.
struct Exposures {
  double start = 0, stop = 0;
  int count = 2;
};

struct FlipOptions {
  double pixels_per_degree = default_pixels_per_degree;
  ToneMapper tone_mapper = ToneMapper::aces;  // HDR only
  std::optional<Exposures> exposures;         // HDR only; from the reference's luminance if absent
};

struct Flip {
  std::string failure;  // empty if the numbers mean something
  image::Image map;     // one channel, error in [0,1]
  double mean = 0;
  double min = 0, max = 0;
  double weighted_quartile1 = 0, weighted_median = 0,
         weighted_quartile3 = 0;                              // of the error mass, not of the pixels
  std::size_t non_finite_reference = 0, non_finite_test = 0;  // pixels
  std::size_t negative_reference = 0, negative_test = 0;      // pixels, taken as 0
  Exposures exposures;                                        // HDR only: those used
  std::vector<unsigned char> exposure_map;  // HDR only: which exposure gave the maximum (the first, if
                                            // several); 255 where the error is 0 at all of them
  bool ok() const { return failure.empty(); }
};

// What the numbers given to ldr_flip are: display values as stored in a PNG, or linear light. Both are cut to
// [0,1].
enum class Values { srgb, linear };

// Three-channel images of one size; anything else is a base::Error. Bit-identical for any number of threads.
Flip ldr_flip(const image::Image& reference, const image::Image& test, Values values,
              const FlipOptions& options = {});

// Linear light of any range.
Flip hdr_flip(const image::Image& reference, const image::Image& test, const FlipOptions& options = {});

// The exposures HDR-FLIP chooses for a reference (to be stored with a golden); nothing if it holds no light.
std::optional<Exposures> automatic_exposures(const image::Image& reference,
                                             ToneMapper tone_mapper = ToneMapper::aces);

// The tone mapper of HDR-FLIP applied at 2^exposure and cut to [0,1]: linear light for ldr_flip or a PNG.
image::Image tone_map(const image::Image& linear, ToneMapper tone_mapper, double exposure);

}  // namespace metric
