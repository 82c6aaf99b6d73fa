#include "report/pixels.h"

#include <gtest/gtest.h>
#include <zlib.h>

#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

namespace report {
namespace {

TEST(Floats, that_have_no_room_leave_those_out_that_are_not_needed) {
  image::Image picture(4, 4, 3, .5f), other(4, 4, 3, .25f);
  Floats needed_only(1000, false), tiny(10, true), all(1000, true);
  EXPECT_EQ(needed_only.add(picture, false), "");
  EXPECT_EQ(needed_only.add(picture, true), "p0");
  EXPECT_EQ(tiny.add(picture, true), "");
  EXPECT_EQ(all.add(picture, false), "p0");
  EXPECT_EQ(all.add(other, false), "p1");
  EXPECT_EQ(all.add(picture, true), "p0") << "each picture once";
  EXPECT_EQ(nlohmann::json::parse(all.json()).size(), 3u) << "two and the colours of maps";
}

TEST(Deflate, is_undone_by_zlib) {
  std::string text;
  for (int i = 0; i < 5000; ++i) text += static_cast<char>(i * i >> 3);
  const std::string packed = deflate(text);
  EXPECT_LT(packed.size(), text.size());
  std::string back(text.size(), ' ');
  uLongf size = back.size();
  ASSERT_EQ(uncompress(reinterpret_cast<Bytef*>(back.data()), &size,
                       reinterpret_cast<const Bytef*>(packed.data()), packed.size()),
            Z_OK);
  EXPECT_EQ(back, text);
}

TEST(Base64, is_that_of_RFC_4648) {
  const std::pair<const char*, const char*> vectors[] = {{"", ""},
                                                         {"f", "Zg=="},
                                                         {"fo", "Zm8="},
                                                         {"foo", "Zm9v"},
                                                         {"foob", "Zm9vYg=="},
                                                         {"fooba", "Zm9vYmE="},
                                                         {"foobar", "Zm9vYmFy"}};
  for (const auto& [plain, encoded] : vectors) EXPECT_EQ(base64(plain), encoded);
  EXPECT_EQ(base64(std::string("\xff\xfe\x00", 3)), "//4A");
}

TEST(Half, of_every_half_is_itself_and_between_two_the_nearest_even) {
  const auto value = [](int half) {  // of a positive finite half
    const int exponent = half >> 10, mantissa = half & 1023;
    return exponent ? std::ldexp(1024. + mantissa, exponent - 25) : std::ldexp(mantissa, -24);
  };
  for (int half = 0; half < 0x7c00; ++half) {
    EXPECT_EQ(to_half(static_cast<float>(value(half))), half);
    EXPECT_EQ(to_half(-static_cast<float>(value(half))), half | 0x8000);
    const double middle = (value(half) + (half == 0x7bff ? 65536 : value(half + 1))) / 2;
    EXPECT_EQ(to_half(static_cast<float>(middle)), half + (half & 1));
    EXPECT_EQ(to_half(std::nextafter(static_cast<float>(middle), 0.f)), half);
    EXPECT_EQ(to_half(std::nextafter(static_cast<float>(middle), 1e9f)), half + 1);
  }
  EXPECT_EQ(to_half(std::numeric_limits<float>::infinity()), 0x7c00);
  EXPECT_EQ(to_half(-1e30f), 0xfc00);
  EXPECT_GT(to_half(std::numeric_limits<float>::quiet_NaN()) & 0x7fff, 0x7c00);
}

TEST(Shown, maps_have_the_colours_of_magma) {
  // Matplotlib 3.8: magma(0), magma(128), magma(255), in 8 bits.
  const double expected[3][3] = {{0, 0, 4}, {183, 55, 121}, {252, 253, 191}};
  image::Image map(3, 1, 1);
  map.data = {0, .50196f, 1};
  const image::Image shown = shown_map(map, 1);
  for (int x = 0; x < 3; ++x)
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(255 * shown.at(x, 0, c), expected[x][c], 6) << x << " " << c;
}

TEST(Shown, differences_are_orange_where_ours_is_brighter_and_blue_where_it_is_darker) {
  image::Image ours(3, 1, 3, .5f), golden = ours;
  ours.at(0, 0, 2) = .75f;
  ours.at(1, 0, 1) = .25f;
  const image::Image shown = shown_signed(largest_channel(difference(ours, golden), 2));
  EXPECT_GT(shown.at(0, 0, 0), shown.at(0, 0, 2));
  EXPECT_LT(shown.at(1, 0, 0), shown.at(1, 0, 2));
  for (int c = 0; c < 3; ++c) EXPECT_EQ(shown.at(2, 0, c), 0);
}

}  // namespace
}  // namespace report
