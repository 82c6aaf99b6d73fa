// Directions drawn from an environment, against sums over its map.
#include "light/environment.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

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
  const Environment environment(e, true);
  int edges = 0;
  for (int i = 0; i < 20000; ++i) {
    const math::Vec4 u = math::Sampler(math::Sampler::Kind::random, 1, i, 0, 0, 0).get(0);
    const Environment::Sample s = environment.sample(u.x, u.y);
    EXPECT_NEAR(math::length(s.direction), 1, 1e-6);
    const Environment::Seen seen = environment.look(s.direction);
    // Rounding may put a direction at a cell's edge into the next.
    const bool edge = std::fabs(seen.pdf / s.seen.pdf - 1) > 1e-4f;
    if (edge) {
      ++edges;
      const math::Vec3 nearby =
          environment.look(math::normalize(s.direction + Vec3(1e-5f, 2e-5f, -1e-5f))).radiance;
      EXPECT_NEAR(nearby.x / s.seen.radiance.x, 1, .05);
      continue;
    }
    ASSERT_NEAR(seen.radiance.x / s.seen.radiance.x, 1, 2e-3) << i;
  }
  EXPECT_LT(edges, 20);
}

// The mean of radiance over density is the light of the whole sphere: a sum of the map over fine cells.
TEST(Environment, samples_bring_all_of_its_light) {
  const scene::Environment e = sky();
  const Environment environment(e, true);
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
  const Environment environment(e, true);
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

// A bright belt over an even ground: the density in it is what it has above the mean over the flux of that,
// by double precision, and nothing else is drawn.
TEST(Environment, beside_bsdf_samples_only_what_lies_above_the_mean_is_drawn) {
  scene::Environment e;
  e.map.width = 64, e.map.height = 256;
  const auto in_belt = [](int row) { return row >= 64 && row < 128; };
  for (int y = 0; y < 256; ++y)
    for (int x = 0; x < 64; ++x) e.map.texels.push_back(math::Vec4(Vec3(in_belt(y) ? 5.f : 1.f), 1));
  const Environment environment(e, false);
  ASSERT_TRUE(environment.sampled());

  const double belt = std::sqrt(.5) / 2;  // its share of the sphere: z from 0 to cos 45 degrees
  const double mean = 1 + 4 * belt, drawn = (5 - mean) * belt;
  EXPECT_NEAR(environment.drawn_luminance() / drawn, 1, .01);  // cells at its edges are bilinear means
  const Vec3 inside(.8f, .6f, 0), outside(.8f, -.6f, 0);
  EXPECT_NEAR(environment.look(inside).pdf * (belt * 4 * std::numbers::pi), 1, .01);
  EXPECT_EQ(environment.look(outside).pdf, 0);
  EXPECT_EQ(environment.look(outside).radiance.x, 1);
  for (int i = 0; i < 2000; ++i) {
    const math::Vec4 u = math::Sampler(math::Sampler::Kind::random, 1, i, 0, 0, 0).get(0);
    const Environment::Sample s = environment.sample(u.x, u.y);
    const double row = std::acos(double{s.direction.y}) / std::numbers::pi * 256;
    ASSERT_TRUE(row > 63 && row < 129) << row;
    ASSERT_GT(s.seen.pdf, 0);
  }
}

TEST(Environment, an_even_one_is_left_to_bsdf_samples_unless_there_are_none) {
  scene::Environment e;
  e.map.width = 16, e.map.height = 8;
  for (int i = 0; i < 300; ++i) {  // however its bilinear mean is rounded
    const float grey = .00713f * static_cast<float>(i + 1);
    e.map.texels.assign(16 * 8, math::Vec4(Vec3(grey), 1));
    EXPECT_FALSE(Environment(e, false).sampled()) << grey;
  }
  ASSERT_TRUE(Environment(e, true).sampled());
  EXPECT_NEAR(Environment(e, true).look(Vec3(.6f, -.8f, 0)).pdf * 4 * math::pi, 1, 1e-4);
}

}  // namespace
}  // namespace light
