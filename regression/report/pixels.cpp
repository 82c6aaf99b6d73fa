#include "report/pixels.h"

#include <zlib.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <new>

#include "image/io.h"
#include "metric/flip.h"

namespace report {
namespace {

// Larger pictures are shown, not inspected.
constexpr std::size_t most_inspected_pixels = 512 * 512;

void set(image::Image& image, std::size_t pixel, double r, double g, double b) {
  float* p = &image.data[3 * pixel];
  p[0] = static_cast<float>(r), p[1] = static_cast<float>(g), p[2] = static_cast<float>(b);
}

bool finite(const image::Image& image, std::size_t pixel) {
  for (int c = 0; c < image.channels; ++c)
    if (!std::isfinite(image.data[pixel * static_cast<std::size_t>(image.channels) + c])) return false;
  return true;
}

// Matplotlib's magma, fitted by Matt Zucker (CC0); off by at most six 8-bit steps.
constexpr double magma[7][3] = {
    {-.002136485, -.000749655, -.005386128},    {.251660541, .677523244, 2.494026599},
    {8.353717279, -3.577719515, .314467903},    {-27.668733086, 14.264730781, -13.649213188},
    {52.17613981, -27.943606072, 12.944169442}, {-50.768525365, 29.046582821, 4.234152994},
    {18.655705066, -11.489773520, -5.601961509}};

}  // namespace

std::string base64(std::string_view bytes) {
  static const char* const digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string out;
  out.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    const std::size_t left = std::min<std::size_t>(3, bytes.size() - i);
    unsigned word = 0;
    for (std::size_t k = 0; k < 3; ++k)
      word = word << 8 | (k < left ? static_cast<unsigned char>(bytes[i + k]) : 0u);
    for (std::size_t k = 0; k < 4; ++k) out += k <= left ? digits[word >> (18 - 6 * k) & 63] : '=';
  }
  return out;
}

std::uint16_t to_half(float value) {
  std::uint32_t bits;
  std::memcpy(&bits, &value, 4);
  const auto sign = static_cast<std::uint16_t>(bits >> 16 & 0x8000);
  const std::uint32_t magnitude = bits & 0x7fffffff;
  if (magnitude > 0x7f800000) return sign | 0x7e00;   // NaN
  if (magnitude >= 0x477ff000) return sign | 0x7c00;  // rounds to infinity
  // The integer nearest to value in units of the half's last place, ties to even by nearbyint.
  const int exponent = std::max(static_cast<int>(magnitude >> 23) - 127, -14);
  const auto units = static_cast<std::uint32_t>(std::nearbyint(std::ldexp(std::fabs(value), 10 - exponent)));
  // A carry out of the mantissa runs into the exponent, as it should. Below 1024 units it is subnormal.
  return static_cast<std::uint16_t>(sign | (units + (static_cast<std::uint32_t>(exponent + 14) << 10)));
}

std::string png_uri(const image::Image& encoded) {
  const std::vector<std::uint8_t> bytes = image::png_bytes(encoded, image::Encoding::srgb);
  return "data:image/png;base64," + base64({reinterpret_cast<const char*>(bytes.data()), bytes.size()});
}

image::Image shown_radiance(const image::Image& linear, double exposure) {
  image::Image out = metric::tone_map(linear, metric::ToneMapper::aces, exposure);
  for (float& v : out.data) v = image::linear_to_srgb(v);
  for (std::size_t p = 0; p < linear.pixels(); ++p)
    if (!finite(linear, p)) set(out, p, 1, 0, 1);
  return out;
}

image::Image shown_vectors(const image::Image& image, double low, double high) {
  image::Image out = image;
  for (float& v : out.data) v = static_cast<float>((v - low) / (high - low));
  return out;
}

image::Image shown_map(const image::Image& map, double white) {
  image::Image out(map.width, map.height, 3);
  for (std::size_t p = 0; p < map.pixels(); ++p) {
    const double t = std::clamp(map.data[p * static_cast<std::size_t>(map.channels)] / white, 0., 1.);
    double rgb[3];
    for (int c = 0; c < 3; ++c) {
      rgb[c] = 0;
      for (int k = 6; k >= 0; --k) rgb[c] = rgb[c] * t + magma[k][c];
    }
    set(out, p, rgb[0], rgb[1], rgb[2]);
  }
  return out;
}

image::Image shown_signed(const image::Image& signed_value) {
  image::Image out(signed_value.width, signed_value.height, 3);
  for (std::size_t p = 0; p < out.pixels(); ++p) {
    const double v = signed_value.data[p];
    if (!std::isfinite(v)) {
      set(out, p, 1, 0, 1);
      continue;
    }
    const double t = std::min(std::fabs(v), 1.), first = std::min(1., 2 * t), last = std::max(0., 2 * t - 1);
    v > 0 ? set(out, p, first, .8 * t, .5 * last) : set(out, p, .5 * last, .8 * t, first);
  }
  return out;
}

image::Image difference(const image::Image& a, const image::Image& b) {
  image::Image out = a;
  for (std::size_t i = 0; i < out.data.size(); ++i) out.data[i] -= b.data[i];
  return out;
}

image::Image largest_channel(const image::Image& image, double gain) {
  image::Image out(image.width, image.height, 1);
  for (std::size_t p = 0; p < image.pixels(); ++p) {
    double largest = 0;
    for (int c = 0; c < image.channels; ++c) {
      const double v = image.data[p * static_cast<std::size_t>(image.channels) + c];
      if (!(std::fabs(v) <= std::fabs(largest))) largest = v;
      if (std::isnan(v)) break;
    }
    out.data[p] = static_cast<float>(largest * gain);
  }
  return out;
}

double percentile(const image::Image& image, double share) {
  std::vector<double> values;
  for (const float v : image.data)
    if (std::isfinite(v)) values.push_back(std::fabs(v));
  if (values.empty()) return 0;
  const auto place =
      values.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), place, values.end());
  return *place;
}

std::string magma_hex() {
  image::Image ramp(256, 1, 1);
  for (int i = 0; i < 256; ++i) ramp.at(i, 0) = static_cast<float>(i) / 255;
  std::string out;
  for (const float v : shown_map(ramp, 1).data) {
    char digits[3];
    std::snprintf(digits, sizeof digits, "%02x",
                  static_cast<unsigned>(std::lround(255 * std::clamp(v, 0.f, 1.f))));
    out += digits;
  }
  return out;
}

std::string deflate(std::string_view bytes) {
  uLongf size = compressBound(static_cast<uLong>(bytes.size()));
  std::string out(size, '\0');
  if (compress2(reinterpret_cast<Bytef*>(out.data()), &size, reinterpret_cast<const Bytef*>(bytes.data()),
                static_cast<uLong>(bytes.size()), Z_BEST_COMPRESSION) != Z_OK)
    throw std::bad_alloc();  // the only way it can fail, with that much room
  out.resize(size);
  return out;
}

std::string Floats::add(const image::Image& image, bool needed) {
  if (image.pixels() > most_inspected_pixels || (!needed && !all_)) return "";
  // A power of two brings the largest value to half's upper end, so that neither sun nor shadow is lost.
  const double largest = percentile(image, 1);
  const int shift = largest > 0 ? std::ilogb(largest) - 14 : 0;
  const std::size_t n = image.data.size(), channels = static_cast<std::size_t>(image.channels);
  std::string bytes(2 * n, '\0');
  for (std::size_t i = 0; i < n; ++i) {
    const std::uint16_t half = to_half(static_cast<float>(std::ldexp(image.data[i], -shift)));
    const std::size_t place = i % channels * image.pixels() + i / channels;
    bytes[place] = static_cast<char>(half >> 8);
    bytes[n + place] = static_cast<char>(half & 255);
  }
  char head[128];
  std::snprintf(head, sizeof head, "{\"w\":%d,\"h\":%d,\"c\":%d,\"scale\":%.17g,\"z\":\"", image.width,
                image.height, image.channels, std::ldexp(1., shift));
  const std::string body = head + base64(deflate(bytes)) + "\"}";
  const auto found = ids_.find(body);
  if (found != ids_.end()) return found->second;
  if (bytes_ + body.size() + 12 > most_bytes_) return "";
  bytes_ += body.size() + 12;
  const std::string id = "p" + std::to_string(entries_.size());
  entries_.push_back(",\n\"" + id + "\":" + body);
  return ids_[body] = id;
}

std::string Floats::json() const {
  std::string out = "{\"magma\":\"" + magma_hex() + "\"";
  for (const std::string& entry : entries_) out += entry;
  return out + "}";
}

}  // namespace report
