#include "metric/statistics_levels.h"

#include <algorithm>
#include <boost/math/distributions/normal.hpp>
#include <boost/math/distributions/students_t.hpp>
#include <boost/math/special_functions/beta.hpp>
#include <cmath>
#include <limits>
#include <numbers>

namespace metric {

namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

// Beyond this many degrees of freedom, Student's distribution is normal to the last digit that matters.
constexpr double normal_from = 1e9;

using Policy = boost::math::policies::policy<
    boost::math::policies::promote_double<false>,
    boost::math::policies::overflow_error<boost::math::policies::ignore_error>,
    boost::math::policies::underflow_error<boost::math::policies::ignore_error>>;
using Student = boost::math::students_t_distribution<double, Policy>;
using Normal = boost::math::normal_distribution<double, Policy>;

}  // namespace

double sidak(double budget, double tests) { return -std::expm1(std::log1p(-budget) / tests); }

double case_false_alarm(int cases) { return sidak(suite_false_alarm, static_cast<double>(cases)); }

double student_two_sided_p(double t, double degrees_of_freedom) {
  const double a = std::abs(t);
  if (std::isnan(a)) return std::numeric_limits<double>::quiet_NaN();
  if (std::isinf(a)) return 0;
  if (degrees_of_freedom > normal_from) return 2 * cdf(complement(Normal(0, 1), a));
  return 2 * cdf(complement(Student(degrees_of_freedom), a));
}

double student_critical(double two_sided_p, double degrees_of_freedom) {
  if (two_sided_p >= 1) return 0;
  if (two_sided_p <= 0) return infinity;
  if (degrees_of_freedom > normal_from) return quantile(complement(Normal(0, 1), two_sided_p / 2));
  return quantile(complement(Student(degrees_of_freedom), two_sided_p / 2));
}

Interval rate_interval(int found, int trials, double confidence) {
  const double rest = (1 - confidence) / 2;
  const auto quantile_of = [](int above, int below, double p) {
    return boost::math::ibeta_inv(static_cast<double>(above), static_cast<double>(below), p, Policy());
  };
  return {found == 0 ? 0 : quantile_of(found, trials - found + 1, rest),
          found == trials ? 1 : quantile_of(found + 1, trials - found, 1 - rest)};
}

double symmetric_p(double s) {
  // 1 / (4 P(N(0,1) >= sqrt 2)), the smallest factor that is right for every sum.
  static const double factor = 1 / (2 * std::erfc(1.));
  return std::min(1., factor * std::erfc(std::abs(s) / std::numbers::sqrt2));
}

double exchange_p(int replicates_a, int replicates_b, double pixels) {
  // log C(a + b, a)
  const double arrangements = std::lgamma(replicates_a + replicates_b + 1.) - std::lgamma(replicates_a + 1.) -
                              std::lgamma(replicates_b + 1.);
  return std::min(1., std::exp(pixels * (std::log(2.) - arrangements)));
}

}  // namespace metric
