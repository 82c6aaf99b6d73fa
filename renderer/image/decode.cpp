#include "image/decode.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <string_view>

#include "image/guard.h"
#include "image/oiio.h"

namespace image {

namespace {

// The name of a format that is not read, for the message.
std::string name_of_format(Bytes bytes) {
  if (bytes.empty()) return "no data";
  const std::string_view head(reinterpret_cast<const char*>(bytes.data()),
                              std::min<std::size_t>(bytes.size(), 16));
  constexpr std::pair<std::string_view, const char*> known[] = {
      {"\xabKTX 20", "KTX2"}, {"\xabKTX 11", "KTX"}, {"GIF8", "GIF"},
      {"BM", "BMP"},          {"DDS ", "DDS"},       {"\x76\x2f\x31\x01", "OpenEXR"},
      {"#?", "Radiance HDR"}, {"8BPS", "Photoshop"}, {"II*", "TIFF"},
      {"MM", "TIFF"}};
  for (const auto& [magic, name] : known)
    if (head.starts_with(magic)) return name;
  if (head.starts_with("RIFF") && head.substr(std::min<std::size_t>(head.size(), 8)).starts_with("WEBP"))
    return "WebP";
  return "an unknown format";
}

}  // namespace

Decoded decode(const std::uint8_t* data, std::size_t size, const std::string& what, const Limits& limits) {
  const Bytes bytes(data, size);
  constexpr std::uint8_t png[] = {0x89, 'P', 'N', 'G', '\r', '\n', 0x1a, '\n'}, jpeg[] = {0xff, 0xd8, 0xff};
  const bool is_png = size >= sizeof png && std::equal(std::begin(png), std::end(png), data);
  const bool is_jpeg = size >= sizeof jpeg && std::equal(std::begin(jpeg), std::end(jpeg), data);
  if (!is_png && !is_jpeg) base::fail(what, ": wanted a PNG or JPEG image, found ", name_of_format(bytes));
  is_png ? check_png(bytes, what, limits) : check_jpeg(bytes, what, limits);

  OIIO::Filesystem::IOMemReader memory(const_cast<std::uint8_t*>(data), size);  // only reads
  const auto input = open_as(is_png ? ".png" : ".jpeg", what, &memory);
  const OIIO::ImageSpec& spec = input->spec();
  check_size(what, spec.width, spec.height, limits);
  if (spec.nchannels < 1 || spec.nchannels > 4 || spec.depth > 1)
    base::fail(what, ": wanted 1 to 4 channels, found ", spec.nchannels);

  // Read some rows at a time as 16 bits, which holds 8 bits exactly as multiples of 257.
  Decoded decoded{spec.width, spec.height, spec.nchannels, {}};
  decoded.texels.reserve(static_cast<std::size_t>(spec.width) * static_cast<std::size_t>(spec.height));
  constexpr int rows = 64;
  const std::size_t channels = static_cast<std::size_t>(spec.nchannels), step = channels <= 2 ? 0 : 1;
  std::vector<std::uint16_t> values(rows * static_cast<std::size_t>(spec.width) * channels);
  for (int y = 0; y < spec.height; y += rows) {
    const int end = std::min(y + rows, spec.height);
    if (!input->read_scanlines(0, 0, y, end, 0, 0, spec.nchannels, OIIO::TypeUInt16, values.data()))
      base::fail(what, ": cannot decode rows ", y, " to ", end - 1, ": ", input->geterror());
    const std::size_t pixels = static_cast<std::size_t>(end - y) * static_cast<std::size_t>(spec.width);
    for (std::size_t i = 0; i < pixels * channels; i += channels)
      decoded.texels.emplace_back(values[i], values[i + step], values[i + 2 * step],
                                  channels % 2 == 0 ? values[i + channels - 1] : std::uint16_t{65535});
  }
  if (input->has_error()) base::fail(what, ": cannot decode: ", input->geterror());
  return decoded;
}

Image read_environment(const std::string& path, const Limits& limits) {
  const std::string extension = lower_extension(path);
  if (extension != ".exr" && extension != ".hdr")
    base::fail(path, ": wanted an environment map in .exr or .hdr, found ",
               extension.empty() ? "no extension" : extension);
  if (extension == ".exr") {
    std::error_code error;
    const std::uint64_t size = std::filesystem::file_size(path, error);
    std::vector<std::uint8_t> head(error ? 0 : std::min<std::uint64_t>(size, exr_head));
    if (std::ifstream(path, std::ios::binary)
            .read(reinterpret_cast<char*>(head.data()), static_cast<std::streamsize>(head.size())) &&
        !head.empty())
      check_exr(head, size, path, limits);
  }
  const auto input = open_as(extension, path);
  const OIIO::ImageSpec& spec = input->spec();
  check_size(path, spec.width, spec.height, limits);
  if (spec.deep || spec.depth > 1 || spec.x != spec.full_x || spec.y != spec.full_y ||
      spec.width != spec.full_width || spec.height != spec.full_height)
    base::fail(
        path,
        ": wanted a flat image whose data fill its window, found deep data or a smaller or larger window");
  Image image = read_rgb(*input, path);
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x) {
      const math::Vec3& texel = image.at(x, y);
      if (!math::is_finite(texel) || texel.x < 0 || texel.y < 0 || texel.z < 0)
        base::fail(path, ": texel (", x, ", ", y, "): wanted finite radiance of at least 0, found ", texel.x,
                   " ", texel.y, " ", texel.z);
    }
  return image;
}

}  // namespace image
