#include "speed/compare.h"

#include <cmath>
#include <numeric>
#include <vector>

namespace speed {
namespace {

using nlohmann::json;

constexpr std::size_t nobody = static_cast<std::size_t>(-1);

std::vector<double> numbers(const json& array, std::size_t left_out = nobody) {
  std::vector<double> all;
  for (std::size_t i = 0; i < array.size(); ++i)
    if (i != left_out && array[i].is_number()) all.push_back(array[i].get<double>());
  return all;
}

std::optional<double> mean(const std::vector<double>& values) {
  if (values.empty()) return std::nullopt;
  return std::accumulate(values.begin(), values.end(), 0.) / static_cast<double>(values.size());
}

// Median time and mean error of the rounds.
std::optional<Point> point(const json& level, const std::string& metric, std::size_t left_out = nobody) {
  const std::vector<double> seconds = numbers(level.at("seconds"), left_out);
  const std::optional<double> error = mean(numbers(level.at(metric), left_out));
  if (seconds.empty() || !error) return std::nullopt;
  return Point{median(seconds), *error};
}

const json* level_at(const json& contestant, int spp) {
  for (const json& level : contestant.at("levels"))
    if (level.at("spp") == spp) return &level;
  return nullptr;
}

std::optional<Ratio> ratio(const json& ours, const json& theirs, const std::string& metric,
                           std::size_t left_out) {
  const json* level = level_at(theirs, theirs.at("compared_at").get<int>());
  const std::optional<Point> goal = level ? point(*level, metric, left_out) : std::nullopt;
  if (!goal) return std::nullopt;
  Curve curve;
  for (const json& one : ours.at("levels"))
    if (const auto p = point(one, metric, left_out)) curve.push_back(*p);
  const std::optional<Equal> equal = time_to(curve, goal->error);
  if (!equal) return std::nullopt;
  return Ratio{goal->seconds / equal->seconds, 0, equal->extrapolated};
}

}  // namespace

std::optional<Ratio> equal_error(const json& scene, const std::string& contestant,
                                 const std::string& opponent, const std::string& metric) {
  const json& ours = scene.at("contestants").at(contestant);
  const json& theirs = scene.at("contestants").at(opponent);
  std::optional<Ratio> all = ratio(ours, theirs, metric, nobody);
  if (!all) return std::nullopt;
  std::vector<double> without;
  for (std::size_t round = 0; round < scene.at("rounds").get<std::size_t>(); ++round)
    if (const auto one = ratio(ours, theirs, metric, round)) without.push_back(one->value);
  const double n = static_cast<double>(without.size()), middle = mean(without).value_or(0);
  for (const double value : without) all->error += (value - middle) * (value - middle) * (n - 1) / n;
  all->error = std::sqrt(all->error);
  return all;
}

std::optional<PowerFit> fit(const json& contestant) {
  std::vector<Level> levels;
  double b2 = 0, smallest = 0;
  for (const json& level : contestant.at("levels")) {
    const std::optional<double> mse = mean(numbers(level.at("mse")));
    if (!mse) continue;
    levels.push_back({level.at("spp").get<double>(), *mse});
    if (!level.contains("bias2")) continue;
    const double value = level["bias2"][0].get<double>(), error = level["bias2"][1].get<double>();
    if (smallest == 0 || error < smallest) smallest = error, b2 = value > normal_999 * error ? value : 0;
  }
  return fit_power(levels, b2);
}

double efficiency(const json& contestant, int spp) {
  const json* level = level_at(contestant, spp);
  const std::optional<Point> p = level ? point(*level, "mse") : std::nullopt;
  return p && p->seconds > 0 && p->error > 0 ? 1 / (p->seconds * p->error) : 0;
}

}  // namespace speed
