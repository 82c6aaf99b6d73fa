#include "report/parts.h"

#include <algorithm>
#include <cmath>

namespace report {
namespace {

constexpr int tile_side = 8;
constexpr double normal_99 = 2.5758293035489004;  // a tile's variance has hundreds of degrees of freedom
constexpr double luminance[3] = {.2126, .7152, .0722};

bool finite(const image::Image& image) {
  return std::all_of(image.data.begin(), image.data.end(), [](float v) { return std::isfinite(v); });
}

double variance_at(const Estimate& e, std::size_t i) { return e.variance.empty() ? 0 : e.variance.data[i]; }

bool comparable(const Estimate& a, const Estimate& b) {
  if (a.mean.empty() || a.mean.channels != 3 || !a.mean.same_shape(b.mean)) return false;
  for (const Estimate* e : {&a, &b})
    if (!finite(e->mean) || !finite(e->variance) ||
        (!e->variance.empty() && !e->variance.same_shape(e->mean)))
      return false;
  return !a.variance.empty() || !b.variance.empty();
}

double square(double x) { return x * x; }

}  // namespace

std::optional<Parts> parts(const Estimate& ours, const Estimate& theirs) {
  if (!comparable(ours, theirs)) return std::nullopt;
  const std::size_t n = ours.mean.pixels();
  const double count = 3. * static_cast<double>(n), pixels = static_cast<double>(n);
  Parts out;
  double sum[3] = {}, variance[3] = {}, error = 0, shape = 0;
  for (std::size_t i = 0; i < 3 * n; ++i) {
    const double d = static_cast<double>(ours.mean.data[i]) - theirs.mean.data[i];
    const double a = variance_at(ours, i), b = variance_at(theirs, i), v = a + b;
    sum[i % 3] += d, variance[i % 3] += v;
    out.total += d * d, out.scale += std::fabs(theirs.mean.data[i]);
    // Var(d^2) = 4 m^2 v + 2 v^2 for a true difference m, and m^2 is d^2 - v on average. The variances are
    // estimates themselves.
    shape += 4 * v * (d * d - v), error += 2 * v * v;
    if (ours.replicates > 1) error += 2 * a * a / (ours.replicates - 1);
    if (theirs.replicates > 1) error += 2 * b * b / (theirs.replicates - 1);
  }
  for (int c = 0; c < 3; ++c) {
    out.noise += variance[c] / count;
    out.bias += (square(sum[c] / pixels) - variance[c] / square(pixels)) / 3;
  }
  out.total /= count, out.scale /= count;
  out.model = out.total - out.noise - out.bias;
  out.model_error = std::sqrt(error + std::max(0., shape)) / count;
  return out;
}

std::vector<TileDifference> tile_differences(const Estimate& ours, const Estimate& theirs) {
  std::vector<TileDifference> out;
  if (!comparable(ours, theirs)) return out;
  const int width = ours.mean.width, height = ours.mean.height;
  for (int y0 = 0; y0 < height; y0 += tile_side)
    for (int x0 = 0; x0 < width; x0 += tile_side) {
      TileDifference tile{x0, y0, std::min(tile_side, width - x0), std::min(tile_side, height - y0), 0, 0,
                          0,  0};
      double d[3] = {}, v[3] = {}, reference = 0, luminance_variance = 0;
      for (int y = y0; y < y0 + tile.height; ++y)
        for (int x = x0; x < x0 + tile.width; ++x) {
          double sigma = 0;  // the channels share their samples, so that their deviations add
          for (int c = 0; c < 3; ++c) {
            const std::size_t i = ours.mean.index(x, y, c);
            const double variance = variance_at(ours, i) + variance_at(theirs, i);
            d[c] += static_cast<double>(ours.mean.data[i]) - theirs.mean.data[i];
            v[c] += variance, sigma += luminance[c] * std::sqrt(variance);
            reference += luminance[c] * theirs.mean.data[i];
          }
          luminance_variance += square(sigma);
        }
      double difference = 0;
      const double error = std::sqrt(luminance_variance);
      for (int c = 0; c < 3; ++c) {
        difference += luminance[c] * d[c];
        const double t = v[c] > 0 ? d[c] / std::sqrt(v[c]) : 0;
        if (std::fabs(t) > std::fabs(tile.t)) tile.t = t;
      }
      if (reference > 0) {
        tile.relative = difference / reference;
        tile.low = (difference - normal_99 * error) / reference;
        tile.high = (difference + normal_99 * error) / reference;
      }
      out.push_back(tile);
    }
  return out;
}

}  // namespace report
