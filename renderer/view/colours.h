// From numbers to the colours on the screen: the picture as assay-render's .png would show it, or the error
// or the difference from a reference in false colours.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "image/display.h"
#include "image/image.h"

namespace view {

// The 8-bit codes of image::to_display, by look-up: exact, and fast enough for every frame.
class Codes {
 public:
  explicit Codes(const image::Display& display);
  std::uint8_t operator()(float value) const {
    if (!(value > 0)) return zero_;
    const auto bits = bits_of(value);
    unsigned code = first_[bits >> 16];
    while (code < 255 && bits >= threshold_[code + 1]) ++code;
    return static_cast<std::uint8_t>(code);
  }

 private:
  static std::uint32_t bits_of(float value);
  std::uint8_t zero_;
  std::array<std::uint32_t, 256> threshold_;  // bits of the smallest positive float with at least this code
  std::vector<std::uint8_t> first_;           // of a float's upper 16 bits: the smallest code
};

using Rgba = std::array<std::uint8_t, 4>;

// Relative standard error of a pixel: the root of the mean of its channels' variances over their mean. NaN
// where the mean is 0.
float relative_error(const math::Vec3& mean, const math::Vec3& variance);
// Largest difference of a channel, over the reference's mean of the channels. NaN where that is 0.
float relative_difference(const math::Vec3& value, const math::Vec3& reference);

// Dark blue for `least`, yellow for `most`, in proportion to the logarithm; grey for NaN.
inline constexpr float least = .001f, most = 1;
Rgba false_colour(float relative);

std::vector<Rgba> show(const image::Image& image, const Codes& codes);
std::vector<Rgba> show_error(const image::Image& mean, const image::Image& variance);
// The reference may have another size: it is sampled at the same place of the picture.
std::vector<Rgba> show_difference(const image::Image& image, const image::Image& reference);

}  // namespace view
