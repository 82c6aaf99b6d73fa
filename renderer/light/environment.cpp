#include "light/environment.h"

#include <algorithm>
#include <cmath>

#include "math/transcendental.h"

namespace light {

using math::Vec2;
using math::Vec3;

Environment::Environment(const scene::Environment& e) : map_(e.map), strength_(e.strength) {
  math::sin_cos(e.rotation, sin_rotation_, cos_rotation_);
  // At least 64 x 32 cells, so that even a constant map is drawn by solid angle.
  columns_ = map_.width * ((63 + map_.width) / map_.width);
  rows_ = map_.height * ((31 + map_.height) / map_.height);
  for (int j = 0; j <= rows_; ++j) {
    double s, c;
    math::sin_cos(static_cast<double>(math::pi) * j / rows_, s, c);
    cos_edge_.push_back(static_cast<float>(c));
  }
  // A cell's weight is the mean of nine bilinear look-ups, so that no cell which shows light has weight zero.
  std::vector<double> weights(static_cast<size_t>(columns_) * static_cast<size_t>(rows_));
  const float sx = static_cast<float>(map_.width) / static_cast<float>(columns_);
  const float sy = static_cast<float>(map_.height) / static_cast<float>(rows_);
  double flux = 0;
  for (int j = 0; j < rows_; ++j)
    for (int i = 0; i < columns_; ++i) {
      double sum = 0;
      for (const float b : {.02f, .5f, .98f})
        for (const float a : {.02f, .5f, .98f})
          sum +=
              math::luminance(bilinear((static_cast<float>(i) + a) * sx, (static_cast<float>(j) + b) * sy));
      const double solid_angle =
          2 * 3.14159265358979 / columns_ *
          (static_cast<double>(cos_edge_[static_cast<size_t>(j)]) - cos_edge_[static_cast<size_t>(j) + 1]);
      weights[static_cast<size_t>(j) * static_cast<size_t>(columns_) + static_cast<size_t>(i)] =
          sum / 9 * solid_angle;
      flux += sum / 9 * solid_angle;
    }
  mean_luminance_ = flux / (4 * 3.14159265358979) * strength_;
  table_ = math::Distribution1D(weights);
}

Vec3 Environment::bilinear(float x, float y) const {
  const float fx = std::floor(x - .5f), fy = std::floor(y - .5f);
  const float a = x - .5f - fx, b = y - .5f - fy;
  const auto column = [&](int i) { return (i % map_.width + map_.width) % map_.width; };
  const auto row = [&](int j) { return std::clamp(j, 0, map_.height - 1); };
  const auto texel = [&](int i, int j) {
    return Vec3(map_.texels[static_cast<size_t>(row(j)) * static_cast<size_t>(map_.width) +
                            static_cast<size_t>(column(i))]);
  };
  const int i = static_cast<int>(fx), j = static_cast<int>(fy);
  return (texel(i, j) * (1 - a) + texel(i + 1, j) * a) * (1 - b) +
         (texel(i, j + 1) * (1 - a) + texel(i + 1, j + 1) * a) * b;
}

// World direction to map coordinates in [0,1]: u = 1/2 + atan2(z, x) / 2 pi, v = acos(y) / pi.
Vec2 Environment::to_uv(const Vec3& d) const {
  // Turned by -rotation about +y.
  const float x = cos_rotation_ * d.x - sin_rotation_ * d.z;
  const float z = sin_rotation_ * d.x + cos_rotation_ * d.z;
  const float u = .5f + math::atan2(z, x) * (.5f * math::inv_pi);
  return {math::saturate(u), math::saturate(math::acos(std::clamp(d.y, -1.f, 1.f)) * math::inv_pi)};
}

Vec3 Environment::radiance(const Vec3& d) const {
  if (map_.width == 1 && map_.height == 1) return Vec3(map_.texels[0]) * strength_;
  const Vec2 uv = to_uv(d);
  return bilinear(uv.x * static_cast<float>(map_.width), uv.y * static_cast<float>(map_.height)) * strength_;
}

float Environment::pdf(const Vec3& d) const {
  if (table_.empty()) return 0;
  const Vec2 uv = to_uv(d);
  const int i = std::min(static_cast<int>(uv.x * static_cast<float>(columns_)), columns_ - 1);
  const int j = std::min(static_cast<int>(uv.y * static_cast<float>(rows_)), rows_ - 1);
  const float solid_angle = 2 * math::pi / static_cast<float>(columns_) *
                            (cos_edge_[static_cast<size_t>(j)] - cos_edge_[static_cast<size_t>(j) + 1]);
  return table_.probability(static_cast<std::uint32_t>(j * columns_ + i)) / solid_angle;
}

Environment::Sample Environment::sample(float u0, float u1) const {
  // One uniform number per axis: what choosing the cell leaves of u0 places the direction in its row, and u1,
  // shifted by the cell, in its column.
  const auto cell = table_.sample(math::join(u0, u1));
  const int i = static_cast<int>(cell.index) % columns_, j = static_cast<int>(cell.index) / columns_;
  const float top = cos_edge_[static_cast<size_t>(j)], bottom = cos_edge_[static_cast<size_t>(j) + 1];
  const float y = top + (bottom - top) * cell.u;
  const float r = std::sqrt(std::max(0.f, 1 - y * y));
  float s, c;
  math::sin_cos(2 * math::pi * ((static_cast<float>(i) + u1) / static_cast<float>(columns_) - .5f), s, c);
  const float x = r * c, z = r * s;
  const Vec3 d(cos_rotation_ * x + sin_rotation_ * z, y, -sin_rotation_ * x + cos_rotation_ * z);
  const float solid_angle = 2 * math::pi / static_cast<float>(columns_) * (top - bottom);
  return {math::normalize(d), cell.probability / solid_angle};
}

}  // namespace light
