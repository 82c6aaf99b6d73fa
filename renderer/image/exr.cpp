#include "image/exr.h"

#include <algorithm>
#include <cmath>

#include "image/oiio.h"

namespace image {

namespace {

constexpr const char* scale_name = "assay:variance_scale";

// The power of two that brings the largest variance into [2^14, 2^15), under half's maximum of 65504: what is
// 2^39 times smaller is still not zero.
float variance_scale(const Image& variance) {
  float largest = 0;
  for (const math::Vec3& pixel : variance.pixels) largest = std::max(largest, math::max_component(pixel));
  if (!(largest > 0) || !std::isfinite(largest)) return 1;
  return std::ldexp(1.f, std::clamp(std::ilogb(largest) - 14, -126, 126));
}

}  // namespace

const Metadata::Value* Metadata::find(const std::string& name) const {
  for (const auto& [key, value] : entries)
    if (key == name) return &value;
  return nullptr;
}

void write_exr(const std::string& path, const Exr& exr) {
  // Describe the channels: R, G, B first.
  const int width = exr.mean.width, height = exr.mean.height;
  OIIO::ImageSpec spec(width, height, 0, OIIO::TypeFloat);
  struct Source {
    const Image* image;
    int component;
    float factor;
  };
  std::vector<Source> sources;
  const auto add = [&](const std::string& name, const Image& image, int component, OIIO::TypeDesc type,
                       float factor) {
    if (image.width != width || image.height != height)
      base::fail(path, ": channel ", name, ": wanted ", width, " x ", height, ", found ", image.width, " x ",
                 image.height);
    spec.channelnames.push_back(name);
    spec.channelformats.push_back(type);
    sources.push_back({&image, component, factor});
  };
  const std::string rgb = "RGB";
  for (int c = 0; c < 3; ++c) add(rgb.substr(c, 1), exr.mean, c, OIIO::TypeFloat, 1);
  if (exr.variance.width > 0) {
    const float scale = variance_scale(exr.variance);
    spec.attribute(scale_name, scale);
    for (int c = 0; c < 3; ++c)
      add("variance." + rgb.substr(c, 1), exr.variance, c, OIIO::TypeHalf, 1 / scale);
  }
  for (const Layer& layer : exr.layers)
    for (int c = 0; c < static_cast<int>(layer.channels.size()); ++c)
      add(layer.name + "." + layer.channels[static_cast<std::size_t>(c)], layer.image, c, OIIO::TypeFloat, 1);
  spec.nchannels = static_cast<int>(sources.size());

  // Describe the rest.
  spec.attribute("compression", "zip");
  spec.attribute("oiio:ColorSpace", "linear");
  for (const auto& [name, value] : exr.metadata.entries)
    std::visit([&, &name = name](const auto& v) { spec.attribute(name, v); }, value);

  // Interleave.
  std::vector<float> pixels;
  pixels.reserve(exr.mean.pixels.size() * sources.size());
  for (std::size_t i = 0; i < exr.mean.pixels.size(); ++i)
    for (const Source& source : sources)
      pixels.push_back(source.image->pixels[i][source.component] * source.factor);
  write_as(".exr", path, spec, OIIO::TypeFloat, pixels.data());
}

}  // namespace image
