// Reading and writing picture files; owns OpenImageIO in the judge. Every failure is a base::Error of one
// line. Writing is atomic: a temporary file in the same folder, then a rename, so a reader never sees half a
// file.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "image/image.h"

namespace image {

// EXR as docs/formats.md (channels found by name, never by position), Radiance .hdr, PNG or JPEG (decoded to
// linear with the sRGB curve, unless a PNG says it is linear). A grey picture becomes three equal channels.
Render read_render(const std::string& path);

// Mean as float, variance as half with its scale in the header, every other layer as float, ZIP compressed.
// The same render gives the same bytes.
void write_exr(const std::string& path, const Render& render);

// What the numbers given to a PNG are: linear ones go through the sRGB curve, encoded ones are written as
// they are.
enum class Encoding { linear, srgb };

// 8-bit PNG of an image with 1 or 3 channels; clamped to [0,1], NaN black.
void write_png(const std::string& path, const Image& image, Encoding encoding);
std::vector<std::uint8_t> png_bytes(const Image& image, Encoding encoding);

// Writes any bytes atomically, creating missing folders.
void write_file(const std::string& path, const void* bytes, std::size_t size);

// The sRGB transfer curve, IEC 61966-2-1, both ways.
float srgb_to_linear(float encoded);
float linear_to_srgb(float linear);

}  // namespace image
