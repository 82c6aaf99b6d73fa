#include "image/io.h"

#include <OpenImageIO/imageio.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>

#include "base/error.h"
#include "image/hash.h"

namespace {

namespace fs = std::filesystem;
using image::Image;
using image::Render;

constexpr float infinity = std::numeric_limits<float>::infinity();

// A folder of this test's own, gone when it ends.
class ImageFiles : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::temp_directory_path() / ("assay_image_test_" + std::to_string(::getpid()));
    fs::create_directories(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }
  std::string file(const std::string& name) const { return (folder_ / name).string(); }
  std::string file(const std::string& name, const std::string& bytes) const {
    std::ofstream(file(name), std::ios::binary) << bytes;
    return file(name);
  }
  static std::string bytes_of(const std::string& path) {
    std::ifstream in(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
  }
  fs::path folder_;
};

// The error's text, or "" if there was none.
std::string error_of(const std::string& path) {
  try {
    image::read_render(path);
  } catch (const base::Error& error) {
    return error.what();
  }
  return "";
}

void expect_one_line_about(const std::string& path) {
  const std::string error = error_of(path);
  EXPECT_NE(error.find(path), std::string::npos) << "error: " << error;
  EXPECT_EQ(error.find('\n'), std::string::npos) << "error: " << error;
}

Image counted(int width, int height, int channels, float first, float step) {
  Image image(width, height, channels);
  for (std::size_t i = 0; i < image.data.size(); ++i) image.data[i] = first + step * static_cast<float>(i);
  return image;
}

void write_with_oiio(const std::string& path, const OIIO::ImageSpec& spec, const std::vector<float>& pixels) {
  const auto output = OIIO::ImageOutput::create(path);
  ASSERT_TRUE(output);
  ASSERT_TRUE(output->open(path, spec)) << output->geterror();
  ASSERT_TRUE(output->write_image(OIIO::TypeFloat, pixels.data()));
  ASSERT_TRUE(output->close());
}

TEST_F(ImageFiles, EverythingInARenderComesBackAsItWasWritten) {
  Render render;
  render.mean = counted(5, 3, 3, -1.5f, 0.37f);
  render.mean.at(2, 1, 0) = std::nanf("");
  render.mean.at(3, 1, 2) = 1e30f;
  render.layers["albedo"] = counted(5, 3, 3, 0, 0.01f);
  render.layers["normal"] = counted(5, 3, 3, -1, 0.02f);
  render.layers["position"] = counted(5, 3, 3, 1e5f, 0.125f);
  render.layers["depth"] = counted(5, 3, 1, 3, 1);
  render.layers["replicate0"] = counted(5, 3, 3, 7, 1);
  render.layers["replicate1"] = counted(5, 3, 3, 8, 1);
  render.layers["A"] = counted(5, 3, 1, 0, 0.05f);
  render.header["assay:seed"] = 42;
  render.header["assay:scale"] = 0.1f;
  render.header["assay:because"] = std::string("a \"reason\", with commas; and more");
  render.header["assay:tiles"] = std::vector<float>{1, 0.1f, -3e-30f, 16777216, infinity};
  render.header["assay:none"] = std::vector<float>{};
  render.header["assay:like"] = std::string("float[2] 1");
  image::write_exr(file("a.exr"), render);
  const Render back = image::read_render(file("a.exr"));

  const auto same = [](const Image& a, const Image& b) {
    EXPECT_TRUE(a.same_shape(b));
    for (std::size_t i = 0; i < a.data.size(); ++i)
      EXPECT_TRUE(a.data[i] == b.data[i] || (std::isnan(a.data[i]) && std::isnan(b.data[i]))) << i;
  };
  same(render.mean, back.mean);
  EXPECT_EQ(render.layers.size(), back.layers.size());
  for (const auto& [name, layer] : render.layers) {
    SCOPED_TRACE(name);
    ASSERT_TRUE(back.layers.count(name));
    same(layer, back.layers.at(name));
  }
  EXPECT_EQ(render.header, back.header);
  EXPECT_FALSE(back.variance);
  EXPECT_FALSE(back.display_referred);
  EXPECT_EQ(image::replicates(back).size(), 2u);
  EXPECT_EQ(image::header_int(back.header, "assay:seed"), 42);
  EXPECT_EQ(image::header_float(back.header, "assay:seed"), 42.0f);
  EXPECT_EQ(image::header_int(back.header, "assay:because"), std::nullopt);
  EXPECT_EQ(image::count_non_finite(back.mean), 1u);
  EXPECT_EQ(image::pixel_hash(render.mean), image::pixel_hash(back.mean));
}

TEST_F(ImageFiles, TheSameRenderGivesTheSameBytesAndLeavesNoTemporaryFile) {
  Render render;
  render.mean = counted(4, 4, 3, 0, 1);
  render.header["assay:seed"] = 1;
  image::write_exr(file("a.exr"), render);
  image::write_exr(file("b.exr"), render);
  image::write_exr(file("b.exr"), render);
  EXPECT_EQ(bytes_of(file("a.exr")), bytes_of(file("b.exr")));
  EXPECT_EQ(std::distance(fs::directory_iterator(folder_), {}), 2);
}

TEST_F(ImageFiles, AVarianceOfAnySizeSurvivesHalfFloats) {
  for (const float magnitude : {1e-30f, 1e-9f, 1.0f, 1e6f, 1e30f}) {
    SCOPED_TRACE(magnitude);
    Render render;
    render.mean = Image(3, 1, 3, 1);
    render.variance = Image(3, 1, 3, magnitude);
    render.variance->at(0, 0, 0) = 0;
    render.variance->at(1, 0, 1) = magnitude * 0.001f;
    render.variance->at(1, 0, 2) = magnitude * 1e-8f;
    image::write_exr(file("v.exr"), render);
    const Render back = image::read_render(file("v.exr"));
    ASSERT_TRUE(back.variance);
    EXPECT_TRUE(back.layers.empty());
    EXPECT_TRUE(back.header.empty());
    EXPECT_EQ(back.variance->at(0, 0, 0), 0);
    EXPECT_NEAR(back.variance->at(0, 0, 1) / magnitude, 1, 1.0 / 2048);
    EXPECT_NEAR(back.variance->at(1, 0, 1) / magnitude, 0.001, 0.001 / 2048);
    EXPECT_NEAR(back.variance->at(1, 0, 2) / magnitude, 1e-8, 1e-9);
  }
}

TEST_F(ImageFiles, ATinyVarianceBesideAHugeOneDoesNotBecomeZeroAndInfinityStays) {
  Render render;
  render.mean = Image(3, 1, 3, 1);
  render.variance = Image(3, 1, 3, 1e20f);
  render.variance->at(1, 0, 0) = 1e-20f;
  render.variance->at(2, 0, 0) = infinity;
  image::write_exr(file("v.exr"), render);
  const Render back = image::read_render(file("v.exr"));
  EXPECT_GT(back.variance->at(1, 0, 0), 0);
  EXPECT_EQ(back.variance->at(2, 0, 0), infinity);
}

TEST_F(ImageFiles, ChannelsAreFoundByNameWhateverTheirOrder) {
  OIIO::ImageSpec spec(1, 1, 8, OIIO::TypeFloat);
  spec.channelnames = {"variance.B", "B", "normal.Z", "G", "normal.X", "R", "normal.Y", "Zz"};
  write_with_oiio(file("o.exr"), spec, {0.5f, 3, 30, 2, 10, 1, 20, 7});
  EXPECT_NE(error_of(file("o.exr")).find("variance: wanted R G B"), std::string::npos)
      << error_of(file("o.exr"));
  spec.channelnames[0] = "odd.B";
  write_with_oiio(file("o.exr"), spec, {0.5f, 3, 30, 2, 10, 1, 20, 7});
  const Render render = image::read_render(file("o.exr"));
  EXPECT_EQ(render.mean.data, (std::vector<float>{1, 2, 3}));
  EXPECT_EQ(render.layers.at("normal").data, (std::vector<float>{10, 20, 30}));
  EXPECT_EQ(render.layers.at("Zz").data, (std::vector<float>{7}));
  EXPECT_EQ(render.layers.at("odd").data, (std::vector<float>{0.5f}));
}

TEST_F(ImageFiles, AGreyPictureHasThreeEqualChannelsAndMissingColoursAreNamed) {
  OIIO::ImageSpec grey(2, 1, 1, OIIO::TypeFloat);
  grey.channelnames = {"Y"};
  write_with_oiio(file("g.exr"), grey, {0.25f, 4});
  EXPECT_EQ(image::read_render(file("g.exr")).mean.data, (std::vector<float>{0.25f, 0.25f, 0.25f, 4, 4, 4}));
  OIIO::ImageSpec two(2, 1, 2, OIIO::TypeFloat);
  two.channelnames = {"R", "B"};
  write_with_oiio(file("t.exr"), two, {1, 2, 3, 4});
  EXPECT_NE(error_of(file("t.exr")).find("wanted R G B or Y, found R B"), std::string::npos)
      << error_of(file("t.exr"));
}

TEST_F(ImageFiles, APngIsDecodedFromSrgbUnlessItSaysItIsLinearAndAlphaDoesNotDarkenIt) {
  OIIO::ImageSpec spec(1, 1, 4, OIIO::TypeUInt8);
  spec.attribute("oiio:UnassociatedAlpha", 1);
  write_with_oiio(file("a.png"), spec, {188 / 255.f, 10 / 255.f, 1, 0.2f});
  const Render render = image::read_render(file("a.png"));
  EXPECT_TRUE(render.display_referred);
  EXPECT_NEAR(render.mean.at(0, 0, 0), std::pow((188 / 255.0 + 0.055) / 1.055, 2.4), 1e-6);
  EXPECT_NEAR(render.mean.at(0, 0, 1), 10 / 255.0 / 12.92, 1e-7);
  EXPECT_EQ(render.mean.at(0, 0, 2), 1);

  OIIO::ImageSpec linear(1, 1, 3, OIIO::TypeUInt16);
  linear.attribute("oiio:ColorSpace", "Linear");
  write_with_oiio(file("l.png"), linear, {0.5f, 0.25f, 1});
  EXPECT_NEAR(image::read_render(file("l.png")).mean.at(0, 0, 0), 0.5, 1e-5);
}

TEST_F(ImageFiles, APngComesBackWithinHalfAStepAndNaNIsBlack) {
  Image ramp = counted(16, 1, 3, 0, 1 / 47.0f);
  ramp.at(3, 0, 0) = std::nanf("");
  ramp.at(4, 0, 0) = 7;
  ramp.at(5, 0, 0) = -7;
  image::write_png(file("r.png"), ramp, image::Encoding::linear);
  const Image back = image::read_render(file("r.png")).mean;
  EXPECT_EQ(back.at(3, 0, 0), 0);
  EXPECT_EQ(back.at(4, 0, 0), 1);
  EXPECT_EQ(back.at(5, 0, 0), 0);
  for (std::size_t i = 18; i < ramp.data.size(); ++i)
    EXPECT_NEAR(image::linear_to_srgb(back.data[i]), image::linear_to_srgb(ramp.data[i]), 0.501 / 255);
  image::write_png(file("e.png"), ramp, image::Encoding::srgb);
  EXPECT_NEAR(image::read_render(file("e.png")).mean.at(15, 0, 1), image::srgb_to_linear(46 / 47.0f), 0.005);
}

TEST_F(ImageFiles, RadianceAndJpegFilesAreRead) {
  OIIO::ImageSpec spec(16, 2, 3, OIIO::TypeFloat);
  write_with_oiio(file("h.hdr"), spec, std::vector<float>(96, 12.5f));
  const Render hdr = image::read_render(file("h.hdr"));
  EXPECT_FALSE(hdr.display_referred);
  EXPECT_NEAR(hdr.mean.at(7, 1, 2), 12.5, 0.06);
  write_with_oiio(file("j.jpg"), OIIO::ImageSpec(16, 16, 3, OIIO::TypeUInt8), std::vector<float>(768, 0.5f));
  const Render jpeg = image::read_render(file("j.jpg"));
  EXPECT_TRUE(jpeg.display_referred);
  EXPECT_NEAR(jpeg.mean.at(3, 3, 1), image::srgb_to_linear(0.5f), 0.005);
}

TEST_F(ImageFiles, ABadFileIsOneLineThatNamesIt) {
  expect_one_line_about(file("absent.exr"));
  expect_one_line_about(folder_.string());
  expect_one_line_about(file("empty.exr", ""));
  expect_one_line_about(file("text.exr", "not a picture\nat all\n"));
  expect_one_line_about(file("text.png", "\x89PNG\r\n\x1a\n but no more"));
  expect_one_line_about(file("ppm.ppm", "P6 1 1 255\nabc"));
}

// A file claiming 100000 x 100000 pixels in 57 bytes; and an EXR whose data window is as large as 32 bits
// allow.
TEST_F(ImageFiles, AHugeClaimIsRefusedBeforeAnythingIsAllocated) {
  const std::string png(
      "\x89PNG\r\n\x1a\n\0\0\0\rIHDR\0\x01\x86\xa0\0\x01\x86\xa0\x08\x02\0\0\0\x27\x30\x9c\x9f", 33);
  expect_one_line_about(
      file("huge.png", png + std::string("\0\0\0\x0cIDATx\x9c\x03\0\0\0\0\x01\x9a\x60\xe1\xd5", 20)));
  Render render;
  render.mean = Image(2, 2, 3, 1);
  image::write_exr(file("small.exr"), render);
  const std::string good = bytes_of(file("small.exr"));
  const auto window = good.find("dataWindow");
  const auto display = good.find("displayWindow");
  ASSERT_NE(window, std::string::npos);
  for (const std::string& corner :
       {std::string("\xff\xff\xff\x7f\xff\xff\xff\x7f", 8), std::string("\xff\xff\x0f\0\xff\xff\x0f\0", 8),
        std::string("\xff\xff\xff\xff\xff\xff\xff\xff", 8), std::string("\0\0\0\x80\0\0\0\x80", 8)}) {
    std::string bad = good;
    bad.replace(window + 11 + 6 + 4 + 8, 8, corner);  // name 0, type "box2i" 0, size, xMin yMin
    bad.replace(display + 14 + 6 + 4 + 8, 8, corner);
    expect_one_line_about(file("huge.exr", bad));
  }
}

TEST_F(ImageFiles, ATruncatedOrCorruptedFileNeverCrashes) {
  Render render;
  render.mean = counted(17, 19, 3, 0, 0.1f);
  render.variance = Image(17, 19, 3, 0.5f);
  render.header["assay:because"] = std::string("a reason");
  image::write_exr(file("good.exr"), render);
  const std::string exr = bytes_of(file("good.exr"));
  image::write_png(file("good.png"), counted(17, 19, 3, 0, 0.001f), image::Encoding::linear);
  const std::string png = bytes_of(file("good.png"));
  int refused = 0;
  for (std::size_t size = 1; size < exr.size(); size += 97)
    refused += !error_of(file("cut.exr", exr.substr(0, size))).empty();
  EXPECT_EQ(refused, static_cast<int>((exr.size() - 2) / 97 + 1))
      << "a truncated EXR was taken for a whole one";
  for (std::size_t size = 1; size + 40 < png.size(); size += 53)
    EXPECT_NE(error_of(file("cut.png", png.substr(0, size))), "") << size << " of " << png.size();

  // One byte changed at many places, by a fixed rule: any answer but a crash.
  for (std::size_t i = 0; i < exr.size(); i += 3) {
    std::string bad = exr;
    bad[i] = static_cast<char>(bad[i] ^ static_cast<char>(1u << (i / 3 % 8)));
    error_of(file("bent.exr", bad));
  }
}

TEST_F(ImageFiles, WhatCannotBeWrittenIsAnErrorAndLeavesTheOldFileAlone) {
  Render render;
  render.mean = Image(2, 2, 3, 1);
  image::write_exr(file("a.exr"), render);
  const std::string before = bytes_of(file("a.exr"));
  render.layers["albedo"] = Image(3, 2, 3, 1);
  EXPECT_THROW(image::write_exr(file("a.exr"), render), base::Error);
  EXPECT_EQ(bytes_of(file("a.exr")), before);
  EXPECT_THROW(image::write_file(file("a.exr") + "/below/a/file.exr", "x", 1), base::Error);
  EXPECT_THROW(image::png_bytes(Image(), image::Encoding::srgb), base::Error);
  EXPECT_THROW(image::png_bytes(Image(1, 1, 2), image::Encoding::srgb), base::Error);
  image::write_file(file("new/folder/f.txt"), "x", 1);
  EXPECT_EQ(bytes_of(file("new/folder/f.txt")), "x");
}

}  // namespace
