#include "math/distribution.h"

#include <cassert>
#include <cmath>
#include <limits>

namespace math {

Distribution1D::Distribution1D(std::span<const double> weights)
    : cumulative_(weights.size() + 1), guide_(weights.size()), probabilities_(weights.size()) {
  assert(weights.size() < std::numeric_limits<std::uint32_t>::max());
  // Sum with compensation (Kahan): the error of a plain sum, times the number of entries, could reach one.
  double sum = 0, lost = 0;
  const auto add = [&](double weight) {
    const double term = weight - lost, next = sum + term;
    lost = (next - sum) - term;
    sum = next;
  };
  for (double weight : weights) {
    assert(std::isfinite(weight) && weight >= 0);
    add(weight);
  }
  if (!(sum > 0)) return;
  assert(std::isfinite(sum));
  sum_ = sum;

  sum = lost = 0;
  for (std::uint32_t i = 0; i < size(); ++i) {
    probabilities_[i] = static_cast<float>(weights[i] / sum_);
    if (probabilities_[i] < std::numeric_limits<float>::min()) probabilities_[i] = 0;
    if (probabilities_[i] > 0) add(weights[i]);
    cumulative_[i + 1] = sum;
  }
  // Divided by itself the last becomes 1 exactly, and with it all entries of weight zero after it.
  for (double& c : cumulative_) c /= sum;
  std::uint32_t entry = 0;
  for (std::uint32_t k = 0; k < size(); ++k) {
    while (cumulative_[entry + 1] <= static_cast<double>(k) / size()) ++entry;
    guide_[k] = entry;
  }
}

}  // namespace math
