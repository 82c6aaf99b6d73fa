#include "integrator/adaptive.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <numeric>

#include "math/sampler.h"
#include "math/transcendental.h"

namespace integrator {

namespace {

// The error of n scrambled Sobol points falls about as n^-p, p = 1.5 for most pixels; the sum of v n^-p over
// pixels is least, for a given sum of n, where n goes as v^(1 / (1 + p)).
constexpr double p = 1.5;

// How many times less variance of what camera rays find is left than their number says: two dimensions are
// stratified better than those of paths. Measured from 1 to 16.
constexpr double stratified = 2;

// The same of light that arrives directly, which two paths from one camera ray find independently. Measured
// from 4 to 16.
constexpr double stratified_direct = 4;

// Sobol points, and so camera rays, come in groups of four that are well distributed by themselves.
constexpr int group = 4;

// Means over 5 x 5 pixels.
std::vector<double> smoothed(const std::vector<double>& v, int width, int height) {
  const auto mean = [](double a, double b, double c, double d, double e) {
    return a * (1. / 9) + b * (2. / 9) + c * (3. / 9) + d * (2. / 9) + e * (1. / 9);
  };
  std::vector<double> once(v.size()), twice(v.size());
  for (int y = 0; y < height; ++y) {
    const double* from = v.data() + static_cast<ptrdiff_t>(y) * width;
    double* to = once.data() + static_cast<ptrdiff_t>(y) * width;
    const auto at = [&](int x) { return from[std::clamp(x, 0, width - 1)]; };
    for (int x = 0; x < width; ++x)
      to[x] = x >= 2 && x + 2 < width ? mean(from[x - 2], from[x - 1], from[x], from[x + 1], from[x + 2])
                                      : mean(at(x - 2), at(x - 1), at(x), at(x + 1), at(x + 2));
  }
  for (int y = 0; y < height; ++y) {
    const auto row = [&](int j) {
      return once.data() + static_cast<ptrdiff_t>(std::clamp(j, 0, height - 1)) * width;
    };
    const double *a = row(y - 2), *b = row(y - 1), *c = row(y), *d = row(y + 1), *e = row(y + 2);
    double* to = twice.data() + static_cast<ptrdiff_t>(y) * width;
    for (int x = 0; x < width; ++x) to[x] = mean(a[x], b[x], c[x], d[x], e[x]);
  }
  return twice;
}

// A block's first row or column.
int corner(int x) { return x / block_side * block_side; }

// Means over 9 x 9.
std::vector<double> wide(const std::vector<double>& v, int width, int height) {
  return smoothed(smoothed(v, width, height), width, height);
}

}  // namespace

ReuseMap::ReuseMap(const Spread& spread, std::uint64_t rays)
    : width_(spread.pairs.width()),
      reuse_(static_cast<size_t>(width_) * static_cast<size_t>(spread.pairs.height())) {
  const int height = spread.pairs.height();
  double pairs = 0, of_reuse = 0;
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width_; ++x) {
      const auto n = static_cast<double>(spread.pairs.samples(x, y));
      pairs += n;
      of_reuse += n * static_cast<double>(spread.pairs.mean(x, y).z);
    }
  const double pair_rays = (static_cast<double>(rays) - of_reuse) / pairs;  // without those of reuse
  for (const int color : {0, 1}) {
    std::vector<double> with, without, rays_with, rays_without;
    for (int y = 0; y < height; ++y)
      for (int x = 0; x < width_; ++x) {
        const bool counts = checkerboard(x, y) == color;
        const glm::dvec3 reuse(spread.reuse.mean(x, y));
        with.push_back(counts ? reuse.x / stratified_direct + reuse.y : 0);
        without.push_back(counts ? reuse.x / stratified_direct + reuse.z : 0);
        rays_with.push_back(counts ? pair_rays + static_cast<double>(spread.pairs.mean(x, y).z) : 0);
        rays_without.push_back(counts ? pair_rays : 0);
      }
    for (std::vector<double>* v : {&with, &without, &rays_with, &rays_without}) *v = wide(*v, width_, height);
    // A block's pixels are as one.
    for (int y = 0; y < height; ++y)
      for (int x = 0; x < width_; ++x) {
        const size_t i = index(corner(x), corner(y));
        if (checkerboard(x, y) != color)
          reuse_[index(x, y)] = with[i] * rays_with[i] < without[i] * rays_without[i];
      }
  }
}

NoiseMap::NoiseMap(const image::Film& pilot, int color, int samples, std::span<const Early> early,
                   const Spread* spread, double path_rays)
    : width_(pilot.width()), height_(pilot.height()), replicates_(pilot.replicates()), pilot_(samples) {
  assert(early.empty() ? replicates_ > 1 : early.back().samples < samples);
  // Of a pixel: the variance of one sample, summed over the channels.
  const auto variance_of = [&](int x, int y) {
    if (early.empty()) {
      const glm::dvec3 of_mean(pilot.variance_of_mean(x, y));
      return (of_mean.x + of_mean.y + of_mean.z) * samples * replicates_;
    }
    const glm::dvec3 all(pilot.mean(x, y));
    glm::dvec3 squares(0), before(0);  // before: the sum of the groups so far
    int first = 0;
    const auto add_group = [&](const glm::dvec3& sum, int last) {
      const double n = last - first;
      const glm::dvec3 difference = (sum - before) / n - all;
      squares += n * difference * difference;
      before = sum, first = last;
    };
    for (const Early& e : early)
      add_group(glm::dvec3(e.film.mean(x, y)) * static_cast<double>(e.samples), e.samples);
    add_group(all * static_cast<double>(samples), samples);
    return (squares.x + squares.y + squares.z) / static_cast<double>(early.size());
  };
  // Few samples say little about one pixel: its variance is a weighted mean over 9 x 9, of one colour.
  std::vector<double> variance, weight;
  for (int y = 0; y < height_; ++y)
    for (int x = 0; x < width_; ++x) {
      const bool counts = checkerboard(x, y) == color;
      variance.push_back(counts ? variance_of(x, y) / 3 : 0);
      weight.push_back(counts);
      if (!counts) continue;
      const glm::dvec3 mean(pilot.mean(x, y));
      mean_ += (mean.x + mean.y + mean.z) / 3;
    }
  mean_ /= std::accumulate(weight.begin(), weight.end(), 0.);
  const auto wide = [&](const std::vector<double>& v) { return integrator::wide(v, width_, height_); };
  variance_ = wide(variance);
  weight = wide(weight);
  for (size_t i = 0; i < variance_.size(); ++i) variance_[i] = weight[i] > 0 ? variance_[i] / weight[i] : 0;

  together_.assign(variance_.size(), 1);
  // K paths that share a camera ray cost 1 + K path_rays rays, and their mean has the variance between +
  // within / K: cost times variance is least where K is the root of within / (between path_rays).
  if (spread) {
    std::vector<double> within, between;
    for (int y = 0; y < height_; ++y)
      for (int x = 0; x < width_; ++x) {
        const bool counts = checkerboard(x, y) == color;
        const glm::dvec3 mean(pilot.mean(x, y)), squares(spread->pairs.mean(x, y));
        within.push_back(counts ? squares.x : 0);
        between.push_back(counts ? (squares.y - dot(mean, mean) - squares.x / 2) / stratified : 0);
      }
    within = wide(within), between = wide(between);
    for (size_t i = 0; i < within.size(); ++i) {
      const double square = within[i] / (std::max(between[i], 1e-300) * path_rays);
      together_[i] = square >= 8 ? 4 : square >= 2 ? 2 : 1;  // the nearest power of two; 1 if 0 / 0
      // The pilot's variance is that of two together.
      const double more = weight[i] > 0 ? (together_[i] - 2) * std::max(between[i], 0.) / weight[i] / 3 : 0;
      variance_[i] = std::max(variance_[i] + more, variance_[i] / 2);
    }
  }
  for (const double v : variance_) need_.push_back(v > 0 ? math::exp(math::log(v) / (1 + p)) : 0);
  // A block's pixels are as one.
  for (int y = 0; y < height_; ++y)
    for (int x = 0; x < width_; ++x) {
      const size_t first = index(corner(x), corner(y));
      need_[index(x, y)] = need_[first];
      together_[index(x, y)] = together_[first];
    }
  if (const double most = *std::max_element(need_.begin(), need_.end()); most > 0)
    for (double& need : need_) need /= most;
}

int NoiseMap::group_of(size_t pixel) const { return group * together_[pixel]; }

int NoiseMap::count(int x, int y, double level) const {
  // The fraction left by rounding down is one more group for as many pixels, chosen by a hash.
  const size_t pixel = index(corner(x), corner(y));
  const int size = group_of(pixel);
  const double more = std::clamp(level * need_[pixel] - pilot_, 0., 1e9);
  return pilot_ +
         size * static_cast<int>(more / size + static_cast<double>(math::hash64(pixel) >> 11) * 0x1p-53);
}

double NoiseMap::mean_count(double level) const {
  const double pilot = pilot_;
  const auto count = [&](size_t i) { return std::max(pilot, level * need_[i]); };
  // Four sums: one would wait for itself.
  double sum[4] = {};
  size_t i = 0;
  for (; i + 4 <= need_.size(); i += 4)
    sum[0] += count(i), sum[1] += count(i + 1), sum[2] += count(i + 2), sum[3] += count(i + 3);
  for (; i < need_.size(); ++i) sum[0] += count(i);
  return (sum[0] + sum[1] + sum[2] + sum[3]) / static_cast<double>(need_.size());
}

double NoiseMap::level_of_mean(double samples) const {
  double low = 0, high = 1;
  if (*std::max_element(need_.begin(), need_.end()) <= 0) return 0;  // nothing to gain anywhere
  while (mean_count(high) < samples && high < 1e30) low = high, high *= 2;
  for (int step = 0; step < 60 && high - low > 1e-9 * high; ++step) {
    const double middle = (low + high) / 2;
    (mean_count(middle) < samples ? low : high) = middle;
  }
  return low;
}

double NoiseMap::mean_for_noise(double noise, double most) const {
  const auto found = [&](double samples) {
    const double level = level_of_mean(samples);
    double sum = 0;
    for (size_t i = 0; i < need_.size(); ++i) {
      // The mean of 1 / count(): counts are rounded, up or down by chance.
      const int size = group_of(i);
      const double groups = std::max(0., level * need_[i] - pilot_) / size, whole = std::floor(groups);
      const double least = pilot_ + size * whole, up = groups - whole;
      sum += variance_[i] * ((1 - up) / least + up / (least + size));
    }
    return std::sqrt(sum / static_cast<double>(need_.size()) / replicates_) / mean_;
  };
  double low = pilot_, high = most;
  if (!(mean_ > 0) || found(low) <= noise) return low;
  for (int step = 0; step < 40; ++step) {
    const double middle = std::sqrt(low * high);
    (found(middle) > noise ? low : high) = middle;
  }
  return high;
}

}  // namespace integrator
