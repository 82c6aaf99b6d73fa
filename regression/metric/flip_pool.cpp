#include "metric/flip_pool.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>

namespace metric {

namespace {

// Errors of about the same size: the same upper half of a float's bits, which sort as the floats do.
constexpr int bucket_count = 0x3f80 + 1;  // up to 1.0f
int bucket_of(float error) { return static_cast<int>(std::bit_cast<std::uint32_t>(error) >> 16); }

// Sorting 2 million errors would take longer than FLIP itself, so only the bucket that holds the answer is
// sorted.
double percentile(const std::vector<float>& errors, const std::vector<double>& bucket_sums, double target) {
  double below = 0;
  int bucket = 0, last = 0;
  for (int b = 0; b < bucket_count; ++b)
    if (bucket_sums[b] > 0) last = b;
  while (bucket < last && below + bucket_sums[bucket] <= target) below += bucket_sums[bucket++];
  std::vector<float> inside;
  for (const float e : errors)
    if (bucket_of(e) == bucket) inside.push_back(e);
  std::sort(inside.begin(), inside.end());
  for (const float e : inside) {
    below += e;
    if (below > target) return e;
  }
  return inside.empty() ? 0 : inside.back();
}

}  // namespace

void pool(Flip& flip) {
  const std::vector<float>& errors = flip.map.data;
  std::vector<double> sums(bucket_count, 0.0);
  float lowest = errors.front(), highest = errors.front();
  double total = 0;
  for (const float e : errors) {
    sums[bucket_of(e)] += e;
    total += e;
    lowest = std::min(lowest, e);
    highest = std::max(highest, e);
  }
  flip.mean = total / static_cast<double>(errors.size());
  flip.min = lowest;
  flip.max = highest;
  flip.weighted_quartile1 = percentile(errors, sums, 0.25 * total);
  flip.weighted_median = percentile(errors, sums, 0.5 * total);
  flip.weighted_quartile3 = percentile(errors, sums, 0.75 * total);
}

}  // namespace metric
