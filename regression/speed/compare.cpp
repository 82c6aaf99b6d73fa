#include "speed/compare.h"

#include <algorithm>
#include <vector>

namespace speed {
namespace {

using nlohmann::json;

// Nothing for what is not a number.
std::optional<double> number(const json& array, std::size_t round) {
  if (round >= array.size() || !array[round].is_number()) return std::nullopt;
  return array[round].get<double>();
}

std::vector<double> numbers(const json& array) {
  std::vector<double> all;
  for (const json& value : array)
    if (value.is_number()) all.push_back(value.get<double>());
  return all;
}

const json* level_at(const json& contestant, int spp) {
  for (const json& level : contestant.at("levels"))
    if (level.at("spp") == spp) return &level;
  return nullptr;
}

Curve curve_of_round(const json& contestant, const std::string& metric, std::size_t round) {
  Curve points;
  for (const json& level : contestant.at("levels")) {
    const auto seconds = number(level.at("seconds"), round), error = number(level.at(metric), round);
    if (seconds && error) points.push_back({*seconds, *error});
  }
  return points;
}

}  // namespace

std::optional<Spread> equal_error(const json& scene, const std::string& contestant,
                                  const std::string& opponent, const std::string& metric) {
  const json& ours = scene.at("contestants").at(contestant);
  const json& theirs = scene.at("contestants").at(opponent);
  const json* level = level_at(theirs, theirs.at("compared_at").get<int>());
  if (!level) return std::nullopt;
  std::vector<double> ratios;
  Spread spread;
  for (std::size_t round = 0; round < scene.at("rounds").get<std::size_t>(); ++round) {
    const auto seconds = number(level->at("seconds"), round), error = number(level->at(metric), round);
    if (!seconds || !error) continue;
    const auto equal = time_to(curve_of_round(ours, metric, round), *error);
    if (!equal) continue;
    ratios.push_back(*seconds / equal->seconds);
    spread.extrapolated |= equal->extrapolated;
  }
  if (ratios.empty()) return std::nullopt;
  spread.median = median(ratios);
  spread.low = *std::min_element(ratios.begin(), ratios.end());
  spread.high = *std::max_element(ratios.begin(), ratios.end());
  return spread;
}

Curve curve(const json& contestant, const std::string& metric) {
  Curve points;
  for (const json& level : contestant.at("levels")) {
    const auto seconds = numbers(level.at("seconds")), errors = numbers(level.at(metric));
    if (!seconds.empty() && !errors.empty()) points.push_back({median(seconds), median(errors)});
  }
  return points;
}

std::optional<PowerFit> fit(const json& contestant) {
  std::vector<Level> levels;
  double b2 = 0, smallest = 0;
  for (const json& level : contestant.at("levels")) {
    const std::vector<double> mse = numbers(level.at("mse"));
    if (mse.empty()) continue;
    double mean = 0;
    for (const double value : mse) mean += value / static_cast<double>(mse.size());
    levels.push_back({level.at("spp").get<double>(), mean});
    if (!level.contains("bias2")) continue;
    const double value = level["bias2"][0].get<double>(), error = level["bias2"][1].get<double>();
    if (smallest == 0 || error < smallest) smallest = error, b2 = value > normal_999 * error ? value : 0;
  }
  return fit_power(levels, b2);
}

double efficiency(const json& contestant, int spp) {
  const json* level = level_at(contestant, spp);
  std::vector<double> values;
  if (level)
    for (std::size_t round = 0; round < level->at("seconds").size(); ++round) {
      const auto seconds = number(level->at("seconds"), round), mse = number(level->at("mse"), round);
      if (seconds && mse && *seconds > 0 && *mse > 0) values.push_back(1 / (*seconds * *mse));
    }
  return values.empty() ? 0 : median(values);
}

}  // namespace speed
