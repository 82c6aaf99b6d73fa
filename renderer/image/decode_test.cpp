#include "image/decode.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <functional>

#include "base/error.h"
#include "image/png_test.h"

using math::U16Vec4;
using namespace image::test;

namespace {

image::Decoded decode(const Bytes& bytes) { return image::decode(bytes.data(), bytes.size(), "test"); }
std::string error_of(const Bytes& bytes, const image::Limits& limits = {}) {
  try {
    image::decode(bytes.data(), bytes.size(), "scene.glb: image 3", limits);
  } catch (const base::Error& error) {
    return error.what();
  }
  return "no error";
}

Bytes file(const std::string& name) {
  std::ifstream in(std::string(ASSAY_SOURCE_DIR) + "/renderer/image/testdata/" + name, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

// Codes of 8 bits in 16.
constexpr std::uint16_t f255(int v) { return static_cast<std::uint16_t>(v * 257); }
constexpr std::uint16_t one = 65535;

}  // namespace

TEST(Decode, EightBitPngsOfEveryChannelCountAreExact) {
  const auto grey = decode(encode({2, 1, 8, 0, {{0, 77}}}));
  EXPECT_EQ(grey.channels, 1);
  EXPECT_EQ(grey.texels, (std::vector<U16Vec4>{{0, 0, 0, one}, {f255(77), f255(77), f255(77), one}}));
  const auto grey_alpha = decode(encode({1, 1, 8, 4, {{77, 3}}}));
  EXPECT_EQ(grey_alpha.channels, 2);
  EXPECT_EQ(grey_alpha.texels, (std::vector<U16Vec4>{{f255(77), f255(77), f255(77), f255(3)}}));
  const auto rgb = decode(encode({1, 2, 8, 2, {{1, 2, 3}, {253, 254, 255}}}));
  EXPECT_EQ(rgb.channels, 3);
  EXPECT_EQ(rgb.texels,
            (std::vector<U16Vec4>{{f255(1), f255(2), f255(3), one}, {f255(253), f255(254), one, one}}));
  EXPECT_EQ(rgb.height, 2);
}

// OpenImageIO multiplies by alpha unless told not to.
TEST(Decode, ColoursUnderSmallOrZeroAlphaAreKept) {
  const auto rgba = decode(encode({2, 1, 8, 6, {{255, 255, 255, 0, 200, 100, 50, 3}}}));
  EXPECT_EQ(rgba.channels, 4);
  EXPECT_EQ(rgba.texels,
            (std::vector<U16Vec4>{{one, one, one, 0}, {f255(200), f255(100), f255(50), f255(3)}}));
}

TEST(Decode, SixteenBitPngsKeepAllBits) {
  const auto rgba = decode(encode({1, 1, 16, 6, {{0x12, 0x34, 0xff, 0xff, 0, 1, 0x80, 0}}}));
  EXPECT_EQ(rgba.texels, (std::vector<U16Vec4>{{0x1234, one, 1, 0x8000}}));
  const auto grey = decode(encode({1, 1, 16, 0, {{0x12, 0x34}}}));
  EXPECT_EQ(grey.texels[0], U16Vec4(0x1234, 0x1234, 0x1234, one));
}

TEST(Decode, GreyOfFewBitsIsExpandedToItsRange) {
  EXPECT_EQ(decode(encode({4, 1, 2, 0, {{0b00011011}}})).texels,
            (std::vector<U16Vec4>{{0, 0, 0, one},
                                  {f255(85), f255(85), f255(85), one},
                                  {f255(170), f255(170), f255(170), one},
                                  {one, one, one, one}}));
  EXPECT_EQ(decode(encode({2, 1, 1, 0, {{0b01000000}}})).texels,
            (std::vector<U16Vec4>{{0, 0, 0, one}, {one, one, one, one}}));
}

TEST(Decode, PalettesAreExpandedWithTheirTransparency) {
  const Bytes palette = {10, 20, 30, 200, 100, 50};
  const auto plain = decode(encode({3, 1, 4, 3, {{0x01, 0x10}}, false, palette}));
  EXPECT_EQ(plain.channels, 3);
  EXPECT_EQ(plain.texels[1], U16Vec4(f255(200), f255(100), f255(50), one));
  const auto transparent = decode(encode({2, 1, 8, 3, {{0, 1}}, false, palette, {0, 128}}));
  EXPECT_EQ(transparent.channels, 4);
  EXPECT_EQ(transparent.texels, (std::vector<U16Vec4>{{f255(10), f255(20), f255(30), 0},
                                                      {f255(200), f255(100), f255(50), f255(128)}}));
}

TEST(Decode, InterlacedPngsComeOutInOrder) {
  // 2 x 2: pass 1 holds (0,0), pass 6 (1,0), pass 7 row 1.
  const auto decoded = decode(encode({2, 2, 8, 0, {{1}, {2}, {3, 4}}, true}));
  ASSERT_EQ(decoded.texels.size(), 4u);
  for (int i = 0; i < 4; ++i) EXPECT_EQ(decoded.texels[static_cast<std::size_t>(i)].x, f255(i + 1));
}

TEST(Decode, TallImagesAreReadWhole) {
  Png png{1, 4097, 8, 0, {}};
  for (int y = 0; y < 4097; ++y) png.rows.push_back({static_cast<std::uint8_t>(y * 7)});
  const auto decoded = decode(encode(png));
  ASSERT_EQ(decoded.texels.size(), 4097u);
  for (std::size_t y = 0; y < 4097; ++y)
    EXPECT_EQ(decoded.texels[y].z, f255(static_cast<std::uint8_t>(y * 7)));
}

TEST(Decode, JpegsAreReadBaselineAndProgressive) {
  // Three blocks of flat colour; quality 95 and subsampled chroma leave a few codes of error inside them.
  const int colours[3][3] = {{200, 100, 50}, {20, 220, 120}, {128, 128, 128}};
  for (const char* name : {"baseline.jpg", "progressive.jpg"}) {
    const auto decoded = decode(file(name));
    ASSERT_EQ(decoded.width, 24);
    ASSERT_EQ(decoded.height, 16);
    EXPECT_EQ(decoded.channels, 3);
    for (std::size_t block = 0; block < 3; ++block)
      for (int c = 0; c < 3; ++c)
        EXPECT_NEAR(decoded.texels[24 * 8 + block * 8 + (block < 2 ? 1 : 6)][c] / 257., colours[block][c], 12)
            << name << block;
    EXPECT_EQ(decoded.texels[0].w, one);
  }
  const auto grey = decode(file("grey.jpg"));
  EXPECT_EQ(grey.channels, 1);
  EXPECT_NEAR(grey.texels[12].y / 257., 120, 3);
}

TEST(Decode, CmykJpegsAreRefused) {
  EXPECT_EQ(error_of(file("cmyk.jpg")),
            "scene.glb: image 3: wanted a grey or RGB JPEG, found one of 4 components (CMYK)");
}

TEST(Decode, OtherFormatsAreRefusedByName) {
  const std::pair<Bytes, const char*> files[] = {
      {{}, "no data"},
      {{'B', 'M', 1, 2}, "BMP"},
      {{0xab, 'K', 'T', 'X', ' ', '2', '0', 0xbb}, "KTX2"},
      {{'R', 'I', 'F', 'F', 0, 0, 0, 0, 'W', 'E', 'B', 'P'}, "WebP"},
      {{'R', 'I', 'F', 'F'}, "an unknown format"},
      {{0x89, 'P', 'N'}, "an unknown format"},
      {{0xff, 0xd8}, "an unknown format"}};
  for (const auto& [bytes, name] : files)
    EXPECT_EQ(error_of(bytes), std::string("scene.glb: image 3: wanted a PNG or JPEG image, found ") + name);
}

TEST(Decode, SizesThatLieOrExceedTheLimitsAreRefusedBeforeAnythingIsAllocated) {
  for (std::uint32_t side : {0u, 16385u, 100000u, 0x7fffffffu, 0xffffffffu}) {
    EXPECT_NE(error_of(encode({side, 1, 8, 0, {{1}}})).find("header: wanted a size"), std::string::npos)
        << side;
    EXPECT_NE(error_of(encode({1, side, 8, 0, {{1}}})).find("header: wanted a size"), std::string::npos)
        << side;
  }
  EXPECT_NE(error_of(encode({16384, 16384, 8, 6, {{1}}})).find("found 16384 x 16384"), std::string::npos);
  // Within the limits, but 67 million pixels in 20 bytes.
  EXPECT_NE(error_of(encode({16384, 4096, 8, 6, {{1}}})).find("wanted data for 16384 x 4096"),
            std::string::npos);
  EXPECT_EQ(error_of(encode({4, 1, 8, 0, {{1, 2, 3, 4}}}), {.side = 4}), "no error");
  EXPECT_NE(error_of(encode({4, 1, 8, 0, {{1, 2, 3, 4}}}), {.side = 3}).find("at most 3 x 3"),
            std::string::npos);
  EXPECT_NE(error_of(file("baseline.jpg"), {.pixels = 383}).find("found 24 x 16"), std::string::npos);
  EXPECT_EQ(error_of(file("baseline.jpg"), {.pixels = 384}), "no error");
}

TEST(Decode, EveryPrefixOfAGoodFileIsRefused) {
  const Bytes files[] = {encode({5, 5, 8, 2, std::vector<Bytes>(5, Bytes(15, 99))}), file("baseline.jpg"),
                         file("progressive.jpg"), file("grey.jpg")};
  for (const Bytes& whole : files) {
    ASSERT_EQ(error_of(whole), "no error");
    for (std::size_t size = 0; size < whole.size(); ++size) {
      const std::string error =
          error_of(Bytes(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(size)));
      EXPECT_EQ(error.find("scene.glb: image 3: "), 0u) << size << " of " << whole.size();
      EXPECT_EQ(error.find('\n'), std::string::npos);
    }
  }
}

TEST(Decode, DamagedPngsAreRefusedByTheirChecksums) {
  const Bytes whole = encode({5, 5, 8, 2, std::vector<Bytes>(5, Bytes(15, 99))});
  for (std::size_t at = 16; at + 12 < whole.size(); ++at) {
    Bytes damaged = whole;
    damaged[at] = static_cast<std::uint8_t>(damaged[at] ^ 0x10);
    const std::string error = error_of(damaged);
    EXPECT_TRUE(error.find(" of the PNG: wanted ") != std::string::npos ||
                error.find("header: wanted") != std::string::npos)
        << at << error;
  }
}

TEST(Decode, DamagedJpegsNeverCrash) {
  const Bytes whole = file("progressive.jpg");
  for (std::size_t at = 2; at < whole.size(); ++at)
    for (int flip : {0x01, 0x80, 0xff}) {
      Bytes damaged = whole;
      damaged[at] = static_cast<std::uint8_t>(damaged[at] ^ flip);
      const std::string error = error_of(damaged, {.side = 4096, .pixels = 1 << 20});
      EXPECT_TRUE(error == "no error" || error.starts_with("scene.glb: image 3: ")) << error;
    }
}
