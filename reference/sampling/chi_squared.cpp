#include "sampling/chi_squared.h"

#include <algorithm>
#include <boost/math/special_functions/gamma.hpp>
#include <cmath>
#include <cstdlib>
#include <ctime>
#include <numeric>

namespace sampling {

double significance(std::size_t verdicts) {
  return -std::expm1(std::log1p(-suite_false_alarm) / static_cast<double>(verdicts));
}
double significance() { return significance(3 * materials().size() * direction_count); }

bool nightly() {
  const char* const text = std::getenv("ASSAY_NIGHTLY");
  return text && *text;
}
int draws() { return nightly() ? 4'000'000 : 1'000'000; }
std::uint64_t seed() { return nightly() ? static_cast<std::uint64_t>(std::time(nullptr)) / 86400 : 20120808; }

Pearson pearson(const std::vector<double>& density, const std::vector<long>& observed) {
  std::vector<std::size_t> order(density.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return density[a] < density[b]; });
  const double total = std::accumulate(density.begin(), density.end(), 0.);
  const double count = static_cast<double>(std::accumulate(observed.begin(), observed.end(), 0L));

  Pearson result;
  double expected = 0, seen = 0, remaining = count;
  for (const std::size_t i : order) {
    const double here = density[i] * count / total;
    expected += here;
    seen += static_cast<double>(observed[i]);
    remaining -= here;
    // The last pool may not leave a rest too small to be one.
    if (i != order.back() && (expected < 10 || remaining < 10)) continue;
    result.statistic += (seen - expected) * (seen - expected) / expected;
    ++result.degrees;
    expected = seen = 0;
  }
  --result.degrees;
  if (result.degrees > 0) result.p = boost::math::gamma_q(.5 * result.degrees, .5 * result.statistic);
  return result;
}

ChiSquared chi_squared(const Subject& subject, int draws, std::uint64_t seed) {
  const Cells cells(subject.bsdf, subject.wo);
  const std::vector<double> density =
      cells.integrate([&](const Vec3& wi) { return static_cast<double>(subject.eval(wi).pdf); });

  std::vector<long> observed(Cells::count, 0);
  Random random(seed);
  for (int i = 0; i < draws; ++i) {
    const float u_lobe = random.uniform(), u = random.uniform(), v = random.uniform();
    const auto s = subject.sample(u_lobe, u, v);
    if (s && !s->is_delta) ++observed[static_cast<std::size_t>(cells.of(s->wi))];
  }

  ChiSquared result;
  const double n = draws;
  result.share = static_cast<double>(std::accumulate(observed.begin(), observed.end(), 0L)) / n;
  result.integral = std::accumulate(density.begin(), density.end(), 0.);
  const double q = std::clamp(result.integral, 0., 1.);
  const double sigma = std::sqrt(std::max(q * (1 - q), 1 / n) / n);
  const double excess = std::max(0., std::fabs(result.share - result.integral) - 1e-4);
  result.p_total = std::erfc(excess / sigma / std::sqrt(2.));

  std::vector<double> ring_density(Cells::radial, 0);
  std::vector<long> ring_observed(Cells::radial, 0);
  for (std::size_t i = 0; i < density.size(); ++i) {
    ring_density[i / Cells::angular] += density[i];
    ring_observed[i / Cells::angular] += observed[i];
  }
  result.cells = pearson(density, observed);
  result.rings = pearson(ring_density, ring_observed);
  return result;
}

}  // namespace sampling
