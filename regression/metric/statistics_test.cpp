// The statistics against closed forms and hand-worked numbers, and their false-alarm rate and power against
// synthetic renders whose truth is known. Seeds are fixed: each study gives the same counts every time.
#include "metric/statistics.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "base/error.h"
#include "metric/synthetic.h"

namespace {

using namespace synthetic;
using image::Image;
using metric::Comparison;
using metric::Noisy;
using metric::WelchOptions;

constexpr double infinity = std::numeric_limits<double>::infinity();

TEST(Student, AgreesWithItsClosedForms) {
  for (const double t : {0.0, 0.1, 1.0, 2.5, -6.7, 40.0, 1e6}) {
    const double a = std::abs(t);
    const auto near = [](double found, double wanted) { EXPECT_NEAR(found / wanted, 1, 1e-9); };
    near(metric::student_two_sided_p(t, 1), 2 / std::numbers::pi * std::atan2(1, a));
    // 1 - a / sqrt(2 + a^2), written so that it does not cancel
    near(metric::student_two_sided_p(t, 2), 2 / (std::sqrt(2 + a * a) * (std::sqrt(2 + a * a) + a)));
    if (a < 30) near(metric::student_two_sided_p(t, infinity), std::erfc(a / std::numbers::sqrt2));
  }
  EXPECT_EQ(metric::student_two_sided_p(infinity, 7), 0);
  EXPECT_TRUE(std::isnan(metric::student_two_sided_p(std::nan(""), 7)));
}

// Percentage points as printed in any statistics book (Fisher and Yates, table III).
TEST(Student, AgreesWithTheTables) {
  const double table[][3] = {{0.05, 1, 12.706},   {0.05, 2, 4.303},       {0.05, 10, 2.228},
                             {0.01, 5, 4.032},    {0.01, 30, 2.750},      {0.001, 5, 6.869},
                             {0.001, 120, 3.373}, {0.05, infinity, 1.960}};
  for (const auto& [p, freedom, t] : table) {
    EXPECT_NEAR(metric::student_critical(p, freedom), t, 5.1e-4) << p << " " << freedom;
    EXPECT_NEAR(metric::student_two_sided_p(metric::student_critical(p, freedom), freedom), p, 1e-9);
  }
  EXPECT_EQ(metric::student_critical(1, 5), 0);
  EXPECT_EQ(metric::student_critical(0, 5), infinity);
}

TEST(Budget, OfManyTestsTogetherIsTheSuites) {
  for (const double budget : {1e-6, 1e-2, 0.5})
    for (const double tests : {1.0, 3.0, 1000.0})
      EXPECT_NEAR(-std::expm1(tests * std::log1p(-metric::sidak(budget, tests))), budget, budget * 1e-12);
  EXPECT_NEAR(metric::case_false_alarm(100), 1e-8, 1e-13);
  // A 64 x 64 case asks for about t = 6.7 in a tile of 448 degrees of freedom.
  const double level = metric::sidak(metric::sidak(metric::case_false_alarm(), 2), 65 * 4);
  EXPECT_NEAR(metric::student_critical(level, 448), 6.8, 0.15);
}

// Two pixels, worked by hand: differences .2 and .4, variances .01 .03 (R = 5) and .02 .04 (R = 3):
// mean .3, standard error sqrt(.1)/2, freedom .1^2 / ((.0001 + .0009)/4 + (.0004 + .0016)/2) = 8.
TEST(Welch, AgreesWithAnExampleWorkedByHand) {
  Image a(2, 1, 3), va(2, 1, 3), b(2, 1, 3), vb(2, 1, 3);
  for (int c = 0; c < 3; ++c) {
    a.at(0, 0, c) = 1, a.at(1, 0, c) = 2, b.at(0, 0, c) = 1.2f, b.at(1, 0, c) = 2.4f;
    va.at(0, 0, c) = 0.01f, va.at(1, 0, c) = 0.03f, vb.at(0, 0, c) = 0.02f, vb.at(1, 0, c) = 0.04f;
  }
  const Comparison c = metric::compare_welch({a, va, 5}, {b, vb, 3});
  ASSERT_TRUE(c.ok());
  ASSERT_EQ(c.tiles.size(), 1u);
  for (const metric::Difference* d : {&c.image[0], &c.image[metric::luminance], &c.tiles[0].difference[2]}) {
    EXPECT_NEAR(d->reference, 1.5, 1e-7);
    EXPECT_NEAR(d->test, 1.8, 1e-7);
    EXPECT_NEAR(d->difference, 0.3, 1e-7);
    EXPECT_NEAR(d->standard_error, std::sqrt(0.1) / 2, 1e-7);
    EXPECT_NEAR(d->degrees_of_freedom, 8, 1e-5);
    EXPECT_NEAR(d->t, 0.6 / std::sqrt(0.1), 1e-5);
    EXPECT_NEAR(d->relative(), 0.2, 1e-7);
    // t(.99, 8) = 3.3554, from the tables
    EXPECT_NEAR(d->interval.high, (0.3 + 3.3554 * std::sqrt(0.1) / 2) / 1.5, 1e-5);
    EXPECT_NEAR(d->interval.low, (0.3 - 3.3554 * std::sqrt(0.1) / 2) / 1.5, 1e-5);
  }
  EXPECT_FALSE(c.biased());
  EXPECT_FALSE(c.equivalent());
}

TEST(Welch, TilesCoverTheImageOnceAndAddUpToIt) {
  Random random(1);
  const Synthetic a =
      synthesise(21, 10, 4, [&](int, int, int) { return static_cast<float>(random.uniform()); });
  const Synthetic b =
      synthesise(21, 10, 4, [&](int, int, int) { return static_cast<float>(random.uniform()); });
  const Comparison c = metric::compare_welch(a.noisy(), b.noisy());
  ASSERT_EQ(c.tiles.size(), 6u);
  EXPECT_EQ(c.tiles[5].x, 16);
  EXPECT_EQ(c.tiles[5].width, 5);
  EXPECT_EQ(c.tiles[5].height, 2);
  double sum = 0, squares = 0;
  for (const metric::Tile& t : c.tiles) {
    const double n = t.width * t.height;
    sum += t.difference[1].difference * n;
    squares += std::pow(t.difference[1].standard_error * n, 2);
  }
  EXPECT_NEAR(sum / 210, c.image[1].difference, 1e-9);
  EXPECT_NEAR(std::sqrt(squares) / 210, c.image[1].standard_error, 1e-9);
}

// 1 - erf(1) = .157299: the factor is 1 / (2 * .157299) = 3.1786.
TEST(Bounds, HaveTheirPublishedValues) {
  EXPECT_NEAR(metric::symmetric_p(6) / std::erfc(6 / std::numbers::sqrt2), 3.1786, 1e-3);
  EXPECT_EQ(metric::symmetric_p(0), 1);
  EXPECT_EQ(metric::symmetric_p(-5), metric::symmetric_p(5));
  EXPECT_NEAR(metric::exchange_p(8, 8, 1), 2 / 12870., 1e-12);
  EXPECT_NEAR(metric::exchange_p(8, 8, 3) / std::pow(2 / 12870., 3), 1, 1e-9);
  EXPECT_NEAR(metric::exchange_p(2, 2, 2), 1 / 9., 1e-12);
}

// 10 of 100: [.0490, .1762]; none of 10^4: 1 - .025^(1/10^4) = 3.69e-4.
TEST(Rates, HaveTheIntervalOfClopperAndPearson) {
  EXPECT_NEAR(metric::rate_interval(10, 100).low, 0.0490, 5e-5);
  EXPECT_NEAR(metric::rate_interval(10, 100).high, 0.1762, 5e-5);
  EXPECT_EQ(metric::rate_interval(0, 10000).low, 0);
  EXPECT_NEAR(metric::rate_interval(0, 10000).high, 3.688e-4, 1e-7);
  EXPECT_EQ(metric::rate_interval(7, 7).high, 1);
}

// Sums of fair signs with any weights stay below the bound: counted exactly over all 2^16 signs.
TEST(Bounds, HoldForEverySumOfFairSigns) {
  for (const double ratio : {1.0, 0.8, 0.5}) {
    std::vector<double> sums;
    double squares = 0;
    for (int i = 0; i < 16; ++i) squares += std::pow(ratio, 2 * i);
    for (int signs = 0; signs < 1 << 16; ++signs) {
      double sum = 0;
      for (int i = 0; i < 16; ++i) sum += (signs >> i & 1 ? 1 : -1) * std::pow(ratio, i);
      sums.push_back(std::abs(sum / std::sqrt(squares)));
    }
    std::sort(sums.begin(), sums.end());
    for (std::size_t i = 0; i < sums.size(); i += 97)
      EXPECT_LE(static_cast<double>(sums.end() - std::lower_bound(sums.begin(), sums.end(), sums[i] - 1e-9)) /
                    65536.,
                metric::symmetric_p(sums[i] - 1e-9) * (1 + 1e-12));
  }
}

// One pixel whose eight replicates agree by chance must not be surer than that chance.
TEST(Bounds, KeepOnePixelFromBeingSurerThanItsReplicates) {
  Image a(16, 16, 3, 1), b = a, none(16, 16, 3, 0);
  for (int c = 0; c < 3; ++c) b.at(9, 9, c) = 1.5f;
  const Comparison one = metric::compare_welch({a, none, 8}, {b, none, 8});
  EXPECT_FALSE(one.biased());
  EXPECT_NEAR(one.tiles[3].difference[0].p, 2 / 12870., 1e-9);
  for (int c = 0; c < 3; ++c) b.at(9, 10, c) = b.at(10, 10, c) = b.at(10, 9, c) = 1.5f;
  EXPECT_TRUE(metric::compare_welch({a, none, 8}, {b, none, 8}).biased());
}

// The golden saw none of a caustic's rare bright paths, the second look with four times the samples 44 of
// them: by the golden's own account it is certain, and 6.6 standard errors off.
TEST(Welch, DoesNotBelieveAGoldenThatCallsItselfQuietWhereMoreSamplesSayNoise) {
  Image a(8, 8, 3, 0), va = a, b = a, vb = a;
  for (int i = 0; i < 44; ++i)
    for (int c = 0; c < 3; ++c) b.at(i % 8, i / 8, c) = 1, vb.at(i % 8, i / 8, c) = 1;
  WelchOptions options;
  options.false_alarm = 1e-6;
  EXPECT_TRUE(metric::compare_welch({a, va, 8}, {b, vb, 8}, options).biased());
  const Comparison c = metric::compare_welch({a, va, 8, 64}, {b, vb, 8, 256}, options);
  EXPECT_FALSE(c.biased());
  EXPECT_NEAR(c.image[0].standard_error, std::sqrt(5 * 44.) / 64, 1e-9);
  // The other way round, and not where the numbers of samples are equal.
  EXPECT_NEAR(metric::compare_welch({b, vb, 8, 256}, {a, va, 8, 64}).image[0].standard_error,
              std::sqrt(5 * 44.) / 64, 1e-9);
  EXPECT_NEAR(metric::compare_welch({a, va, 8, 64}, {b, vb, 8, 64}).image[0].standard_error,
              std::sqrt(44.) / 64, 1e-9);
}

TEST(Degenerate, WithoutAnyNoiseTheComparisonIsExactUpToRounding) {
  const Image a(16, 8, 3, 0.5f), none(16, 8, 3, 0);
  Image same = a, rounded = a, different = a;
  rounded.at(3, 3, 1) += 1e-6f;
  for (int x = 0; x < 8; ++x)
    for (int y = 0; y < 8; ++y) different.at(x, y, 1) += 0.001f;
  const Comparison equal = metric::compare_welch({a, none, 2}, {same, none, 2});
  EXPECT_TRUE(equal.equivalent());
  EXPECT_EQ(equal.smallest_p, 1);
  const Comparison rounding = metric::compare_welch({a, none, 2}, {rounded, none, 2});
  EXPECT_FALSE(rounding.biased());
  EXPECT_TRUE(rounding.equivalent());
  const Comparison bias = metric::compare_welch({a, none, 2}, {different, none, 2});
  EXPECT_TRUE(bias.biased());
  EXPECT_TRUE(bias.tiles[0].significant());
  EXPECT_FALSE(bias.tiles[1].significant());
  EXPECT_EQ(bias.tiles[0].difference[metric::green].t, infinity);
}

TEST(Degenerate, ABlackReferenceIsEqualToBlackAndToNothingElse) {
  const Image black(8, 8, 3, 0), none(8, 8, 3, 0);
  Image lit = black;
  for (float& v : lit.data) v = 1e-20f;
  EXPECT_TRUE(metric::compare_welch({black, none, 2}, {black, none, 2}).equivalent());
  const Comparison c = metric::compare_welch({black, none, 2}, {lit, none, 2});
  EXPECT_TRUE(c.biased());
  EXPECT_FALSE(c.equivalent());
}

TEST(Degenerate, OneReplicateOrBadNumbersAreNoVerdict) {
  const Image a(8, 8, 3, 0.5f), v(8, 8, 3, 0.01f);
  Image nan = a, infinite = v, negative = v;
  nan.at(2, 2, 2) = std::nanf("");
  infinite.at(2, 2, 2) = std::numeric_limits<float>::infinity();
  negative.at(2, 2, 2) = -0.01f;
  const auto failure = [&](const Noisy& r, const Noisy& t) {
    const Comparison c = metric::compare_welch(r, t);
    EXPECT_FALSE(c.ok());
    EXPECT_FALSE(c.biased());
    EXPECT_FALSE(c.equivalent());
    return c.failure;
  };
  EXPECT_NE(failure({a, v, 1}, {a, v, 8}).find("reference: one replicate"), std::string::npos);
  EXPECT_NE(failure({a, v, 8}, {a, v, 1}).find("test image: one replicate"), std::string::npos);
  EXPECT_NE(failure({a, v, 8}, {nan, v, 8}).find("test image: 1 non-finite"), std::string::npos);
  EXPECT_NE(failure({a, infinite, 8}, {a, v, 8}).find("reference: 1 variances"), std::string::npos);
  EXPECT_NE(failure({a, v, 8}, {a, negative, 8}).find("test image: 1 variances"), std::string::npos);
  EXPECT_THROW(metric::compare_welch({a, v, 8}, {Image(8, 9, 3), Image(8, 9, 3), 8}), base::Error);
  EXPECT_THROW(metric::compare_welch({a, Image(), 8}, {a, v, 8}), base::Error);
}

// What a paired comparison takes: means and tile means of replicates.
struct Tiled {
  Image mean;
  std::vector<Image> tiles;
  explicit Tiled(const Synthetic& s) : mean(s.mean) {
    for (const Image& r : s.replicates) tiles.push_back(metric::tile_means(r));
  }
  Tiled times(float factor) const {
    Tiled other = *this;
    for (float& v : other.mean.data) v *= factor;
    for (Image& t : other.tiles)
      for (float& v : t.data) v *= factor;
    return other;
  }
  metric::Paired paired() const { return {mean, tiles}; }
};

// Both sides share their noise, so a lobe scaled by 1.003 shows although the noise hides it from Welch.
TEST(Paired, SeesAThousandthWhereTheNoiseIsShared) {
  Random random(8);
  const Synthetic a = normal_render(random, 32, 0.5);
  Synthetic b = a;
  for (float& v : b.mean.data) v *= 1.003f;
  EXPECT_FALSE(metric::compare_welch(a.noisy(), b.noisy()).biased());
  const Tiled ta(a);
  const Comparison c = metric::compare_paired(ta.paired(), ta.times(1.003f).paired());
  EXPECT_TRUE(c.biased());
  EXPECT_NEAR(c.image[0].relative(), 0.003, 1e-4);
  EXPECT_TRUE(metric::compare_paired(ta.paired(), ta.paired()).equivalent());
  EXPECT_TRUE(metric::compare_paired(ta.paired(), ta.times(1 + 1e-7f).paired()).equivalent())
      << "rounding is not bias";
}

TEST(Paired, SeesAFaultInOneTile) {
  Random random(12);
  const Tiled a(normal_render(random, 32, 0.05));
  Tiled b = a;
  for (int y = 8; y < 16; ++y)
    for (int x = 16; x < 24; ++x)
      for (int c = 0; c < 3; ++c) b.mean.at(x, y, c) *= 1.02f;
  for (Image& t : b.tiles)
    for (int c = 0; c < 3; ++c) t.at(2, 1, c) *= 1.02f;
  const Comparison c = metric::compare_paired(a.paired(), b.paired());
  for (const metric::Tile& t : c.tiles) EXPECT_EQ(t.significant(), t.x == 16 && t.y == 8);
}

// Noise that nothing shares: every test is at most as often low as its level says, and the image's, which is
// made of many pixels, not much less often.
TEST(Paired, RaisesNoMoreFalseAlarmsThanItMay) {
  Random random(9);
  int tests = 0, low = 0, images = 0, low_images = 0;
  for (int i = 0; i < 1500; ++i) {
    const Tiled a(
        synthesise(16, 16, 4, [&](int, int, int) { return static_cast<float>(1 + 0.1 * random.normal()); }));
    const Tiled b(
        synthesise(16, 16, 4, [&](int, int, int) { return static_cast<float>(1 + 0.1 * random.normal()); }));
    const Comparison c = metric::compare_paired(a.paired(), b.paired());
    for (const metric::Tile& t : c.tiles)
      for (int q = 0; q < 3; ++q, ++tests) low += t.difference[q].p < 0.05;
    for (int q = 0; q < 3; ++q, ++images) low_images += c.image[q].p < 0.05;
  }
  EXPECT_LE(low, expected(tests, 0.05) + spread(tests, 0.05));
  EXPECT_LE(low_images, expected(images, 0.05) + spread(images, 0.05));
  EXPECT_GT(low_images, expected(images, 0.05) / 20);
}

// An edge that a sample grid sees as 21/64 or 22/64: by chance all eight replicates of a tile move by the
// same step, one in 2^16 and with a variance of 0. Eight numbers cannot make that certain.
TEST(Paired, IsNotFooledByASampleGrid) {
  Image mean(16, 16, 3, 0.5f);
  Tiled a(Synthetic{mean, mean, std::vector<Image>(8, mean)}), b = a;
  b.mean.at(3, 3, 0) += 1 / 64.f;
  for (Image& t : b.tiles) t.at(0, 0, 0) += 1 / 64.f / 64;
  const Comparison c = metric::compare_paired(a.paired(), b.paired());
  EXPECT_FALSE(c.biased());
  EXPECT_GT(c.smallest_p, 0.1);
}

TEST(Paired, WantsTheReplicatesOfBothSides) {
  const Image mean(16, 16, 3, 1), tall(16, 24, 3, 1), tiles(2, 2, 3, 1);
  const std::vector<Image> one{tiles}, two{tiles, tiles};
  EXPECT_THROW(metric::compare_paired({mean, two}, {mean, one}), base::Error);
  EXPECT_THROW(metric::compare_paired({tall, two}, {tall, two}), base::Error);
  EXPECT_THROW(metric::compare_paired({mean, two}, {tall, two}), base::Error);
  EXPECT_FALSE(metric::compare_paired({mean, one}, {mean, one}).ok());
  std::vector<Image> bad = two;
  bad[1].at(0, 0, 0) = std::nanf("");
  EXPECT_FALSE(metric::compare_paired({mean, two}, {mean, bad}).ok());
  Image bad_mean = mean;
  bad_mean.at(5, 5, 1) = std::nanf("");
  EXPECT_FALSE(metric::compare_paired({mean, two}, {bad_mean, two}).ok());
}

TEST(TileMeans, AreThoseOfThePixelsInside) {
  Image image(5, 3, 1);
  for (std::size_t i = 0; i < 15; ++i) image.data[i] = static_cast<float>(i);
  const Image means = metric::tile_means(image, 2);
  EXPECT_EQ(means.width, 3);
  EXPECT_EQ(means.height, 2);
  EXPECT_EQ(means.data, (std::vector<float>{3, 5, 6.5f, 10.5f, 12.5f, 14}));
}

TEST(Noise, ThatRoseOrFellIsFoundAndTheSameNoiseIsNot) {
  Random random(10);
  const Synthetic a = normal_render(random, 64, 0.1), same = normal_render(random, 64, 0.1);
  const Synthetic noisier = normal_render(random, 64, 0.11), quieter = normal_render(random, 64, 0.09);
  EXPECT_GT(metric::noise_ratio(a.noisy(), same.noisy()).p, 1e-3);
  const metric::NoiseRatio up = metric::noise_ratio(a.noisy(), noisier.noisy());
  EXPECT_LT(up.p, 1e-9);
  EXPECT_NEAR(up.ratio, 1.21, 0.05);
  EXPECT_NEAR(up.pooled, 1.21, 0.05);
  EXPECT_LT(up.interval.low, 1.21);
  EXPECT_GT(up.interval.high, 1.21);
  EXPECT_EQ(up.blocks, 256);
  const metric::NoiseRatio down = metric::noise_ratio(a.noisy(), quieter.noisy());
  EXPECT_LT(down.p, 1e-9);
  EXPECT_LT(down.interval.high, 1);
}

TEST(Noise, WithHeavyTailsRaisesNoMoreFalseAlarmsThanTheLevel) {
  Random random(11);
  int low = 0;
  constexpr int pairs = 600;
  for (int i = 0; i < pairs; ++i) {
    const Synthetic a = heavy_render(random, 32), b = heavy_render(random, 32);
    low += metric::noise_ratio(a.noisy(), b.noisy()).p < 0.01;
  }
  EXPECT_LE(low, expected(pairs, 0.01) + spread(pairs, 0.01));
}

TEST(Noise, WithoutAnyIsNoClaimAndNoiseFromNothingIs) {
  const Image a(64, 64, 3, 1), none(64, 64, 3, 0), some(64, 64, 3, 0.1f), small(8, 8, 3, 1);
  EXPECT_EQ(metric::noise_ratio({a, none, 2}, {a, none, 2}).p, 1);
  EXPECT_EQ(metric::noise_ratio({a, some, 2}, {a, some, 2}).p, 1);
  EXPECT_LT(metric::noise_ratio({a, none, 2}, {a, some, 2}).p, 1e-50);
  EXPECT_EQ(metric::noise_ratio({small, small, 2}, {small, small, 2}).p, 1);
}

TEST(Noise, OfRoundingIsNoneAndNoiseAboveItIsFound) {
  const auto with_noise = [](double relative) {
    return Image(64, 64, 3, static_cast<float>(4 * relative * relative));
  };
  const Image a(64, 64, 3, 2);
  const Image little = with_noise(2e-8), twice = with_noise(4e-8), above = with_noise(4e-6);
  EXPECT_EQ(metric::noise_ratio({a, little, 2}, {a, twice, 2}).p, 1);
  EXPECT_EQ(metric::noise_ratio({a, little, 2}, {a, twice, 2}).blocks, 0);
  EXPECT_LT(metric::noise_ratio({a, little, 2}, {a, above, 2}).p, 1e-50);
  EXPECT_LT(metric::noise_ratio({a, above, 2}, {a, little, 2}).p, 1e-50);
}

TEST(Witness, AgreesIfTheDifferenceAndItsErrorFitIntoTheMargin) {
  metric::Difference d;
  d.scale = 2;
  d.difference = -0.003;
  d.standard_error = 0.001;
  EXPECT_TRUE(metric::agrees(d, 0.00326));
  EXPECT_FALSE(metric::agrees(d, 0.00324));
  d.standard_error = 0;
  EXPECT_TRUE(metric::agrees(d, 0.0015));
  d.difference = std::nan("");
  EXPECT_FALSE(metric::agrees(d, 0.5));
  EXPECT_TRUE(metric::flip_agrees(0.054, 0.04));
  EXPECT_FALSE(metric::flip_agrees(0.056, 0.04));
  EXPECT_FALSE(metric::flip_agrees(std::nan(""), 0.04));
}

}  // namespace
