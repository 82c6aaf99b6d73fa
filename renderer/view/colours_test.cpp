#include "view/colours.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

namespace view {
namespace {

using math::Vec3;

TEST(Codes, are_those_of_the_saved_png_for_any_value_and_setting) {
  std::mt19937 random(1);
  std::uniform_real_distribution<float> exponent(-20, 8);
  const image::Display settings[] = {{},           {2.5f, 0, false}, {-3, 2.2f, false},
                                     {0, 1, true}, {1, 0, true},     {60, .3f, false}};
  for (const image::Display& display : settings) {
    const Codes codes(display);
    for (int i = 0; i < 50000; ++i) {
      const float value = std::exp2(exponent(random));
      ASSERT_EQ(codes(value), image::to_display(Vec3(value), display)[0]) << value;
    }
    const float infinity = std::numeric_limits<float>::infinity();
    for (const float value : {0.f, -0.f, -1.f, 1e-45f, 3e38f, infinity, -infinity, std::nanf("")})
      EXPECT_EQ(codes(value), image::to_display(Vec3(value), display)[0]) << value;
  }
}

TEST(FalseColour, rises_in_brightness_from_least_to_most_and_is_grey_where_there_is_no_error_to_speak_of) {
  const auto brightness = [](const Rgba& c) { return 2 * c[0] + 5 * c[1] + c[2]; };
  int last = 0;
  for (float x = least; x <= most * 1.001f; x *= 1.3f) {
    EXPECT_GT(brightness(false_colour(x)), last);
    last = brightness(false_colour(x));
  }
  EXPECT_EQ(false_colour(0), false_colour(least)) << "cut";
  EXPECT_EQ(false_colour(50), false_colour(most)) << "cut";
  EXPECT_EQ(false_colour(std::nanf("")), (Rgba{96, 96, 96, 255}));
}

// Ten samples of mean 2 in each channel and variance of the mean .04: 10 %.
TEST(FalseColour, the_error_is_the_standard_error_over_the_mean) {
  EXPECT_FLOAT_EQ(relative_error(Vec3(2), Vec3(.04f)), .1f);
  EXPECT_TRUE(std::isnan(relative_error(Vec3(0), Vec3(0))));
  EXPECT_FLOAT_EQ(relative_difference({1, 2, 3}, {1, 2, 2.5f}), .5f / (5.5f / 3));
}

TEST(FalseColour, a_reference_of_another_size_is_compared_at_the_same_place) {
  image::Image one(4, 2), two(2, 1);
  for (int x = 0; x < 4; ++x) one.at(x, 0) = one.at(x, 1) = Vec3(x < 2 ? 1.f : 3.f);
  two.at(0, 0) = Vec3(1), two.at(1, 0) = Vec3(2);
  const std::vector<Rgba> map = show_difference(one, two);
  EXPECT_EQ(map[0], false_colour(0));
  EXPECT_EQ(map[5], false_colour(0));
  EXPECT_EQ(map[2], false_colour(.5f));
  EXPECT_EQ(map[7], false_colour(.5f));
}

}  // namespace
}  // namespace view
