#include "image/display.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "image/oiio.h"
#include "math/transcendental.h"

namespace image {

namespace {

float encode(float value, const Display& display) {
  // Cut to what can be told apart, so that infinity stays the brightest of all; NaN fails every comparison.
  value = value > 0 ? std::min(value * math::pow(2.f, display.exposure), 1e6f) : 0;
  if (display.filmic) value = value * (2.51f * value + .03f) / (value * (2.43f * value + .59f) + .14f);
  value = std::min(value, 1.f);
  if (display.gamma > 0) return math::pow(value, 1 / display.gamma);
  return value <= .0031308f ? 12.92f * value : 1.055f * math::pow(value, 1 / 2.4f) - .055f;
}

}  // namespace

std::array<std::uint8_t, 3> to_display(const math::Vec3& radiance, const Display& display) {
  std::array<std::uint8_t, 3> code;
  for (int c = 0; c < 3; ++c)
    code[static_cast<std::size_t>(c)] = static_cast<std::uint8_t>(encode(radiance[c], display) * 255 + .5f);
  return code;
}

std::int64_t write_display(const std::string& path, const Image& image, const Display& display) {
  const std::string extension = lower_extension(path);
  if (extension != ".png" && extension != ".jpg" && extension != ".jpeg" && extension != ".hdr")
    base::fail(path, ": wanted an extension of .png, .jpg or .hdr");

  const bool linear = extension == ".hdr";
  OIIO::ImageSpec spec(image.width, image.height, 3, linear ? OIIO::TypeFloat : OIIO::TypeUInt8);
  spec.attribute("oiio:ColorSpace", linear ? "linear" : "sRGB");
  if (linear) {
    // RGBE has no sign, NaN or infinity, and OpenImageIO would wrap negative values round to large ones.
    std::vector<math::Vec3> pixels = image.pixels;
    for (math::Vec3& pixel : pixels)
      for (int c = 0; c < 3; ++c) pixel[c] = pixel[c] > 0 ? std::min(pixel[c], 1e38f) : 0;
    write_as(extension, path, spec, OIIO::TypeFloat, pixels.data());
  } else {
    spec.attribute("compression", "jpeg:95");
    std::vector<std::array<std::uint8_t, 3>> pixels;
    for (const math::Vec3& pixel : image.pixels) pixels.push_back(to_display(pixel, display));
    write_as(extension, path, spec, OIIO::TypeUInt8, pixels.data());
  }
  return std::count_if(image.pixels.begin(), image.pixels.end(), [](const math::Vec3& pixel) {
    return !math::is_finite(pixel) || pixel.x < 0 || pixel.y < 0 || pixel.z < 0;
  });
}

}  // namespace image
