// Discrete distribution: an index chosen with probability proportional to its weight, in constant time by the
// alias method (Walker 1974, built as Vose 1991 in double precision). A two-dimensional table, as of an
// environment map, is this one over index y * width + x.
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

  // Never an index of weight zero. A table of n entries uses up log2(n) bits of u before anything is left to
  // decide between entry and alias: for more than about a thousand entries give join(u0, u1), not one float.
  Sample sample(double u) const {
    const double scaled = u * static_cast<double>(entries_.size());
    const std::uint32_t slot = std::min(static_cast<std::uint32_t>(scaled), size() - 1);
    const double rest = scaled - slot;
    const Entry& entry = entries_[slot];
    const double threshold = entry.threshold;
    const bool own = rest < threshold;
    const std::uint32_t index = own ? slot : entry.alias;
    const double remapped = own ? rest / threshold : (rest - threshold) / (1 - threshold);
    return {index, probabilities_[index], std::min(static_cast<float>(remapped), 0x1.fffffep-1f)};
  }

 private:
  struct Entry {
    float threshold;  // the share of this slot that is its own
    std::uint32_t alias;
  };
  std::vector<Entry> entries_;
  std::vector<float> probabilities_;
  double sum_ = 0;
};

}  // namespace math
