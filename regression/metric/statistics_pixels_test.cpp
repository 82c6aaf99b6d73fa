// Wrong pixels are found, and neither fireflies nor the sample grid are wrong pixels.
#include "metric/statistics_pixels.h"

#include <gtest/gtest.h>

#include <cmath>

#include "base/error.h"
#include "metric/synthetic.h"

namespace {

using namespace synthetic;
using metric::WrongPixel;

std::vector<const Image*> pointers(const Synthetic& s) {
  std::vector<const Image*> p;
  for (const Image& r : s.replicates) p.push_back(&r);
  return p;
}

std::vector<WrongPixel> wrong(const Synthetic& golden, const Synthetic& test, double samples = 64) {
  return metric::wrong_pixels(golden.noisy(), test.noisy(), pointers(test), samples);
}

// A grey picture, noise 5 % per replicate, in which `fault` may replace a replicate's value.
Synthetic picture(std::uint64_t seed,
                  const std::function<float(int x, int y, int replicate, float value)>& fault,
                  double noise = .05, int replicates = 8) {
  Random random(seed);
  int call = 0;
  return synthesise(16, 16, replicates, [&](int x, int y, int) {
    const int replicate = call++ / (16 * 16 * 3);
    return fault(x, y, replicate, static_cast<float>(1 + noise * random.normal()));
  });
}
const auto sound = [](int, int, int, float value) { return value; };

TEST(WrongPixels, AreFoundWhereTheyAre) {
  for (const float value : {0.f, 2.f, 100.f}) {
    const Synthetic dead =
        picture(2, [&](int x, int y, int, float v) { return x == 5 && y == 11 ? value : v; });
    const std::vector<WrongPixel> found = wrong(picture(1, sound), dead);
    ASSERT_EQ(found.size(), 1u) << value;
    EXPECT_EQ(found[0].x, 5);
    EXPECT_EQ(found[0].y, 11);
    EXPECT_EQ(found[0].test, value);
    EXPECT_NEAR(found[0].reference, 1, .1);
    EXPECT_GT(found[0].sigmas, 20);
  }
}

TEST(WrongPixels, AreNoFireflies) {
  for (int hit = 1; hit <= 3; ++hit) {
    const Synthetic firefly =
        picture(2, [&](int x, int y, int r, float v) { return x == 5 && y == 11 && r < hit ? 1e4f : v; });
    EXPECT_TRUE(wrong(picture(1, sound), firefly).empty()) << hit;
    EXPECT_TRUE(wrong(firefly, picture(1, sound)).empty()) << hit << " of the golden";
  }
}

TEST(WrongPixels, AreLookedForWithTheNoiseOfTheirNeighbourhood) {
  // 20 sigma of an 8-replicate mean, both sides: 20 * .05 / sqrt(8) * sqrt(2) = .5, more where a neighbour is
  // louder.
  const auto shifted = [](double by) {
    return picture(
        2, [by](int x, int y, int, float v) { return x == 8 && y == 8 ? v + static_cast<float>(by) : v; });
  };
  EXPECT_TRUE(wrong(picture(1, sound), shifted(.4)).empty());
  EXPECT_EQ(wrong(picture(1, sound), shifted(1.2)).size(), 1u);
  const auto loud = [](int x, int y, int r, float v) { return x == 9 && y == 9 ? v + (r % 2 ? 1 : -1) : v; };
  EXPECT_TRUE(wrong(picture(1, loud), shifted(1.2)).empty());
  const auto far = [](int x, int y, int r, float v) { return x == 10 && y == 9 ? v + (r % 2 ? 1 : -1) : v; };
  EXPECT_EQ(wrong(picture(1, far), shifted(1.2)).size(), 1u);
}

TEST(WrongPixels, WithoutNoiseAreAllThatDifferBeyondRoundingAndTheSampleGrid) {
  const auto flat = [](float edge, float pixel) {
    return synthesise(16, 16, 8, [=](int x, int y, int) {
      return x == 5 && y == 5 ? pixel : x > 5 ? edge : 1.f;
    });
  };
  EXPECT_TRUE(wrong(flat(1, 1), flat(1, 1 + 5e-6f)).empty());
  const auto found = wrong(flat(1, 1), flat(1, 1.001f));
  ASSERT_EQ(found.size(), 1u);
  EXPECT_TRUE(std::isinf(found[0].sigmas));
  // Beside an edge of contrast 1, of 64 samples up to four may fall on the other side.
  EXPECT_TRUE(wrong(flat(0, 1), flat(0, 1 - 4 / 64.f)).empty());
  EXPECT_EQ(wrong(flat(0, 1), flat(0, 1 - 5 / 64.f)).size(), 1u);
}

TEST(WrongPixels, NeedTheMiddleOfTheReplicates) {
  const auto lifted = [](int up, int replicates) {
    return picture(
        2, [=](int x, int y, int r, float v) { return x == 3 && y == 3 && r < up ? v + 3e5f : v; }, 1e-6,
        replicates);
  };
  const Synthetic golden = picture(1, sound, 1e-6);
  EXPECT_TRUE(wrong(golden, lifted(4, 8)).empty());  // the nearer of the two middle ones is sound
  EXPECT_EQ(wrong(golden, lifted(8, 8)).size(), 1u);
  EXPECT_TRUE(wrong(golden, lifted(2, 5)).empty());
  EXPECT_EQ(wrong(golden, lifted(5, 5)).size(), 1u);
  EXPECT_TRUE(metric::wrong_pixels(golden.noisy(), golden.noisy(), {}, 64).empty());
  const Image small(8, 8, 3);
  EXPECT_THROW(metric::wrong_pixels(golden.noisy(), golden.noisy(), {&small, &small}, 64), base::Error);
}

TEST(WrongPixels, AreNotFoundInSoundPictures) {
  for (const double tail : {0., 1.5}) {
    Random random(7);
    int found = 0;
    for (int i = 0; i < 200; ++i) {
      const Synthetic a = tail > 0 ? heavy_render(random, 16) : normal_render(random, 16, .3);
      const Synthetic b = tail > 0 ? heavy_render(random, 16) : normal_render(random, 16, .3);
      found += static_cast<int>(wrong(a, b).size());
    }
    EXPECT_EQ(found, 0) << "of 51200 pixels";
  }
}

}  // namespace
