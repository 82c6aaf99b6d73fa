#include "disney/disney.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace disney {
namespace {

constexpr double pi = std::numbers::pi;

double sqr(double x) { return x * x; }
double mix(double a, double b, double t) { return a * (1 - t) + b * t; }
double saturate(double x) { return std::clamp(x, 0., 1.); }

Colour operator+(const Colour& a, const Colour& b) { return {a.r + b.r, a.g + b.g, a.b + b.b}; }
Colour operator*(const Colour& c, double s) { return {c.r * s, c.g * s, c.b * s}; }
Colour mix(const Colour& a, const Colour& b, double t) { return a * (1 - t) + b * t; }
double mean(const Colour& c) { return (c.r + c.g + c.b) / 3; }
const Colour white{1, 1, 1};

double dot(const Vector& a, const Vector& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
Vector unit(const Vector& a) {
  const double length = std::sqrt(dot(a, a));
  return {a.x / length, a.y / length, a.z / length};
}

// ---- Section 2, "The microfacet model": f = D F G / (4 (n.l)(n.v)), in terms of h and of these angles. ----

struct Angles {
  Vector l, v, h;
  double n_l, n_v, n_h;
  double l_h;  // cos of the paper's difference angle theta_d; equal to v.h

  // l and v are unit as far as float goes, and taken as they are: h is normalised here. |l+v| / (|l|+|v|) is
  // the cosine of half the angle between them, which l.h loses to cancellation when they are nearly opposite,
  // and |l+v|/2 to lengths that are not 1 when they are nearly one.
  Angles(const Vector& to_viewer, const Vector& to_light) : l(to_light), v(to_viewer) {
    const Vector sum{l.x + v.x, l.y + v.y, l.z + v.z};
    h = unit(sum);
    n_l = l.z;
    n_v = v.z;
    n_h = h.z;
    l_h = std::sqrt(dot(sum, sum)) / (std::sqrt(dot(l, l)) + std::sqrt(dot(v, v)));
  }
  bool below() const { return !(n_l > 0 && n_v > 0); }
};

// Schlick's weight, (1 - cos)^5: section 5.3 for the diffuse, 5.5 for the specular Fresnel term.
double schlick(double cosine) { return std::pow(saturate(1 - cosine), 5); }

// Section 5.3: f_d = base/pi (1 + (FD90 - 1)(1 - cos theta_l)^5)(1 + (FD90 - 1)(1 - cos theta_v)^5),
// FD90 = 0.5 + 2 roughness cos^2 theta_d. A smooth surface darkens towards the edge, a rough one brightens.
Colour diffuse(const Colour& base, double roughness, const Angles& a) {
  const double fd90 = .5 + 2 * roughness * sqr(a.l_h);
  return base * (1 / pi * (1 + (fd90 - 1) * schlick(a.n_l)) * (1 + (fd90 - 1) * schlick(a.n_v)));
}

// The hue of the base colour: base over its luminance; white if black.
Colour hue(const Colour& base, double luminance) { return luminance > 0 ? base * (1 / luminance) : white; }
// Disney's shader: "luminance approx."
Colour hue_by_disney(const Colour& base) { return hue(base, .3 * base.r + .6 * base.g + .1 * base.b); }
// Rec.709's, which Blender uses for the sheen only.
Colour hue_by_rec709(const Colour& base) {
  return hue(base, .2126729 * base.r + .7151522 * base.g + .0721750 * base.b);
}

// Section 5.2 and the shader: the reflectance of the specular lobe at normal incidence, .08 specular for a
// dielectric (specular .5 is 4 %, IOR 1.5), optionally tinted, blended into the base colour of a metal.
Colour tinted_specular(const Material& m) {
  const Colour dielectric = mix(white, hue_by_disney(m.base), m.specular_tint) * (.08 * m.specular);
  return mix(dielectric, m.base, m.metallic);
}
// The same of the models that know no tint.
Colour plain_specular(const Material& m) { return mix(white * (.08 * m.specular), m.base, m.metallic); }

// Section 5.4 and appendix B (anisotropic): D of GTR with gamma = 2, GGX,
// 1 / (pi ax ay ((h.x/ax)^2 + (h.y/ay)^2 + (n.h)^2)^2).
double gtr_2(const Vector& h, double ax, double ay) {
  return 1 / (pi * ax * ay * sqr(sqr(h.x / ax) + sqr(h.y / ay) + sqr(h.z)));
}

// Section 5.4 and appendix B: D of GTR with gamma = 1, Berry; (a^2 - 1)/ln a^2 tends to 1 as a does.
double gtr_1(double n_h, double alpha) {
  if (alpha >= 1) return 1 / pi;
  const double a2 = sqr(alpha);
  return (a2 - 1) / (pi * std::log(a2) * (1 + (a2 - 1) * sqr(n_h)));
}

// Section 5.6, Smith's shadowing for GGX (Walter 2007): G1 = 2 / (1 + sqrt(1 + alpha^2 tan^2)). Along w the
// anisotropic alpha^2 tan^2 is ((w.x ax)^2 + (w.y ay)^2) / w.z^2.
double smith(const Vector& w, double ax, double ay) {
  return 2 / (1 + std::sqrt(1 + (sqr(w.x * ax) + sqr(w.y * ay)) / sqr(w.z)));
}

// G / (4 (n.l)(n.v)), which the shader writes as a product of 1/(n.w + sqrt(...)). G is separable: G1(l)
// G1(v).
double visibility(const Angles& a, double ax, double ay) {
  return smith(a.l, ax, ay) * smith(a.v, ax, ay) / (4 * a.n_l * a.n_v);
}

// Section 5.5: Schlick's Fresnel.
Colour fresnel_schlick(const Colour& at_normal, double l_h) { return mix(at_normal, white, schlick(l_h)); }

// Appendix B: aspect = sqrt(1 - 0.9 anisotropic), ax = roughness^2 / aspect, ay = roughness^2 aspect.
double aspect(const Material& m) { return std::sqrt(1 - .9 * m.anisotropic); }

// ---- Blender ----

// Exact Fresnel equations of a dielectric of relative index eta, unpolarised. Long double: g - c cancels as
// eta tends to 1.
long double dielectric(long double c, long double eta) {
  const long double g = std::sqrt(eta * eta - 1 + c * c);
  const long double s = (g - c) / (g + c), p = (c * (g + c) - 1) / (c * (g - c) + 1);
  return s * s * (1 + p * p) / 2;
}

// Blender's stand-in for Schlick's weight: that curve, rescaled to 0 at normal incidence and 1 at grazing.
double dielectric_weight(double l_h, long double eta) {
  const long double at_normal = dielectric(1, eta);
  return static_cast<double>((dielectric(l_h, eta) - at_normal) / (1 - at_normal));
}

// A closure of less than this weight is not made.
constexpr double closure_cutoff = 1e-5;
// A microfacet lobe of ax ay up to this is a mirror, which no light of the scene meets by chance.
constexpr double mirror_cutoff = 1e-7;

double blender_ax(const Material& m) { return saturate(sqr(m.roughness) / aspect(m)); }
double blender_ay(const Material& m) { return saturate(sqr(m.roughness) * aspect(m)); }
double blender_coat_alpha(const Material& m) { return saturate(sqr(m.clearcoat_roughness)); }

}  // namespace

// The sum of the shader's last lines: [base/pi Fd + Fsheen](1 - metallic) + Gs Fs Ds + .25 clearcoat Gr Fr
// Dr.
Colour burley_2012(const Material& m, const Vector& v, const Vector& l) {
  const Angles a(v, l);
  if (a.below()) return {};

  // Section 5.3 and the shader, sheen: Fsheen = sheen mix(1, hue, sheen_tint) (1 - cos theta_d)^5, without
  // 1/pi.
  const Colour sheen = mix(white, hue_by_disney(m.base), m.sheen_tint) * (m.sheen * schlick(a.l_h));

  // Specular. Neither alpha is below .001; ax may exceed 1.
  const double ax = std::max(.001, sqr(m.roughness) / aspect(m));
  const double ay = std::max(.001, sqr(m.roughness) * aspect(m));
  const Colour specular =
      fresnel_schlick(tinted_specular(m), a.l_h) * (gtr_2(a.h, ax, ay) * visibility(a, ax, ay));

  // Clearcoat: a GTR1 lobe of IOR 1.5 (4 %), G of the fixed alpha .25, at most a quarter as strong. The
  // shader's gloss keeps alpha in [.001, .1]; roughness may go up to 1.
  const double coat_alpha = std::max(.001, sqr(m.clearcoat_roughness));
  const double coat =
      .25 * m.clearcoat * gtr_1(a.n_h, coat_alpha) * mix(.04, 1, schlick(a.l_h)) * visibility(a, .25, .25);

  const Colour f = (diffuse(m.base, m.roughness, a) + sheen) * (1 - m.metallic) + specular + white * coat;
  return f * a.n_l;
}

bool blender_specular_is_mirror(const Material& m) { return blender_ax(m) * blender_ay(m) <= mirror_cutoff; }
bool blender_coat_is_mirror(const Material& m) { return sqr(blender_coat_alpha(m)) <= mirror_cutoff; }

// F = mix(c0, 1, weight of the dielectric curve). The index follows from `specular` for metals too, so that
// a metal of specular 0 has the same colour at every angle.
Colour blender_specular_fresnel(const Material& m, double l_h) {
  if (m.specular <= closure_cutoff && m.metallic <= closure_cutoff) return {};
  const Colour c0 = tinted_specular(m);
  const long double eta = 2 / (1 - std::sqrt(.08L * m.specular)) - 1;
  return mix({saturate(c0.r), saturate(c0.g), saturate(c0.b)}, white, dielectric_weight(l_h, eta));
}

// A quarter of clearcoat times F of IOR 1.5; the closure's weight is 1, its strength stands outside.
double blender_coat_fresnel(const Material& m, double l_h) {
  return m.clearcoat < closure_cutoff ? 0 : .25 * m.clearcoat * mix(.04, 1, dielectric_weight(l_h, 1.5L));
}

// Principled v1: a plain sum of closures.
Colour blender_341(const Material& m, const Vector& v, const Vector& l) {
  const Angles a(v, l);
  if (a.below()) return {};
  const double dielectric_share = 1 - saturate(m.metallic);
  Colour f;

  // Diffuse: Blender's arrangement of the terms, with the retro-reflection R = roughness (1 + l.v); equal to
  // section 5.3's, since 1 + l.v = 2 cos^2 theta_d.
  const Colour diffuse_weight = m.base * dielectric_share;
  if (mean(diffuse_weight) >= closure_cutoff) {
    const double fl = schlick(a.n_l), fv = schlick(a.n_v), r = 2 * m.roughness * sqr(a.l_h);
    f = f + diffuse_weight * (((1 - fl / 2) * (1 - fv / 2) + r * (fl + fv + fl * fv * (r - 1))) / pi);
  }
  // Sheen: Disney's, with Rec.709's luminance.
  const Colour sheen_weight = mix(white, hue_by_rec709(m.base), m.sheen_tint) * (m.sheen * dielectric_share);
  if (mean(sheen_weight) >= closure_cutoff) f = f + sheen_weight * schlick(a.l_h);

  // Specular, metal included.
  if (!blender_specular_is_mirror(m)) {
    const double ax = blender_ax(m), ay = blender_ay(m);
    f = f + blender_specular_fresnel(m, a.l_h) * (gtr_2(a.h, ax, ay) * visibility(a, ax, ay));
  }
  // Clearcoat.
  if (!blender_coat_is_mirror(m))
    f = f + white * (blender_coat_fresnel(m, a.l_h) * gtr_1(a.n_h, blender_coat_alpha(m)) *
                     visibility(a, .25, .25));
  return f * a.n_l;
}

// Section 5.4 and appendix B, GTR of any gamma:
//   c = (gamma - 1)(alpha^2 - 1) / (pi (1 - alpha^(2(1 - gamma)))),  gamma = 1: (alpha^2 - 1)/(pi ln
//   alpha^2).
// 1 - alpha^(2(1 - gamma)) = -expm1((1 - gamma) ln alpha^2), which does not cancel near gamma = 1.
double gtr_constant(double gamma, double alpha) {
  if (alpha >= 1) return 1 / pi;
  const double a2 = sqr(alpha);
  if (gamma == 1) return (a2 - 1) / (pi * std::log(a2));
  return (gamma - 1) * (a2 - 1) / (pi * -std::expm1((1 - gamma) * std::log(a2)));
}

// Section 5.6, first edition: G is Smith's for GGX with its roughness remapped to [.5, 1], alpha_g =
// (.5 + roughness/2)^2.
Colour report_2018(const Material& m, double gamma, std::optional<double> constant, const Vector& v,
                   const Vector& l) {
  const Angles a(v, l);
  if (a.below()) return {};
  Colour f = diffuse(m.base, m.roughness, a) * (1 - m.metallic);
  if (m.specular > 0 || m.metallic > 0) {
    const double alpha = std::max(.001, sqr(m.roughness)), alpha_g = sqr(.5 + m.roughness / 2);
    const double sin2 = sqr(a.h.x) + sqr(a.h.y);
    const double c = constant ? *constant : gtr_constant(gamma, alpha);
    const double d = c / std::pow(sqr(alpha) * sqr(a.n_h) + sin2, gamma);
    f = f + fresnel_schlick(plain_specular(m), a.l_h) * (d * visibility(a, alpha_g, alpha_g));
  }
  return f * a.n_l;
}

Colour lambert_ggx(const Material& m, const Vector& v, const Vector& l) {
  const Angles a(v, l);
  if (a.below()) return {};
  Colour f = m.base * ((1 - m.metallic) / pi);
  if (m.specular > 0 || m.metallic > 0) {
    const double alpha = std::max(.001, sqr(m.roughness));
    f = f +
        fresnel_schlick(plain_specular(m), a.l_h) * (gtr_2(a.h, alpha, alpha) * visibility(a, alpha, alpha));
  }
  return f * a.n_l;
}

}  // namespace disney
