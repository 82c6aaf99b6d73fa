// Discrete distribution: an index chosen with probability proportional to its weight, by inverting the
// cumulative sum. The inverse is monotone, so well distributed numbers stay well distributed (an alias table,
// as fast, tears neighbours apart: an environment with a sun had 2.4 times the variance). A guide table
// says where the search begins: on average half of `guided` steps remain, whatever the weights (Chen & Asau
// 1974; Devroye 1986, "Non-Uniform Random Variate Generation", III.2.4).
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

  // Weights are finite and not negative (checked by assert). Probabilities are multiples of 2^-31, and at
  // least that where the weight is not 0: what probability() says is just what sample() does.
  explicit Distribution1D(std::span<const double> weights);

  // True if there are no weights or all of them are zero: then sample must not be called.
  bool empty() const { return sum_ == 0; }
  std::uint32_t size() const { return static_cast<std::uint32_t>(cumulative_.size()) - 1; }
  double sum() const { return sum_; }  // of the weights
  float probability(std::uint32_t index) const {
    return static_cast<float>(cumulative_[index + 1] - cumulative_[index]) * 0x1p-31f;
  }

  // Never an index of weight zero. Monotone in u. A table of n entries uses up about log2(n) bits of u before
  // anything is left for Sample::u: for more than about a thousand entries give join(u0, u1), not one float.
  Sample sample(double u) const {
    const double scaled = u * 0x1p31;
    const auto whole = static_cast<std::uint32_t>(scaled);
    std::uint32_t i = guide_[static_cast<std::uint64_t>(whole) * guide_.size() >> 31];
    while (cumulative_[i + 1] <= whole) ++i;
    const double remapped = (scaled - cumulative_[i]) / (cumulative_[i + 1] - cumulative_[i]);
    return {i, probability(i), std::min(static_cast<float>(remapped), 0x1.fffffep-1f)};
  }

 private:
  static constexpr std::uint32_t guided = 8;     // entries for one of the guide: together a cache line or two
  std::vector<std::uint32_t> cumulative_ = {0};  // times 2^31; size() + 1, from 0 to 2^31
  std::vector<std::uint32_t> guide_;             // [k]: the entry that u = k / size of guide chooses
  double sum_ = 0;
};

}  // namespace math
