#include "light/environment.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "math/lanes.h"
#include "math/transcendental.h"

namespace light {

using math::Vec2;
using math::Vec3;

Environment::Environment(const scene::Environment& e, bool light_sampling_only)
    : map_(e.map), strength_(e.strength) {
  math::sin_cos(e.rotation, sin_rotation_, cos_rotation_);
  // At least 64 x 32 cells, so that even a constant map is drawn by solid angle.
  const int columns = map_.width * ((63 + map_.width) / map_.width);
  const int rows = map_.height * ((31 + map_.height) / map_.height);
  for (int j = 0; j <= rows; ++j) {
    double s, c;
    math::sin_cos(static_cast<double>(math::pi) * j / rows, s, c);
    cos_edge_.push_back(static_cast<float>(c));
  }
  const auto solid_angle = [&](int j) {  // of a cell
    return 2 * std::numbers::pi / columns *
           (static_cast<double>(cos_edge_[static_cast<size_t>(j)]) - cos_edge_[static_cast<size_t>(j) + 1]);
  };
  // The threshold is no less than the mean, so that of a constant map nothing is drawn.
  double threshold = 0;
  if (!light_sampling_only) {
    for (int j = 0; j < rows; ++j) {
      double sum = 0;
      for (int i = 0; i < map_.width; ++i) sum += math::luminance(Vec3(texel(i, j * map_.height / rows)));
      threshold += sum / map_.width * (solid_angle(j) * columns) / (4 * std::numbers::pi);
    }
    threshold *= 1 + 1e-4;
  }
  // A cell's weight is the mean of nine bilinear look-ups, so that no cell which shows light is overlooked.
  const float sx = static_cast<float>(map_.width) / static_cast<float>(columns);
  const float sy = static_cast<float>(map_.height) / static_cast<float>(rows);
  std::vector<double> row_flux, weights(static_cast<size_t>(columns));
  for (int j = 0; j < rows; ++j) {
    for (int i = 0; i < columns; ++i) {
      double sum = 0;
      for (const float b : {.02f, .5f, .98f})
        for (const float a : {.02f, .5f, .98f})
          sum +=
              math::luminance(bilinear((static_cast<float>(i) + a) * sx, (static_cast<float>(j) + b) * sy));
      weights[static_cast<size_t>(i)] = std::max(0., sum / 9 - threshold);
    }
    columns_.emplace_back(weights);
    row_flux.push_back(columns_.back().sum() * solid_angle(j));
  }
  rows_ = math::Distribution1D(row_flux);
  drawn_luminance_ = rows_.sum() / (4 * std::numbers::pi) * strength_;
}

const math::Vec4& Environment::texel(int column, int row) const {
  return map_
      .texels[static_cast<size_t>(row) * static_cast<size_t>(map_.width) + static_cast<size_t>(column)];
}

// Calls the texels near uv from memory, to be read later.
void Environment::fetch(const Vec2& uv) const {
  const int x = math::floor_to_int(uv.x * static_cast<float>(map_.width) - .5f),
            y = math::floor_to_int(uv.y * static_cast<float>(map_.height) - .5f);
  for (const int row : {y, y + 1})
    __builtin_prefetch(&texel(std::clamp(x, 0, map_.width - 1), std::clamp(row, 0, map_.height - 1)));
}

Vec3 Environment::bilinear(float x, float y) const {
  const int fx = math::floor_to_int(x - .5f), fy = math::floor_to_int(y - .5f);
  const float a = x - .5f - static_cast<float>(fx), b = y - .5f - static_cast<float>(fy);
  const auto column = [&](int i) { return i < 0 ? i + map_.width : i >= map_.width ? i - map_.width : i; };
  const auto row = [&](int j) { return std::clamp(j, 0, map_.height - 1); };
  const int i = column(fx), i1 = column(fx + 1), j = row(fy), j1 = row(fy + 1);
  const math::Lanes c = math::bilinear(math::load(texel(i, j)), math::load(texel(i1, j)),
                                       math::load(texel(i, j1)), math::load(texel(i1, j1)), a, b);
  return {c[0], c[1], c[2]};
}

// World direction to map coordinates in [0,1]: u = 1/2 + atan2(z, x) / 2 pi, v = acos(y) / pi.
Vec2 Environment::to_uv(const Vec3& d) const {
  // Turned by -rotation about +y.
  const float x = cos_rotation_ * d.x - sin_rotation_ * d.z;
  const float z = sin_rotation_ * d.x + cos_rotation_ * d.z;
  const float u = .5f + math::atan2(z, x) * (.5f * math::inv_pi);
  return {math::saturate(u), math::saturate(math::acos(std::clamp(d.y, -1.f, 1.f)) * math::inv_pi)};
}

Vec3 Environment::radiance_at(const Vec2& uv) const {
  return bilinear(uv.x * static_cast<float>(map_.width), uv.y * static_cast<float>(map_.height)) * strength_;
}

Vec3 Environment::radiance(const Vec3& d) const {
  if (map_.width == 1 && map_.height == 1) return Vec3(map_.texels[0]) * strength_;
  return radiance_at(to_uv(d));
}

float Environment::cell_pdf(std::uint32_t row, std::uint32_t column) const {
  const float solid_angle =
      2 * math::pi / static_cast<float>(columns_[row].size()) * (cos_edge_[row] - cos_edge_[row + 1]);
  return rows_.probability(row) * (columns_[row].probability(column) / solid_angle);
}

Environment::Seen Environment::look(const Vec3& d) const {
  if (!sampled()) return {radiance(d), 0};
  const Vec2 uv = to_uv(d);
  const auto cell = [](float u, std::uint32_t n) {
    return std::min(static_cast<std::uint32_t>(u * static_cast<float>(n)), n - 1);
  };
  const std::uint32_t row = cell(uv.y, rows_.size());
  return {radiance_at(uv), cell_pdf(row, cell(uv.x, columns_[row].size()))};
}

Environment::Sample Environment::sample(float u0, float u1) const {
  // What choosing the row leaves of u0 places the direction within it, and what choosing the column leaves of
  // u1 within that. The other number gives the bits below 2^-24 that large maps use.
  const auto row = rows_.sample(math::join(u0, u1));
  const math::Distribution1D& columns = columns_[row.index];
  const auto column = columns.sample(math::join(u1, u0));
  const float top = cos_edge_[row.index], bottom = cos_edge_[row.index + 1];
  const float y = top + (bottom - top) * row.u;
  const float r = std::sqrt(std::max(0.f, 1 - y * y));
  const float u = (static_cast<float>(column.index) + column.u) / static_cast<float>(columns.size());
  fetch({u, (static_cast<float>(row.index) + row.u) / static_cast<float>(rows_.size())});
  float s, c;
  math::sin_cos(2 * math::pi * (u - .5f), s, c);
  const float x = r * c, z = r * s;
  const Vec3 d(cos_rotation_ * x + sin_rotation_ * z, y, -sin_rotation_ * x + cos_rotation_ * z);
  return {
      math::normalize(d),
      {radiance_at({u, math::saturate(math::acos(y) * math::inv_pi)}), cell_pdf(row.index, column.index)}};
}

}  // namespace light
