// Differences whose parts are known: noise of a known size, an offset, and a pattern that cancels in the
// mean.
#include "report/parts.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace report {
namespace {

constexpr double sigma_ours = .03, sigma_theirs = .04;

// Grey .5 with normal noise; `offset` everywhere and a checkerboard of tiles of size `pattern` on top.
Estimate estimate(double sigma, unsigned seed, double offset = 0, double pattern = 0) {
  std::mt19937 random(seed);
  std::normal_distribution<double> noise(0, sigma);
  Estimate out = {image::Image(64, 64, 3), image::Image(64, 64, 3, static_cast<float>(sigma * sigma)), 8};
  for (int y = 0; y < 64; ++y)
    for (int x = 0; x < 64; ++x)
      for (int c = 0; c < 3; ++c)
        out.mean.at(x, y, c) =
            static_cast<float>(.5 + offset + ((x / 8 + y / 8) % 2 ? pattern : -pattern) + noise(random));
  return out;
}

TEST(Parts, of_known_noise_bias_and_pattern_are_found) {
  const Parts p = *parts(estimate(sigma_ours, 1, .02, .01), estimate(sigma_theirs, 2));
  EXPECT_NEAR(p.scale, .5, .001);
  EXPECT_NEAR(p.noise, .0025, 1e-8) << "sum of the variances";
  EXPECT_NEAR(std::sqrt(p.bias), .02, .001);
  EXPECT_NEAR(p.model, 1e-4, 4 * p.model_error);
  EXPECT_GT(p.model, 0);
  EXPECT_NEAR(p.total, p.noise + p.bias + p.model, 1e-12);
}

TEST(Parts, of_noise_alone_are_noise_alone_as_often_as_the_standard_error_says) {
  // |z| > 4 has a chance of 6e-5, 200 times: 1.3 % at most (the seeds are fixed).
  double sum = 0, squares = 0, bias = 0;
  for (unsigned i = 0; i < 200; ++i) {
    const Parts p = *parts(estimate(sigma_ours, 2 * i), estimate(sigma_theirs, 2 * i + 1));
    const double z = p.model / p.model_error;
    EXPECT_LT(std::fabs(z), 4) << i;
    sum += z, squares += z * z;
    bias += p.bias;
  }
  // The variances given are exact here, while the standard error allows for estimates from eight replicates,
  // so the spread of z is below 1: 2 v^2 / (2 v^2 + 2 (a^2 + b^2) / 7).
  const double a = sigma_ours * sigma_ours, b = sigma_theirs * sigma_theirs, v = a + b;
  const double expected = v * v / (v * v + (a * a + b * b) / 7);
  EXPECT_NEAR(sum / 200, 0, 4 / std::sqrt(200.));
  // Each bias: three squares of means of 4096 pixels, less what noise puts there.
  EXPECT_NEAR(bias / 200, 0, 4 * v / 4096 * std::sqrt(2. / 3 / 200));
  EXPECT_NEAR(squares / 200, expected, 4 * expected * std::sqrt(2 / 200.));
}

TEST(Parts, are_none_without_variance_or_with_other_sizes_or_not_a_number) {
  const Estimate a = estimate(.1, 1);
  Estimate exact = a, other = a, bad = a;
  exact.variance = {};
  other.mean = image::Image(8, 8, 3);
  bad.mean.data[7] = NAN;
  EXPECT_TRUE(parts(a, a));
  EXPECT_TRUE(parts(a, exact)) << "one of the two may be exact";
  EXPECT_FALSE(parts(exact, exact));
  EXPECT_FALSE(parts(a, other));
  EXPECT_FALSE(parts(a, bad));
  EXPECT_FALSE(parts(a, {}));
  EXPECT_TRUE(tile_differences(a, bad).empty());
}

TEST(TileDifferences, stand_out_where_the_pictures_differ_and_only_there) {
  Estimate ours = estimate(sigma_ours, 5);
  const Estimate theirs = estimate(sigma_theirs, 6);
  for (int y = 16; y < 24; ++y)
    for (int x = 40; x < 48; ++x) ours.mean.at(x, y, 1) += .1f;
  const std::vector<TileDifference> tiles = tile_differences(ours, theirs);
  ASSERT_EQ(tiles.size(), 64u);
  // Green's t: .1 * 8 / .05 = 16, give or take 1. Elsewhere the largest of 3 normals, 63 times: above 4.6
  // with 0.08 %.
  for (const TileDifference& t : tiles) {
    EXPECT_EQ(t.width * t.height, 64);
    if (t.x == 40 && t.y == 16) {
      EXPECT_NEAR(t.t, 16, 4);
      EXPECT_NEAR(t.relative, .7152 * .1 / .5, .05);
      EXPECT_GT(t.low, 0);
      EXPECT_LT(t.low, t.relative);
    } else {
      EXPECT_LT(std::fabs(t.t), 4.6) << t.x << " " << t.y;
      EXPECT_LT(t.low, t.high);
    }
  }
}

}  // namespace
}  // namespace report
