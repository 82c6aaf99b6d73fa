// What the measurements of a scene (measure.h) say: fits, efficiency and times to equal error.
#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "speed/fit.h"

namespace speed {

// Of the rounds: the middle, the smallest, the largest.
struct Spread {
  double median = 0, low = 0, high = 0;
  bool extrapolated = false;  // in any round
};

// Time `opponent` takes for its level `compared_at`, over the time `contestant` takes to the same error;
// above 1 the contestant is faster. `metric`: "mse" (the same for RMSE), "relative" or "flip". Each round by
// itself.
std::optional<Spread> equal_error(const nlohmann::json& scene, const std::string& contestant,
                                  const std::string& opponent, const std::string& metric);

// Medians over the rounds.
Curve curve(const nlohmann::json& contestant, const std::string& metric);

// a N^-p + b^2 of a contestant. b^2 from the level with the smallest standard error, and from there to 0 if
// not significant at 99.9 %.
std::optional<PowerFit> fit(const nlohmann::json& contestant);

// 1 / (MSE x seconds), median over the rounds, at this number of samples; 0 if not measured.
double efficiency(const nlohmann::json& contestant, int spp);

}  // namespace speed
