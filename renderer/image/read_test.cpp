#include "image/read.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <fstream>

#include "base/error.h"
#include "image/display.h"
#include "image/exr.h"

namespace image {
namespace {

class ReadPicture : public testing::Test {
 protected:
  void SetUp() override { std::filesystem::create_directories(folder_); }
  void TearDown() override { std::filesystem::remove_all(folder_); }
  std::string file(const std::string& name) const { return folder_ + "/" + name; }

 private:
  const std::string folder_ = testing::TempDir() + "assay-read-" + std::to_string(getpid());
};

Image gradient() {
  Image image(17, 5);
  for (int y = 0; y < 5; ++y)
    for (int x = 0; x < 17; ++x)
      image.at(x, y) = {static_cast<float>(x) / 16, static_cast<float>(y) / 4, .25f};
  return image;
}

TEST_F(ReadPicture, an_exr_comes_back_bit_by_bit_negative_values_too) {
  Exr exr;
  exr.mean = gradient();
  exr.mean.at(3, 2) = {-1, 1e9f, 0};
  exr.variance = gradient();
  write_exr(file("a.exr"), exr);
  EXPECT_EQ(read_picture(file("a.exr")).pixels, exr.mean.pixels);
}

// 8 bits: the error in linear light is at most half a code times the curve's slope, 2.4 at white.
TEST_F(ReadPicture, a_png_of_ours_comes_back_to_its_radiance) {
  const Image image = gradient();
  write_display(file("a.png"), image, {});
  const Image read = read_picture(file("a.png"));
  ASSERT_EQ(read.width, 17);
  ASSERT_EQ(read.height, 5);
  for (std::size_t i = 0; i < image.pixels.size(); ++i)
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(read.pixels[i][c], image.pixels[i][c], 2.4 * .51 / 255);
}

TEST_F(ReadPicture, what_is_no_picture_is_refused_by_name) {
  std::ofstream(file("no.png")) << "text";
  std::ofstream(file("no.exr")) << "text";
  for (const char* name : {"no.png", "no.exr", "none.png", "none.exr", "a.tiff", "a"})
    EXPECT_THROW(
        try { read_picture(file(name)); } catch (const base::Error& error) {
          EXPECT_NE(std::string(error.what()).find(name), std::string::npos) << error.what();
          throw;
        },
        base::Error);
}

}  // namespace
}  // namespace image
