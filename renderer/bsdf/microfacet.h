// Microfacet terms D, G and F shared by the lobes.
//
// Vectors are unit, in the shading frame, pointing away from the surface: wo to the eye, wi to the light. The
// half vector is kept unnormalised and in double: D at alpha = 0.001 is decided by an angle of 0.06 degrees,
// which float cannot hold (sin^2 + alpha^2 cos^2 of a float half vector errs by 1e-3; 1 + (alpha^2-1) cos^2
// in float by 12 %).
//
// Sources: GTR and Schlick: Burley 2012, appendix B. Smith G1 for GGX: Walter et al. 2007, eq. 34;
// anisotropic: Heitz 2014, JCGT 3(2), eq. 80 and 87.
#pragma once

#include <cmath>

#include "math/transcendental.h"
#include "math/vec.h"

namespace bsdf {

using math::Vec3;

inline constexpr double pi = 3.14159265358979323846;

// f_cos, 1/sr, and the density of sampling that direction, 1/sr.
struct Value {
  Vec3 f_cos{0, 0, 0};
  float pdf = 0;
};

// wi + wo and what all lobes need of it.
struct HalfVector {
  double x, y, z;         // wi + wo, not normalised
  double length_squared;  // 0 for wi = -wo
  double cos_d;           // wi . wh, in [1e-30,1]

  HalfVector(const Vec3& wo, const Vec3& wi)
      : x(static_cast<double>(wi.x) + wo.x),
        y(static_cast<double>(wi.y) + wo.y),
        z(static_cast<double>(wi.z) + wo.z) {
    length_squared = x * x + y * y + z * z;
    // Half the length of wi + wo, which unlike wi . wh does not cancel for nearly opposite directions at
    // grazing angles and is the same from both sides. Divided by the mean length of wi and wo, as float
    // vectors are unit only to 1e-7: (1 + x)/2 is the square root of x to 1e-14 there, and 1 - s/8 is 2/s
    // for an s near 4.
    const double wi2 = static_cast<double>(wi.x) * wi.x + static_cast<double>(wi.y) * wi.y +
                       static_cast<double>(wi.z) * wi.z;
    const double wo2 = static_cast<double>(wo.x) * wo.x + static_cast<double>(wo.y) * wo.y +
                       static_cast<double>(wo.z) * wo.z;
    cos_d = std::sqrt(length_squared) * (1 - (2 + wi2 + wo2) / 8);
    if (cos_d > 1) cos_d = 1;
    if (cos_d < 1e-30)
      cos_d = 1e-30;  // nearly opposite along the horizon: densities over it stay within float
  }
  double sin2_h() const { return (x * x + y * y) / length_squared; }
  double cos2_h() const { return z * z / length_squared; }
};

// Schlick's weight (1-c)^5.
inline float schlick(float c) {
  const float m = math::saturate(1 - c);
  return (m * m) * (m * m) * m;
}
inline double schlick(double c) {
  const double m = c < 0 ? 1 : c > 1 ? 0 : 1 - c;
  return (m * m) * (m * m) * m;
}

// Fresnel reflectance of a dielectric, exact, unpolarised; eta >= 1 is the relative index of refraction.
inline double fresnel_dielectric(double c, double eta) {
  // 1/2 a^2 (1 + b^2), a = (g - c) / (g + c), b = (c (g + c) - 1) / (c (g - c) + 1), over one denominator.
  const double g2 = eta * eta - 1 + c * c;
  const double g = std::sqrt(g2 > 0 ? g2 : 0);
  const double b_top = c * (g + c) - 1, b_bottom = c * (g - c) + 1, bottom = (g + c) * b_bottom;
  return .5 * (g - c) * (g - c) * (b_bottom * b_bottom + b_top * b_top) / (bottom * bottom);
}
// The same rescaled to 0 at normal incidence and 1 at grazing: Cycles' replacement for Schlick's weight. f0
// is fresnel_dielectric(1, eta). An eta of 1 has no interface, hence weight 0 everywhere.
inline double fresnel_weight(double c, double eta, double f0) {
  if (!(eta > 1)) return 0;
  const double weight = (fresnel_dielectric(c, eta) - f0) * (1 / (1 - f0));
  return weight < 0 ? 0 : weight > 1 ? 1 : weight;
}

// Anisotropic GTR2 (GGX), per steradian; integral of D cos over the hemisphere is 1. ax, ay > 0.
inline double d_gtr2(const HalfVector& h, double ax, double ay) {
  // 1 / (pi ax ay q^2) with q = (x^2/ax^2 + y^2/ay^2 + z^2) / length^2, over one denominator.
  const double a2 = ax * ay, x = h.x * ay, y = h.y * ax, z = h.z * a2;
  const double q = x * x + y * y + z * z, top = h.length_squared * a2;
  return top * top * a2 / (pi * q * q);
}

// GTR1 (Berry), per steradian, normalised; alpha in (0, 1), log_alpha2 = ln alpha^2. For alpha >= 1: 1/pi.
inline double d_gtr1(double sin2, double cos2, double alpha, double log_alpha2) {
  if (!(alpha < 1)) return 1 / pi;
  const double a2 = alpha * alpha;
  return (a2 - 1) / (pi * log_alpha2 * (sin2 + a2 * cos2));
}

// Normalisation of GTR with any real gamma in (0, 10] (Burley 2012, appendix B.2, eq. 4 with the measure cos
// dw): the factor c for which D = c / (alpha^2 cos^2 + sin^2)^gamma integrates to 1. alpha in (0, 1]. With s
// = ln alpha^2 and k = 1 - gamma: c = k (e^s - 1) / (pi (e^(k s) - 1)), by expm1; k s -> 0 has the limit (e^s
// - 1) / (pi s), s -> 0 the limit 1/pi.
inline double gtr_constant(double alpha, double gamma) {
  const double s = 2 * math::log(alpha);
  if (!(s < -1e-12)) return 1 / pi;
  const double k = 1 - gamma;
  const double ks = k * s;
  // (e^(ks) - 1) / k, written so that k = 0 is s: its series is s (1 + ks/2 + (ks)^2/6 + ...)
  const double denominator = std::fabs(ks) < 1e-5 ? s * (1 + ks / 2 + ks * ks / 6) : math::expm1(ks) / k;
  return math::expm1(s) / (pi * denominator);
}

// Smith's masking for GGX divided by 2 cos(w): G1(w) = 2 cos(w) * g1_over_2cos(w), w.z > 0. So a separable
// G / (4 cos cos) is the product of two of these.
inline float g1_over_2cos(const Vec3& w, float ax, float ay) {
  const float x = w.x * ax, y = w.y * ay;
  return 1 / (w.z + std::sqrt(x * x + y * y + w.z * w.z));
}

// Unit half vector with the given sin^2 of its polar angle and azimuth 2 pi v.
inline Vec3 half_direction(double sin2, float v) {
  sin2 = sin2 < 0 ? 0 : sin2 > 1 ? 1 : sin2;
  float s, c;
  math::sin_cos(2 * math::pi * v, s, c);
  const float r = static_cast<float>(std::sqrt(sin2));
  return {r * c, r * s, static_cast<float>(std::sqrt(1 - sin2))};
}

// wo mirrored at wh, normalised.
inline Vec3 reflect(const Vec3& wo, const Vec3& wh) {
  return math::renormalize(wh * (2 * math::dot(wo, wh)) - wo);
}

}  // namespace bsdf
