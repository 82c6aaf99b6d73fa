// Reading pictures with OpenImageIO 2.4, which must be told: channels are found by name; a PNG's colours are
// not to be multiplied by its alpha; a file may claim any size, and a truncated one opens without complaint.
#include <OpenImageIO/imageio.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <memory>

#include "base/error.h"
#include "image/floats.h"
#include "image/io.h"

namespace image {

namespace {

// 1 GiB of float samples: a picture of the suite is a thousand times smaller, a claim beyond this is a broken
// file.
constexpr double max_bytes = 1073741824.0;

// A channel of the file, and where it belongs: "variance.R" is component R of layer "variance".
struct Channel {
  std::string layer, component;
  int index;
};

// Components in the order people expect, whatever the file's.
int rank(const std::string& component) {
  static const std::string order[] = {"R", "G", "B", "A", "X", "Y", "Z"};
  return static_cast<int>(std::find(std::begin(order), std::end(order), component) - std::begin(order));
}

std::vector<Channel> channels_of(const OIIO::ImageSpec& spec) {
  std::vector<Channel> channels;
  for (int i = 0; i < spec.nchannels; ++i) {
    const std::string& name = spec.channelnames[i];
    const auto dot = name.rfind('.');
    if (dot == std::string::npos)
      channels.push_back({"", name, i});
    else
      channels.push_back({name.substr(0, dot), name.substr(dot + 1), i});
  }
  std::stable_sort(channels.begin(), channels.end(), [](const Channel& a, const Channel& b) {
    if (a.layer != b.layer) return a.layer < b.layer;
    if (rank(a.component) != rank(b.component)) return rank(a.component) < rank(b.component);
    return a.component < b.component;
  });
  return channels;
}

std::string names_of(const OIIO::ImageSpec& spec) {
  std::string names;
  for (int i = 0; i < spec.nchannels && i < 16; ++i) names += (i ? " " : "") + spec.channelnames[i];
  return names + (spec.nchannels > 16 ? " ..." : "");
}

Image gather(const std::vector<float>& pixels, const OIIO::ImageSpec& spec, const std::vector<int>& indices) {
  Image image(spec.width, spec.height, static_cast<int>(indices.size()));
  for (std::size_t p = 0; p < image.pixels(); ++p)
    for (std::size_t c = 0; c < indices.size(); ++c)
      image.data[p * indices.size() + c] = pixels[p * spec.nchannels + indices[c]];
  return image;
}

Header header_of(const OIIO::ImageSpec& spec) {
  Header header;
  for (const OIIO::ParamValue& p : spec.extra_attribs) {
    const std::string name(p.name().string());
    if (name.rfind("assay:", 0) != 0) continue;
    if (p.type() == OIIO::TypeInt) {
      header[name] = p.get_int();
    } else if (p.type() == OIIO::TypeFloat) {
      header[name] = p.get_float();
    } else if (p.type() == OIIO::TypeString) {
      if (auto floats = floats_from_text(p.get_string()))
        header[name] = std::move(*floats);
      else
        header[name] = p.get_string();
    }
  }
  return header;
}

// Undoes the transfer curve of an 8- or 16-bit file. A PNG with gamma 1 (POV-Ray's) holds linear light
// already.
void decode(Image& image, const OIIO::ImageSpec& spec) {
  const std::string space = spec.get_string_attribute("oiio:ColorSpace", "sRGB");
  const float gamma = spec.get_float_attribute("oiio:Gamma", 0);
  if (space == "Linear" || space == "linear" || gamma == 1) return;
  if (space.rfind("Gamma", 0) == 0 && gamma > 0 && std::abs(gamma - 2.2f) > 0.01f) {
    for (float& v : image.data) v = std::pow(v, gamma);
    return;
  }
  for (float& v : image.data) v = srgb_to_linear(v);
}

// The colours: R G B, or a single Y or I for all three.
Image colours(const std::string& path, const std::vector<float>& pixels, const OIIO::ImageSpec& spec,
              const std::vector<Channel>& channels) {
  std::vector<int> rgb, grey;
  for (const Channel& c : channels) {
    if (!c.layer.empty()) continue;
    if (c.component == "R" || c.component == "G" || c.component == "B") rgb.push_back(c.index);
    if (c.component == "Y" || c.component == "I") grey.push_back(c.index);
  }
  if (rgb.size() == 3) return gather(pixels, spec, rgb);
  if (rgb.empty() && grey.size() == 1) return gather(pixels, spec, {grey[0], grey[0], grey[0]});
  base::fail_in(path, "channels", "R G B or Y", names_of(spec));
}

// The file's own scale of its variance, which halves could not hold otherwise.
float take_variance_scale(const std::string& path, Header& header) {
  const std::string name = "assay:variance_scale";
  if (!header.count(name)) return 1;
  const auto scale = header_float(header, name);
  if (!scale || !(*scale > 0) || !std::isfinite(*scale))
    base::fail_in(path, name, "a positive number", scale ? std::to_string(*scale) : "something else");
  header.erase(name);
  return *scale;
}

}  // namespace

Render read_render(const std::string& path) {
  std::error_code ignored;
  if (!std::filesystem::is_regular_file(path, ignored))
    base::fail_in(path, "", "a picture file",
                  std::filesystem::exists(path, ignored) ? "something else" : "nothing");
  if (std::filesystem::file_size(path, ignored) == 0)
    base::fail_in(path, "", "a picture file", "an empty file");

  // Open by content; only the formats that the suite knows how to interpret.
  OIIO::ImageSpec wishes;
  wishes.attribute("oiio:UnassociatedAlpha", 1);
  const std::unique_ptr<OIIO::ImageInput> input = OIIO::ImageInput::open(path, &wishes);
  if (!input) base::fail_in(path, "", "a picture", OIIO::geterror());
  const std::string format = input->format_name();
  const bool encoded = format == "png" || format == "jpeg";
  if (!encoded && format != "openexr" && format != "hdr")
    base::fail_in(path, "", "an EXR, HDR, PNG or JPEG picture", format);

  // Believe nothing the file says about its size before it was weighed.
  const OIIO::ImageSpec& spec = input->spec();
  const std::string size = std::to_string(spec.width) + " x " + std::to_string(spec.height) + " x " +
                           std::to_string(spec.nchannels) + " samples";
  if (spec.width < 1 || spec.height < 1 || spec.depth > 1 || spec.nchannels < 1 ||
      static_cast<double>(spec.width) * spec.height * spec.nchannels * sizeof(float) > max_bytes)
    base::fail_in(path, "size", "at least one pixel and at most 1 GiB", size);
  if (spec.deep) base::fail_in(path, "", "a flat picture", "a deep one");
  if (spec.x != spec.full_x || spec.y != spec.full_y || spec.width != spec.full_width ||
      spec.height != spec.full_height)
    base::fail_in(path, "data window", "the whole display window", size + " of a larger or smaller one");

  const std::vector<Channel> channels = channels_of(spec);
  std::vector<float> pixels(static_cast<std::size_t>(spec.width) * spec.height * spec.nchannels);
  if (!input->read_image(0, 0, 0, spec.nchannels, OIIO::TypeFloat, pixels.data()))
    base::fail_in(path, "pixels", size, input->geterror());

  Render render;
  render.header = header_of(spec);
  render.display_referred = encoded;
  render.mean = colours(path, pixels, spec, channels);
  if (encoded) decode(render.mean, spec);

  // Everything else by layer; an unnamed channel beside the colours is a layer of its own.
  std::map<std::string, std::vector<int>> layers;
  for (const Channel& c : channels) {
    if (!c.layer.empty())
      layers[c.layer].push_back(c.index);
    else if (std::string("RGBYI").find(c.component) == std::string::npos)
      layers[c.component].push_back(c.index);
  }
  for (const auto& [name, indices] : layers) {
    Image layer = gather(pixels, spec, indices);
    if (name != "variance") {
      render.layers[name] = std::move(layer);
      continue;
    }
    if (layer.channels != 3)
      base::fail_in(path, "variance", "R G B", std::to_string(layer.channels) + " channels");
    const float scale = take_variance_scale(path, render.header);
    for (float& v : layer.data) v *= scale;
    render.variance = std::move(layer);
  }
  return render;
}

}  // namespace image
