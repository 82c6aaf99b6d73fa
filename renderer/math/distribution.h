// Discrete distribution: an index chosen with probability proportional to its weight, by inverting the
// cumulative sum. The inverse is monotone, so well distributed numbers stay well distributed (an alias table,
// as fast, tears neighbours apart: an environment with a sun had three times the variance). A guide table
// says where the search begins: 2 steps on average, whatever the weights (Chen & Asau 1974; Devroye 1986,
// "Non-Uniform Random Variate Generation", III.2.4).
#pragma once

#include <algorithm>
#include <cstdint>
#include <span>
#include <vector>

namespace math {

// One number with 48 random bits from two floats of 24. The first decides, the second refines.
inline double join(float u0, float u1) { return static_cast<double>(u0) + static_cast<double>(u1) * 0x1p-24; }

class Distribution1D {
 public:
  struct Sample {
    std::uint32_t index;
    float probability;  // probability(index)
    float u;            // in [0,1), independent of the index: to be used for another choice
  };

  Distribution1D() = default;

  // Weights are finite and not negative (checked by assert). Probabilities below the smallest normal
  // float, 1.2e-38, count as zero.
  explicit Distribution1D(std::span<const double> weights);

  // True if there are no weights or all of them are zero: then sample must not be called.
  bool empty() const { return sum_ == 0; }
  std::uint32_t size() const { return static_cast<std::uint32_t>(probabilities_.size()); }
  double sum() const { return sum_; }  // of the weights
  float probability(std::uint32_t index) const { return probabilities_[index]; }

  // Never an index of weight zero. Monotone in u. A table of n entries uses up about log2(n) bits of u before
  // anything is left for Sample::u: for more than about a thousand entries give join(u0, u1), not one float.
  Sample sample(double u) const {
    std::uint32_t i = guide_[std::min(static_cast<std::uint32_t>(u * size()), size() - 1)];
    while (cumulative_[i] > u) --i;  // u * size() was rounded up
    while (cumulative_[i + 1] <= u) ++i;
    const double below = cumulative_[i];
    return {i, probabilities_[i],
            std::min(static_cast<float>((u - below) / (cumulative_[i + 1] - below)), 0x1.fffffep-1f)};
  }

 private:
  std::vector<double> cumulative_;    // size() + 1, from 0 to 1
  std::vector<std::uint32_t> guide_;  // [k]: the entry that u = k / size() chooses
  std::vector<float> probabilities_;
  double sum_ = 0;
};

}  // namespace math
