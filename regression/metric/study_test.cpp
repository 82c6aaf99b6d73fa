// False-alarm rate and power of the statistics, measured on synthetic renders whose truth is known. Seeds are
// fixed: each study gives the same counts every time.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "metric/synthetic.h"

namespace {

using namespace synthetic;
using metric::Comparison;
using metric::WelchOptions;

// What the null study counts: tests of single tiles and channels below the level, and comparisons with any
// alarm.
struct Rates {
  int tests = 0, low = 0, comparisons = 0, alarms = 0;
};

Rates null_study(double level, int pairs, const std::function<Synthetic(Random&)>& render) {
  Random random(20240607);
  WelchOptions options;
  options.false_alarm = level;
  options.rounding = 0;
  Rates rates;
  for (int i = 0; i < pairs; ++i) {
    const Synthetic a = render(random), b = render(random);
    const Comparison c = metric::compare_welch(a.noisy(), b.noisy(), options);
    ++rates.comparisons;
    rates.alarms += c.biased();
    for (const metric::Tile& t : c.tiles)
      for (int q = 0; q < 3; ++q, ++rates.tests) rates.low += t.difference[q].p < level;
  }
  std::printf("level %.3g: single tests %.3g, whole comparisons %.3g\n", level,
              static_cast<double>(rates.low) / rates.tests,
              static_cast<double>(rates.alarms) / rates.comparisons);
  return rates;
}

TEST(NullStudy, NormalNoiseRaisesAsManyFalseAlarmsAsItMay) {
  const Rates r = null_study(1e-2, 2000, [](Random& random) { return normal_render(random, 16, 0.3); });
  EXPECT_NEAR(r.low, expected(r.tests, 1e-2), spread(r.tests, 1e-2));
  EXPECT_NEAR(r.alarms, expected(r.comparisons, 1e-2), spread(r.comparisons, 1e-2));
}

// The difference of two renders is symmetric however skewed each is, and an outlier raises its own variance:
// the test may only become more careful.
TEST(NullStudy, HeavyTailsDoNotRaiseMoreFalseAlarmsThanTheLevel) {
  const Rates r = null_study(1e-2, 2000, [](Random& random) { return heavy_render(random, 16); });
  EXPECT_LE(r.low, expected(r.tests, 1e-2) + spread(r.tests, 1e-2));
  EXPECT_GE(r.low, expected(r.tests, 1e-2) / 4) << "so careful that it sees nothing";
  EXPECT_LE(r.alarms, expected(r.comparisons, 1e-2) + spread(r.comparisons, 1e-2));
}

TEST(NullStudy, FirefliesDoNotRaiseMoreFalseAlarmsThanTheLevel) {
  const Rates r = null_study(1e-2, 2000, [](Random& random) {
    return synthesise(16, 16, 8, [&](int, int, int) {
      return static_cast<float>(1 + 0.1 * random.normal() + (random.uniform() < 1e-3 ? 100 : 0));
    });
  });
  EXPECT_LE(r.low, expected(r.tests, 1e-2) + spread(r.tests, 1e-2));
  EXPECT_LE(r.alarms, expected(r.comparisons, 1e-2) + spread(r.comparisons, 1e-2));
}

// 64 x 64, R = 8, noise 7 % per pixel and replicate: standard error of the image mean's difference .0547 %.
TEST(Power, ABiasOfTheDetectableSizeIsFoundNinetyNineTimesInAHundred) {
  Random random(77);
  WelchOptions options;
  options.rounding = 0;
  const Synthetic a = normal_render(random, 64, 0.07), b = normal_render(random, 64, 0.07);
  const double detectable = metric::compare_welch(a.noisy(), b.noisy(), options).image[0].detectable;
  EXPECT_LT(detectable, 0.005);
  std::printf("detectable bias of the image mean: %.3f %%\n", 100 * detectable);
  int found = 0;
  constexpr int trials = 400;
  for (int i = 0; i < trials; ++i) {
    const Synthetic r = normal_render(random, 32, 0.035),
                    t = normal_render(random, 32, 0.035, 1 + detectable);
    const Comparison c = metric::compare_welch(r.noisy(), t.noisy(), options);
    // the same standard error with a quarter of the pixels at half the noise; compared at the level of 64 x
    // 64
    found += c.image[0].p < metric::sidak(options.false_alarm, 65 * 4);
  }
  EXPECT_GE(found, 0.99 * trials - 1.96 * std::sqrt(trials * 0.99 * 0.01));
  EXPECT_LT(found, trials + 1);
}

TEST(Power, AHalfPercentBiasIsFoundInTheImageAndNotWhereItIsNot) {
  Random random(5);
  const Synthetic a = normal_render(random, 64, 0.08), same = normal_render(random, 64, 0.08);
  const Synthetic biased = normal_render(random, 64, 0.08, 1.005);
  const Comparison null = metric::compare_welch(a.noisy(), same.noisy());
  EXPECT_FALSE(null.biased());
  EXPECT_TRUE(null.equivalent());
  EXPECT_GT(null.smallest_p, 1e-3);
  const Comparison found = metric::compare_welch(a.noisy(), biased.noisy());
  EXPECT_TRUE(found.biased());
  EXPECT_FALSE(found.equivalent());
  EXPECT_LT(found.smallest_p, 5e-9);
  EXPECT_LT(found.image[0].interval.low, 0.005);
  EXPECT_GT(found.image[0].interval.high, 0.005);
  EXPECT_GT(found.image[0].interval.low, 0);
}

TEST(Power, AFaultInOneTileIsFoundThereOnly) {
  Random random(6);
  const Synthetic a = normal_render(random, 64, 0.08);
  const Synthetic b = synthesise(64, 64, 8, [&](int x, int y, int c) {
    const double fault = x / 8 == 3 && y / 8 == 5 && c == 2 ? 1.05 : 1;
    return static_cast<float>(fault + 0.08 * random.normal());
  });
  const Comparison c = metric::compare_welch(a.noisy(), b.noisy());
  EXPECT_TRUE(c.biased());
  for (const metric::Difference& d : c.image) EXPECT_FALSE(d.significant);
  for (const metric::Tile& t : c.tiles) EXPECT_EQ(t.significant(), t.x == 24 && t.y == 40);
  const metric::Tile& tile = c.tiles[5 * 8 + 3];
  EXPECT_TRUE(tile.difference[metric::blue].significant);
  EXPECT_FALSE(tile.difference[metric::red].significant);
  EXPECT_NEAR(tile.t(), tile.difference[metric::blue].t, 0);
  EXPECT_GT(tile.t(), 6.7);
}

TEST(Power, TooLittleDataIsNeitherBiasedNorEquivalent) {
  Random random(7);
  const Synthetic a = normal_render(random, 16, 2), b = normal_render(random, 16, 2);
  const Comparison c = metric::compare_welch(a.noisy(), b.noisy());
  EXPECT_FALSE(c.biased());
  EXPECT_FALSE(c.equivalent());
  EXPECT_GT(c.image[0].detectable, 0.1);
}

}  // namespace
