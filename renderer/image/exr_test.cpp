#include "image/exr.h"

#include <gtest/gtest.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <filesystem>
#include <fstream>

#include "base/error.h"
#include "image/decode.h"
#include "image/file.h"
#include "image/oiio.h"
#include "image/read_exr_test.h"

namespace fs = std::filesystem;
using image::Exr;
using image::Image;
using math::Vec3;

namespace {

class Files : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::temp_directory_path() / ("assay_image_test_" + std::to_string(getpid()));
    fs::create_directories(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }
  std::string path(const std::string& name) const { return (folder_ / name).string(); }
  std::size_t files() const {
    return static_cast<std::size_t>(std::distance(fs::directory_iterator(folder_), {}));
  }
  static std::string bytes(const std::string& path) {
    std::ifstream file(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
  }
  static std::string error_of(const std::function<void()>& action) {
    try {
      action();
    } catch (const base::Error& error) {
      return error.what();
    }
    return "no error";
  }
  fs::path folder_;
};

using ExrFile = Files;
using Environment = Files;

Image pattern(int width, int height, float factor) {
  Image image(width, height);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const float v = static_cast<float>(1 + x + width * y);
      image.at(x, y) = Vec3(v, v / 3, 1 / v) * factor;
    }
  return image;
}

Exr example() {
  Exr exr{pattern(17, 9, 1), pattern(17, 9, .25f), {}, {}};
  exr.layers.push_back({"albedo", "RGB", pattern(17, 9, .01f)});
  exr.layers.push_back({"depth", "Z", pattern(17, 9, 7)});
  exr.layers.push_back({"normal", "XYZ", pattern(17, 9, -.1f)});
  exr.metadata.set("assay:shader", std::string("disney"));
  exr.metadata.set("assay:spp", 256);
  exr.metadata.set("assay:text", std::string("two words, \"quotes\" and {\"json\": [1, 2]}"));
  return exr;
}

}  // namespace

TEST_F(ExrFile, EverythingWrittenIsReadBack) {
  const Exr exr = example();
  image::write_exr(path("a.exr"), exr);
  const Exr back = image::read_exr(path("a.exr"));
  ASSERT_EQ(back.mean.width, 17);
  ASSERT_EQ(back.mean.height, 9);
  EXPECT_EQ(back.mean.pixels, exr.mean.pixels);
  for (std::size_t i = 0; i < exr.variance.pixels.size(); ++i)
    for (int c = 0; c < 3; ++c)
      EXPECT_NEAR(back.variance.pixels[i][c], exr.variance.pixels[i][c],
                  exr.variance.pixels[i][c] * 0x1p-11f);
  ASSERT_EQ(back.layers.size(), 3u);
  for (std::size_t k = 0; k < 3; ++k) {
    EXPECT_EQ(back.layers[k].name, exr.layers[k].name);
    EXPECT_EQ(back.layers[k].channels, exr.layers[k].channels);
    for (std::size_t i = 0; i < exr.mean.pixels.size(); ++i)
      for (int c = 0; c < static_cast<int>(exr.layers[k].channels.size()); ++c)
        EXPECT_EQ(back.layers[k].image.pixels[i][c], exr.layers[k].image.pixels[i][c]);
  }
  ASSERT_EQ(back.metadata.entries.size(), exr.metadata.entries.size());
  for (const auto& [name, value] : exr.metadata.entries) {
    ASSERT_NE(back.metadata.find(name), nullptr) << name;
    EXPECT_EQ(*back.metadata.find(name), value) << name;
  }
  EXPECT_EQ(files(), 1u);
}

TEST_F(ExrFile, ChannelsHaveTheNamesOrderAndTypesOfTheFormat) {
  image::write_exr(path("a.exr"), example());
  const auto input = OIIO::ImageInput::open(path("a.exr"));
  ASSERT_TRUE(input);
  const OIIO::ImageSpec& spec = input->spec();
  const std::vector<std::string> first(spec.channelnames.begin(), spec.channelnames.begin() + 3);
  EXPECT_EQ(first, (std::vector<std::string>{"R", "G", "B"}));
  for (const char* name : {"variance.R", "variance.G", "variance.B", "albedo.R", "albedo.G", "albedo.B",
                           "normal.X", "normal.Y", "normal.Z", "depth.Z", "R"}) {
    const int c = spec.channelindex(name);
    ASSERT_GE(c, 0) << name;
    EXPECT_EQ(spec.channelformat(c),
              std::string(name).starts_with("variance") ? OIIO::TypeHalf : OIIO::TypeFloat)
        << name;
  }
  EXPECT_EQ(spec.nchannels, 13);
  EXPECT_EQ(spec.get_string_attribute("compression"), "zip");
  EXPECT_EQ(spec.get_int_attribute("assay:spp"), 256);
  EXPECT_GT(spec.get_float_attribute("assay:variance_scale"), 0);
}

TEST_F(ExrFile, TheSameInputGivesTheSameBytes) {
  image::write_exr(path("a.exr"), example());
  image::write_exr(path("b.exr"), example());
  EXPECT_EQ(bytes(path("a.exr")), bytes(path("b.exr")));
  EXPECT_GT(bytes(path("a.exr")).size(), 500u);
}

TEST_F(ExrFile, ValuesThatHalfCannotHoldSurviveInMeanAndVariance) {
  for (float scale : {1e-30f, 1e-12f, 1.f, 1e6f, 1e30f}) {
    Exr exr{Image(4, 1), Image(4, 1), {}, {}};
    const float values[4] = {1, 1e-4f, 0, .3f};
    for (int x = 0; x < 4; ++x) exr.mean.at(x, 0) = exr.variance.at(x, 0) = Vec3(scale * values[x]);
    image::write_exr(path("a.exr"), exr);
    const Exr back = image::read_exr(path("a.exr"));
    for (int x = 0; x < 4; ++x) {
      EXPECT_EQ(back.mean.at(x, 0), exr.mean.at(x, 0));
      EXPECT_NEAR(back.variance.at(x, 0).y / scale, values[x], values[x] * 0x1p-11f) << scale;
    }
  }
  // Exactly, in float.
  Exr exr{Image(6, 1), {}, {}, {}};
  const float values[6] = {65504, 65519, 65520, 1e6f, 1e30f, 5e-8f};
  for (int x = 0; x < 6; ++x) exr.mean.at(x, 0) = Vec3(values[x]);
  image::write_exr(path("a.exr"), exr);
  EXPECT_EQ(image::read_exr(path("a.exr")).mean.pixels, exr.mean.pixels);
}

TEST_F(ExrFile, ABlackVarianceIsBlack) {
  image::write_exr(path("a.exr"), {Image(2, 2), Image(2, 2), {}, {}});
  EXPECT_EQ(image::read_exr(path("a.exr")).variance.pixels, Image(2, 2).pixels);
}

TEST_F(ExrFile, AFailureNamesTheFileAndLeavesNothing) {
  EXPECT_EQ(error_of([&] { image::write_exr(path("no/such/folder.exr"), example()); }),
            path("no/such/folder.exr") + ": cannot write: No such file or directory");
  fs::create_directory(path("taken.exr"));
  EXPECT_NE(
      error_of([&] { image::write_exr(path("taken.exr"), example()); }).find("taken.exr: cannot write: "),
      std::string::npos);
  EXPECT_EQ(files(), 1u);
}

TEST_F(ExrFile, AFullDiskKeepsTheOldFileAndLeavesNoPart) {
  image::write_exr(path("a.exr"), {pattern(2, 2, 1), {}, {}, {}});
  const std::string before = bytes(path("a.exr"));
  // A limit on the size of files acts like a full disk.
  const auto old_handler = signal(SIGXFSZ, SIG_IGN);
  rlimit old_limit{}, limit{};
  getrlimit(RLIMIT_FSIZE, &old_limit);
  limit = old_limit;
  limit.rlim_cur = 1000;
  setrlimit(RLIMIT_FSIZE, &limit);
  const std::string error = error_of([&] {
    image::write_exr(path("a.exr"), {pattern(200, 200, 1), {}, {}, {}});
  });
  setrlimit(RLIMIT_FSIZE, &old_limit);
  signal(SIGXFSZ, old_handler);
  EXPECT_EQ(error, path("a.exr") + ": cannot write: File too large");
  EXPECT_EQ(bytes(path("a.exr")), before);
  EXPECT_EQ(files(), 1u);
}

TEST_F(ExrFile, LayersOfAnotherSizeAreRefused) {
  Exr exr = example();
  exr.layers[1].image = Image(3, 3);
  EXPECT_EQ(error_of([&] { image::write_exr(path("a.exr"), exr); }),
            path("a.exr") + ": channel depth.Z: wanted 17 x 9, found 3 x 3");
  EXPECT_EQ(files(), 0u);
}

TEST_F(ExrFile, WhatIsNoExrIsRefused) {
  std::ofstream(path("a.exr")) << "hello";
  EXPECT_NE(error_of([&] { image::read_exr(path("a.exr")); }).find("a.exr: cannot read"), std::string::npos);
  EXPECT_NE(error_of([&] { image::read_exr(path("none.exr")); }).find("none.exr: cannot read"),
            std::string::npos);
}

TEST_F(Environment, ExrIsReadAsItIs) {
  const Image map = pattern(8, 4, 1000);
  image::write_exr(path("sky.exr"), {map, {}, {}, {}});
  EXPECT_EQ(image::read_environment(path("sky.exr")).pixels, map.pixels);
}

TEST_F(Environment, LayersBesideTheColoursDoNotMatter) {
  image::write_exr(path("sky.EXR"), example());
  EXPECT_EQ(image::read_environment(path("sky.EXR")).pixels, example().mean.pixels);
}

TEST_F(Environment, BadTexelsAreRefusedByPlace) {
  for (const auto& [value, text] : {std::pair{NAN, "nan"}, {INFINITY, "inf"}, {-.5f, "-0.5"}}) {
    Image map = pattern(8, 4, 1);
    map.at(5, 2).y = value;
    image::write_exr(path("sky.exr"), {map, {}, {}, {}});
    EXPECT_EQ(error_of([&] {
                image::read_environment(path("sky.exr"));
              }).find(path("sky.exr") + ": texel (5, 2): wanted finite radiance of at least 0, found "),
              0u);
    EXPECT_NE(error_of([&] { image::read_environment(path("sky.exr")); }).find(text), std::string::npos);
  }
}

TEST_F(Environment, OtherFilesAreRefused) {
  std::ofstream(path("sky.png")) << "x";
  EXPECT_EQ(error_of([&] { image::read_environment(path("sky.png")); }),
            path("sky.png") + ": wanted an environment map in .exr or .hdr, found .png");
  EXPECT_NE(error_of([&] { image::read_environment(path("none.hdr")); }).find("none.hdr: cannot read"),
            std::string::npos);
  image::write_exr(path("sky.exr"), {pattern(8, 4, 1), {}, {}, {}});
  EXPECT_NE(error_of([&] { image::read_environment(path("sky.exr"), {.side = 7}); }).find("found 8 x 4"),
            std::string::npos);
}

// OpenEXR takes the memory a header asks for before it finds that the file is short. scripts/mutate found 443
// bytes that took 1.8 GB.
TEST_F(Environment, HeadersThatLieAreRefusedBeforeOpenExrSeesThem) {
  image::write_exr(path("sky.exr"), {pattern(8, 4, 1), {}, {}, {}});
  const std::string whole = bytes(path("sky.exr"));
  const auto with = [&](const std::string& key, std::size_t at, const std::string& value) {
    std::string file = whole;
    const std::size_t place = file.find(key);
    EXPECT_NE(place, std::string::npos) << key;
    file.replace(place + at, value.size(), value);
    std::ofstream(path("bad.exr"), std::ios::binary) << file;
    return error_of([&] { image::read_environment(path("bad.exr")); });
  };
  const std::string channels("channels\0chlist\0", 16), window("dataWindow\0box2i\0\x10\0\0\0", 21),
      compression("compression\0compression\0\1\0\0\0", 28), magic("v/1\1", 4);
  EXPECT_EQ(with(magic, 0, "v"), "no error");
  const std::pair<std::string, const char*> bad[] = {
      {with(magic, 4, "\1"), "version 2, one part"},
      {with(magic, 5, "\x10"), "version 2, one part"},  // parts
      {with(magic, 5, "\x08"), "version 2, one part"},  // deep
      {with(magic, 5, "\2"), "tiles where there are any"},
      {with(channels, 16, "\x65\x74\x61\x65"), "attribute channels to end in the file"},
      {with(channels, 16, "\xff\xff\xff\xff"), "attribute channels to end in the file"},
      {with(channels, 16, std::string("\x36\0\0\0", 4)), "attribute channels of type chlist and its length"},
      {with(window, 17, std::string("\x0f\0\0\0", 4)), "attribute dataWindow of type box2i and its length"},
      {with(channels, 0, "x"), "cannot read"},
      {with(window, 21 + 8, "\xff\xff\xff\x7f"), "header: wanted a size"},
      {with(window, 21 + 12, std::string("\xff\x3f\0\0", 4)), "a table of "},
      {with(window, 0, "x"), "a data window, a compression"},
      {with(compression, 28, "\x4d"), "a known compression, found 77"}};
  for (const auto& [said, wanted] : bad)
    EXPECT_NE(said.find(wanted), std::string::npos) << wanted << ": " << said;

  // A list of channels that ends, with the file, within a channel.
  std::string cut = whole.substr(0, whole.find(channels) + 16 + 4 + 0x30);
  cut[whole.find(channels) + 16] = 0x30;
  std::ofstream(path("bad.exr"), std::ios::binary) << cut;
  EXPECT_NE(error_of([&] { image::read_environment(path("bad.exr")); }).find("type chlist and its length"),
            std::string::npos);
}

// What other programs write into headers, and the same with a length that lies within.
TEST_F(Environment, PreviewsAndListsOfStringsMayStandInAHeader) {
  image::write_exr(path("sky.exr"), {pattern(8, 4, 1), {}, {}, {}});
  const std::string whole = bytes(path("sky.exr"));
  const auto with = [&](const std::string& type, const std::string& data, const std::string& name = "x") {
    const std::string attribute = name + std::string(1, '\0') + type + std::string(1, '\0') +
                                  std::string{static_cast<char>(data.size()), 0, 0, 0} + data;
    std::ofstream(path("more.exr"), std::ios::binary) << whole.substr(0, 8) << attribute << whole.substr(8);
    return error_of([&] { image::read_environment(path("more.exr")); });
  };
  // The places of the blocks in the file are those without the attribute: reading fails behind the header.
  for (const auto& [type, good, bad] :
       {std::array<std::string, 3>{"preview", {"\1\0\0\0\1\0\0\0abcd", 12}, {"\1\0\0\0\2\0\0\0abcd", 12}},
        {"stringvector", {"\1\0\0\0a\2\0\0\0bc", 11}, {"\1\0\0\0a\3\0\0\0bc", 11}},
        {"stringvector", "", {"\xff\xff\xff\x7f", 4}},
        {"unheard of", "anything", {"\0", 0}}}) {
    EXPECT_EQ(with(type, good).find("of the OpenEXR header"), std::string::npos) << with(type, good);
    if (bad.empty()) continue;
    EXPECT_NE(with(type, bad).find("of the OpenEXR header"), std::string::npos) << with(type, bad);
  }
  // Names, too, have an end: an error that quotes one stays short.
  for (const std::string::size_type length : {255, 256}) {
    const std::string long_name(length, 'n');
    const std::string said[] = {with("text", "anything", long_name), with(long_name, "anything")};
    for (const std::string& error : said)
      EXPECT_EQ(error.find("wanted a name of at most 255 characters, found 256") != std::string::npos,
                length == 256)
          << error;
  }
}

TEST_F(Environment, EveryPrefixOfAFileIsRefused) {
  image::write_exr(path("sky.exr"), {pattern(32, 16, 1), {}, {}, {}});
  const std::string whole = bytes(path("sky.exr"));
  for (std::size_t size = 0; size < whole.size(); size += 16) {
    std::ofstream(path("part.exr"), std::ios::binary) << whole.substr(0, size);
    EXPECT_NE(error_of([&] { image::read_environment(path("part.exr")); }).find("part.exr: "),
              std::string::npos)
        << size;
  }
}
