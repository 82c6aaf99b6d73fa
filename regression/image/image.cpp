#include "image/image.h"

#include <cmath>

namespace image {

namespace {

template <typename T>
std::optional<T> entry(const Header& header, const std::string& name) {
  const auto it = header.find(name);
  if (it == header.end() || !std::holds_alternative<T>(it->second)) return std::nullopt;
  return std::get<T>(it->second);
}

}  // namespace

std::optional<int> header_int(const Header& header, const std::string& name) {
  return entry<int>(header, name);
}

std::optional<float> header_float(const Header& header, const std::string& name) {
  if (const auto i = entry<int>(header, name)) return static_cast<float>(*i);
  return entry<float>(header, name);
}

std::optional<std::string> header_string(const Header& header, const std::string& name) {
  return entry<std::string>(header, name);
}

std::optional<std::vector<float>> header_floats(const Header& header, const std::string& name) {
  return entry<std::vector<float>>(header, name);
}

std::vector<const Image*> replicates(const Render& render) {
  std::vector<const Image*> found;
  for (;;) {
    const auto it = render.layers.find("replicate" + std::to_string(found.size()));
    if (it == render.layers.end()) return found;
    found.push_back(&it->second);
  }
}

std::size_t count_non_finite(const Image& image) {
  std::size_t count = 0;
  for (std::size_t i = 0; i < image.data.size(); i += image.channels) {
    bool finite = true;
    for (int c = 0; c < image.channels; ++c) finite = finite && std::isfinite(image.data[i + c]);
    count += !finite;
  }
  return count;
}

}  // namespace image
