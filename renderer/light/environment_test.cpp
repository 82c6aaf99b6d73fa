// Directions drawn from an environment, against sums over its map.
#include "light/environment.h"

#include <gtest/gtest.h>

#include <cmath>

#include "math/sampler.h"

namespace light {
namespace {

using math::Vec3;

// A grey sky, darker towards the ground, with a sun of 3 x 2 texels.
scene::Environment sky(float rotation = .7f) {
  scene::Environment e;
  e.rotation = rotation;
  e.map.width = 128, e.map.height = 64;
  for (int y = 0; y < 64; ++y)
    for (int x = 0; x < 128; ++x) {
      const bool sun = x >= 40 && x < 43 && y >= 12 && y < 14;
      e.map.texels.push_back(math::Vec4(Vec3(sun ? 2000.f : .2f + .01f * static_cast<float>(64 - y)), 1));
    }
  return e;
}

TEST(Environment, what_a_sample_says_is_what_its_direction_shows) {
  const scene::Environment e = sky();
  const Environment environment(e);
  for (int i = 0; i < 20000; ++i) {
    const math::Vec4 u = math::Sampler(math::Sampler::Kind::random, 1, i, 0, 0, 0).get(0);
    const Environment::Sample s = environment.sample(u.x, u.y);
    EXPECT_NEAR(math::length(s.direction), 1, 1e-6);
    const Environment::Seen seen = environment.look(s.direction);
    // Rounding may put a direction at a cell's edge into the next.
    const bool edge = std::fabs(seen.pdf / s.seen.pdf - 1) > 1e-4f;
    if (edge) {
      const math::Vec3 nearby =
          environment.look(math::normalize(s.direction + Vec3(1e-5f, 2e-5f, -1e-5f))).radiance;
      EXPECT_NEAR(nearby.x / s.seen.radiance.x, 1, .05);
      continue;
    }
    ASSERT_NEAR(seen.radiance.x / s.seen.radiance.x, 1, 2e-3) << i;
  }
}

// The mean of radiance over density is the light of the whole sphere: a sum of the map over fine cells.
TEST(Environment, samples_bring_all_of_its_light) {
  const scene::Environment e = sky();
  const Environment environment(e);
  double wanted = 0;
  constexpr int rows = 1280, columns = 2560;
  for (int j = 0; j < rows; ++j) {
    const double theta = math::pi * (j + .5) / rows;
    for (int i = 0; i < columns; ++i) {
      const double phi = 2 * math::pi * (i + .5) / columns;
      const Vec3 d(static_cast<float>(std::sin(theta) * std::cos(phi)), static_cast<float>(std::cos(theta)),
                   static_cast<float>(std::sin(theta) * std::sin(phi)));
      wanted += double{environment.radiance(d).x} * std::sin(theta) * 2 * math::pi * math::pi /
                (double{rows} * columns);
    }
  }
  double found = 0;
  constexpr int n = 700;
  for (int j = 0; j < n; ++j)
    for (int i = 0; i < n; ++i) {
      const auto s = environment.sample((static_cast<float>(i) + .5f) / n, (static_cast<float>(j) + .5f) / n);
      found += double{s.seen.radiance.x} / s.seen.pdf / (n * n);
    }
  EXPECT_NEAR(found / wanted, 1, 1e-3);
}

// Well distributed numbers stay so: of 64 samples as many see the sun as should, give or take one at each of
// its four edges. Chosen at random the count would have a standard deviation of 4: an alias table's did.
TEST(Environment, the_suns_share_of_sobol_samples_is_its_share_of_light) {
  const scene::Environment e = sky(0);
  const Environment environment(e);
  const Vec3 sun = [] {
    const float phi = 2 * math::pi * (41.5f / 128 - .5f), theta = math::pi * 13 / 64;
    return Vec3(std::sin(theta) * std::cos(phi), std::cos(theta), std::sin(theta) * std::sin(phi));
  }();
  double squares = 0, sum = 0;
  constexpr int pixels = 400;
  for (int pixel = 0; pixel < pixels; ++pixel) {
    int count = 0;
    for (std::uint32_t i = 0; i < 64; ++i) {
      const math::Vec4 u = math::Sampler(math::Sampler::Kind::sobol, 1, pixel, 0, 0, i).get(1);
      count += math::dot(environment.sample(u.x, u.y).direction, sun) > std::cos(.15f);
    }
    sum += count, squares += count * count;
  }
  const double mean = sum / pixels, deviation = std::sqrt(squares / pixels - mean * mean);
  EXPECT_GT(mean, 16);
  EXPECT_LT(mean, 60);
  EXPECT_LT(deviation, 1.2);
}

}  // namespace
}  // namespace light
