// Vectors and matrices. This header owns GLM: no other file of the renderer includes it.
// Lengths are metres, angles radians, colours linear Rec.709.
#pragma once

#define GLM_FORCE_CTOR_INIT
#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <glm/mat3x3.hpp>
#include <glm/mat4x4.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>
#include <limits>

namespace math {

using Vec2 = glm::vec2;
using Vec3 = glm::vec3;
using Vec4 = glm::vec4;
using Mat3 = glm::mat3;  // column-major, as in glTF
using Mat4 = glm::mat4;
using DVec3 = glm::dvec3;  // sums of many samples
using DMat4 = glm::dmat4;  // products of many transforms
using IVec2 = glm::ivec2;
using UVec3 = glm::uvec3;
using U16Vec4 = glm::vec<4, std::uint16_t>;

inline constexpr float pi = 3.14159265358979323846f;
inline constexpr float inv_pi = 0.31830988618379067154f;

inline float dot(const Vec3& a, const Vec3& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
inline Vec3 cross(const Vec3& a, const Vec3& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
inline double dot(const DVec3& a, const DVec3& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
inline DVec3 cross(const DVec3& a, const DVec3& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
inline float length(const Vec3& v) { return std::sqrt(dot(v, v)); }
inline double length(const DVec3& v) { return std::sqrt(dot(v, v)); }
inline Vec3 abs(const Vec3& v) { return {std::fabs(v.x), std::fabs(v.y), std::fabs(v.z)}; }
// (Not std::fmax, which is a call of libm for the sake of NaN. Of a NaN these may give either operand.)
inline float max_component(const Vec3& v) { return std::max(v.x, std::max(v.y, v.z)); }
inline Vec3 smaller(const Vec3& a, const Vec3& b) {  // of each component
  return {std::min(a.x, b.x), std::min(a.y, b.y), std::min(a.z, b.z)};
}
inline Vec3 larger(const Vec3& a, const Vec3& b) {
  return {std::max(a.x, b.x), std::max(a.y, b.y), std::max(a.z, b.z)};
}
inline float mean(const Vec3& v) { return (v.x + v.y + v.z) / 3; }
inline bool is_finite(const Vec3& v) {
  return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}
inline bool is_black(const Vec3& v) {  // each 0 or -0, in integers, which is one jump
  const auto bits = [](float x) { return std::bit_cast<std::uint32_t>(x); };
  return ((bits(v.x) | bits(v.y) | bits(v.z)) & 0x7fffffff) == 0;
}
inline float saturate(float x) { return x < 0 ? 0 : x > 1 ? 1 : x; }
inline float mix(float a, float b, float t) { return a * (1 - t) + b * t; }
inline Vec3 mix(const Vec3& a, const Vec3& b, float t) { return a * (1 - t) + b * t; }
inline float sqr(float x) { return x * x; }
inline double sqr(double x) { return x * x; }

// Relative luminance of linear Rec.709.
inline float luminance(const Vec3& c) { return 0.2126729f * c.x + 0.7151522f * c.y + 0.0721750f * c.z; }

// Unit vector along v, computed in double so that any finite v from 1e-300 to 1e300 works; zero or non-finite
// input gives `otherwise`.
inline Vec3 normalize(const Vec3& v, const Vec3& otherwise = {0, 0, 1}) {
  const double x = v.x, y = v.y, z = v.z;
  const double square = x * x + y * y + z * z;
  if (!(square > 0) || !std::isfinite(square)) return otherwise;
  const double scale = 1 / std::sqrt(square);
  return {static_cast<float>(x * scale), static_cast<float>(y * scale), static_cast<float>(z * scale)};
}

// The same for a v whose length is 1 but for rounding: one step of Newton's method for 1 / sqrt, which leaves
// 3/8 of the square of what v . v differs from 1.
inline Vec3 renormalize(const Vec3& v) {
  const double x = v.x, y = v.y, z = v.z;
  const double scale = 1.5 - .5 * (x * x + y * y + z * z);
  return {static_cast<float>(x * scale), static_cast<float>(y * scale), static_cast<float>(z * scale)};
}

inline Vec3 transform_point(const Mat4& m, const Vec3& p) {
  return {m[0].x * p.x + m[1].x * p.y + m[2].x * p.z + m[3].x,
          m[0].y * p.x + m[1].y * p.y + m[2].y * p.z + m[3].y,
          m[0].z * p.x + m[1].z * p.y + m[2].z * p.z + m[3].z};
}
inline Vec3 transform_vector(const Mat4& m, const Vec3& v) {
  return {m[0].x * v.x + m[1].x * v.y + m[2].x * v.z, m[0].y * v.x + m[1].y * v.y + m[2].y * v.z,
          m[0].z * v.x + m[1].z * v.y + m[2].z * v.z};
}

// How many times a matrix enlarges the largest component of a vector at most; infinite if it is not finite.
inline double growth(const DMat4& m) {
  double most = 0;
  for (int row = 0; row < 3; ++row) {
    const double sum = std::fabs(m[0][row]) + std::fabs(m[1][row]) + std::fabs(m[2][row]);
    if (!std::isfinite(sum)) return std::numeric_limits<double>::infinity();
    most = std::fmax(most, sum);
  }
  return most;
}

}  // namespace math
