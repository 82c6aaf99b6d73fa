// Pixels as a page can hold them: colours for maps, PNG data URIs, and half floats in base64 for the exposure
// slider and the pixel inspector.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "image/image.h"

namespace report {

std::string base64(std::string_view bytes);

// IEEE 754 binary16, round to nearest even.
std::uint16_t to_half(float value);

// "data:image/png;base64,…"
std::string png_uri(const image::Image& encoded);  // values are sRGB already

// Linear light as FLIP shows it: ACES at 2^exposure, then the sRGB curve. Not a number: magenta.
image::Image shown_radiance(const image::Image& linear, double exposure);

// Vectors: [low, high] of any channel to [0,1].
image::Image shown_vectors(const image::Image& image, double low, double high);

// The first channel in magma, 0 black to `white` nearly white.
image::Image shown_map(const image::Image& map, double white);

// `signed_value` (one channel): black 0, to light orange at +1, to light blue at -1.
image::Image shown_signed(const image::Image& signed_value);

// a - b. Same shapes.
image::Image difference(const image::Image& a, const image::Image& b);

// The channel of largest size with its sign, times `gain`, as one channel; not a number wins.
image::Image largest_channel(const image::Image& image, double gain);

// The value that `share` of all finite |values| do not exceed; 0 if there are none.
double percentile(const image::Image& image, double share);

// The 256 colours of shown_map() as "rrggbb…".
std::string magma_hex();

// zlib's stream, which a browser's DecompressionStream("deflate") reads.
std::string deflate(std::string_view bytes);

// The pictures of a page as half floats, each distinct one once.
class Floats {
 public:
  // Takes pictures as long as their text stays below `most_bytes`; without `all` only those that are needed.
  Floats(std::size_t most_bytes, bool all) : most_bytes_(most_bytes), all_(all) {}

  // The picture's id in the table; empty if it is not taken, or too large for a page. A needed one belongs to
  // a case that is not IDENTICAL or that has another renderer's picture.
  std::string add(const image::Image& image, bool needed);

  // {"magma": "…", "p0": {"w", "h", "c", "scale", "z"}, …}; z: all values' high bytes, then all low bytes,
  // channel by channel, deflated, in base64.
  std::string json() const;

 private:
  std::size_t most_bytes_, bytes_ = 0;
  bool all_;
  std::vector<std::string> entries_;
  std::map<std::string, std::string> ids_;  // from content
};

}  // namespace report
