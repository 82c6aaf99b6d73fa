// An orthonormal right-handed frame: tangent, bitangent, normal.
#pragma once

#include <cmath>

#include "math/vec.h"

namespace math {

struct Frame {
  Vec3 tangent{1, 0, 0}, bitangent{0, 1, 0}, normal{0, 0, 1};

  Vec3 to_local(const Vec3& v) const { return {dot(v, tangent), dot(v, bitangent), dot(v, normal)}; }
  Vec3 to_world(const Vec3& v) const {
    return {v.x * tangent.x + v.y * bitangent.x + v.z * normal.x,
            v.x * tangent.y + v.y * bitangent.y + v.z * normal.y,
            v.x * tangent.z + v.y * bitangent.z + v.z * normal.z};
  }
};

// Frame about a unit normal whose tangent does not matter.
// Duff et al. 2017, "Building an Orthonormal Basis, Revisited", JCGT 6(1), listing 3.
inline Frame frame_from_normal(const Vec3& n) {
  const float sign = std::copysign(1.f, n.z);
  const float a = -1 / (sign + n.z);
  const float b = n.x * n.y * a;
  return {{1 + sign * n.x * n.x * a, sign * b, -sign * n.x}, {b, sign + n.y * n.y * a, -n.y}, n};
}

// Frame about a unit normal whose tangent is `tangent` (any length) made perpendicular to it. A tangent that
// is zero, not finite or parallel to the normal (within 1e-4) gives frame_from_normal.
inline Frame frame_from_normal_and_tangent(const Vec3& n, const Vec3& tangent) {
  const Vec3 unit = normalize(tangent, {0, 0, 0});
  const Vec3 across = unit - n * dot(n, unit);
  if (!(dot(across, across) > 1e-8f)) return frame_from_normal(n);
  // A second projection removes what rounding left of n in a nearly parallel tangent.
  const Vec3 once = normalize(across);
  const Vec3 t = normalize(once - n * dot(n, once));
  return {t, cross(n, t), n};
}

}  // namespace math
