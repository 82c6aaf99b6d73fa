#include "math/distribution.h"

#include <cassert>
#include <cmath>
#include <limits>

namespace math {

Distribution1D::Distribution1D(std::span<const double> weights)
    : entries_(weights.size()), probabilities_(weights.size()) {
  assert(weights.size() <= std::numeric_limits<std::uint32_t>::max());
  double sum = 0, largest = 0;
  std::uint32_t heaviest = 0;
  for (std::uint32_t i = 0; i < size(); ++i) {
    assert(std::isfinite(weights[i]) && weights[i] >= 0);
    sum += weights[i];
    if (weights[i] > largest) largest = weights[i], heaviest = i;
  }
  if (!(sum > 0)) return;
  assert(std::isfinite(sum));
  sum_ = sum;

  // Scale the weights to a mean of one: what exceeds one must be given away as somebody's alias. Weights that
  // count as zero go to the far end of the list, to be served first, while there certainly is something to
  // give.
  const double count = static_cast<double>(size());
  std::vector<double> scaled(size());
  std::vector<std::uint32_t> poor, rich, none;
  for (std::uint32_t i = 0; i < size(); ++i) {
    probabilities_[i] = static_cast<float>(weights[i] / sum);
    if (probabilities_[i] < std::numeric_limits<float>::min()) probabilities_[i] = 0;
    scaled[i] = probabilities_[i] > 0 ? weights[i] / sum * count : 0;
    (scaled[i] == 0 ? none : scaled[i] < 1 ? poor : rich).push_back(i);
  }
  poor.insert(poor.end(), none.begin(), none.end());

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
  // What remains on either list differs from one by rounding only.
  for (std::uint32_t i : rich) entries_[i] = {1, i};
  for (std::uint32_t i : poor) {
    if (probabilities_[i] > 0)
      entries_[i] = {1, i};
    else
      entries_[i] = {0, heaviest};
  }
}

}  // namespace math
