// Image files to numbers: textures from memory, environment maps from disk.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "image/image.h"
#include "math/vec.h"

namespace image {

// What a file's header may claim before any pixel is allocated.
struct Limits {
  int side = 16384;
  std::int64_t pixels = std::int64_t{1} << 26;
};

// A texture: codes as the file has them (of 16 bits, 8-bit ones times 257; sRGB *not* decoded), alpha
// unassociated and 65535 where the file has none; grey and palette expanded.
struct Decoded {
  int width = 0, height = 0;
  int channels = 0;                   // 1 grey, 2 grey and alpha, 3 RGB, 4 RGBA (palette files: 3 or 4)
  std::vector<math::U16Vec4> texels;  // row-major from the top
};

// Decodes a PNG or a JPEG, recognised by its first bytes. `what` names the image in error messages. Throws
// base::Error for every other format (named where it is known), for CMYK JPEGs, sizes beyond the limits,
// truncated or corrupt data. Embedded gamma, profiles and orientation are ignored, as glTF demands.
Decoded decode(const std::uint8_t* bytes, std::size_t size, const std::string& what,
               const Limits& limits = {});

// Reads a latitude-longitude map from an .exr or .hdr file: linear radiance from the channels R, G, B. Throws
// base::Error if it cannot, and for a texel that is not finite or negative, naming the first one.
Image read_environment(const std::string& path, const Limits& limits = {});

}  // namespace image
