// Disney's clearcoat: GTR1, Fresnel of index 1.5, Smith G with alpha fixed at 1/4, a quarter of the strength
// (Burley 2012, section 5.6). Sampled by GTR1's own half-vector density.
#pragma once

#include "bsdf/microfacet.h"

namespace bsdf {

struct Clearcoat {
  float weight = 0;  // clearcoat / 4
  float alpha = .1f;
  double log_alpha2 = -4.605170185988091;  // ln alpha^2
  bool dielectric = false;  // Fresnel: true the renormalised dielectric curve (Blender), false Schlick
  bool is_delta = false;

  static constexpr float alpha_g = .25f;

  float fresnel(double cos_d) const {
    constexpr double f0 = .04;  // of eta = 1.5
    const double t = dielectric ? fresnel_weight(cos_d, 1.5, f0) : schlick(cos_d);
    return static_cast<float>(f0 + (1 - f0) * t);
  }
  // Density of wi: D cos(wh) / (4 wi.wh).
  Value eval(const Vec3& wo, const Vec3& wi, const HalfVector& h) const {
    const double d = d_gtr1(h.sin2_h(), h.cos2_h(), alpha, log_alpha2);
    const float g = g1_over_2cos(wo, alpha_g, alpha_g) * g1_over_2cos(wi, alpha_g, alpha_g);
    return {Vec3(weight * static_cast<float>(d) * fresnel(h.cos_d) * g * wi.z),
            static_cast<float>(d * h.z / std::sqrt(h.length_squared) / (4 * h.cos_d))};
  }
  // Half vector from two uniform numbers: cos^2 = (1 - (alpha^2)^(1-u)) / (1 - alpha^2).
  Vec3 sample_half(float u, float v) const {
    const double a2 = static_cast<double>(alpha) * alpha;
    // sin^2 = ((alpha^2)^(1-u) - alpha^2) / (1 - alpha^2), which keeps small angles.
    const double sin2 = alpha < 1 ? a2 * math::expm1(-u * log_alpha2) / (1 - a2) : u;
    return half_direction(sin2, v);
  }
};

}  // namespace bsdf
