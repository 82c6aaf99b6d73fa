// The specular lobe, which is also the metal: F D G / (4 cos cos).
//
//   path, disney, principled: D anisotropic GTR2, G Smith with the same alphas, sampled by visible normals
//   path_disney:              D = c / (alpha^2 cos^2 + sin^2)^gamma, G Smith with alpha_g = (1/2 +
//   roughness/2)^2
//                             (Burley 2012, section 5.4), sampled by the normalised D of the same gamma
#pragma once

#include "bsdf/microfacet.h"

namespace bsdf {

struct Specular {
  bool present = false;
  bool is_delta = false;  // a perfect mirror of reflectance F
  bool dielectric =
      false;         // Fresnel: true the renormalised dielectric curve of `eta` (Blender), false Schlick
  bool gtr = false;  // D of path_disney
  Vec3 f0{.04f, .04f, .04f};
  double eta = 1.5, fresnel0 = .04;  // of the dielectric curve
  float ax = .25f, ay = .25f;
  float ax_g = .25f, ay_g = .25f;                           // alphas of G
  double gamma = 2, constant = 0, normalised_constant = 0;  // of gtr

  Vec3 fresnel(double cos_d) const {
    const double t = dielectric ? fresnel_weight(cos_d, eta, fresnel0) : schlick(cos_d);
    const float w = static_cast<float>(t), rest = static_cast<float>(1 - t);
    return f0 * rest + Vec3(w);
  }

  // D of path_disney over its constant.
  double gtr_shape(const HalfVector& h) const {
    const double t = h.sin2_h() + static_cast<double>(ax) * ax * h.cos2_h();
    if (gamma == 1) return 1 / t;
    if (gamma == 2) return 1 / (t * t);
    return math::exp(-gamma * math::log(t));
  }
  double d(const HalfVector& h) const { return gtr ? constant * gtr_shape(h) : d_gtr2(h, ax, ay); }

  // Density of wi: of visible normals D G1(wo) / (4 wo.z), of path_disney's D cos(wh) / (4 wi.wh).
  Value eval(const Vec3& wo, const Vec3& wi, const HalfVector& h) const {
    const double shape = gtr ? gtr_shape(h) : d_gtr2(h, ax, ay);
    const float d = static_cast<float>(gtr ? constant * shape : shape);
    const float g_wo = g1_over_2cos(wo, ax_g, ay_g), g = g_wo * g1_over_2cos(wi, ax_g, ay_g);
    return {fresnel(h.cos_d) * (d * g * wi.z),
            gtr ? static_cast<float>(normalised_constant * shape * h.z / std::sqrt(h.length_squared) /
                                     (4 * h.cos_d))
                : d * g_wo * .5f};
  }

  // Half vector from two uniform numbers.
  Vec3 sample_half(const Vec3& wo, float u, float v) const;
};

}  // namespace bsdf
