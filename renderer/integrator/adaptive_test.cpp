// Adaptive sampling of pixels whose distribution is known, and of a real render. Limits are 4.5 standard
// errors of the means themselves, measured from independent pictures: with fresh seeds a right program fails
// seven times in a million.
#include "integrator/adaptive.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "integrator/render.h"
#include "math/sampler.h"

namespace integrator {
namespace {

using math::Vec3;

constexpr int size = 48, replicates = 8, pilot = 2;
constexpr double rare = .02;  // chance of a firefly of radiance 1 / rare

// Fireflies everywhere, more of them to the right; every pixel's mean is 1.
Vec3 firefly(std::uint32_t seed, int x, int y, int r, int i) {
  const math::Sampler sampler(math::Sampler::Kind::random, seed, x, y, r, static_cast<std::uint32_t>(i));
  const double chance = x < size / 2 ? rare : 4 * rare;
  return Vec3(sampler.get(0).x < chance ? static_cast<float>(1 / chance) : 0);
}

// The mean of a picture with `spp` samples: counts chosen by the other half, or, as it must not be done, by
// the replicate's own.
double picture_mean(std::uint32_t seed, int spp, bool naive, bool weigh_alike = true) {
  image::Film film(size, size, replicates);
  const auto add = [&](int x, int y, int r, int first, int last) {
    for (int i = first; i < last; ++i) film.add(x, y, r, firefly(seed, x, y, r, i));
  };
  const auto everywhere = [&](const std::function<void(int, int, int)>& body) {
    for (int y = 0; y < size; ++y)
      for (int x = 0; x < size; ++x)
        for (int r = 0; r < replicates; ++r) body(x, y, r);
  };
  everywhere([&](int x, int y, int r) { add(x, y, r, 0, pilot); });
  const NoiseMap says[2] = {{film, 0, 2, pilot}, {film, 1, 2, pilot}};
  const double level[2] = {says[0].level_of_mean(spp / replicates), says[1].level_of_mean(spp / replicates)};
  everywhere([&](int x, int y, int r) {
    const int half = naive ? r % 2 : 1 - r % 2;
    add(x, y, r, pilot, says[half].count(x, y, level[half]));
  });
  if (weigh_alike) film.weigh_replicates_alike();
  double sum = 0;
  for (int y = 0; y < size; ++y)
    for (int x = 0; x < size; ++x) sum += film.mean(x, y).x;
  return sum / (size * size);
}

struct Estimate {
  double mean = 0, error = 0;
};
Estimate estimate(const std::function<double(std::uint32_t)>& picture, int pictures) {
  double sum = 0, squares = 0;
  for (int k = 0; k < pictures; ++k) {
    const double m = picture(static_cast<std::uint32_t>(k + 1));
    sum += m, squares += m * m;
  }
  const double mean = sum / pictures;
  return {mean, std::sqrt((squares / pictures - mean * mean) / (pictures - 1))};
}

// To 1.5 % (one standard error is below .35 %). Counts by a replicate's own pilot lose light, and so does
// weighing by counts.
TEST(Adaptive, fireflies_keep_their_light_and_the_naive_way_loses_some) {
  const Estimate ours = estimate([](std::uint32_t seed) { return picture_mean(seed, 64, false); }, 60);
  EXPECT_LT(ours.error, .0035);
  EXPECT_NEAR(ours.mean, 1, 4.5 * ours.error);
  const Estimate naive = estimate([](std::uint32_t seed) { return picture_mean(seed, 64, true); }, 60);
  EXPECT_LT(naive.mean, 1 - 6 * naive.error);
  const Estimate by_counts =
      estimate([](std::uint32_t seed) { return picture_mean(seed, 64, false, false); }, 60);
  EXPECT_LT(by_counts.mean, 1 - 5 * by_counts.error);
}

TEST(Adaptive, counts_have_the_mean_asked_for_go_where_the_noise_is_and_never_shrink) {
  image::Film film(size, size, replicates);
  for (int y = 0; y < size; ++y)
    for (int x = 0; x < size; ++x)
      for (int r = 0; r < replicates; ++r) {
        const math::Sampler sampler(math::Sampler::Kind::random, 1, x, y, r, 0);
        const float noise = (sampler.get(0).x - .5f) * (x < size / 2 ? .1f : .5f);
        for (int i = 0; i < pilot; ++i) film.add(x, y, r, Vec3(1 + noise));
      }
  const NoiseMap map(film, 0, 2, pilot);
  double last = 0;
  std::vector<int> before(size * size, pilot);
  for (const double mean : {2., 3., 8., 64., 1000.}) {
    const double level = map.level_of_mean(mean);
    EXPECT_GE(level, last);
    last = level;
    double sum[2] = {0, 0}, away[2] = {0, 0};  // away from the border between the halves
    for (int y = 0; y < size; ++y)
      for (int x = 0; x < size; ++x) {
        const int count = map.count(x, y, level);
        int& least = before[static_cast<size_t>(y * size + x)];
        ASSERT_GE(count, least);
        least = count;
        sum[x < size / 2 ? 0 : 1] += count / (.5 * size * size);
        if (x < size / 2 - 4 || x >= size / 2 + 4) away[x < size / 2 ? 0 : 1] += count;
      }
    EXPECT_NEAR((sum[0] + sum[1]) / 2 / mean, 1, .02) << mean;
    if (mean > 20) {
      EXPECT_NEAR(away[1] / away[0], std::pow(25, .4), .2) << mean;  // variances as 25 to 1
    }
  }
}

// Two replicates of 8 samples, of which 2 and 5 came early: what the other's three groups say.
TEST(Adaptive, with_two_replicates_their_parts_show_the_noise_and_no_light_is_lost) {
  constexpr int each = 8;
  const auto picture = [&](std::uint32_t seed, double* ratio) {
    image::Film film(size, size, 2);
    const auto add = [&](int x, int y, int r, int first, int last) {
      for (int i = first; i < last; ++i) film.add(x, y, r, firefly(seed, x, y, r, i));
    };
    const auto everywhere = [&](const std::function<void(int, int, int)>& body) {
      for (int y = 0; y < size; ++y)
        for (int x = 0; x < size; ++x)
          for (int r = 0; r < 2; ++r) body(x, y, r);
    };
    std::vector<NoiseMap::Early> early;
    int done = 0;
    for (const int until : {2, 5, each}) {
      if (done > 0) early.push_back({film, done});
      everywhere([&](int x, int y, int r) { add(x, y, r, done, until); });
      done = until;
    }
    film.weigh_replicates_alike();
    const NoiseMap says[2] = {{film, 0, each, early}, {film, 1, each, early}};
    const double level[2] = {says[0].level_of_mean(40), says[1].level_of_mean(40)};
    double counts[2] = {0, 0};
    everywhere([&](int x, int y, int r) {
      const int count = says[1 - r].count(x, y, level[1 - r]);
      counts[x < size / 2] += count;
      add(x, y, r, each, count);
    });
    *ratio = counts[1] / counts[0];
    double sum = 0;
    for (int y = 0; y < size; ++y)
      for (int x = 0; x < size; ++x) sum += film.mean(x, y).x;
    return sum / (size * size);
  };
  double ratio = 0, ratios = 0;
  const Estimate ours = estimate(
      [&](std::uint32_t seed) {
        const double mean = picture(seed, &ratio);
        ratios += ratio / 60;
        return mean;
      },
      60);
  EXPECT_LT(ours.error, .0045);
  EXPECT_NEAR(ours.mean, 1, 4.5 * ours.error);
  EXPECT_GT(ratios, 1.3);  // variances are as 4.3 to 1: 4.3^0.4 is 1.8, less what the pilot gives to all
}

TEST(Adaptive, a_picture_without_noise_stays_with_its_pilot) {
  image::Film film(4, 4, replicates);
  for (int y = 0; y < 4; ++y)
    for (int x = 0; x < 4; ++x)
      for (int r = 0; r < replicates; ++r) film.add(x, y, r, Vec3(.5f));
  const NoiseMap map(film, 1, 2, 1);
  EXPECT_EQ(map.count(1, 2, map.level_of_mean(100)), 1);
  EXPECT_EQ(map.mean_for_noise(.01, 1000, map), 1);
}

// Uniform noise of standard deviation s: n samples in all leave s / sqrt(n).
TEST(Adaptive, the_total_for_a_noise_is_what_reaches_it) {
  image::Film film(64, 64, replicates);
  for (int y = 0; y < 64; ++y)
    for (int x = 0; x < 64; ++x)
      for (int r = 0; r < replicates; ++r)
        for (int i = 0; i < 4; ++i) {
          const math::Sampler sampler(math::Sampler::Kind::random, 2, x, y, r, static_cast<std::uint32_t>(i));
          film.add(x, y, r, Vec3(2 * sampler.get(0).x));  // mean 1, deviation 1 / sqrt(3)
        }
  EXPECT_NEAR(film.noise(), std::sqrt(1 / 3. / 32), .002);
  const NoiseMap a(film, 0, 4, 4), b(film, 2, 4, 4);
  const double wanted = .02;
  EXPECT_NEAR(a.mean_for_noise(wanted, 1e6, b) * replicates / (1 / 3. / (wanted * wanted)), 1, .1);
  EXPECT_EQ(a.mean_for_noise(1e-9, 100, b), 100);
}

}  // namespace
}  // namespace integrator
