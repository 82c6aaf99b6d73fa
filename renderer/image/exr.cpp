#include "image/exr.h"

#include <algorithm>
#include <cmath>

#include "base/error.h"
#include "image/file.h"
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

  // Interleave, encode in memory, write in one piece.
  std::vector<float> pixels;
  pixels.reserve(exr.mean.pixels.size() * sources.size());
  for (std::size_t i = 0; i < exr.mean.pixels.size(); ++i)
    for (const Source& source : sources)
      pixels.push_back(source.image->pixels[i][source.component] * source.factor);
  prepare_oiio();
  std::vector<unsigned char> bytes;
  OIIO::Filesystem::IOVecOutput memory(bytes);
  const auto output = OIIO::ImageOutput::create("memory.exr", &memory);
  if (!output) base::fail(path, ": cannot write: ", OIIO::geterror());
  if (!output->open("memory.exr", spec) || !output->write_image(OIIO::TypeFloat, pixels.data()) ||
      !output->close())
    base::fail(path, ": cannot write: ", output->geterror());
  write_whole(path, bytes.data(), bytes.size());
}

Exr read_exr(const std::string& path) {
  std::string error;
  const auto input = open_as(".exr", path, nullptr, error);
  if (!input) base::fail(path, ": cannot read: ", error);
  const OIIO::ImageSpec& spec = input->spec();
  if (spec.deep) base::fail(path, ": wanted a flat image, found deep pixels");
  const std::size_t channels = static_cast<std::size_t>(spec.nchannels);
  std::vector<float> pixels(static_cast<std::size_t>(spec.width) * static_cast<std::size_t>(spec.height) *
                            channels);
  if (!input->read_image(0, 0, 0, spec.nchannels, OIIO::TypeFloat, pixels.data()))
    base::fail(path, ": cannot read: ", input->geterror());

  Exr exr;
  const float scale = spec.get_float_attribute(scale_name, 1);
  for (std::size_t c = 0; c < channels; ++c) {
    // "albedo.R" is component R of layer albedo; "R" of the mean.
    const std::string& name = spec.channelnames[c];
    const std::size_t dot = name.rfind('.');
    const std::string layer = dot == std::string::npos ? "" : name.substr(0, dot);
    const std::string letter = dot == std::string::npos ? name : name.substr(dot + 1);
    Image* image = nullptr;
    std::size_t component = std::string("RGB").find(letter);
    float factor = 1;
    if (layer.empty() || layer == "variance") {
      image = layer.empty() ? &exr.mean : &exr.variance;
      factor = layer.empty() ? 1 : scale;
    } else {
      if (exr.layers.empty() || exr.layers.back().name != layer) exr.layers.push_back({layer, "", {}});
      image = &exr.layers.back().image;
      component = exr.layers.back().channels.size();
      exr.layers.back().channels += letter;
    }
    if (component > 2)
      base::fail(path, ": channel ", name, ": wanted at most three per layer, R, G, B in the first");
    if (image->width == 0) *image = Image(spec.width, spec.height);
    for (std::size_t i = 0; i < image->pixels.size(); ++i)
      image->pixels[i][static_cast<int>(component)] = pixels[i * channels + c] * factor;
  }
  if (exr.mean.width == 0) base::fail(path, ": wanted channels R, G, B, found none of them");
  for (const OIIO::ParamValue& attribute : spec.extra_attribs) {
    const std::string name = attribute.name().string();
    if (!name.starts_with("assay:") || name == scale_name) continue;
    if (attribute.type() == OIIO::TypeInt)
      exr.metadata.set(name, attribute.get_int());
    else if (attribute.type() == OIIO::TypeFloat)
      exr.metadata.set(name, attribute.get_float());
    else
      exr.metadata.set(name, attribute.get_string());
  }
  return exr;
}

}  // namespace image
