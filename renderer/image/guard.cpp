#include "image/guard.h"

#include <zlib.h>

#include <algorithm>
#include <string_view>
#include <utility>
#include <vector>

#include "base/error.h"

namespace image {

namespace {

unsigned big_endian(Bytes bytes, std::size_t at, int count) {
  unsigned value = 0;
  for (int i = 0; i < count; ++i) value = value << 8 | bytes[at + static_cast<std::size_t>(i)];
  return value;
}

// The scanlines as they are compressed: each its filter's number and then its pixels, interlaced ones in
// seven passes.
class Scanlines {
 public:
  Scanlines(std::int64_t width, std::int64_t height, int bits, bool interlaced) {
    constexpr int x0[] = {0, 4, 0, 2, 0, 1, 0}, dx[] = {8, 8, 4, 4, 2, 2, 1};
    constexpr int y0[] = {0, 0, 4, 0, 2, 0, 1}, dy[] = {8, 8, 8, 4, 4, 2, 2};
    const auto add = [&](std::int64_t columns, std::int64_t rows) {
      const std::int64_t length = 1 + (columns * bits + 7) / 8;
      if (columns > 0 && rows > 0) passes_.push_back({rows, length});
    };
    if (!interlaced) add(width, height);
    for (int i = 0; interlaced && i < 7; ++i)
      add((width - x0[i] + dx[i] - 1) / dx[i], (height - y0[i] + dy[i] - 1) / dy[i]);
  }

  bool complete() const { return pass_ == passes_.size(); }

  // False: a filter that there is not, or more data than pixels.
  bool take(Bytes data) {
    while (!data.empty()) {
      if (complete() || (at_ == 0 && data[0] > 4)) return false;
      const std::int64_t length = passes_[pass_].length;
      const auto part = std::min(static_cast<std::size_t>(length - at_), data.size());
      data = data.subspan(part);
      at_ += static_cast<std::int64_t>(part);
      if (at_ < length) return true;
      at_ = 0;
      if (++row_ == passes_[pass_].rows) row_ = 0, ++pass_;
    }
    return true;
  }

 private:
  struct Pass {
    std::int64_t rows, length;
  };
  std::vector<Pass> passes_;
  std::size_t pass_ = 0;
  std::int64_t row_ = 0, at_ = 0;
};

// Decompresses the data of all IDAT chunks into the scanlines.
class Inflater {
 public:
  explicit Inflater(Scanlines& lines) : lines_(lines), room_(std::size_t{1} << 15) { inflateInit(&stream_); }
  ~Inflater() { inflateEnd(&stream_); }
  Inflater(const Inflater&) = delete;
  Inflater& operator=(const Inflater&) = delete;

  bool ended() const { return ended_; }

  // False: the data are damaged, or do not make the scanlines. What follows their end is ignored.
  bool take(Bytes data) {
    stream_.next_in = const_cast<std::uint8_t*>(data.data());  // zlib only reads
    stream_.avail_in = static_cast<uInt>(data.size());
    for (int state = ended_ ? Z_STREAM_END : Z_OK; state == Z_OK;) {
      stream_.next_out = room_.data();
      stream_.avail_out = static_cast<uInt>(room_.size());
      state = inflate(&stream_, Z_NO_FLUSH);
      if (state != Z_OK && state != Z_STREAM_END && state != Z_BUF_ERROR) return false;
      if (!lines_.take({room_.data(), room_.size() - stream_.avail_out})) return false;
      ended_ = state == Z_STREAM_END;
    }
    return true;
  }

 private:
  Scanlines& lines_;
  std::vector<std::uint8_t> room_;
  z_stream stream_{};
  bool ended_ = false;
};

}  // namespace

void check_size(const std::string& what, std::int64_t width, std::int64_t height, const Limits& limits) {
  if (width < 1 || height < 1 || width > limits.side || height > limits.side ||
      width * height > limits.pixels)
    base::fail(what, ": header: wanted a size of at most ", limits.side, " x ", limits.side, " and ",
               limits.pixels, " pixels (see --max-memory), found ", width, " x ", height);
}

void check_png(Bytes bytes, const std::string& what, const Limits& limits) {
  std::size_t at = 8;
  const auto fail = [&](const auto&... wanted) {
    base::fail(what, ": byte ", at, " of the PNG: wanted ", wanted...);
  };
  constexpr const char* damage = ", found the end of the data or a wrong checksum";
  constexpr unsigned IHDR = 0x49484452, PLTE = 0x504c5445, tRNS = 0x74524e53, IDAT = 0x49444154,
                     IEND = 0x49454e44, ancillary = 0x20000000;

  // The header: size, and what its pixels are made of.
  constexpr std::size_t header_size = 25;
  if (bytes.size() < at + header_size || big_endian(bytes, at, 4) != 13 ||
      big_endian(bytes, at + 4, 4) != IHDR)
    fail("an IHDR chunk", damage);
  const std::int64_t width = big_endian(bytes, 16, 4), height = big_endian(bytes, 20, 4);
  check_size(what, width, height, limits);
  const int depth = bytes[24], colour = bytes[25], interlaced = bytes[28];
  constexpr int depths[] = {1 | 2 | 4 | 8 | 16, 0, 8 | 16, 1 | 2 | 4 | 8, 8 | 16, 0, 8 | 16};
  constexpr int channels[] = {1, 0, 3, 1, 2, 0, 4};
  if (colour > 6 || (depth & (depth - 1)) != 0 || (depths[colour] & depth) == 0 || bytes[26] != 0 ||
      bytes[27] != 0 || interlaced > 1)
    fail("a colour type, depth and methods of the PNG specification, found ", colour, ", ", depth, " and ",
         int{bytes[26]}, ", ", int{bytes[27]}, ", ", interlaced);

  Scanlines lines(width, height, depth * channels[colour], interlaced == 1);
  Inflater inflater(lines);
  std::int64_t compressed = 0;
  std::size_t palette = 0;  // entries
  bool transparent = false, finished = false;
  for (unsigned kind = 0; kind != IEND;) {
    if (bytes.size() - at < 12) fail("a chunk", damage);
    const std::size_t length = big_endian(bytes, at, 4), whole = length + 12;
    kind = big_endian(bytes, at + 4, 4);
    if (bytes.size() - at < whole) fail("a whole chunk", damage);
    if (crc32_z(0, &bytes[at + 4], length + 4) != big_endian(bytes, at + 8 + length, 4))
      fail("an undamaged chunk", damage);
    const Bytes data = bytes.subspan(at + 8, length);
    if (kind != IDAT && compressed > 0) finished = true;
    if (kind == IHDR) {
      if (at != 8) fail("one IHDR chunk, found another");
    } else if (kind == PLTE && colour == 3) {  // to others it is a hint
      if (palette > 0 || compressed > 0 || length == 0 || length % 3 != 0 || length / 3 > 1u << depth)
        fail("one palette of 1 to ", 1 << depth, " colours before the pixels, found another, or one of ",
             length, " bytes");
      palette = length / 3;
    } else if (kind == tRNS && colour <= 3) {
      const bool fits = colour == 3 ? length >= 1 && length <= palette : length == (colour == 0 ? 2 : 6);
      if (transparent || compressed > 0 || !fits)
        fail(
            "one tRNS chunk before the pixels, as long as their colour type has it, found another, or one "
            "of ",
            length, " bytes");
      transparent = true;
    } else if (kind == IDAT) {
      compressed += static_cast<std::int64_t>(length);
      if (finished || (colour == 3 && palette == 0))
        fail("the pixels in one place, after their palette, found others");
      if (!inflater.take(data))
        fail("compressed scanlines for ", width, " x ", height, " pixels, found damaged data or more");
    } else if (kind == IEND) {
      if (length != 0) fail("an empty IEND chunk, found ", length, " bytes");
    } else if ((kind & ancillary) == 0 && kind != PLTE) {
      fail("a chunk of the PNG specification, found an unknown one that must be understood");
    }
    at += whole;
  }
  if (!lines.complete() || !inflater.ended())
    base::fail(what, ": wanted data for ", width, " x ", height, " pixels, found only ", compressed,
               " bytes of it");
}

void check_jpeg(Bytes bytes, const std::string& what, const Limits& limits) {
  // Walks the segments up to the frame header.
  for (std::size_t at = 2; at + 9 < bytes.size() && bytes[at] == 0xff;) {
    const int marker = bytes[at + 1];
    const bool is_frame =
        marker >= 0xc0 && marker <= 0xcf && marker != 0xc4 && marker != 0xc8 && marker != 0xcc;
    if (marker == 0xff) {  // fill byte
      ++at;
      continue;
    }
    if (!is_frame) {
      at += 2 + big_endian(bytes, at + 2, 2);
      continue;
    }
    check_size(what, big_endian(bytes, at + 7, 2), big_endian(bytes, at + 5, 2), limits);
    const int components = bytes[at + 9];
    if (components != 1 && components != 3)
      base::fail(what, ": wanted a grey or RGB JPEG, found one of ", components, " components",
                 components == 4 ? " (CMYK)" : "");
    return;
  }
  base::fail(what, ": wanted a JPEG frame header, found none");
}

namespace {

// What OpenEXR reads of an attribute of these types, whatever length the file says; of others, that length.
constexpr std::pair<std::string_view, std::int64_t> exr_sizes[] = {{"box2f", 16},
                                                                   {"box2i", 16},
                                                                   {"chromaticities", 32},
                                                                   {"compression", 1},
                                                                   {"deepImageState", 1},
                                                                   {"double", 8},
                                                                   {"envmap", 1},
                                                                   {"float", 4},
                                                                   {"int", 4},
                                                                   {"keycode", 28},
                                                                   {"lineOrder", 1},
                                                                   {"m33d", 72},
                                                                   {"m33f", 36},
                                                                   {"m44d", 128},
                                                                   {"m44f", 64},
                                                                   {"rational", 8},
                                                                   {"tiledesc", 9},
                                                                   {"timecode", 8},
                                                                   {"v2d", 16},
                                                                   {"v2f", 8},
                                                                   {"v2i", 8},
                                                                   {"v3d", 24},
                                                                   {"v3f", 12},
                                                                   {"v3i", 12}};

// Length of the list of channels, each a name and 16 bytes, that begins the data; 0 if it does not end.
std::int64_t length_of_channels(Bytes data) {
  for (auto at = data.begin(); at != data.end();) {
    if (*at == 0) return at - data.begin() + 1;
    at = std::find(at, data.end(), 0);
    if (data.end() - at < 18) break;
    at += 17;
  }
  return 0;
}

}  // namespace

void check_exr(Bytes head, std::uint64_t size, const std::string& what, const Limits& limits) {
  std::size_t at = 0;
  const auto want = [&](bool holds, const auto&... wanted) {
    if (!holds) base::fail(what, ": byte ", at, " of the OpenEXR header: wanted ", wanted...);
  };
  const auto need = [&](std::size_t count) {
    want(head.size() - at >= count, count, " bytes more, found the end");
  };
  const auto number = [&](std::size_t place) {
    return std::int64_t{static_cast<std::int32_t>(head[place] | head[place + 1] << 8 | head[place + 2] << 16 |
                                                  static_cast<unsigned>(head[place + 3]) << 24)};
  };
  const auto name = [&] {
    const auto end = std::find(head.begin() + static_cast<std::ptrdiff_t>(at), head.end(), 0);
    want(end != head.end(), "a name, found no end of one");
    std::string text(head.begin() + static_cast<std::ptrdiff_t>(at), end);
    want(text.size() <= 255, "a name of at most 255 characters, found ", text.size());  // as OpenEXR does
    at += text.size() + 1;
    return text;
  };

  constexpr std::int64_t tiled = 0x200, long_names = 0x400;
  need(8);
  const std::int64_t version = number(4);
  at = 4;
  want((version & 255) == 2 && (version & ~(255 | tiled | long_names)) == 0,
       "version 2, one part and an image, found ", version & 255, " and flags ", version >> 8);
  at = 8;
  std::int64_t width = 0, height = 0, lines = 0, tile_width = 0, tile_height = 0;
  for (std::string key = name(); !key.empty(); key = name()) {
    const std::string type = name();
    need(4);
    const std::int64_t length = number(at);
    at += 4;
    want(length >= 0 && length <= static_cast<std::int64_t>(head.size() - at), "attribute ", key,
         " to end in the file, found ", length, " bytes of it");
    std::int64_t read = length;
    for (const auto& [known, bytes] : exr_sizes)
      if (type == known) read = bytes;
    const Bytes data = head.subspan(at, static_cast<std::size_t>(length));
    if (type == "chlist") read = length_of_channels(data);
    if (type == "preview") {  // width, height, then four bytes each
      const std::int64_t columns = length < 8 ? -1 : number(at), rows = length < 8 ? -1 : number(at + 4);
      read = columns < 0 || rows < 0 || columns > 65536 || rows > 65536 ? -1 : 8 + 4 * columns * rows;
    }
    if (type == "stringvector") {  // each its length and its letters
      for (read = 0; read >= 0 && read + 4 <= length;) {
        const std::int64_t letters = number(at + static_cast<std::size_t>(read));
        read = letters < 0 ? -1 : read + 4 + letters;
      }
    }
    want(read == length, "attribute ", key, " of type ", type, " and its length, found ", length, " bytes");
    if (key == "dataWindow" && type == "box2i") {
      width = number(at + 8) - number(at) + 1, height = number(at + 12) - number(at + 4) + 1;
      check_size(what, width, height, limits);
    } else if (key == "compression" && type == "compression") {
      constexpr int lines_of[] = {1, 1, 1, 16, 32, 16, 32, 32, 32, 256};
      want(head[at] < std::size(lines_of), "a known compression, found ", int{head[at]});
      lines = lines_of[head[at]];
    } else if (key == "tiles" && type == "tiledesc") {
      tile_width = number(at), tile_height = number(at + 4);
      want(tile_width > 0 && tile_height > 0, "tiles of a size, found ", tile_width, " x ", tile_height);
    }
    at += static_cast<std::size_t>(length);
  }
  want(width > 0 && lines > 0 && ((version & tiled) == 0 || tile_width > 0),
       "a data window, a compression, and tiles where there are any, found not all");
  // Eight bytes for the place of each block, which are there before any pixel.
  const auto parts = [](std::int64_t whole, std::int64_t part) { return (whole + part - 1) / part; };
  const std::int64_t blocks =
      (version & tiled) != 0 ? parts(width, tile_width) * parts(height, tile_height) : parts(height, lines);
  want(static_cast<std::uint64_t>(blocks) <= size / 8, "a table of ", blocks, " blocks, found only ", size,
       " bytes in the file");
}

}  // namespace image
