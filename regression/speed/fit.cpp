#include "speed/fit.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <utility>

namespace speed {
namespace {

struct Line {
  double slope = 0, at_zero = 0, residual = 0;
};

std::optional<Line> least_squares(const std::vector<std::pair<double, double>>& points) {
  double x = 0, y = 0, xx = 0, xy = 0;
  const double n = static_cast<double>(points.size());
  for (const auto& [px, py] : points) x += px / n, y += py / n;
  for (const auto& [px, py] : points) xx += (px - x) * (px - x), xy += (px - x) * (py - y);
  if (points.size() < 2 || xx <= 0) return std::nullopt;
  Line line{xy / xx, y - xy / xx * x, 0};
  for (const auto& [px, py] : points) {
    const double off = py - line.at_zero - line.slope * px;
    line.residual += off * off / n;
  }
  line.residual = std::sqrt(line.residual);
  return line;
}

// The falling curve that is nearest in least squares: pool adjacent violators. Sorted by time.
void make_falling(std::vector<std::pair<double, double>>& points) {
  struct Block {
    double mean;
    std::size_t count;
  };
  std::vector<Block> blocks;
  for (const auto& [time, error] : points) {
    blocks.push_back({error, 1});
    while (blocks.size() > 1 && blocks.back().mean > blocks[blocks.size() - 2].mean) {
      const Block last = blocks.back();
      blocks.pop_back();
      Block& b = blocks.back();
      const double count = static_cast<double>(b.count), more = static_cast<double>(last.count);
      b = {(count * b.mean + more * last.mean) / (count + more), b.count + last.count};
    }
  }
  std::size_t i = 0;
  for (const Block& block : blocks)
    for (std::size_t k = 0; k < block.count; ++k) points[i++].second = block.mean;
}

}  // namespace

std::optional<Equal> time_to(Curve curve, double error) {
  std::vector<std::pair<double, double>> points;  // logarithms
  for (const Point& point : curve)
    if (point.seconds > 0 && point.error > 0)
      points.emplace_back(std::log(point.seconds), std::log(point.error));
  std::sort(points.begin(), points.end());
  if (points.size() < 2 || !(error > 0)) return std::nullopt;
  make_falling(points);
  const double wanted = std::log(error);

  // Inside: the first crossing.
  for (std::size_t i = 1; i < points.size(); ++i) {
    const auto& [t0, e0] = points[i - 1];
    const auto& [t1, e1] = points[i];
    if (e0 >= wanted && wanted >= e1 && e0 > e1)
      return Equal{std::exp(t0 + (t1 - t0) * (e0 - wanted) / (e0 - e1)), false};
  }

  // Outside: from the nearest end along the slope of all points.
  const std::optional<Line> line = least_squares(points);
  if (!line || line->slope >= 0) return std::nullopt;
  const auto& [t, e] = wanted > points.front().second ? points.front() : points.back();
  const double step = (wanted - e) / line->slope;
  if (std::abs(step) > std::log(reach)) return std::nullopt;
  return Equal{std::exp(t + step), true};
}

std::optional<PowerFit> fit_power(const std::vector<Level>& levels, double b2) {
  std::vector<std::pair<double, double>> points;
  for (const Level& level : levels)
    if (level.samples > 0 && level.mse > b2)
      points.emplace_back(std::log(level.samples), std::log(level.mse - b2));
  const std::optional<Line> line = least_squares(points);
  if (!line) return std::nullopt;
  return PowerFit{std::exp(line->at_zero), -line->slope, b2, line->residual};
}

double median(std::vector<double> values) {
  assert(!values.empty());
  std::sort(values.begin(), values.end());
  const std::size_t n = values.size();
  return n % 2 ? values[n / 2] : .5 * (values[n / 2 - 1] + values[n / 2]);
}

}  // namespace speed
