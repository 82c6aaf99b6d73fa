// From the unit square to the distributions a renderer needs, each warp beside its density. The u of every
// function are in [0,1); no input gives a non-finite result.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>

#include "math/transcendental.h"
#include "math/vec.h"

namespace math {

// Unit disk, area-preserving and continuous (Shirley & Chiu 1997). Density 1/pi.
inline Vec2 sample_disk(float u0, float u1) {
  const float a = 2 * u0 - 1, b = 2 * u1 - 1;
  if (a == 0 && b == 0) return {0, 0};
  float s = 0, c = 0;
  if (std::fabs(a) > std::fabs(b)) {
    sin_cos(pi / 4 * (b / a), s, c);
    return {a * c, a * s};
  }
  sin_cos(pi / 4 * (a / b), s, c);
  return {b * s, b * c};
}
inline constexpr float pdf_disk = inv_pi;

// Upper hemisphere, density proportional to the cosine (Malley). z is at least 1e-6: never a zero density.
inline Vec3 sample_cosine_hemisphere(float u0, float u1) {
  const Vec2 d = sample_disk(u0, u1);
  return {d.x, d.y, std::sqrt(std::max(1 - d.x * d.x - d.y * d.y, 1e-12f))};
}
inline float pdf_cosine_hemisphere(float cos_theta) { return cos_theta > 0 ? cos_theta * inv_pi : 0; }

inline Vec3 sample_sphere(float u0, float u1) {
  const float z = 1 - 2 * u0;
  const float r = std::sqrt(std::max(0.f, (1 - z) * (1 + z)));
  float s = 0, c = 0;
  sin_cos(2 * pi * u1, s, c);
  return {r * c, r * s, z};
}
inline constexpr float pdf_sphere = inv_pi / 4;

// Barycentric weights (of the first, second, third vertex) uniform over a triangle, with less distortion than
// the usual square root. Heitz 2019, "A Low-Distortion Map Between Triangle and Square". Density per area:
// 1/area.
inline Vec3 sample_triangle(float u0, float u1) {
  float b0 = u0 / 2, b1 = u1 / 2;
  const float offset = b1 - b0;
  if (offset > 0)
    b1 += offset;
  else
    b0 -= offset;
  return {b0, b1, std::max(0.f, 1 - b0 - b1)};
}

// Half vector with the density of the normals of a GGX surface (roughness alpha_x along x, alpha_y along y)
// that are visible from `wo`: D(h) G1(wo) max(0, wo.h) / wo.z, evaluated in bsdf/. wo is unit with wo.z >= 0;
// the result is unit with z >= 0. Dupuy & Benyoub 2023, "Sampling Visible GGX Normals with Spherical Caps",
// listing 3.
inline Vec3 sample_visible_normal(const Vec3& wo, float alpha_x, float alpha_y, float u0, float u1) {
  // In double: at the rim of the cap c + w cancels, and a small alpha magnifies what is left.
  double x = static_cast<double>(wo.x) * alpha_x, y = static_cast<double>(wo.y) * alpha_y, z = wo.z;
  const double length = std::sqrt(x * x + y * y + z * z);
  if (!(length > 0)) return {0, 0, 1};
  const double shorter = 1 / length;
  x *= shorter, y *= shorter, z *= shorter;
  // A point c uniform on the sphere's cap above -z; the half vector is c + w.
  const double h_z = (1 - static_cast<double>(u1)) * (1 + z), c_z = h_z - z;
  const double radius = std::sqrt(std::max(0., (1 - c_z) * (1 + c_z)));
  double s = 0, c = 0;
  sin_cos(6.283185307179586 * u0, s, c);
  const double h_x = (radius * c + x) * alpha_x, h_y = (radius * s + y) * alpha_y;
  const double scale = 1 / std::sqrt(h_x * h_x + h_y * h_y + h_z * h_z);
  return {static_cast<float>(h_x * scale), static_cast<float>(h_y * scale), static_cast<float>(h_z * scale)};
}

// Pixel filters: an offset in pixels from the pixel's centre with the filter as its density.

// Triangle of radius 1 pixel.
inline float sample_triangle_filter(float u) {
  return u < .5f ? std::sqrt(2 * u) - 1 : 1 - std::sqrt(2 * (1 - u));
}
inline float pdf_triangle_filter(float x) { return std::max(0.f, 1 - std::fabs(x)); }

// Blackman-Harris window of radius 1.5 pixels, Blender's default.
class BlackmanHarris {
 public:
  static constexpr float radius = 1.5f;
  BlackmanHarris();
  float sample(float u) const {
    // One half of the inverse distribution function is tabulated, the other is its mirror image. The root
    // spreads the tail, where the function is steep.
    const float v = std::sqrt(1 - std::fabs(2 * u - 1)) * intervals;
    const int i = std::min(static_cast<int>(v), intervals - 1);
    const float x = mix(inverse_[i], inverse_[i + 1], v - static_cast<float>(i));
    return u < .5f ? -x : x;
  }
  static double pdf(double x);  // x in pixels
  static double cdf(double x);

 private:
  static constexpr int intervals = 1024;
  std::array<float, intervals + 1> inverse_;  // [i]: the x beyond which lies (i / intervals)^2 / 2
};

}  // namespace math
