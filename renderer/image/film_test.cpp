#include "image/film.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "math/sampler.h"

using image::Film;
using math::Vec3;

namespace {
Vec3 random(int i) {
  const math::Vec4 u =
      math::Sampler(math::Sampler::Kind::random, 11, 0, 0, 0, static_cast<std::uint32_t>(i)).get(0);
  return {u.x, u.y, u.z};
}
}  // namespace

// Mitsuba 2 issue 82: .5054 at 1e7 samples, 1 at 1e8.
TEST(Film, TheMeanDoesNotDependOnTheNumberOfSamples) {
  for (int count : {100000, (1 << 24) + 1, 100000000}) {
    Film film(1, 1, 1);
    for (int i = 0; i < count; ++i) film.add(0, 0, 0, Vec3(.5f, 1e-3f, .3f));
    EXPECT_EQ(film.samples(0, 0), count);
    EXPECT_NEAR(film.mean(0, 0).x, .5, 1e-7);
    EXPECT_NEAR(film.mean(0, 0).y, 1e-3f, 1e-9);
    EXPECT_NEAR(film.mean(0, 0).z, .3f, 1e-7);
  }
}

TEST(Film, TheMeanOfUniformNumbersIsTheirMeanInDouble) {
  Film film(1, 1, 4);
  double sum = 0;
  constexpr int count = 10000000;
  for (int i = 0; i < count; ++i) {
    const Vec3 u = random(i);
    sum += u.x;
    film.add(0, 0, i % 4, u);
  }
  EXPECT_NEAR(film.mean(0, 0).x, sum / count, 1e-7);
  EXPECT_NEAR(film.mean(0, 0).x, .5, 4.5 / std::sqrt(12. * count));  // 4.5 sigma, and a fixed seed
}

TEST(Film, ABrightSampleBeforeOrAfterManyDimOnesCountsTheSame) {
  Film before(1, 1, 1), after(1, 1, 1);
  before.add(0, 0, 0, Vec3(1e8f));
  for (int i = 0; i < 100000; ++i) before.add(0, 0, 0, Vec3(.5f)), after.add(0, 0, 0, Vec3(.5f));
  after.add(0, 0, 0, Vec3(1e8f));
  EXPECT_EQ(before.mean(0, 0), after.mean(0, 0));
  EXPECT_NEAR(before.mean(0, 0).x * 100001., 100050000, 10);  // float's own rounding of 1000.49
}

// E[x^2] - E[x]^2 in float gives -281 here.
TEST(Film, TheVarianceDoesNotCancelOnAHighMean) {
  constexpr int replicates = 4096, each = 16;
  Film film(1, 1, replicates);
  for (int i = 0; i < replicates * each; ++i) film.add(0, 0, i % replicates, Vec3(999.5f) + random(i));
  const double wanted = 1 / 12. / (replicates * each);
  // An estimate from 4096 replicates scatters by sqrt(2/4095) = 2.2 %; 3.5 of that. Float spacing at 1000 is
  // 6e-5.
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(film.variance_of_mean(0, 0)[c], wanted, .077 * wanted);
}

TEST(Film, TheVarianceIsThatOfTheReplicatesMeans) {
  Film film(1, 1, 3);
  const float values[3][2] = {{1, 2}, {4, 4}, {9, 10}};
  for (int r = 0; r < 3; ++r)
    for (float v : values[r]) film.add(0, 0, r, Vec3(v, 2 * v, 0));
  // Means 1.5, 4, 9.5 about 5: squares 12.25 + 1 + 20.25, over 2, over 3.
  EXPECT_FLOAT_EQ(film.variance_of_mean(0, 0).x, 33.5f / 6);
  EXPECT_FLOAT_EQ(film.variance_of_mean(0, 0).y, 4 * 33.5f / 6);
  EXPECT_EQ(film.variance_of_mean(0, 0).z, 0);
  EXPECT_FLOAT_EQ(film.replicate_mean(0, 0, 2).x, 9.5f);
}

// With unequal numbers of samples per replicate the estimate stays right on average.
TEST(Film, TheVarianceIsUnbiasedForUnequalReplicates) {
  double sum = 0;
  constexpr int films = 20000;
  for (int f = 0; f < films; ++f) {
    Film film(1, 1, 4);
    for (int r = 0, i = f * 16; r < 4; ++r)
      for (int k = 0; k <= 2 * r; ++k) film.add(0, 0, r, random(i++));
    sum += film.variance_of_mean(0, 0).x;
  }
  // 1/12 over 16 samples; the estimates scatter by about 0.85 of their mean.
  EXPECT_NEAR(sum / films * 12 * 16, 1, 4.5 * .85 / std::sqrt(films));
}

TEST(Film, WithFewerThanTwoReplicatesThereIsNoVariance) {
  Film film(1, 1, 4);
  EXPECT_EQ(film.variance_of_mean(0, 0), Vec3(0));
  film.add(0, 0, 2, Vec3(1));
  film.add(0, 0, 2, Vec3(2));
  EXPECT_EQ(film.variance_of_mean(0, 0), Vec3(0));
  EXPECT_EQ(film.mean(0, 0), Vec3(1.5f));
  film.add(0, 0, 0, Vec3(3));
  EXPECT_GT(film.variance_of_mean(0, 0).x, 0);
}

TEST(Film, BadSamplesAreCountedLeftOutAndTouchNoNeighbour) {
  constexpr float nan = std::numeric_limits<float>::quiet_NaN(),
                  infinity = std::numeric_limits<float>::infinity();
  Film film(3, 2, 2);
  for (int y = 0; y < 2; ++y)
    for (int x = 0; x < 3; ++x)
      for (int r = 0; r < 2; ++r) film.add(x, y, r, Vec3(static_cast<float>(1 + x + 3 * y)));
  EXPECT_EQ(film.rejected(), 0);
  for (const Vec3& bad : {Vec3(nan, 0, 0), Vec3(0, infinity, 0), Vec3(0, 0, -infinity), Vec3(1, -1e-30f, 1)})
    film.add(1, 0, 1, bad);
  film.add(2, 1, 0, Vec3(nan));
  EXPECT_EQ(film.rejected(), 5);
  EXPECT_EQ(film.samples(1, 0), 2);
  const image::Image mean = film.mean_image(), variance = film.variance_image();
  for (int y = 0; y < 2; ++y)
    for (int x = 0; x < 3; ++x) {
      EXPECT_EQ(mean.at(x, y), Vec3(static_cast<float>(1 + x + 3 * y)));
      EXPECT_EQ(variance.at(x, y), Vec3(0));
    }
  film.add(0, 0, 0, Vec3(-0.f));  // black
  EXPECT_EQ(film.rejected(), 5);
}

// scripts/mutate found the pixel of an environment map that is 1e38.
TEST(Film, TheVarianceOfHugeRadianceIsFinite) {
  Film film(2, 1, 2);
  for (int r = 0; r < 2; ++r) film.add(0, 0, r, Vec3(r == 0 ? 3e38f : 0, 1e10f * static_cast<float>(r), 0));
  EXPECT_EQ(film.rejected(), 0);
  EXPECT_EQ(film.mean(0, 0).x, 1.5e38f);
  EXPECT_EQ(film.variance_of_mean(0, 0).x, std::numeric_limits<float>::max());
  EXPECT_NEAR(film.variance_of_mean(0, 0).y, 2.5e19, 1e13);
  EXPECT_TRUE(std::isfinite(film.noise()));
}

TEST(Film, APixelWithoutSamplesIsBlack) {
  const Film film(2, 2, 3);
  EXPECT_EQ(film.mean(1, 1), Vec3(0));
  EXPECT_EQ(film.replicate_mean(1, 1, 2), Vec3(0));
  EXPECT_EQ(film.samples(1, 1), 0);
}
