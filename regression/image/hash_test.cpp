#include "image/hash.h"

#include <gtest/gtest.h>

#include <cstdio>
#include <fstream>

#include "base/error.h"

namespace {

// FIPS 180-2, appendix B, and the empty message.
TEST(Hash, AgreesWithThePublishedExamples) {
  EXPECT_EQ(image::sha256("abc"), "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
  EXPECT_EQ(image::sha256(""), "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
  image::Hasher pieces;
  pieces.add("a");
  pieces.add("");
  pieces.add("bc");
  EXPECT_EQ(pieces.hex(), image::sha256("abc"));
}

TEST(Hash, OfAFileIsThatOfItsBytes) {
  const std::string path = testing::TempDir() + "assay_hash_test.bin", bytes(200000, 'x');
  std::ofstream(path, std::ios::binary) << bytes;
  EXPECT_EQ(image::sha256_file(path), image::sha256(bytes));
  std::remove(path.c_str());
  EXPECT_THROW(image::sha256_file(path), base::Error);
  EXPECT_THROW(image::sha256_file(testing::TempDir()), base::Error);
}

// The bytes of the definition, written out: 2, 1, then 1.0 -2.0 0.5 0 0 0.
TEST(Hash, OfPixelsIsThatOfSizeAndFloatsInLittleEndianOrder) {
  image::Image image(2, 1, 3);
  image.data = {1, -2, 0.5f, 0, 0, 0};
  const std::string bytes("\x02\0\0\0\x01\0\0\0\0\0\x80\x3f\0\0\0\xc0\0\0\0\x3f\0\0\0\0\0\0\0\0\0\0\0\0", 32);
  EXPECT_EQ(image::pixel_hash(image), image::sha256(bytes));
  image::Image turned = image;
  std::swap(turned.width, turned.height);
  EXPECT_NE(image::pixel_hash(turned), image::pixel_hash(image)) << "the shape is part of the hash";
}

}  // namespace
