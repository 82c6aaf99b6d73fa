// Images as the judge sees them. Pixels are float, row-major from the top, channels interleaved; colours are
// linear Rec.709. A Render is what a file of docs/formats.md holds: the mean, its uncertainty, further
// layers, provenance.
#pragma once

#include <cassert>
#include <cstddef>
#include <map>
#include <optional>
#include <string>
#include <variant>
#include <vector>

namespace image {

struct Image {
  int width = 0, height = 0, channels = 0;
  std::vector<float> data;

  Image() = default;
  Image(int w, int h, int c, float fill = 0)
      : width(w), height(h), channels(c), data(static_cast<std::size_t>(w) * h * c, fill) {}

  bool empty() const { return data.empty(); }
  std::size_t pixels() const { return static_cast<std::size_t>(width) * height; }
  std::size_t index(int x, int y, int c = 0) const {
    assert(x >= 0 && x < width && y >= 0 && y < height && c >= 0 && c < channels);
    return (static_cast<std::size_t>(y) * width + x) * channels + c;
  }
  float& at(int x, int y, int c = 0) { return data[index(x, y, c)]; }
  float at(int x, int y, int c = 0) const { return data[index(x, y, c)]; }
  bool same_shape(const Image& o) const {
    return width == o.width && height == o.height && channels == o.channels;
  }
};

// One entry of a file's provenance, "assay:seed" and so on.
using Value = std::variant<int, float, std::string, std::vector<float>>;
using Header = std::map<std::string, Value>;

struct Render {
  Image mean;                     // three channels, R G B
  std::optional<Image> variance;  // three channels: variance of the mean, any header scale already undone
  std::map<std::string, Image>
      layers;                     // "albedo" (R G B), "normal" (X Y Z), "depth" (Z), "replicate0", ...; "A"
  Header header;                  // the attributes named assay:*, without assay:variance_scale
  bool display_referred = false;  // from a PNG or JPEG: decoded to linear, cannot exceed 1
};

// Looks up a header entry; nothing if it is absent or of another kind. An int also answers as a float.
std::optional<int> header_int(const Header& header, const std::string& name);
std::optional<float> header_float(const Header& header, const std::string& name);
std::optional<std::string> header_string(const Header& header, const std::string& name);
std::optional<std::vector<float>> header_floats(const Header& header, const std::string& name);

// Layers replicate0, replicate1, ... in order, up to the first absent one.
std::vector<const Image*> replicates(const Render& render);

// How many pixels hold a NaN or an infinity in any channel.
std::size_t count_non_finite(const Image& image);

}  // namespace image
