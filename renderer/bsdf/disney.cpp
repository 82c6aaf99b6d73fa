#include "bsdf/disney.h"

#include <algorithm>
#include <cassert>
#include <limits>

#include "math/sampler.h"
#include "math/warp.h"

namespace bsdf {

namespace {

using math::mix;
using math::saturate;

// Lobes weaker than this are dropped, by Cycles for its closures.
constexpr float principled_closure_cutoff = 1e-5f;
// Cycles treats a GGX or GTR1 lobe as a mirror when alpha_x alpha_y is at most this: roughness <= .0177828.
constexpr float principled_delta_threshold = 1e-7f;
// Burley's lower bound for alpha (public reference shader).
constexpr float disney_min_alpha = .001f;

float disney_luma(const Vec3& c) { return .3f * c.x + .6f * c.y + .1f * c.z; }

// Base colour of luminance 1. Division in double: base colours may be denormal.
Vec3 tint(const Vec3& base, float luma) {
  if (!(luma > 0)) return Vec3(1);
  const double scale = 1. / luma;
  return {static_cast<float>(base.x * scale), static_cast<float>(base.y * scale),
          static_cast<float>(base.z * scale)};
}

Parameters clamped(Parameters p) {
  const auto unit = [](float x) { return x > 0 ? std::min(x, 1.f) : 0.f; };  // NaN becomes 0
  for (int i = 0; i < 3; ++i) p.base_color[i] = unit(p.base_color[i]);
  for (float* x : {&p.metallic, &p.roughness, &p.specular, &p.specular_tint, &p.anisotropic, &p.sheen,
                   &p.sheen_tint, &p.clearcoat, &p.clearcoat_roughness})
    *x = unit(*x);
  return p;
}

void set_alpha(Specular& s, const Parameters& p, Model model) {
  const float alpha = p.roughness * p.roughness;
  const float aspect = std::sqrt(1 - .9f * p.anisotropic);
  switch (model) {
    case Model::disney:
      s.ax = std::max(disney_min_alpha, alpha / aspect);
      s.ay = std::max(disney_min_alpha, alpha * aspect);
      break;
    case Model::principled:
      s.ax = saturate(alpha / aspect);
      s.ay = saturate(alpha * aspect);
      s.is_delta = s.ax * s.ay <= principled_delta_threshold;
      break;
    case Model::path:
    case Model::path_disney:
      s.ax = s.ay = std::max(disney_min_alpha, alpha);
      break;
  }
  s.ax_g = s.ax;
  s.ay_g = s.ay;
}

Specular make_specular(Model model, const Gtr& gtr, const Parameters& p) {
  Specular s;
  const float dielectric_f0 = .08f * p.specular;
  const bool tinted = p.specular_tint > 0 && (model == Model::disney || model == Model::principled);
  const Vec3 colour =
      tinted ? mix(Vec3(1), tint(p.base_color, disney_luma(p.base_color)), p.specular_tint) : Vec3(1);
  s.f0 = mix(colour * dielectric_f0, p.base_color, p.metallic);
  s.present = true;
  set_alpha(s, p, model);
  if (model == Model::principled) {
    s.present = p.specular > principled_closure_cutoff || p.metallic > principled_closure_cutoff;
    for (int i = 0; i < 3; ++i) s.f0[i] = saturate(s.f0[i]);
    s.dielectric = true;
    s.eta = 2 / (1 - std::sqrt(.08 * p.specular)) - 1;
    s.fresnel0 = fresnel_dielectric(1, s.eta);
    if (!(s.eta > 1) && math::is_black(s.f0)) s.present = false;  // F is 0 at every angle
  } else if (p.specular <= 0 && p.metallic <= 0) {
    // "No specular" means none: without this Schlick's curve would leave a white edge on a purely diffuse
    // surface. Disney's reference shader keeps that edge.
    s.present = model == Model::disney;
  }
  if (model == Model::path_disney) {
    s.gtr = true;
    s.gamma = gtr.gamma;
    s.normalised_constant = gtr_constant(s.ax, s.gamma);
    s.constant = gtr.constant ? *gtr.constant : s.normalised_constant;
    s.ax_g = s.ay_g = math::sqr(.5f + .5f * p.roughness);
  }
  return s;
}

Clearcoat make_clearcoat(Model model, const Parameters& p) {
  Clearcoat c;
  c.weight = .25f * p.clearcoat;
  const float alpha = p.clearcoat_roughness * p.clearcoat_roughness;
  if (model == Model::principled) {
    c.dielectric = true;
    c.alpha = alpha;
    c.is_delta = alpha * alpha <= principled_delta_threshold;
    if (p.clearcoat < principled_closure_cutoff) c.weight = 0;
  } else {
    c.alpha = std::max(disney_min_alpha, alpha);
  }
  if (!c.is_delta && c.alpha < 1) c.log_alpha2 = 2 * math::log(static_cast<double>(c.alpha));
  return c;
}

// What a light sees of the difference between shading, smooth and geometric normals.
//  - every model but principled: a direction below the triangle carries no light (no leaks);
//  - principled, specular and coat: nothing unless the smooth normal faces the light (Blender 3.4.1);
//  - principled, diffuse and sheen: the bump terminator.
bool leaks(const Bsdf& b, const Vec3& wi) {
  return b.model != Model::principled && math::dot(b.normals.geometric, wi) <= 0;
}
bool specular_sees(const Bsdf& b, const Vec3& wi) {
  return b.model != Model::principled || math::dot(b.normals.smooth, wi) >= 0;
}
float bump_terminator(const Bsdf& b, const Vec3& wi) {
  if (b.model != Model::principled || b.normals.smooth.z >= 1) return 1;
  const float g = math::dot(b.normals.smooth, wi) / (wi.z * b.normals.smooth.z);
  if (g >= 1) return 1;
  if (!(g > 0)) return 0;
  return g * (1 + g * (1 - g));
}

// Lobes are chosen in proportion to their reflectance seen from wo, none below a tenth, so that a lobe whose
// reflectance this estimate misses (Fresnel at grazing half vectors) cannot make a sample's weight explode.
void set_probabilities(Bsdf& b, const Vec3& wo) {
  const float edge = schlick(wo.z);
  float weight[lobe_count];
  weight[0] = b.mean_diffuse + b.mean_sheen * (.02f + .1f * edge);
  // A lobe that is black at normal incidence is not so at others: seen along the normal its share must not be
  // 0.
  constexpr float tiny = std::numeric_limits<float>::min();
  // Schlick's curve also for what follows the dielectric one: near enough for a choice.
  weight[1] = b.specular.present ? std::max(tiny, b.mean_f0 + (1 - b.mean_f0) * edge) : 0;
  weight[2] = b.clearcoat.weight > 0 ? b.clearcoat.weight * (.04f + .96f * edge) : 0;
  const float sum = weight[0] + weight[1] + weight[2];
  if (!(sum > 0)) return;
  constexpr float floor = .1f;
  const float rest = 1 - floor * static_cast<float>((weight[0] > 0) + (weight[1] > 0) + (weight[2] > 0));
  const double scale = 1. / sum;
  for (int i = 0; i < lobe_count; ++i)
    if (weight[i] > 0) b.probability[i] = floor + rest * static_cast<float>(weight[i] * scale);
}

}  // namespace

Bsdf make(Model model, const Gtr& gtr, const Parameters& parameters) {
  const Parameters p = clamped(parameters);
  Bsdf b;
  b.model = model;
  b.diffuse.weight = p.base_color * (1 - p.metallic);
  b.diffuse.retro = model == Model::path ? -1 : p.roughness;
  b.specular = make_specular(model, gtr, p);
  const bool all_lobes = model == Model::disney || model == Model::principled;
  if (all_lobes && p.sheen > 0) {
    const float luma = model == Model::disney ? disney_luma(p.base_color) : math::luminance(p.base_color);
    b.sheen.weight = mix(Vec3(1), tint(p.base_color, luma), p.sheen_tint) * (p.sheen * (1 - p.metallic));
  }
  if (all_lobes && p.clearcoat > 0) b.clearcoat = make_clearcoat(model, p);
  if (model == Model::principled) {
    if (math::mean(b.diffuse.weight) < principled_closure_cutoff) b.diffuse.weight = Vec3(0);
    if (math::mean(b.sheen.weight) < principled_closure_cutoff) b.sheen.weight = Vec3(0);
  }
  b.mean_diffuse = math::mean(b.diffuse.weight);
  b.mean_sheen = math::mean(b.sheen.weight);
  b.mean_f0 = math::mean(b.specular.f0);
  return b;
}

void orient(Bsdf& b, const Normals& normals, const Vec3& wo) {
  b.normals = normals;
  if (wo.z > 0) set_probabilities(b, wo);
  const bool smooth_specular = b.probability[1] > 0 && !b.specular.is_delta;
  const bool smooth_coat = b.probability[2] > 0 && !b.clearcoat.is_delta;
  b.only_delta = b.probability[0] == 0 && !smooth_specular && !smooth_coat;
}

Bsdf prepare(Model model, const Gtr& gtr, const Parameters& parameters, const Normals& normals,
             const Vec3& wo) {
  Bsdf b = make(model, gtr, parameters);
  orient(b, normals, wo);
  return b;
}

Value eval(const Bsdf& b, const Vec3& wo, const Vec3& wi) {
  Value value;
  if (!(wo.z > 0 && wi.z > 0)) return value;
  const HalfVector h(wo, wi);
  if (!(h.length_squared > 0)) return value;

  if (b.probability[0] > 0) {
    value.pdf += b.probability[0] * wi.z * math::inv_pi;
    value.f_cos +=
        (b.diffuse.f_cos(wo.z, wi.z, h.cos_d) + b.sheen.f_cos(wi.z, h.cos_d)) * bump_terminator(b, wi);
  }
  const bool seen = specular_sees(b, wi);
  if (b.probability[1] > 0 && !b.specular.is_delta) {
    const Value specular = b.specular.eval(wo, wi, h);
    value.pdf += b.probability[1] * specular.pdf;
    if (seen) value.f_cos += specular.f_cos;
  }
  if (b.probability[2] > 0 && !b.clearcoat.is_delta) {
    const Value coat = b.clearcoat.eval(wo, wi, h);
    value.pdf += b.probability[2] * coat.pdf;
    if (seen) value.f_cos += coat.f_cos;
  }
  if (leaks(b, wi)) value.f_cos = Vec3(0);
  return value;
}

std::array<Vec3, eval_lobe_count> eval_lobes(const Bsdf& b, const Vec3& wo, const Vec3& wi) {
  std::array<Vec3, eval_lobe_count> f{};
  if (!(wo.z > 0 && wi.z > 0) || leaks(b, wi)) return f;
  const HalfVector h(wo, wi);
  if (!(h.length_squared > 0)) return f;
  if (b.probability[0] > 0) {
    f[0] = b.diffuse.f_cos(wo.z, wi.z, h.cos_d) * bump_terminator(b, wi);
    f[1] = b.sheen.f_cos(wi.z, h.cos_d) * bump_terminator(b, wi);
  }
  if (!specular_sees(b, wi)) return f;
  if (b.probability[1] > 0 && !b.specular.is_delta) f[2] = b.specular.eval(wo, wi, h).f_cos;
  if (b.probability[2] > 0 && !b.clearcoat.is_delta) f[3] = b.clearcoat.eval(wo, wi, h).f_cos;
  return f;
}

namespace {

// The lobe chosen by u, or -1 if none reflects; u becomes what is left of it, in [0,1).
int choose_lobe(const Bsdf& b, float& u) {
  int lobe = -1;
  float below = 0;
  for (int i = 0; i < lobe_count; ++i) {
    if (!(b.probability[i] > 0)) continue;
    if (lobe >= 0) below += b.probability[lobe];
    lobe = i;
    if (u < below + b.probability[i]) break;
  }
  if (lobe >= 0) u = std::clamp((u - below) / b.probability[lobe], 0.f, math::largest_u);
  return lobe;
}

std::optional<Sample> sample_lobe(const Bsdf& b, const Vec3& wo, int lobe, float u, float v) {
  Sample s;
  s.lobe = static_cast<Lobe>(lobe);
  const bool mirror = (s.lobe == Lobe::specular && b.specular.is_delta) ||
                      (s.lobe == Lobe::clearcoat && b.clearcoat.is_delta);
  if (mirror) {
    s.wi = {-wo.x, -wo.y, wo.z};
    s.is_delta = true;
    s.pdf = b.probability[lobe];
    // Without masking, as in Cycles: only principled has mirrors.
    const Vec3 reflectance = s.lobe == Lobe::specular ? b.specular.fresnel(wo.z)
                                                      : Vec3(b.clearcoat.weight * b.clearcoat.fresnel(wo.z));
    const bool seen = specular_sees(b, s.wi) && !leaks(b, s.wi);
    s.f_cos = seen ? reflectance : Vec3(0);
    return s;
  }
  switch (s.lobe) {
    case Lobe::diffuse:
      s.wi = math::sample_cosine_hemisphere(u, v);
      break;
    case Lobe::specular:
      s.wi = reflect(wo, b.specular.sample_half(wo, u, v));
      break;
    case Lobe::clearcoat:
      s.wi = reflect(wo, b.clearcoat.sample_half(u, v));
      break;
  }
  const Value value = eval(b, wo, s.wi);
  if (!(value.pdf > 0)) return std::nullopt;
  s.f_cos = value.f_cos;
  s.pdf = value.pdf;
  return s;
}

}  // namespace

std::optional<Sample> sample(const Bsdf& b, const Vec3& wo, float u_lobe, float u, float v) {
  const int lobe = wo.z > 0 ? choose_lobe(b, u_lobe) : -1;
  return lobe >= 0 ? sample_lobe(b, wo, lobe, u, v) : std::nullopt;
}

std::optional<Sample> sample(const Bsdf& b, const Vec3& wo, float u, float v) {
  const int lobe = wo.z > 0 ? choose_lobe(b, u) : -1;
  return lobe >= 0 ? sample_lobe(b, wo, lobe, u, v) : std::nullopt;
}

Vec3 albedo(const Bsdf& b) { return b.diffuse.weight + (b.specular.present ? b.specular.f0 : Vec3(0)); }

Vec3 Specular::sample_half(const Vec3& wo, float u, float v) const {
  if (!gtr) return math::sample_visible_normal(wo, ax, ay, u, v);
  // u = CDF of the normalised GTR. With s = ln alpha^2, k = 1 - gamma and t = sin^2 + alpha^2 cos^2:
  // ln(t / alpha^2) = log1p(u (e^(-k s) - 1)) / k, and -u s for gamma = 1 (Burley 2012, appendix B.2,
  // rearranged so that small angles keep their precision).
  const double a2 = static_cast<double>(ax) * ax;
  if (!(a2 < 1 - 1e-7)) return half_direction(u, v);
  const double s = math::log(a2), k = 1 - gamma;
  const double exponent = k == 0 ? -u * s : math::log1p(u * math::expm1(-k * s)) / k;
  return half_direction(a2 * math::expm1(exponent) / (1 - a2), v);
}

}  // namespace bsdf
