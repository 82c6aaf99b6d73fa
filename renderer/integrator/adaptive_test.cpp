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
  math::Sampler sampler(math::Sampler::Kind::random, seed, x, y, r, static_cast<std::uint32_t>(i));
  const double chance = x < size / 2 ? rare : 4 * rare;
  return Vec3(sampler.get(0).x < chance ? static_cast<float>(1 / chance) : 0);
}

// A picture with `spp` samples, its counts chosen by the other colour or, as it must not be done, by the
// pixel's own; `few`: one replicate, whose parts show the noise. The mean, and how many times as many samples
// the left half has.
struct Picture {
  double mean, ratio;
};
Picture picture(std::uint32_t seed, int spp, bool naive, bool few) {
  const int parts = few ? 1 : replicates, each = few ? 8 : 2;
  image::Film film(size, size, parts);
  std::vector<NoiseMap::Early> early;
  const auto everywhere = [&](const std::function<void(int, int, int)>& body) {
    for (int y = 0; y < size; ++y)
      for (int x = 0; x < size; ++x)
        for (int r = 0; r < parts; ++r) body(x, y, r);
  };
  const auto add = [&](int x, int y, int r, int first, int last) {
    for (int i = first; i < last; ++i) film.add(x, y, r, firefly(seed, x, y, r, i));
  };
  int done = 0;
  for (const int until : {2, 5, each}) {
    if (until > each) break;
    if (done > 0) early.push_back({film, done});
    everywhere([&](int x, int y, int r) { add(x, y, r, done, until); });
    done = until;
  }
  if (!few) early.clear();
  const Plan plan(NoiseMap(film, 0, each, early), NoiseMap(film, 1, each, early));
  const double mean = static_cast<double>(spp) / parts;
  const Plan::Levels levels = plan.levels_of_mean({mean, mean});
  double counts[2] = {0, 0};
  everywhere([&](int x, int y, int r) {
    // The block beside has the other colour: what it is told comes from this pixel and others of its colour.
    const int count = plan.count(naive ? x ^ block_side : x, y, levels);
    counts[x < size / 2] += count;
    add(x, y, r, each, count);
  });
  double sum = 0;
  for (int y = 0; y < size; ++y)
    for (int x = 0; x < size; ++x) sum += film.mean(x, y).x;
  return {sum / (size * size), counts[1] / counts[0]};
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

// To 2 % (one standard error is below .45 %). Counts by a pixel's own pilot lose light.
TEST(Adaptive, fireflies_keep_their_light_and_the_naive_way_loses_some) {
  for (const bool few : {false, true}) {
    double ratio = 0;
    const Estimate ours = estimate(
        [&](std::uint32_t seed) {
          const Picture p = picture(seed, 64, false, few);
          ratio += p.ratio / 60;
          return p.mean;
        },
        60);
    EXPECT_LT(ours.error, .0045) << few;
    EXPECT_NEAR(ours.mean, 1, 4.5 * ours.error) << few;
    EXPECT_GT(ratio, 1.3)
        << few;  // variances are as 4.3 to 1: 4.3^0.4 is 1.8, less what the pilot gives to all
    const Estimate naive =
        estimate([&](std::uint32_t seed) { return picture(seed, 64, true, few).mean; }, 60);
    EXPECT_LT(naive.mean, 1 - 6 * naive.error) << few;
  }
}

TEST(Adaptive, counts_have_the_mean_asked_for_go_where_the_noise_is_and_never_shrink) {
  image::Film film(size, size, replicates);
  for (int y = 0; y < size; ++y)
    for (int x = 0; x < size; ++x)
      for (int r = 0; r < replicates; ++r) {
        math::Sampler sampler(math::Sampler::Kind::random, 1, x, y, r, 0);
        const float noise = (sampler.get(0).x - .5f) * (x < size / 2 ? .1f : .5f);
        for (int i = 0; i < pilot; ++i) film.add(x, y, r, Vec3(1 + noise));
      }
  const NoiseMap map(film, 0, pilot);
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

// What camera rays find differs to the left, paths from one of them to the right, so that both halves have
// the same variance.
TEST(Adaptive, paths_share_camera_rays_where_it_is_the_paths_that_differ) {
  constexpr int rays = 8;
  image::Film film(size, size, replicates);
  const image::Film data(size, size, replicates, image::Film::Holds::data);
  Spread spread{data, data};
  for (int y = 0; y < size; ++y)
    for (int x = 0; x < size; ++x)
      for (int r = 0; r < replicates; ++r)
        for (int i = 0; i < rays; ++i) {
          math::Sampler sampler(math::Sampler::Kind::random, 4, x, y, r, static_cast<std::uint32_t>(i));
          const math::Vec4 u = sampler.get(0);
          const float found = x < size / 2 ? .9f * u.x : 0, rest = x < size / 2 ? .1f : .9f;
          const Vec3 a(found + rest * u.y), b(found + rest * u.z), half = (a + b) * .5f;
          film.add(x, y, r, a), film.add(x, y, r, b);
          spread.pairs.add(x, y, r, {dot(a - b, a - b) / 2, dot(half, half), 0});
        }
  const auto of = [&](double path_rays) { return NoiseMap(film, 0, 2 * rays, {}, &spread, path_rays); };
  EXPECT_EQ(of(2).together(3, 3), 1);
  EXPECT_EQ(of(2).together(size - 4, 3), 4);
  EXPECT_EQ(of(1e9).together(size - 4, 3), 1);  // camera rays cost nothing beside such paths
  EXPECT_EQ(NoiseMap(film, 0, 2 * rays).together(size - 4, 3), 1);
  // Where no path goes on from what is seen, camera rays are all there is.
  image::Film seen(size, size, replicates);
  const Spread alike{data, data};
  for (int i = 0; i < 2 * size * size; ++i)
    seen.add(i / 2 % size, i / 2 / size, i % 2, Vec3(static_cast<float>(i % 3)));
  EXPECT_EQ(NoiseMap(seen, 0, 1, {}, &alike, 0).together(3, 3), 1);
  // Counts are whole camera rays, four by four.
  const NoiseMap map = of(2);
  for (int x = 0; x < size; ++x)
    EXPECT_EQ((map.count(x, 5, map.level_of_mean(100)) - 2 * rays) % (4 * map.together(x, 5)), 0) << x;
}

// Shared light is a third as noisy to the left, nearly as noisy as it was to the right; a pair has 10 rays
// and 4 more for reuse.
TEST(Adaptive, paths_are_reused_where_that_is_worth_its_rays) {
  const image::Film data(size, size, 1, image::Film::Holds::data);
  const auto map = [&](float own, float rays) {
    Spread spread{data, data};
    for (int y = 0; y < size; ++y)
      for (int x = 0; x < size; ++x) {
        spread.pairs.add(x, y, 0, {1, 1, rays});
        spread.reuse.add(x, y, 0, {own, x < size / 2 ? .3f : .9f, 1});
      }
    return ReuseMap(spread, static_cast<std::uint64_t>(10 + rays) * size * size);
  };
  const ReuseMap quiet = map(0, 4), noisy = map(20, 4), dear = map(0, 30), free = map(0, 0);
  for (int y = 0; y < size; ++y)
    for (const int x : {0, 1, 2, 9, size - 10, size - 2, size - 1}) {
      const bool left = x < size / 2;
      EXPECT_EQ(quiet.at(x, y), left);
      EXPECT_FALSE(noisy.at(x, y));  // 4 to 1 with direct light
      EXPECT_FALSE(dear.at(x, y));
      EXPECT_TRUE(free.at(x, y));
    }
  // The other colour decides: noise of one colour alone is acted on by the other alone.
  Spread spread{data, data};
  for (int y = 0; y < size; ++y)
    for (int x = 0; x < size; ++x) {
      spread.pairs.add(x, y, 0, {1, 1, 4});
      spread.reuse.add(x, y, 0, {0, checkerboard(x, y) == 0 ? .3f : .9f, 1});
    }
  const ReuseMap other(spread, 14 * size * size);
  for (int y = 0; y < size; ++y)
    for (int x = 0; x < size; ++x) EXPECT_EQ(other.at(x, y), checkerboard(x, y) == 1);
}

TEST(Adaptive, a_picture_without_noise_stays_with_its_pilot) {
  image::Film film(4, 4, replicates);
  for (int y = 0; y < 4; ++y)
    for (int x = 0; x < 4; ++x)
      for (int r = 0; r < replicates; ++r) film.add(x, y, r, Vec3(.5f));
  const NoiseMap map(film, 1, 1);
  EXPECT_EQ(map.count(1, 2, map.level_of_mean(100)), 1);
  EXPECT_EQ(map.mean_for_noise(.01, 1000), 1);
}

// Uniform noise of standard deviation s: n samples in all leave s / sqrt(n).
TEST(Adaptive, the_total_for_a_noise_is_what_reaches_it) {
  image::Film film(64, 64, replicates);
  for (int y = 0; y < 64; ++y)
    for (int x = 0; x < 64; ++x)
      for (int r = 0; r < replicates; ++r)
        for (int i = 0; i < 4; ++i) {
          math::Sampler sampler(math::Sampler::Kind::random, 2, x, y, r, static_cast<std::uint32_t>(i));
          film.add(x, y, r, Vec3(2 * sampler.get(0).x));  // mean 1, deviation 1 / sqrt(3)
        }
  EXPECT_NEAR(film.noise(), std::sqrt(1 / 3. / 32), .002);
  const NoiseMap map(film, 0, 4);
  const double wanted = .02;
  EXPECT_NEAR(map.mean_for_noise(wanted, 1e6) * replicates / (1 / 3. / (wanted * wanted)), 1, .1);
  EXPECT_EQ(map.mean_for_noise(1e-9, 100), 100);
}

// The same of one replicate with independent samples: its parts, of 2, 3 and 3 samples, show the variance.
TEST(Adaptive, parts_of_one_replicate_show_the_variance) {
  constexpr int side = 128;
  image::Film film(side, side, 1);
  std::vector<NoiseMap::Early> early;
  int done = 0;
  for (const int until : {2, 5, 8}) {
    if (done > 0) early.push_back({film, done});
    for (int y = 0; y < side; ++y)
      for (int x = 0; x < side; ++x)
        for (int i = done; i < until; ++i) {
          math::Sampler sampler(math::Sampler::Kind::random, 3, x, y, 0, static_cast<std::uint32_t>(i));
          film.add(x, y, 0, Vec3(2 * sampler.get(0).x));
        }
    done = until;
  }
  const NoiseMap map(film, 0, 8, early);
  const double wanted = .02;
  EXPECT_NEAR(map.mean_for_noise(wanted, 1e6) / (1 / 3. / (wanted * wanted)), 1, .05);
}

}  // namespace
}  // namespace integrator
