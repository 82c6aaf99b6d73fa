// For tests: reads what write_exr wrote (variance already multiplied by its scale; assay:* metadata only).
#pragma once

#include "image/exr.h"
#include "image/oiio.h"

namespace image {

inline Exr read_exr(const std::string& path) {
  const auto input = open_as(".exr", path);
  const OIIO::ImageSpec& spec = input->spec();
  if (spec.deep) base::fail(path, ": wanted a flat image, found deep pixels");
  const std::size_t channels = static_cast<std::size_t>(spec.nchannels);
  std::vector<float> pixels(static_cast<std::size_t>(spec.width) * static_cast<std::size_t>(spec.height) *
                            channels);
  if (!input->read_image(0, 0, 0, spec.nchannels, OIIO::TypeFloat, pixels.data()))
    base::fail(path, ": cannot read: ", input->geterror());

  Exr exr;
  const float scale = spec.get_float_attribute("assay:variance_scale", 1);
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
    if (!name.starts_with("assay:") || name == "assay:variance_scale") continue;
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
