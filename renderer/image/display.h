// From radiance to a picture for the eye.
#pragma once

#include <array>
#include <cstdint>
#include <string>

#include "image/image.h"

namespace image {

struct Display {
  float exposure = 0;   // stops: radiance is multiplied by 2^exposure
  float gamma = 0;      // > 0: encoded = value^(1/gamma); 0: the sRGB transfer function, IEC 61966-2-1
  bool filmic = false;  // first compress highlights by Narkowicz's fit of ACES (2015)
};

// Radiance 1 is white; above it is cut. Negative values and NaN give 0, infinity gives 255.
std::array<std::uint8_t, 3> to_display(const math::Vec3& radiance, const Display& display);

// Writes .png or .jpg (8 bits, by `display`) or .hdr (RGBE: linear radiance, `display` not applied; negative
// values and NaN become 0), by the extension. Returns the number of pixels that held a NaN, infinity or
// negative value. The file appears whole or not at all; throws base::Error.
std::int64_t write_display(const std::string& path, const Image& image, const Display& display);

}  // namespace image
