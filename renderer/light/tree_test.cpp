// Fixed seeds. Chi-squared tests have limits of 4.5 standard deviations: fresh seeds would fail a right tree
// three times in a million.
#include "light/tree.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace light {
namespace {

using math::Vec3;

struct Random {
  std::mt19937 bits{11};
  float operator()() { return static_cast<float>(bits() >> 8) * 0x1p-24f; }
  Vec3 direction() { return math::normalize(Vec3((*this)() - .5f, (*this)() - .5f, (*this)() - .5f)); }
};

// Small planar lights in a slab of unit height, some two-sided, some points, of intensities from 1 to e^4.
std::vector<Bounds> lights(int n, Random& random) {
  std::vector<Bounds> result;
  for (int i = 0; i < n; ++i) {
    const Vec3 p(4 * random() - 2, random(), 4 * random() - 2), half(.05f * random());
    Bounds b{p - half, p + half, random.direction(), 1, 0, random() < .3f, std::exp(4 * random())};
    if (random() < .2f) b.low = b.high = p, b.cos_normals = -1;
    result.push_back(b);
  }
  return result;
}

Receiver receiver(Random& random) {
  return {{6 * random() - 3, 2 * random() - .5f, 6 * random() - 3}, random.direction()};
}

double sum_of(const Tree& tree, const Receiver& r, int n) {
  double sum = 0;
  for (int i = 0; i < n; ++i) sum += static_cast<double>(tree.probability(r, i));
  return sum;
}

// Points around a receiver's bright side reach it all: no way down ends without a light.
TEST(Tree, probabilities_sum_to_one_from_1_to_100000_lights) {
  for (const int n : {1, 2, 3, 31, 32, 33, 129, 1000, 100000}) {
    Random random;
    std::vector<Bounds> points = lights(n, random);
    for (Bounds& b : points) b.low = b.high, b.cos_normals = -1;
    const Tree tree(points, {{2, Vec3(0)}, {3, Vec3(0, 1, 0)}});
    for (int k = 0; k < (n > 10000 ? 1 : 30); ++k) {
      const Receiver r{{6 * random() - 3, -.01f, 6 * random() - 3}, {0, 1, 0}};
      EXPECT_NEAR(sum_of(tree, r, n + 2), 1, 1e-5) << n;
    }
  }
}

TEST(Tree, a_choice_carries_the_probability_that_is_asked_for_later) {
  Random random;
  const int n = 3000;
  const Tree tree(lights(n, random), {{100, Vec3(0, 1, 0)}});
  int found = 0;
  for (int k = 0; k < 20000; ++k) {
    const Receiver r = receiver(random);
    const auto choice = tree.sample(r, static_cast<double>(random()) + random() * 0x1p-24);
    if (!choice) continue;
    ++found;
    ASSERT_GT(choice->probability, 0);
    ASSERT_NEAR(tree.probability(r, choice->light) / choice->probability, 1, 1e-5);
  }
  EXPECT_GT(found, 15000);
}

TEST(Tree, lights_are_chosen_as_often_as_their_probability_says) {
  Random random;
  const int n = 500, draws = 400000;
  const Tree tree(lights(n, random), {{20, Vec3(0, 1, 0)}, {5, Vec3(0)}});
  for (int k = 0; k < 4; ++k) {
    const Receiver r = receiver(random);
    std::vector<double> count(n + 3);  // the last: no light
    for (int i = 0; i < draws; ++i) {
      const auto choice = tree.sample(r, (i + static_cast<double>(random())) / draws);
      ++count[static_cast<size_t>(choice ? choice->light : n + 2)];
    }
    // Stratified draws: a light's intervals of u are few, so each count is within some of its expectation.
    double worst = 0;
    for (int i = 0; i < n + 2; ++i)
      worst = std::max(worst, std::fabs(count[static_cast<size_t>(i)] -
                                        draws * static_cast<double>(tree.probability(r, i))));
    EXPECT_LT(worst, 3);
    EXPECT_NEAR(count[n + 2], draws * (1 - sum_of(tree, r, n + 2)), 300);
  }
}

// The irradiance of a small light of `intensity` per projected area; what the tree's estimate bounds.
float sends(const Bounds& b, const Receiver& r) {
  const Vec3 d = (b.low + b.high) * .5f - r.from;
  const float d2 = math::dot(d, d);
  const Vec3 wi = d / std::sqrt(d2);
  float cosine = -math::dot(b.axis, wi);
  if (b.two_sided) cosine = std::fabs(cosine);
  if (b.cos_normals < 0) cosine = 1;
  return b.intensity * std::max(0.f, cosine) * std::max(0.f, math::dot(r.normal, wi)) / d2;
}

// The sum of all lights, each sample divided by its probability, is that of weighing every one: without bias,
// and with less noise than choosing by power. Limits of 4.5 standard errors.
TEST(Tree, the_sum_of_all_lights_is_found_from_1_to_100000) {
  for (const int n : {1, 2, 40, 1000, 100000}) {
    Random random;
    const std::vector<Bounds> all = lights(n, random);
    const Tree tree(all, {});
    double power = 0;
    for (const Bounds& b : all) power += b.intensity;
    for (int k = 0; k < (n > 10000 ? 1 : 4); ++k) {
      const Receiver r = receiver(random);
      double exact = 0, by_power = 0;
      for (size_t i = 0; i < all.size(); ++i) {
        const double f = sends(all[i], r);
        exact += f;
        by_power += f * f * power / all[i].intensity;
        if (f > 0) {
          ASSERT_GT(tree.probability(r, static_cast<int>(i)), 0) << n;
        }
      }
      const int draws = 20000;
      double sum = 0, squares = 0;
      for (int i = 0; i < draws; ++i) {
        const auto choice = tree.sample(r, static_cast<double>(random()) + random() * 0x1p-24);
        const double f = choice ? sends(all[static_cast<size_t>(choice->light)], r) / choice->probability : 0;
        sum += f, squares += f * f;
      }
      const double mean = sum / draws, variance = std::max(0., squares / draws - mean * mean);
      EXPECT_NEAR(mean, exact, 4.5 * std::sqrt(variance / draws) + 1e-5 * exact) << n;
      if (n >= 40) {
        EXPECT_LT(variance, .5 * (by_power - exact * exact)) << n;
      }
    }
  }
}

TEST(Tree, lights_behind_the_surface_and_facing_away_are_never_chosen) {
  const Bounds above{{-.1f, 1, -.1f}, {.1f, 1, .1f}, {0, -1, 0}, 1, 0, false, 1};
  Bounds below = above, away = above;
  below.low.y = below.high.y = -1, below.axis = {0, 1, 0};
  away.axis = {0, 1, 0};
  const Tree tree({above, below, away}, {{1, Vec3(0, -1, 0)}});
  const Receiver r{{0, 0, 0}, {0, 1, 0}};
  EXPECT_EQ(tree.probability(r, 0), 1);
  EXPECT_EQ(sum_of(tree, r, 4), 1);
  away.two_sided = true;
  EXPECT_EQ(Tree({above, below, away}, {}).probability(r, 2), .5f);
}

// A thousand lights in one place, each as good as the other: nothing to split by.
TEST(Tree, lights_that_coincide_are_halved) {
  const std::vector<Bounds> same(1000, Bounds{Vec3(1), Vec3(1), {0, 0, 1}, -1, 0, false, 1});
  const Tree tree(same, {});
  const Receiver r{Vec3(0), Vec3(0, 1, 0)};
  EXPECT_NEAR(sum_of(tree, r, 1000), 1, 1e-5);
  for (int i = 0; i < 1000; ++i) ASSERT_NEAR(tree.probability(r, i), .001f, .001f);
}

}  // namespace
}  // namespace light
