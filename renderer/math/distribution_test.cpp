#include "math/distribution.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numeric>

#include "math/sampler.h"

using math::Distribution1D;

namespace {

Distribution1D make(std::initializer_list<double> weights) {
  return Distribution1D(std::span<const double>(weights.begin(), weights.size()));
}

math::Vec4 random(int i) {
  return math::Sampler(math::Sampler::Kind::random, 7, 0, 0, 0, static_cast<std::uint32_t>(i)).get(0);
}

// Values of u where a mistake would show: the ends, and each slot's border with its neighbours in float.
std::vector<float> edges(std::uint32_t slots) {
  std::vector<float> all = {0, 0x1p-149f, 0x1p-24f, math::largest_u};
  for (std::uint32_t i = 1; i < slots; ++i) {
    const float edge = static_cast<float>(i) / static_cast<float>(slots);
    for (float u : {std::nextafter(edge, 0.f), edge, std::nextafter(edge, 1.f)}) all.push_back(u);
  }
  return all;
}

// The probabilities that the alias table really gives, by a fine regular grid of u.
std::vector<double> frequencies(const Distribution1D& d, int n) {
  std::vector<double> count(d.size());
  for (int i = 0; i < n; ++i) count[d.sample((i + .5) / n).index] += 1. / n;
  return count;
}

}  // namespace

TEST(Distribution, NothingToChooseFromIsEmpty) {
  EXPECT_TRUE(Distribution1D().empty());
  EXPECT_TRUE(make({}).empty());
  EXPECT_TRUE(make({0, 0, 0}).empty());
  EXPECT_FALSE(make({0, 1e-300, 0}).empty());
}

TEST(Distribution, AnEntryOfWeightZeroIsNeverChosen) {
  const Distribution1D d = make({0, 1, 0, 2, 0});
  for (float u : edges(5)) {
    const auto s = d.sample(u);
    EXPECT_TRUE(s.index == 1 || s.index == 3) << u;
    EXPECT_GT(s.probability, 0);
  }
  const auto found = frequencies(d, 300000);
  EXPECT_NEAR(found[1], 1 / 3., 1e-5);
  EXPECT_NEAR(found[3], 2 / 3., 1e-5);
}

TEST(Distribution, ZerosAmongWeightsThatRoundingLeavesOverAreNotChosen) {
  // Thirds, tenths and zeros leave rests on both lists of the builder.
  for (int n = 3; n < 200; ++n) {
    std::vector<double> weights;
    for (int i = 0; i < n; ++i) weights.push_back(i % 3 == 1 ? 0 : .1 + (i * 7 % 5) / 3.);
    const Distribution1D d(weights);
    for (float u : edges(d.size())) {
      const auto s = d.sample(u);
      ASSERT_GT(weights[s.index], 0) << n << " " << u;
      ASSERT_EQ(s.probability, d.probability(s.index));
    }
  }
}

// Rounding may use up the last giver one zero too early.
TEST(Distribution, AFewWeightsAmongManyZerosServeAllOfThem) {
  for (std::size_t n = 4; n < 400; ++n) {
    std::vector<double> weights(n);
    weights[0] = .1, weights[n / 2] = .7, weights[n - 1] = 1 / 3.;
    const Distribution1D d(weights);
    for (std::size_t slot = 0; slot < n; ++slot)
      for (double within : {0., .5, .999}) {
        const auto s = d.sample((static_cast<double>(slot) + within) / static_cast<double>(n));
        ASSERT_GT(weights[s.index], 0) << n;
      }
  }
}

TEST(Distribution, RemappedNumberStaysBelowOne) {
  const Distribution1D d = make({1, 1e-8, 1});
  for (float u : edges(3)) {
    const auto s = d.sample(u);
    EXPECT_GE(s.u, 0);
    EXPECT_LT(s.u, 1) << u;
  }
  // 48 bits, closer to 1 than a float can be.
  for (int entries = 1; entries < 50; ++entries) {
    const auto s = Distribution1D(std::vector<double>(static_cast<std::size_t>(entries), 1))
                       .sample(math::join(math::largest_u, math::largest_u));
    EXPECT_EQ(s.index + 1, static_cast<std::uint32_t>(entries));
    EXPECT_LT(s.u, 1);
  }
  for (int i = 0; i < 10000000; ++i) {
    const auto s = d.sample((i + .5) * 1e-7);
    ASSERT_TRUE(s.u >= 0 && s.u < 1) << i;
  }
}

TEST(Distribution, RemappedNumberIsUniformAndIndependentOfTheIndex) {
  const Distribution1D d = make({1, 5, 2, .3});
  double count[4] = {}, sum[4] = {}, squares[4] = {};
  for (int i = 0; i < 1000000; ++i) {
    const auto s = d.sample((i + .5) * 1e-6);
    ++count[s.index], sum[s.index] += s.u, squares[s.index] += double{s.u} * s.u;
  }
  for (int i = 0; i < 4; ++i) {
    EXPECT_NEAR(sum[i] / count[i], .5, 1e-4);
    EXPECT_NEAR(squares[i] / count[i], 1 / 3., 1e-4);
  }
}

// EGSnrc issue 24: this table once got a weight of -0.715.
TEST(Distribution, SixEntriesThatBrokeAnotherTableAreRight) {
  const std::vector<double> weights = {1.028976e-5, 1.9611e-4, 1.028976e-5,
                                       1.028976e-5, 1.9611e-4, 1.028976e-5};
  const Distribution1D d(weights);
  const auto found = frequencies(d, 6000000);
  for (std::uint32_t i = 0; i < 6; ++i) {
    EXPECT_NEAR(d.probability(i), weights[i] / d.sum(), 1e-7);
    EXPECT_NEAR(found[i], weights[i] / d.sum(), 1e-6);
  }
}

TEST(Distribution, AMillionWeightsOverSixtyDecadesKeepTheirProbabilities) {
  std::vector<double> weights;
  for (int i = 0; i < 1000000; ++i) weights.push_back(std::pow(10., 60 * random(i).x - 30));
  const Distribution1D d(weights);
  const double sum = std::accumulate(weights.begin(), weights.end(), 0.);
  double total = 0;
  for (std::uint32_t i = 0; i < d.size(); ++i) total += d.probability(i);
  EXPECT_NEAR(total, 1, 1e-6);

  // Counts of four million draws, for the entries that expect at least 100, within 5 sigma: about 200
  // entries, so a false alarm once in ten thousand seeds.
  constexpr int draws = 4000000;
  std::vector<int> count(d.size());
  for (int i = 0; i < draws; ++i) {
    const math::Vec4 u = random(i);
    const auto s = d.sample(math::join(u.y, u.z));
    ASSERT_GT(s.probability, 0);
    ++count[s.index];
  }
  int checked = 0;
  for (std::uint32_t i = 0; i < d.size(); ++i) {
    const double expected = weights[i] / sum * draws;
    if (expected < 100) continue;
    ++checked;
    EXPECT_NEAR(count[i], expected, 5 * std::sqrt(expected)) << i;
  }
  EXPECT_GT(checked, 30);
}

// A table of two million entries takes 21 of a float's 24 bits: the second number must carry the rest.
TEST(Distribution, ALargeTableNeedsTheSecondNumberAndUsesIt) {
  std::vector<double> weights(1u << 21, 1);
  for (std::size_t i = 0; i < weights.size(); i += 2) weights[i] = 1.9;
  const Distribution1D d(weights);
  double even = 0, moments = 0;
  constexpr int draws = 4000000;
  for (int i = 0; i < draws; ++i) {
    const math::Vec4 u = random(i);
    const auto s = d.sample(math::join(u.x, u.y));
    even += s.index % 2 == 0;
    moments += s.u;
  }
  // 4.5 sigma: false alarm 7e-6.
  EXPECT_NEAR(even / draws, 1.9 / 2.9, 4.5 * .5 / std::sqrt(draws));
  EXPECT_NEAR(moments / draws, .5, 4.5 * .29 / std::sqrt(draws));
}

// What stratified numbers need: none of two entries' samples lie on both sides of another's.
TEST(Distribution, ChoosingIsMonotone) {
  std::vector<double> weights;
  for (int i = 0; i < 5000; ++i) weights.push_back(i % 7 == 3 ? 0 : std::pow(10., 6 * random(i).x));
  weights[2500] = 1e9;  // a sun
  const Distribution1D d(weights);
  double last = 0;
  for (int i = 0; i < 2000000; ++i) {
    const auto s = d.sample(i * 5e-7);
    const double place = s.index + double{s.u};
    ASSERT_GE(place, last) << i;
    last = place;
  }
  EXPECT_GT(last, 4999);
}

TEST(Distribution, ProbabilitiesAreJustWhatSamplingDoes) {
  std::vector<double> weights;
  for (int i = 0; i < 1000; ++i) weights.push_back(std::pow(10., 12 * random(i).x));
  const Distribution1D d(weights);
  double sum = 0;
  for (std::uint32_t i = 0; i < d.size(); ++i) sum += double{d.probability(i)};
  EXPECT_NEAR(sum, 1, 1e-6);
  for (std::uint32_t i = 0; i < d.size(); ++i) ASSERT_GE(d.probability(i), 0x1p-31f) << i;
  // The share of u that chooses an entry, by its ends.
  double below = 0;
  for (std::uint32_t i = 0; i < d.size(); ++i) {
    const double end = below + double{d.probability(i)};
    if (d.probability(i) > 1e-4f) {
      EXPECT_EQ(d.sample(below + 1e-6).index, i);
      EXPECT_EQ(d.sample(end - 1e-6).index, i);
    }
    below = end;
  }
}
