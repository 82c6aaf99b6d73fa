// What is judged of an image before a decoder sees it. Private to this room.
#pragma once

#include <cstdint>
#include <span>
#include <string>

#include "image/decode.h"

namespace image {

using Bytes = std::span<const std::uint8_t>;

// Refuses a size of 0 or beyond the limits. Throws base::Error, as all of these.
void check_size(const std::string& what, std::int64_t width, std::int64_t height, const Limits& limits);

// Refuses a PNG that libpng would refuse, which writes to stderr when it does: every chunk it needs, its
// checksum, length and place, and what is compressed. Nothing is allocated for the pixels.
void check_png(Bytes bytes, const std::string& what, const Limits& limits);

// Refuses a JPEG by its frame header: size and number of components.
void check_jpeg(Bytes bytes, const std::string& what, const Limits& limits);

// Refuses an OpenEXR file by its header, for which OpenEXR would take whatever it says: `head` is the
// beginning of a file of `size` bytes, all of its header.
void check_exr(Bytes head, std::uint64_t size, const std::string& what, const Limits& limits);
constexpr std::size_t exr_head = std::size_t{1} << 20;  // as much of the file as it needs

}  // namespace image
