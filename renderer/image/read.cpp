#include "image/read.h"

#include <fstream>
#include <iterator>

#include "image/decode.h"
#include "image/oiio.h"
#include "math/transcendental.h"

namespace image {

namespace {

Image read_encoded(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  const std::vector<std::uint8_t> bytes{std::istreambuf_iterator<char>(file), {}};
  if (!file) base::fail(path, ": cannot read");
  const Decoded decoded = decode(bytes.data(), bytes.size(), path);
  Image image(decoded.width, decoded.height);
  for (std::size_t i = 0; i < image.pixels.size(); ++i)
    for (int c = 0; c < 3; ++c)
      image.pixels[i][c] = math::srgb_to_linear(static_cast<float>(decoded.texels[i][c]) / 65535);
  return image;
}

}  // namespace

Image read_picture(const std::string& path) {
  const std::string extension = lower_extension(path);
  if (extension == ".png" || extension == ".jpg" || extension == ".jpeg") return read_encoded(path);
  if (extension != ".exr" && extension != ".hdr")
    base::fail(path, ": wanted an .exr, .hdr, .png or .jpg, found ",
               extension.empty() ? "no extension" : extension);
  const auto input = open_as(extension, path);
  const OIIO::ImageSpec& spec = input->spec();
  const Limits limits;
  if (spec.width > limits.side || spec.height > limits.side || spec.deep || spec.depth > 1)
    base::fail(path, ": wanted a flat picture of at most ", limits.side, " pixels a side, found another");
  return read_rgb(*input, path);
}

}  // namespace image
