// SHA-256 in lower-case hexadecimal, as every hash of docs/formats.md.
#pragma once

#include <string>
#include <string_view>

#include "image/image.h"

namespace image {

std::string sha256(std::string_view bytes);
std::string sha256_file(const std::string& path);

// SHA-256 over several pieces as if they were one.
class Hasher {
 public:
  Hasher();
  ~Hasher();
  Hasher(const Hasher&) = delete;
  Hasher& operator=(const Hasher&) = delete;
  void add(std::string_view bytes);
  void add_file(const std::string& path);
  std::string hex();  // finishes: call once

 private:
  void* context_;
};

// Of width and height as little-endian uint32 and the float32 R G B pixels, row-major from the top.
std::string pixel_hash(const Image& rgb);

}  // namespace image
