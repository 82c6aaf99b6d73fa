#include "math/distribution.h"

#include <cassert>
#include <cmath>
#include <limits>

namespace math {

Distribution1D::Distribution1D(std::span<const double> weights)
    : entries_(weights.size()), probabilities_(weights.size()) {
  assert(weights.size() <= std::numeric_limits<std::uint32_t>::max());
  // Sum with compensation (Kahan): the error of a plain sum, times the number of entries, could reach one.
  double sum = 0, lost = 0;
  for (double weight : weights) {
    assert(std::isfinite(weight) && weight >= 0);
    const double term = weight - lost, next = sum + term;
    lost = (next - sum) - term;
    sum = next;
  }
  if (!(sum > 0)) return;
  assert(std::isfinite(sum));
  sum_ = sum;

  // Scale the weights to a mean of one: what exceeds one must be given away as somebody's alias.
  const double count = static_cast<double>(size());
  std::vector<double> scaled(size());
  std::vector<std::uint32_t> poor, rich;
  for (std::uint32_t i = 0; i < size(); ++i) {
    probabilities_[i] = static_cast<float>(weights[i] / sum);
    if (probabilities_[i] < std::numeric_limits<float>::min()) probabilities_[i] = 0;
    scaled[i] = probabilities_[i] > 0 ? weights[i] / sum * count : 0;
    (scaled[i] < 1 ? poor : rich).push_back(i);
  }
  while (!poor.empty() && !rich.empty()) {
    const std::uint32_t taker = poor.back(), giver = rich.back();
    poor.pop_back();
    entries_[taker] = {static_cast<float>(scaled[taker]), giver};
    scaled[giver] -= 1 - scaled[taker];
    if (scaled[giver] < 1) {
      rich.pop_back();
      poor.push_back(giver);
    }
  }
  // The mean of what remains on either list is one and none on the list of the poor is above it: so each
  // differs from one by rounding only, and no zero is among them.
  for (const auto& list : {rich, poor})
    for (std::uint32_t i : list) {
      assert(std::fabs(scaled[i] - 1) < 1e-3);
      entries_[i] = {1, i};
    }
}

}  // namespace math
