// For the tests of the statistics: synthetic renders whose truth is known, the same with every standard
// library.
#pragma once

#include <cmath>
#include <cstdint>
#include <functional>
#include <numbers>
#include <vector>

#include "metric/statistics.h"

namespace synthetic {

using image::Image;
using metric::Noisy;

// SplitMix64 and Box-Muller: the same numbers with every standard library.
class Random {
 public:
  explicit Random(std::uint64_t seed) : state_(seed) {}
  double uniform() {
    std::uint64_t z = (state_ += 0x9e3779b97f4a7c15u);
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    return (static_cast<double>((z ^ (z >> 31)) >> 11) + 0.5) * 0x1p-53;
  }
  double normal() {
    const double radius = std::sqrt(-2 * std::log(uniform())), angle = 2 * std::numbers::pi * uniform();
    return radius * std::cos(angle);
  }

 private:
  std::uint64_t state_;
};

// A synthetic render: `sample` gives one replicate's value of a pixel and channel.
struct Synthetic {
  Image mean, variance;
  std::vector<Image> replicates;
  Noisy noisy() const { return {mean, variance, static_cast<int>(replicates.size())}; }
};

inline Synthetic synthesise(int width, int height, int replicates,
                            const std::function<float(int x, int y, int c)>& sample) {
  Synthetic s{Image(width, height, 3), Image(width, height, 3),
              std::vector<Image>(replicates, Image(width, height, 3))};
  for (Image& replicate : s.replicates)
    for (int y = 0; y < height; ++y)
      for (int x = 0; x < width; ++x)
        for (int c = 0; c < 3; ++c) replicate.at(x, y, c) = sample(x, y, c);
  for (std::size_t i = 0; i < s.mean.data.size(); ++i) {
    double sum = 0, squares = 0;
    for (const Image& r : s.replicates) sum += r.data[i];
    const double mean = sum / replicates;
    for (const Image& r : s.replicates) squares += (r.data[i] - mean) * (r.data[i] - mean);
    s.mean.data[i] = static_cast<float>(mean);
    s.variance.data[i] = static_cast<float>(squares / (replicates - 1) / replicates);
  }
  return s;
}

// Value 1 with normal noise of the given standard deviation per replicate.
inline Synthetic normal_render(Random& random, int size, double sigma, double value = 1) {
  return synthesise(size, size, 8,
                    [&](int, int, int) { return static_cast<float>(value + sigma * random.normal()); });
}

// Mean 1 and a long tail: most of the light of a pixel comes from few of its replicates, as with a caustic.
inline Synthetic heavy_render(Random& random, int size, double value = 1) {
  constexpr double s = 1.5;
  return synthesise(size, size, 8, [&](int, int, int) {
    return static_cast<float>(value * std::exp(s * random.normal() - s * s / 2));
  });
}

// The 95 % interval of a binomial count.
inline double expected(int n, double p) { return n * p; }
inline double spread(int n, double p) { return 1.96 * std::sqrt(n * p * (1 - p)); }

}  // namespace synthetic
