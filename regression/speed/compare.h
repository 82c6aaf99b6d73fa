// What the measurements of a scene (measure.h) say: fits, efficiency and times to equal error.
#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "speed/fit.h"

namespace speed {

// A ratio, and its standard error by the jackknife over the rounds.
struct Ratio {
  double value = 0, error = 0;
  bool extrapolated = false;
};

// Time `opponent` takes for its level `compared_at`, over the time `contestant` takes to the same error;
// above 1 the contestant is faster. `metric`: "mse" (the same for RMSE), "relative" or "flip". Errors are
// means over the rounds, which alone have no bias where a few fireflies are most of it; times are medians.
std::optional<Ratio> equal_error(const nlohmann::json& scene, const std::string& contestant,
                                 const std::string& opponent, const std::string& metric);

// a N^-p + b^2 of a contestant. b^2 from the level with the smallest standard error, and from there to 0 if
// not significant at 99.9 %.
std::optional<PowerFit> fit(const nlohmann::json& contestant);

// 1 / (MSE x seconds), mean error and median time of the rounds, at this number of samples; 0 if not
// measured.
double efficiency(const nlohmann::json& contestant, int spp);

}  // namespace speed
