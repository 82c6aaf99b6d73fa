// When Blender's answers agree with Assay's, for one subset of the soup.
//
// Cycles computes in float, and D of a narrow lobe from cos(theta_h) alone. So a sample agrees when Blender's
// value lies between those that remain possible for an (n.h)^2 off by 4e-7, widened by 1e-5 (plus 1.2e-7/cos
// for the rounding of n.l and n.v at grazing angles), all relative to the sample's largest channel. At the
// peak of a lobe that is 1e-5 + 8e-7/alpha^2 for the specular lobe and 1e-5 + 4e-7/alpha^2 for the coat; away
// from the peak it is far less. Where both roughnesses are at least .3 it must also be within 1e-4 for 99.9 %
// of the samples and 1e-3 for all.
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "blender/soup.h"

namespace blender {

inline constexpr double rounding_of_cos2 = 4e-7, rounding_of_cosine = 1.2e-7, rounding = 1e-5;
// Below this a value is compared as if it were this: Fresnel terms near zero are differences of float
// numbers.
inline constexpr double dark = 1e-6;
inline constexpr double near = 1e-4, far = 1e-3, share_near = .999;

inline double relative_difference(const Configuration& c, const Answer& a) {
  const double scale = std::max({a.total(0), a.total(1), a.total(2), dark});
  double worst = 0;
  for (int k = 0; k < 3; ++k) {
    const double d = std::fabs(c.blender[static_cast<std::size_t>(k)] - a.total(k)) / scale;
    if (!(d <= worst)) worst = d;  // NaN counts
  }
  return worst;
}

inline bool explained_by_float(const Configuration& c, const Answer& a) {
  double cosine = 1;
  for (const Vec3d& w : {c.wo, c.wi})
    cosine = std::min(cosine, c.normal[0] * w[0] + c.normal[1] * w[1] + c.normal[2] * w[2]);
  const double scale = std::max({a.total(0), a.total(1), a.total(2), dark});
  const double tolerance = scale * (rounding + rounding_of_cosine / cosine);
  for (int k = 0; k < 3; ++k) {
    const double value = c.blender[static_cast<std::size_t>(k)];
    const double highest = a.off(k, -rounding_of_cos2);
    // s may vanish: then Cycles' own quotient may be anything, even negative.
    if (std::isinf(highest)) continue;
    if (!(value <= highest + tolerance && value >= a.off(k, rounding_of_cos2) - tolerance)) return false;
  }
  return true;
}

struct Verdict {
  std::vector<double> differences;  // sorted
  int unexplained = 0;

  double quantile(double q) const {
    const auto last = differences.size() - 1;
    return differences[std::min(last, static_cast<std::size_t>(q * static_cast<double>(differences.size())))];
  }
  double largest() const { return differences.back(); }
  double share_within(double bound) const {
    const auto end = std::upper_bound(differences.begin(), differences.end(), bound);
    return static_cast<double>(end - differences.begin()) / static_cast<double>(differences.size());
  }
  bool within_float() const { return unexplained == 0; }
  bool close() const { return share_within(near) >= share_near && largest() <= far; }
};

// Of all configurations for which `belongs(configuration)`.
template <class Belongs>
Verdict judge(const Soup& soup, bsdf::Model model, Belongs belongs, const Fault& fault = {}) {
  Verdict v;
  for (const Configuration& c : soup.configurations) {
    if (!belongs(c)) continue;
    const Answer a = ask(c, model, fault);
    v.differences.push_back(relative_difference(c, a));
    v.unexplained += !explained_by_float(c, a);
  }
  std::sort(v.differences.begin(), v.differences.end());
  return v;
}

}  // namespace blender
