// Closed forms: curves and fits whose answer is known, with and without a planted bias.
#include "speed/fit.h"

#include <gtest/gtest.h>

#include <cmath>

namespace speed {
namespace {

// MSE = constant x seconds^-slope at 1, 2, 4, ... 64 seconds.
Curve power_law(double constant, double slope) {
  Curve curve;
  for (double t = 1; t <= 64; t *= 2) curve.push_back({t, constant * std::pow(t, -slope)});
  return curve;
}

TEST(TimeToEqualError, is_exact_on_a_power_law_and_says_when_it_prolonged_it) {
  const Curve curve = power_law(3, 1.3);
  for (const double t : {1., 1.7, 5., 63.}) {
    const auto equal = time_to(curve, 3 * std::pow(t, -1.3));
    ASSERT_TRUE(equal);
    EXPECT_NEAR(equal->seconds, t, 1e-9 * t);
    EXPECT_FALSE(equal->extrapolated);
  }
  for (const double t : {.25, 200.}) {
    const auto equal = time_to(curve, 3 * std::pow(t, -1.3));
    ASSERT_TRUE(equal);
    EXPECT_NEAR(equal->seconds, t, 1e-6 * t);
    EXPECT_TRUE(equal->extrapolated);
  }
  EXPECT_FALSE(time_to(curve, 3 * std::pow(64 * 1.01 * reach, -1.3))) << "prolonged without end";
}

TEST(TimeToEqualError, interpolates_between_logarithms_not_between_values) {
  EXPECT_NEAR(time_to({{1, 100}, {4, 1}}, 10)->seconds, 2, 1e-12);
  EXPECT_NEAR(time_to({{4, 1}, {1, 100}}, 10)->seconds, 2, 1e-12) << "order must not matter";
}

TEST(TimeToEqualError, has_no_answer_on_curves_that_do_not_fall) {
  EXPECT_FALSE(time_to({{1, 1}, {2, 2}}, .5));
  EXPECT_FALSE(time_to({{1, 1}}, 1));
  EXPECT_FALSE(time_to({{1, 1}, {2, .5}}, 0));
  EXPECT_FALSE(time_to({{1, 1}, {2, -.5}}, .5)) << "a negative estimate is no point of a curve";
}

TEST(TimeToEqualError, averages_what_noise_made_rise) {
  // 2 and 8 at 2 and 4 seconds become 4 each, in logarithms; then 1 at 8 seconds.
  EXPECT_NEAR(time_to({{1, 16}, {2, 2}, {4, 8}, {8, 1}}, 2)->seconds, 4 * std::sqrt(2.), 1e-12);
  EXPECT_NEAR(time_to({{1, 16}, {2, 2}, {4, 8}, {8, 1}}, 8)->seconds, std::sqrt(2.), 1e-12);
}

TEST(PowerFit, finds_constant_and_exponent_once_the_bias_is_taken_out) {
  constexpr double a = .7, p = 1.12, b2 = 2e-3;
  std::vector<Level> levels;
  for (double n = 4; n <= 1024; n *= 2) levels.push_back({n, a * std::pow(n, -p) + b2});
  const auto fit = fit_power(levels, b2);
  ASSERT_TRUE(fit);
  EXPECT_NEAR(fit->a, a, 1e-9);
  EXPECT_NEAR(fit->p, p, 1e-9);
  EXPECT_LT(fit->residual, 1e-9);
  // The same data with the bias overlooked: a slower fall that no power law follows.
  const auto blind = fit_power(levels, 0);
  ASSERT_TRUE(blind);
  EXPECT_LT(blind->p, 1.0);
  EXPECT_GT(blind->residual, .1);
}

TEST(PowerFit, needs_two_levels_above_the_bias) {
  EXPECT_FALSE(fit_power({{4, 1}, {8, .5}}, .6));
  EXPECT_FALSE(fit_power({{4, 1}, {4, .5}}, 0));
}

TEST(Median, is_the_middle) {
  EXPECT_EQ(median({5, 1, 3}), 3);
  EXPECT_EQ(median({4, 1, 3, 2}), 2.5);
}

}  // namespace
}  // namespace speed
