// Estimators of error on pictures whose noise and bias are planted. Limits are 5 standard errors of the
// numbers under test (false alarm 6e-7 each, seeds fixed).
#include "speed/errors.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "base/error.h"

namespace speed {
namespace {

using image::Image;

constexpr int side = 64, samples = side * side * 3;

// Every pixel its own radiance; `sigma` of noise, independent in all; `bias` added to all.
Image render(unsigned seed, double sigma, double bias = 0) {
  std::mt19937 random(seed);
  std::normal_distribution<double> noise(0, sigma);
  Image picture(side, side, 3);
  for (std::size_t i = 0; i < picture.data.size(); ++i)
    picture.data[i] = static_cast<float>(.2 + .1 * static_cast<double>(i % 7) + bias + noise(random));
  return picture;
}

Reference reference(double sigma) { return Reference(render(1001, sigma), render(1002, sigma)); }

TEST(Errors, variance_needs_no_reference_and_no_bias_enters_it) {
  const Errors errors = variance(render(1, .1, .05), render(2, .1, .05), reference(.02).mean);
  // Mean of `samples` squares of variance .01: relative error sqrt(2 / samples).
  EXPECT_NEAR(errors.mse, .01, 5 * .01 * std::sqrt(2. / samples));
  EXPECT_GT(errors.relative_mse, errors.mse);
}

TEST(Errors, against_a_noisy_reference_are_those_against_a_perfect_one) {
  const Errors errors = against(render(1, .1, .05), reference(.08));
  // Noise .01 and bias .0025; a blind mean square would find .0032 more, 20 times the limit.
  EXPECT_NEAR(errors.mse, .0125, .0008);
}

TEST(Errors, bias_squared_finds_a_planted_bias_and_none_where_there_is_none) {
  const Reference truth = reference(.05);
  for (const double bias : {0., .02, .05}) {
    const Image a = render(1, .1, bias), b = render(2, .1, bias), c = render(3, .1, bias);
    const Estimate b2 = bias_squared({&a, &b, &c}, truth);
    EXPECT_NEAR(b2.value, bias * bias, 5 * b2.standard_error) << bias;
    EXPECT_LT(b2.standard_error, 3e-4);
    if (bias > .04) {
      EXPECT_GT(b2.value, 5 * b2.standard_error) << "a bias of half a sigma must be seen";
    }
  }
}

TEST(Errors, the_standard_error_of_bias_squared_is_its_spread) {
  double sum = 0, squares = 0, told = 0;
  constexpr int trials = 60;
  for (unsigned t = 0; t < trials; ++t) {
    const Image a = render(10 * t + 1, .1), b = render(10 * t + 2, .1);
    const Estimate b2 = bias_squared({&a, &b}, Reference(render(10 * t + 3, .05), render(10 * t + 4, .05)));
    sum += b2.value / trials, squares += b2.value * b2.value / trials, told += b2.standard_error / trials;
  }
  const double spread = std::sqrt(squares - sum * sum);
  EXPECT_NEAR(told / spread, 1, 5 / std::sqrt(2. * trials));
  EXPECT_NEAR(sum, 0, 5 * spread / std::sqrt(trials));
}

TEST(Errors, the_mean_of_an_image_knows_its_error) {
  const Image a = render(1, .1, .03), b = render(2, .1, .03), exact = render(3, 0);
  const Estimate mean = image_mean({&a, &b}), truth = image_mean({&exact, &exact});
  EXPECT_EQ(truth.standard_error, 0);
  EXPECT_NEAR(mean.value - truth.value, .03, 5 * mean.standard_error);
  // Two pictures of `samples` independent numbers each.
  EXPECT_NEAR(mean.standard_error, .1 / std::sqrt(2. * samples), .05 * .1 / std::sqrt(2. * samples));
}

TEST(Errors, refuse_what_cannot_be_compared) {
  const Image a = render(1, .1);
  EXPECT_THROW(variance(a, Image(2, 2, 3), a), base::Error);
  Image broken = a;
  broken.data[5] = std::nanf("");
  EXPECT_THROW(against(broken, reference(.1)), base::Error);
  EXPECT_THROW(bias_squared({&a, &broken}, reference(.1)), base::Error);
}

}  // namespace
}  // namespace speed
