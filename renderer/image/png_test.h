// For the tests of this room: a PNG encoder for the few lines that a test wants to control, chunks by hand
// and zlib without compression.
#pragma once

#include <algorithm>
#include <cstdint>
#include <string>
#include <vector>

namespace image::test {

using Bytes = std::vector<std::uint8_t>;

inline void put32(Bytes& out, std::uint32_t v) {
  for (int shift = 24; shift >= 0; shift -= 8) out.push_back(static_cast<std::uint8_t>(v >> shift));
}
inline void chunk(Bytes& out, const std::string& kind, const Bytes& data) {
  put32(out, static_cast<std::uint32_t>(data.size()));
  Bytes body(kind.begin(), kind.end());
  body.insert(body.end(), data.begin(), data.end());
  std::uint32_t crc = 0xffffffff;
  for (std::uint8_t b : body) {
    crc ^= b;
    for (int i = 0; i < 8; ++i) crc = crc & 1 ? crc >> 1 ^ 0xedb88320 : crc >> 1;
  }
  out.insert(out.end(), body.begin(), body.end());
  put32(out, ~crc);
}
inline Bytes zlib(const Bytes& raw) {
  const auto low = [](std::size_t v) { return static_cast<std::uint8_t>(v & 255); };
  Bytes out = {0x78, 0x01};
  std::uint32_t a = 1, b = 0;
  for (std::uint8_t v : raw) a = (a + v) % 65521, b = (b + a) % 65521;
  for (std::size_t at = 0; at < raw.size(); at += 65535) {
    const std::size_t n = std::min<std::size_t>(65535, raw.size() - at);
    out.insert(out.end(),
               {static_cast<std::uint8_t>(at + n == raw.size()), low(n), low(n >> 8), low(~n), low(~n >> 8)});
    out.insert(out.end(), raw.begin() + static_cast<std::ptrdiff_t>(at),
               raw.begin() + static_cast<std::ptrdiff_t>(at + n));
  }
  put32(out, b << 16 | a);
  return out;
}
struct Png {
  std::uint32_t width, height;
  std::uint8_t depth, color_type;
  std::vector<Bytes> rows;  // packed, without filter byte; with Adam7: of the passes
  bool interlaced = false;
  Bytes palette = {}, transparency = {};
};
inline Bytes encode(const Png& png) {
  Bytes out = {0x89, 'P', 'N', 'G', '\r', '\n', 0x1a, '\n'}, header, raw;
  put32(header, png.width), put32(header, png.height);
  header.insert(header.end(), {png.depth, png.color_type, 0, 0, static_cast<std::uint8_t>(png.interlaced)});
  chunk(out, "IHDR", header);
  chunk(out, "gAMA", {0, 0, 0xb1, 0x8f});  // to be ignored
  if (!png.palette.empty()) chunk(out, "PLTE", png.palette);
  if (!png.transparency.empty()) chunk(out, "tRNS", png.transparency);
  for (const Bytes& row : png.rows) {
    raw.push_back(0);
    raw.insert(raw.end(), row.begin(), row.end());
  }
  chunk(out, "IDAT", zlib(raw));
  chunk(out, "IEND", {});
  return out;
}

}  // namespace image::test
