#include "app/compare.h"

#include <algorithm>
#include <cmath>
#include <iostream>
#include <nlohmann/json.hpp>

#include "app/results.h"
#include "base/error.h"
#include "image/hash.h"
#include "image/io.h"
#include "metric/flip.h"
#include "metric/rmse.h"
#include "metric/statistics.h"
#include "suite/judge.h"

namespace app {
namespace {

using Json = nlohmann::ordered_json;

Json number(double x) { return std::isfinite(x) ? Json(x) : Json(nullptr); }

// Bias with its interval, if both pictures carry their uncertainty.
Json bias(const image::Render& reference, const image::Render& test) {
  if (!reference.variance || !test.variance) return nullptr;
  const int reference_replicates = image::header_int(reference.header, "assay:replicates").value_or(0);
  const int test_replicates = image::header_int(test.header, "assay:replicates").value_or(0);
  if (reference_replicates < 2 || test_replicates < 2) return nullptr;
  const metric::Comparison c =
      metric::compare_welch({reference.mean, *reference.variance, reference_replicates},
                            {test.mean, *test.variance, test_replicates});
  if (!c.ok()) return {{"failure", c.failure}};
  Json channels = Json::object();
  static const char* const names[] = {"red", "green", "blue", "luminance"};
  for (int q = 0; q < metric::quantity_count; ++q) {
    const metric::Difference& d = c.image[q];
    channels[names[q]] = {{"relative", number(d.relative())},
                          {"low", number(d.interval.low)},
                          {"high", number(d.interval.high)},
                          {"p", number(d.p)},
                          {"significant", d.significant}};
  }
  const auto tiles =
      std::count_if(c.tiles.begin(), c.tiles.end(), [](const auto& t) { return t.significant(); });
  return {{"biased", c.biased()},    {"equivalent", c.equivalent()}, {"image", channels},
          {"tiles", c.tiles.size()}, {"tiles_significant", tiles},   {"smallest_p", number(c.smallest_p)}};
}

}  // namespace

int compare(const CompareOptions& options) {
  const image::Render reference = image::read_render(options.reference),
                      test = image::read_render(options.test);
  if (!reference.mean.same_shape(test.mean))
    base::fail_in(options.test, "size",
                  std::to_string(reference.mean.width) + " x " + std::to_string(reference.mean.height) +
                      " as " + options.reference,
                  std::to_string(test.mean.width) + " x " + std::to_string(test.mean.height));
  const bool ldr = options.ldr || (!options.hdr && (reference.display_referred || test.display_referred));
  metric::FlipOptions flip_options;
  if (options.pixels_per_degree > 0) flip_options.pixels_per_degree = options.pixels_per_degree;
  const metric::Flip flip =
      ldr ? metric::ldr_flip(reference.mean, test.mean, metric::Values::linear, flip_options)
          : metric::hdr_flip(reference.mean, test.mean, flip_options);
  const metric::Rmse rmse = metric::rmse(reference.mean, test.mean);
  const bool identical = image::pixel_hash(reference.mean) == image::pixel_hash(test.mean);
  const std::size_t bad = flip.non_finite_reference + flip.non_finite_test;

  bool same = bad == 0;
  if (!options.max_flip && !options.max_rmse) same = same && identical;
  // A metric that could not be computed is inside no limit, unless there is nothing to measure.
  if (options.max_flip) same = same && (identical || (flip.ok() && flip.mean <= *options.max_flip));
  if (options.max_rmse) same = same && rmse.rmse <= *options.max_rmse;

  if (!options.flip_map.empty()) write_map(options.flip_map, flip.map);

  Json out = {{"reference", options.reference},
              {"test", options.test},
              {"identical", identical},
              {"same", same},
              {"non_finite_pixels", bad},
              {"flip",
               {{"kind", ldr ? "ldr" : "hdr"},
                {"pixels_per_degree", flip_options.pixels_per_degree},
                {"failure", flip.failure},
                {"mean", number(flip.mean)},
                {"min", number(flip.min)},
                {"max", number(flip.max)},
                {"weighted_quartile1", number(flip.weighted_quartile1)},
                {"weighted_median", number(flip.weighted_median)},
                {"weighted_quartile3", number(flip.weighted_quartile3)}}},
              {"rmse", number(rmse.rmse)},
              {"relative_mse", number(rmse.relative_mse)},
              {"max_difference", number(rmse.max_difference)},
              {"bias", bad ? Json(nullptr) : bias(reference, test)}};
  if (!ldr && flip.ok())
    out["flip"]["exposures"] = {flip.exposures.start, flip.exposures.stop, flip.exposures.count};
  if (options.max_flip) out["flip"]["limit"] = *options.max_flip;
  if (options.max_rmse) out["rmse_limit"] = *options.max_rmse;

  if (options.json) {
    std::cout << out.dump(1) << "\n";
    return same ? 0 : 1;
  }
  const auto limit = [](const std::optional<double>& l) {
    return l ? " (limit " + std::to_string(*l) + ")" : "";
  };
  if (bad)
    std::cout << (identical ? "identical bits, but no pictures to compare" : "different") << ": "
              << flip.non_finite_reference << " pixels of the reference and " << flip.non_finite_test
              << " of the test are not finite\n";
  else
    std::cout << (identical ? "identical pixels" : same ? "inside the limits" : "different") << "\n";
  if (flip.ok())
    std::cout << (ldr ? "LDR" : "HDR") << "-FLIP mean " << flip.mean << limit(options.max_flip)
              << ", weighted median " << flip.weighted_median << ", max " << flip.max << "\n";
  else if (!bad)
    std::cout << "FLIP: " << flip.failure << "\n";
  if (bad) return 1;
  std::cout << "RMSE " << rmse.rmse << limit(options.max_rmse) << ", relMSE " << rmse.relative_mse
            << ", largest difference " << rmse.max_difference << "\n";
  const Json& b = out["bias"];
  if (b.is_object() && b.contains("image")) {
    for (const auto& [channel, d] : b["image"].items())
      std::cout << "bias " << channel << " " << suite::percent(d["relative"]) << " ["
                << suite::percent(d["low"]) << ", " << suite::percent(d["high"]) << "]"
                << (d["significant"] == true ? " significant" : "") << "\n";
    std::cout << b["tiles_significant"] << " of " << b["tiles"] << " tiles significant\n";
  }
  return same ? 0 : 1;
}

}  // namespace app
