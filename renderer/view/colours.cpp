#include "view/colours.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

namespace view {
using math::Vec3;

namespace {

constexpr std::uint32_t infinity = 0x7f800000u;  // positive floats are ordered as their bits

float float_of(std::uint32_t bits) {
  float value;
  std::memcpy(&value, &bits, sizeof value);
  return value;
}

}  // namespace

std::uint32_t Codes::bits_of(float value) {
  std::uint32_t bits;
  std::memcpy(&bits, &value, sizeof bits);
  return bits;
}

Codes::Codes(const image::Display& display) : first_(infinity / 65536 + 1) {
  const auto code = [&](std::uint32_t bits) { return image::to_display(Vec3(float_of(bits)), display)[0]; };
  zero_ = code(0);
  threshold_[0] = 0;
  for (unsigned k = 1; k < 256; ++k) {
    std::uint32_t below = threshold_[k - 1], above = infinity + 1;  // above: no float has this code
    while (below < above) {
      const std::uint32_t middle = below + (above - below) / 2;
      if (middle <= infinity && code(middle) < k)
        below = middle + 1;
      else
        above = middle;
    }
    threshold_[k] = below;
  }
  unsigned k = 0;
  for (std::size_t i = 0; i < first_.size(); ++i) {
    while (k < 255 && threshold_[k + 1] <= i << 16) ++k;
    first_[i] = static_cast<std::uint8_t>(k);
  }
}

float relative_error(const Vec3& mean, const Vec3& variance) {
  const float m = math::mean(mean);
  return m != 0 ? std::sqrt(std::max(math::mean(variance), 0.f)) / std::fabs(m)
                : std::numeric_limits<float>::quiet_NaN();
}

float relative_difference(const Vec3& value, const Vec3& reference) {
  const float m = math::mean(reference);
  return m != 0 ? math::max_component(math::abs(value - reference)) / std::fabs(m)
                : std::numeric_limits<float>::quiet_NaN();
}

// The colour map viridis (Smith, van der Walt and Firing 2015), as Matt Zucker's polynomial of degree six.
Rgba false_colour(float relative) {
  if (!std::isfinite(relative)) return {96, 96, 96, 255};
  const float t =
      math::saturate(std::log10(std::max(relative, least * .5f) / least) / std::log10(most / least));
  static const Vec3 c[] = {
      {.2777273272f, .0054073445f, .3340998053f},      {.1050930431f, 1.4046135299f, 1.3845901626f},
      {-.3308618287f, .2148475595f, .0950951630f},     {-4.6342304990f, -5.7991009734f, -19.3324409563f},
      {6.2282699363f, 14.1799333668f, 56.6905526007f}, {4.7763849977f, -13.7451453777f, -65.3530326334f},
      {-5.4354558559f, 4.6458526122f, 26.3124352496f}};
  Vec3 v(0);
  for (int i = 6; i >= 0; --i) v = v * t + c[i];
  Rgba out{0, 0, 0, 255};
  for (int i = 0; i < 3; ++i)
    out[static_cast<std::size_t>(i)] = static_cast<std::uint8_t>(math::saturate(v[i]) * 255 + .5f);
  return out;
}

std::vector<Rgba> show(const image::Image& image, const Codes& codes) {
  std::vector<Rgba> out;
  out.reserve(image.pixels.size());
  for (const Vec3& p : image.pixels) out.push_back({codes(p.x), codes(p.y), codes(p.z), 255});
  return out;
}

std::vector<Rgba> show_error(const image::Image& mean, const image::Image& variance) {
  std::vector<Rgba> out;
  out.reserve(mean.pixels.size());
  for (std::size_t i = 0; i < mean.pixels.size(); ++i)
    out.push_back(false_colour(i < variance.pixels.size() ? relative_error(mean.pixels[i], variance.pixels[i])
                                                          : std::numeric_limits<float>::quiet_NaN()));
  return out;
}

std::vector<Rgba> show_difference(const image::Image& image, const image::Image& reference) {
  std::vector<Rgba> out;
  out.reserve(image.pixels.size());
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x)
      out.push_back(false_colour(relative_difference(
          image.at(x, y), reference.at((2 * x + 1) * reference.width / (2 * image.width),
                                       (2 * y + 1) * reference.height / (2 * image.height)))));
  return out;
}

}  // namespace view
