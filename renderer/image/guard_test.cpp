// PNGs whose checksums are right and whose contents are not. libpng writes what it thinks of a file to
// stderr, also where it goes on; an error of ours is one line. So nothing it would object to may reach it.
#include <gtest/gtest.h>

#include "base/error.h"
#include "image/decode.h"
#include "image/png_test.h"

using namespace image::test;

namespace {

struct Chunk {
  std::string kind;
  Bytes data;
};

Bytes png_of(const std::vector<Chunk>& chunks) {
  Bytes out = {0x89, 'P', 'N', 'G', '\r', '\n', 0x1a, '\n'};
  for (const Chunk& c : chunks) chunk(out, c.kind, c.data);
  return out;
}

// What is said, by us and by any library; "" if the image is decoded in silence.
std::string said_of(const Bytes& png) {
  testing::internal::CaptureStderr();
  std::string error;
  try {
    image::decode(png.data(), png.size(), "image", {.side = 4096, .pixels = 1 << 20});
  } catch (const base::Error& e) {
    error = e.what();
  }
  const std::string printed = testing::internal::GetCapturedStderr();
  return error + (printed.empty() ? "" : " PRINTED " + printed);
}

// 2 x 2 pixels in a palette of two colours.
const std::vector<Chunk> good = {{"IHDR", {0, 0, 0, 2, 0, 0, 0, 2, 8, 3, 0, 0, 0}},
                                 {"PLTE", {1, 2, 3, 4, 5, 6}},
                                 {"tRNS", {7}},
                                 {"IDAT", zlib({0, 0, 1, 0, 1, 0})},
                                 {"IEND", {}}};

}  // namespace

TEST(Guard, RefusesEveryPngThatLibpngWouldComplainAbout) {
  ASSERT_EQ(said_of(png_of(good)), "");
  const auto with = [](std::size_t at, const Bytes& data) {
    std::vector<Chunk> chunks = good;
    chunks[at].data = data;
    return png_of(chunks);
  };
  const auto and_before = [](std::size_t at, const Chunk& more) {
    std::vector<Chunk> chunks = good;
    chunks.insert(chunks.begin() + static_cast<std::ptrdiff_t>(at), more);
    return png_of(chunks);
  };
  const auto header = [&](std::uint8_t depth, std::uint8_t colour, std::uint8_t a, std::uint8_t b,
                          std::uint8_t c) {
    return with(0, {0, 0, 0, 2, 0, 0, 0, 2, depth, colour, a, b, c});
  };
  Bytes wrong_sum = zlib({0, 0, 1, 0, 1, 0});
  wrong_sum.back() ^= 1;
  const std::pair<Bytes, const char*> bad[] = {
      {header(3, 3, 0, 0, 0), "wanted a colour type"},
      {header(0, 0, 0, 0, 0), "wanted a colour type"},
      {header(16, 3, 0, 0, 0), "wanted a colour type"},
      {header(8, 5, 0, 0, 0), "wanted a colour type"},
      {header(8, 200, 0, 0, 0), "wanted a colour type"},
      {header(8, 3, 1, 0, 0), "wanted a colour type"},
      {header(8, 3, 0, 1, 0), "wanted a colour type"},
      {header(8, 3, 0, 0, 2), "wanted a colour type"},
      {with(1, {}), "wanted one palette"},
      {with(1, {1, 2, 3, 4}), "wanted one palette"},
      {with(1, Bytes(3 * 257)), "wanted one palette"},
      {and_before(2, good[1]), "wanted one palette"},
      {with(2, {}), "wanted one tRNS"},
      {with(2, {1, 2, 3}), "wanted one tRNS"},
      {and_before(3, good[2]), "wanted one tRNS"},
      {and_before(4, good[2]), "wanted one tRNS"},
      {and_before(1, good[0]), "wanted one IHDR"},
      {and_before(1, {"ABCD", {1}}), "an unknown one"},
      {and_before(1, good[3]), "after their palette"},
      {png_of({good[0], good[1], good[3], {"tEXt", {}}, {"IDAT", {}}, good[4]}), "in one place"},
      {with(3, zlib({0, 0, 1, 9, 1, 0})), "wanted compressed scanlines"},
      {with(3, zlib({0, 0, 1, 0, 1, 0, 0})), "wanted compressed scanlines"},
      {with(3, wrong_sum), "wanted compressed scanlines"},
      {with(3, {1, 2, 3}), "wanted compressed scanlines"},
      {with(3, zlib({0, 0, 1, 0, 1})), "wanted data for 2 x 2 pixels, found only"},
      {with(3, {}), "wanted data for 2 x 2 pixels, found only 0 bytes"},
      {with(4, {1}), "wanted an empty IEND"}};
  for (const auto& [png, wanted] : bad) {
    const std::string said = said_of(png);
    EXPECT_NE(said.find(wanted), std::string::npos) << said;
    EXPECT_EQ(said.find("PRINTED"), std::string::npos) << said;
    EXPECT_EQ(said.find('\n'), std::string::npos) << said;
  }
}

// These say nothing of the pixels, however wrong they are; nor does what follows the end of the data.
TEST(Guard, DecodesInSilenceWhatSaysNothingOfThePixels) {
  const Chunk idle[] = {{"gAMA", {0, 0, 0, 0}},  {"sRGB", {9}},  {"iCCP", Bytes(22)},    {"cHRM", Bytes(32)},
                        {"tEXt", Bytes(99)},     {"sBIT", {99}}, {"bKGD", {1, 2}},       {"hIST", {1}},
                        {"tIME", Bytes(7, 255)}, {"pHYs", {}},   {"zTXt", {1, 0, 0, 1}}, {"aBCD", {1}}};
  for (const Chunk& c : idle)
    for (std::size_t at = 1; at < good.size(); ++at) {
      std::vector<Chunk> chunks = good;
      chunks.insert(chunks.begin() + static_cast<std::ptrdiff_t>(at), c);
      EXPECT_EQ(said_of(png_of(chunks)), "") << c.kind << at;
    }
  std::vector<Chunk> more = good;
  more[3].data.push_back(0);
  more.insert(more.begin() + 4, {"IDAT", {1, 2, 3}});
  EXPECT_EQ(said_of(png_of(more)), "");
  // Data in many chunks, some of them empty.
  std::vector<Chunk> chunks(good.begin(), good.begin() + 3);
  for (const std::uint8_t byte : good[3].data) chunks.insert(chunks.end(), {{"IDAT", {byte}}, {"IDAT", {}}});
  chunks.push_back(good[4]);
  EXPECT_EQ(said_of(png_of(chunks)), "");
  // A palette in an image of true colours, or of grey, is not one.
  EXPECT_EQ(said_of(png_of({{"IHDR", {0, 0, 0, 1, 0, 0, 0, 1, 8, 2, 0, 0, 0}},
                            good[1],
                            {"IDAT", zlib({0, 1, 2, 3})},
                            good[4]})),
            "");
  EXPECT_EQ(
      said_of(png_of(
          {{"IHDR", {0, 0, 0, 1, 0, 0, 0, 1, 8, 0, 0, 0, 0}}, good[1], {"IDAT", zlib({0, 1})}, good[4]})),
      "");
}

// Adam7's passes of every size up to 9 x 9, which the scanlines must end with exactly.
TEST(Guard, CountsTheScanlinesOfInterlacedPngs) {
  for (std::uint8_t width = 1; width <= 9; ++width)
    for (std::uint8_t height = 1; height <= 9; ++height)
      for (const std::uint8_t depth : {std::uint8_t{1}, std::uint8_t{8}}) {
        // Written out once more, from the specification's picture of the pattern.
        constexpr const char* pattern = "1646264677777777565656567777777736463646777777775656565677777777";
        Bytes raw;
        for (char pass = '1'; pass <= '7'; ++pass)
          for (int y = 0; y < height; ++y) {
            int columns = 0;
            for (int x = 0; x < width; ++x) columns += pattern[y % 8 * 8 + x % 8] == pass;
            if (columns > 0) raw.insert(raw.end(), 1 + static_cast<std::size_t>(columns * depth + 7) / 8, 0);
          }
        const Chunk header{"IHDR", {0, 0, 0, width, 0, 0, 0, height, depth, 0, 0, 0, 1}};
        EXPECT_EQ(said_of(png_of({header, {"IDAT", zlib(raw)}, good[4]})), "")
            << int{width} << " x " << int{height};
        raw.pop_back();
        EXPECT_NE(said_of(png_of({header, {"IDAT", zlib(raw)}, good[4]})), "");
      }
}

// Whatever is done to the chunks: libpng has nothing to say.
TEST(Guard, LeavesLibpngNothingToSayAboutDamagedChunks) {
  std::uint64_t state = 7;
  const auto dice = [&](std::size_t sides) {
    return static_cast<std::size_t>((state = state * 6364136223846793005ull + 1442695040888963407ull) >> 33) %
           sides;
  };
  int decoded = 0, refused = 0;
  for (int round = 0; round < 4000; ++round) {
    std::vector<Chunk> chunks = good;
    Bytes pixels = {0, 0, 1, 0, 1, 0};
    for (std::size_t i = 0; i <= dice(2); ++i) {
      const std::size_t at = dice(chunks.size());
      Bytes& data = chunks[at].data;
      if (const std::size_t way = dice(10); way == 0)
        chunks.erase(chunks.begin() + static_cast<std::ptrdiff_t>(at));
      else if (way == 1)
        chunks.insert(chunks.begin() + static_cast<std::ptrdiff_t>(dice(chunks.size() + 1)),
                      Chunk(chunks[at]));
      else if (way == 2)
        data.resize(dice(20));
      else if (way < 5)
        pixels[dice(pixels.size())] = static_cast<std::uint8_t>(dice(8)),
        chunks[std::min<std::size_t>(3, chunks.size() - 1)].data = zlib(pixels);
      else if (!data.empty())
        data[dice(data.size())] = static_cast<std::uint8_t>(dice(2) ? dice(256) : dice(9));
      if (chunks.empty()) chunks = good;
    }
    const std::string said = said_of(png_of(chunks));
    ++(said.empty() ? decoded : refused);
    EXPECT_EQ(said.find('\n'), std::string::npos) << said;
  }
  EXPECT_GT(decoded, 300);
  EXPECT_GT(refused, 1000);
  RecordProperty("measured", std::to_string(refused) + " damaged PNGs refused in one line, " +
                                 std::to_string(decoded) + " decoded; libpng printed nothing");
}
