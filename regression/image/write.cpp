#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <memory>

#include "base/error.h"
#include "image/floats.h"
#include "image/io.h"

namespace image {

namespace {

constexpr float smallest_half = 5.9604645e-8f;  // 2^-24
constexpr float largest_half = 65504;

// The power of two that brings the largest finite variance just below 2^15, well inside half's range. 1 if
// every variance is 0, or is already held well.
float variance_scale(const Image& variance) {
  float largest = 0;
  for (const float v : variance.data)
    if (std::isfinite(v)) largest = std::max(largest, v);
  if (largest == 0) return 1;
  int exponent = 0;
  std::frexp(largest, &exponent);
  return std::ldexp(1.0f, std::clamp(exponent - 15, -126, 127));
}

// Scaled for half. A variance too small for it is rounded up: claiming none at all would make every
// difference significant.
float scaled(float variance, float scale) {
  const float v = variance / scale;
  if (v > 0 && v < smallest_half) return smallest_half;
  return std::isfinite(v) ? std::min(v, largest_half) : v;
}

// Channel names of a layer: colours unless the layer is known to hold coordinates.
std::vector<std::string> components(const std::string& layer, int channels) {
  if (channels == 1) return {layer == "depth" ? "Z" : "Y"};
  if (layer == "normal" || layer == "position") return {"X", "Y", "Z"};
  return {"R", "G", "B", "A"};
}

// Interleaves the planes of a render as an EXR wants them.
struct Planes {
  OIIO::ImageSpec spec;
  std::vector<float> pixels;
};

Planes interleave(const std::string& path, const Render& render) {
  struct Source {
    const Image* image;
    std::string name;
  };
  std::vector<Source> sources{{&render.mean, ""}};
  for (const auto& [name, layer] : render.layers) sources.push_back({&layer, name});
  Image variance;
  float scale = 1;
  if (render.variance) {
    scale = variance_scale(*render.variance);
    variance = *render.variance;
    for (float& v : variance.data) v = scaled(v, scale);
    sources.push_back({&variance, "variance"});
  }

  Planes planes;
  OIIO::ImageSpec& spec = planes.spec;
  spec = OIIO::ImageSpec(render.mean.width, render.mean.height, 0, OIIO::TypeFloat);
  spec.channelnames.clear();
  for (const Source& source : sources) {
    const Image& image = *source.image;
    if (image.width != spec.width || image.height != spec.height || image.channels < 1 ||
        image.channels > 4 || (source.name.empty() && image.channels != 3) || image.empty())
      base::fail_in(path, source.name.empty() ? "mean" : source.name, "an image of the size of the mean",
                    std::to_string(image.width) + " x " + std::to_string(image.height) + " x " +
                        std::to_string(image.channels));
    const std::vector<std::string> names = components(source.name, image.channels);
    for (int c = 0; c < image.channels; ++c) {
      const bool alone = image.channels == 1 && source.name == "A";
      spec.channelnames.push_back(source.name.empty() ? names[c]
                                  : alone             ? source.name
                                                      : source.name + "." + names[c]);
      spec.channelformats.push_back(&image == &variance ? OIIO::TypeHalf : OIIO::TypeFloat);
    }
  }
  spec.nchannels = static_cast<int>(spec.channelnames.size());
  planes.pixels.resize(render.mean.pixels() * spec.nchannels);
  int offset = 0;
  for (const Source& source : sources) {
    const Image& image = *source.image;
    for (std::size_t p = 0; p < image.pixels(); ++p)
      for (int c = 0; c < image.channels; ++c)
        planes.pixels[p * spec.nchannels + offset + c] = image.data[p * image.channels + c];
    offset += image.channels;
  }

  spec.attribute("compression", "zip");
  for (const auto& [name, value] : render.header) {
    if (const int* i = std::get_if<int>(&value)) spec.attribute(name, *i);
    if (const float* f = std::get_if<float>(&value)) spec.attribute(name, *f);
    if (const std::string* s = std::get_if<std::string>(&value)) spec.attribute(name, *s);
    if (const auto* v = std::get_if<std::vector<float>>(&value)) spec.attribute(name, floats_to_text(*v));
  }
  if (render.variance) spec.attribute("assay:variance_scale", scale);
  return planes;
}

// Encodes in memory, so that what reaches the disk is complete.
std::vector<std::uint8_t> encode(const std::string& path, const char* format, const OIIO::ImageSpec& spec,
                                 OIIO::TypeDesc type, const void* pixels) {
  OIIO::Filesystem::IOVecOutput memory;
  OIIO::Filesystem::IOProxy* proxy = &memory;
  const std::unique_ptr<OIIO::ImageOutput> output = OIIO::ImageOutput::create(format);
  if (!output) base::fail(path, ": ", OIIO::geterror());
  OIIO::ImageSpec wanted = spec;
  wanted.attribute("oiio:ioproxy", OIIO::TypeDesc::PTR, &proxy);
  if (!output->open(format, wanted) || !output->write_image(type, pixels) || !output->close())
    base::fail(path, ": ", output->geterror());
  return memory.buffer();
}

}  // namespace

float srgb_to_linear(float s) { return s <= 0.04045f ? s / 12.92f : std::pow((s + 0.055f) / 1.055f, 2.4f); }

float linear_to_srgb(float l) {
  return l <= 0.0031308f ? 12.92f * l : 1.055f * std::pow(l, 1 / 2.4f) - 0.055f;
}

void write_file(const std::string& path, const void* bytes, std::size_t size) {
  namespace fs = std::filesystem;
  std::error_code error;
  // Renaming over a device or a folder would replace it.
  if (fs::exists(path, error) && !fs::is_regular_file(path, error))
    base::fail_in(path, "", "a file to write", "something that is not a file");
  const fs::path folder = fs::path(path).parent_path();
  if (!folder.empty()) fs::create_directories(folder, error);
  const std::string temporary = path + ".tmp" + std::to_string(::getpid());
  {
    std::ofstream file(temporary, std::ios::binary | std::ios::trunc);
    file.write(static_cast<const char*>(bytes), static_cast<std::streamsize>(size));
    file.close();
    if (!file) {
      fs::remove(temporary, error);
      base::fail_in(path, "", "to write it", "a folder or disk that does not allow it");
    }
  }
  fs::rename(temporary, path, error);
  if (error) {
    const std::string why = error.message();
    fs::remove(temporary, error);
    base::fail_in(path, "", "to write it", why);
  }
}

void write_exr(const std::string& path, const Render& render) {
  const Planes planes = interleave(path, render);
  const std::vector<std::uint8_t> bytes =
      encode(path, "exr", planes.spec, OIIO::TypeFloat, planes.pixels.data());
  write_file(path, bytes.data(), bytes.size());
}

std::vector<std::uint8_t> png_bytes(const Image& image, Encoding encoding) {
  if (image.empty() || (image.channels != 1 && image.channels != 3))
    base::fail_in("PNG", "", "an image of 1 or 3 channels", std::to_string(image.channels));
  std::vector<std::uint8_t> pixels(image.data.size());
  for (std::size_t i = 0; i < pixels.size(); ++i) {
    float v = image.data[i];
    v = v > 0 ? std::min(v, 1.0f) : 0.0f;  // NaN fails the comparison
    if (encoding == Encoding::linear) v = linear_to_srgb(v);
    pixels[i] = static_cast<std::uint8_t>(std::lround(v * 255));
  }
  OIIO::ImageSpec spec(image.width, image.height, image.channels, OIIO::TypeUInt8);
  spec.attribute("oiio:ColorSpace", "sRGB");
  return encode("PNG", "png", spec, OIIO::TypeUInt8, pixels.data());
}

void write_png(const std::string& path, const Image& image, Encoding encoding) {
  const std::vector<std::uint8_t> bytes = png_bytes(image, encoding);
  write_file(path, bytes.data(), bytes.size());
}

}  // namespace image
