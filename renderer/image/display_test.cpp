#include "image/display.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>

#include "base/error.h"
#include "image/decode.h"
#include "image/oiio.h"

using image::Display;
using image::Image;
using math::Vec3;

namespace {

constexpr float not_a_number = std::numeric_limits<float>::quiet_NaN(),
                infinity = std::numeric_limits<float>::infinity();

std::string path(const std::string& name) {
  return (std::filesystem::temp_directory_path() / ("assay_display_test_" + std::to_string(getpid()) + name))
      .string();
}

std::string bytes(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

int code(float value, const Display& display = {}) { return image::to_display(Vec3(value), display)[0]; }

}  // namespace

TEST(ToDisplay, SrgbCodesSurviveARoundTrip) {
  for (int k = 0; k < 256; ++k) {
    const double v = k / 255.;
    const double linear = v <= .04045 ? v / 12.92 : std::pow((v + .055) / 1.055, 2.4);
    EXPECT_EQ(code(static_cast<float>(linear)), k);
  }
  EXPECT_EQ(code(.0031308f), static_cast<int>(std::lround(12.92 * .0031308 * 255)));
}

TEST(ToDisplay, ExposureCountsInStopsAndGammaIsAPlainPower) {
  EXPECT_EQ(code(.25f, {2, 1, false}), 255);
  EXPECT_EQ(code(.25f, {1, 1, false}), 128);
  EXPECT_EQ(code(4, {-3, 1, false}), 128);
  for (float v : {.01f, .2f, .7f})
    EXPECT_EQ(code(v, {0, 2.2f, false}), std::lround(255 * std::pow(v, 1 / 2.2)));
}

TEST(ToDisplay, FilmicIsNarkowiczsCurve) {
  for (float v : {.01f, .18f, .5f, 1.f, 4.f}) {
    const double wanted = v * (2.51 * v + .03) / (v * (2.43 * v + .59) + .14);
    EXPECT_NEAR(code(v, {0, 1, true}), std::min(wanted, 1.) * 255, .51) << v;
  }
}

TEST(ToDisplay, EveryInputHasACodeAndTheCodesAreMonotone) {
  for (const Display& display :
       {Display{}, {0, 2.2f, false}, {0, 0, true}, {20, 0, false}, {-20, 1, true}, {200, 0, true}}) {
    int last = 0;
    for (float v : {-infinity, -1.f, -0.f, 0.f, 1e-45f, 1e-10f, .001f, .0031308f, .0031309f, .1f, .5f, 1.f,
                    10.f, 1e6f, 1e38f, infinity}) {
      EXPECT_GE(code(v, display), last) << v;
      last = code(v, display);
    }
    EXPECT_EQ(code(infinity, display), 255);
    EXPECT_EQ(code(-1, display), 0);
    EXPECT_EQ(code(not_a_number, display), 0);
  }
}

TEST(WriteDisplay, PngHoldsTheCodesAndBadPixelsAreCounted) {
  Image image(3, 2);
  image.at(0, 0) = {1, .5f, 0};
  image.at(1, 0) = {not_a_number, .5f, 0};
  image.at(2, 0) = {infinity, 0, 0};
  image.at(0, 1) = {0, -1, 0};
  const std::string file = path("a.png");
  EXPECT_EQ(image::write_display(file, image, {}), 3);
  const std::string first = bytes(file);
  const auto back = image::decode(reinterpret_cast<const std::uint8_t*>(first.data()), first.size(), file);
  ASSERT_EQ(back.texels.size(), 6u);
  for (std::size_t i = 0; i < 6; ++i)
    for (int c = 0; c < 3; ++c)
      EXPECT_EQ(back.texels[i][c] / 257, image::to_display(image.pixels[i], {})[static_cast<std::size_t>(c)]);
  image::write_display(file, image, {});
  EXPECT_EQ(bytes(file), first);
  std::filesystem::remove(file);
}

TEST(WriteDisplay, JpegIsCloseToItsCodes) {
  const std::string file = path("a.jpg");
  EXPECT_EQ(image::write_display(file,
                                 [] {
                                   Image image(16, 16);
                                   for (Vec3& pixel : image.pixels) pixel = {.2f, .4f, .1f};
                                   return image;
                                 }(),
                                 {}),
            0);
  const std::string all = bytes(file);
  const auto back = image::decode(reinterpret_cast<const std::uint8_t*>(all.data()), all.size(), file);
  ASSERT_EQ(back.texels.size(), 256u);
  for (int c = 0; c < 3; ++c)
    EXPECT_NEAR(back.texels[100][c] / 257.,
                image::to_display({.2f, .4f, .1f}, {})[static_cast<std::size_t>(c)], 3);
  std::filesystem::remove(file);
}

// OpenImageIO would write -1 as 3.
TEST(WriteDisplay, HdrKeepsRadianceAndHasNoNegatives) {
  Image image(4, 1);
  image.at(0, 0) = {1000, 500, 250};
  image.at(1, 0) = {-1, -1e6f, 2};
  image.at(2, 0) = {not_a_number, 1, 1};
  image.at(3, 0) = {1e-3f, infinity, 0};
  const std::string file = path("a.hdr");
  EXPECT_EQ(image::write_display(file, image, {5, 2.2f, true}), 3);
  const Image back = image::read_environment(file);
  ASSERT_EQ(back.width, 4);
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(back.at(0, 0)[c], image.at(0, 0)[c], 1000 / 128.);
  EXPECT_EQ(back.at(1, 0).x, 0);
  EXPECT_EQ(back.at(1, 0).y, 0);
  EXPECT_NEAR(back.at(1, 0).z, 2, 2 / 128.);
  EXPECT_EQ(back.at(2, 0).x, 0);
  EXPECT_GT(back.at(3, 0).y, 1e37f);
  std::filesystem::remove(file);
}

TEST(WriteDisplay, FailuresNameTheFile) {
  const auto error_of = [](const std::string& file) -> std::string {
    try {
      image::write_display(file, Image(2, 2), {});
    } catch (const base::Error& error) {
      return error.what();
    }
    return "no error";
  };
  EXPECT_EQ(error_of("a.tiff"), "a.tiff: wanted an extension of .png, .jpg or .hdr");
  EXPECT_EQ(error_of("/no/such/a.png"), "/no/such/a.png: cannot write: No such file or directory");
}
