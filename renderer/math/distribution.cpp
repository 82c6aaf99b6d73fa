#include "math/distribution.h"

#include <algorithm>
#include <cassert>
#include <cmath>

namespace math {

Distribution1D::Distribution1D(std::span<const double> weights) : cumulative_(weights.size() + 1) {
  assert(weights.size() < (1u << 30));
  // Sum with compensation (Kahan): the error of a plain sum, times the number of entries, could reach one.
  double sum = 0, lost = 0;
  const auto add = [&](double weight) {
    const double term = weight - lost, next = sum + term;
    lost = (next - sum) - term;
    sum = next;
  };
  std::uint32_t present = 0;
  for (double weight : weights) {
    assert(std::isfinite(weight) && weight >= 0);
    add(weight);
    present += weight > 0;
  }
  if (!(sum > 0)) return;
  assert(std::isfinite(sum));
  sum_ = sum;

  // One part of 2^31 for each entry that is not 0, the rest by weight.
  constexpr std::uint32_t one = 1u << 31;
  sum = lost = 0;
  std::uint32_t before = 0;
  for (std::uint32_t i = 0; i < size(); ++i) {
    if (weights[i] > 0) ++before, add(weights[i]);
    const double share = std::min(1., sum / sum_);
    cumulative_[i + 1] = before + static_cast<std::uint32_t>(share * (one - present));
    if (before == present) cumulative_[i + 1] = one;
  }
  guide_.resize((size() + guided - 1) / guided);
  std::uint32_t entry = 0;
  for (std::uint32_t k = 0; k < guide_.size(); ++k) {
    // The least u that is led here.
    const std::uint64_t first = ((static_cast<std::uint64_t>(k) << 31) + guide_.size() - 1) / guide_.size();
    while (cumulative_[entry + 1] <= first) ++entry;
    guide_[k] = entry;
  }
}

}  // namespace math
