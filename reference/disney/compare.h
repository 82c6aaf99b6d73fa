// How the tests compare the renderer's BRDF with the formulas.
//
// Both get the same float parameters and vectors. The tolerance is 1e-5 of each channel, with an absolute
// floor, a share of what a white metal of the same roughness reflects. It is for channels that reflect
// nothing at normal incidence. They have only the rise of the Fresnel curve, which near l.h = 1 is lost to
// the rounding of a float l.h, 3e-8:
//
//   Schlick's (1 - l.h)^5 is off by more than 1e-5 where 1 - l.h < .015, and there by less than
//   5 (.015)^4 3e-8 = 8e-15;
//
//   principled's k (1 - l.h)^2, k < 1, where 1 - l.h < .006, by less than 2 (.006) 3e-8 = 4e-10.
#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <functional>
#include <numbers>
#include <optional>
#include <random>
#include <string>

#include "bsdf/disney.h"
#include "disney/disney.h"

namespace disney::comparison {

using bsdf::Gtr;
using bsdf::Model;
using bsdf::Parameters;
using math::Vec3;

inline constexpr double tolerance = 1e-5;
inline constexpr double pi = std::numbers::pi;
inline constexpr Model models[] = {Model::disney, Model::principled, Model::path_disney, Model::path};

inline const char* name(Model model) {
  switch (model) {
    case Model::disney:
      return "disney";
    case Model::principled:
      return "principled";
    case Model::path_disney:
      return "path_disney";
    case Model::path:
      return "path";
  }
  return "?";
}

inline Vector widened(const Vec3& v) { return {v.x, v.y, v.z}; }
// Not inlined: g++ 12 at -O2 drops a double's way through float and back (its SLP vectoriser), and the
// formula would not see what the renderer sees.
[[gnu::noinline]] inline Vec3 rounded(double x, double y, double z) {
  return {static_cast<float>(x), static_cast<float>(y), static_cast<float>(z)};
}

inline Material widened(const Parameters& p) {
  return {{p.base_color.x, p.base_color.y, p.base_color.z},
          p.metallic,
          p.roughness,
          p.specular,
          p.specular_tint,
          p.anisotropic,
          p.sheen,
          p.sheen_tint,
          p.clearcoat,
          p.clearcoat_roughness};
}

inline Colour formula(Model model, const Gtr& gtr, const Parameters& p, const Vec3& wo, const Vec3& wi) {
  const Material m = widened(p);
  const Vector v = widened(wo), l = widened(wi);
  switch (model) {
    case Model::disney:
      return disney::burley_2012(m, v, l);
    case Model::principled:
      return disney::blender_341(m, v, l);
    case Model::path:
      return disney::lambert_ggx(m, v, l);
    case Model::path_disney:
      break;
  }
  return disney::report_2018(m, gtr.gamma, gtr.constant ? std::optional<double>(*gtr.constant) : std::nullopt,
                             v, l);
}

inline Vec3 rendered(Model model, const Gtr& gtr, const Parameters& p, const Vec3& wo, const Vec3& wi) {
  return bsdf::eval(bsdf::prepare(model, gtr, p, {}, wo), wo, wi).f_cos;
}

// path_disney with a number for its constant makes lobes without a bound; past this a float's D overflows
// before F and G have had their say.
inline bool of_this_world(const Colour& f) { return f.r < 1e30 && f.g < 1e30 && f.b < 1e30; }

inline double share_of_white_metal(Model model) { return model == Model::principled ? 4e-10 : 1e-14; }

inline double floor_of(Model model, const Gtr& gtr, Parameters p, const Vec3& wo, const Vec3& wi) {
  p.base_color = {1, 1, 1};
  p.metallic = 1;
  return share_of_white_metal(model) * (1 + formula(model, gtr, p, wo, wi).r);
}

// The largest relative difference of any channel beyond the floor; infinite where not finite.
inline double difference(const Vec3& ours, const Colour& truth, double floor) {
  double worst = 0;
  const double pairs[3][2] = {{ours.x, truth.r}, {ours.y, truth.g}, {ours.z, truth.b}};
  for (const auto& [got, wanted] : pairs) {
    if (!std::isfinite(got)) return INFINITY;
    if (std::fabs(got - wanted) <= floor) continue;
    worst = std::fmax(worst, std::fabs(got - wanted) / wanted);
  }
  return worst;
}

// Random numbers that are the same with every standard library.
class Random {
 public:
  explicit Random(unsigned seed) : bits_(seed) {}
  double uniform() { return static_cast<double>(bits_() >> 11) * 0x1p-53; }
  bool chance(double probability) { return uniform() < probability; }
  // A parameter: the ends of its range, tiny and all but one, often enough.
  float parameter() {
    const double which = uniform(), u = uniform();
    if (which < .1) return 0;
    if (which < .2) return 1;
    if (which < .23) return static_cast<float>(std::exp(-16 * u));
    if (which < .26) return static_cast<float>(1 - std::exp(-16 * u));
    return static_cast<float>(u);
  }
  Parameters parameters() {
    Parameters p;
    const float r = parameter(), g = parameter(), b = parameter();
    p.base_color = {r, g, b};
    for (float* x : {&p.metallic, &p.roughness, &p.specular, &p.specular_tint, &p.anisotropic, &p.sheen,
                     &p.sheen_tint, &p.clearcoat, &p.clearcoat_roughness})
      *x = parameter();
    return p;
  }
  Gtr gtr() {
    Gtr g;
    g.gamma = static_cast<float>(.05 + 9.95 * uniform());
    if (chance(.3)) g.constant = static_cast<float>(std::pow(10, -6 + 6 * uniform()));
    return g;
  }
  // Cosine uniform in (lowest, 1], or, grazing, log-uniform in [1e-4, .1].
  Vec3 direction(double lowest, bool grazing) {
    const double u = uniform();
    return at(grazing ? std::pow(10, -4 + 3 * u) : 1 - (1 - lowest) * u, 2 * pi * uniform());
  }
  // A direction near the mirror of wo: the half vector within some alphas of the normal.
  Vec3 near_mirror(const Vec3& wo, double alpha) {
    const double slope = alpha * std::tan(1.5 * uniform()), azimuth = 2 * pi * uniform();
    const double hx = slope * std::cos(azimuth), hy = slope * std::sin(azimuth);
    const double scale = 2 * (wo.x * hx + wo.y * hy + wo.z) / (hx * hx + hy * hy + 1);
    return rounded(scale * hx - wo.x, scale * hy - wo.y, scale - wo.z);
  }
  static Vec3 at(double cosine, double azimuth) {
    const double sine = std::sqrt(1 - cosine * cosine);
    return rounded(sine * std::cos(azimuth), sine * std::sin(azimuth), cosine);
  }

 private:
  std::mt19937_64 bits_;
};

struct Worst {
  double error = 0;
  long compared = 0, beyond = 0;
  std::string where;
};

inline std::string describe(const Gtr& g, const Parameters& p, const Vec3& wo, const Vec3& wi,
                            const Vec3& got, const Colour& wanted) {
  char text[900];
  std::snprintf(text, sizeof text,
                "base %.9g %.9g %.9g metallic %.9g roughness %.9g specular %.9g tint %.9g anisotropic %.9g "
                "sheen %.9g tint %.9g clearcoat %.9g roughness %.9g gamma %.9g constant %.9g\n"
                "wo %.9g %.9g %.9g wi %.9g %.9g %.9g\ngot %.9g %.9g %.9g wanted %.9g %.9g %.9g",
                p.base_color.x, p.base_color.y, p.base_color.z, p.metallic, p.roughness, p.specular,
                p.specular_tint, p.anisotropic, p.sheen, p.sheen_tint, p.clearcoat, p.clearcoat_roughness,
                g.gamma, g.constant ? *g.constant : -1.f, wo.x, wo.y, wo.z, wi.x, wi.y, wi.z, got.x, got.y,
                got.z, wanted.r, wanted.g, wanted.b);
  return text;
}

using Edit = std::function<void(Parameters&, Gtr&)>;

// Compares at `count` random parameters, edited, and directions: half of them far from, half near the mirror
// direction, where the narrow lobes are.
inline Worst compare(Model model, int count, bool grazing, const Edit& edit) {
  Random random(20120808);
  Worst worst;
  while (worst.compared + worst.beyond < count) {
    Parameters p = random.parameters();
    Gtr g = random.gtr();
    edit(p, g);
    const double lowest = grazing ? 1e-4 : .02;
    const bool graze_wo = grazing && random.chance(.6),
               graze_wi = grazing && (!graze_wo || random.chance(.5));
    const Vec3 wo = random.direction(lowest, graze_wo);
    Vec3 wi = random.direction(lowest, graze_wi);
    if (random.chance(.5)) {
      const double roughness = random.chance(.5) ? p.roughness : p.clearcoat_roughness;
      wi = random.near_mirror(wo, std::fmax(.001, roughness * roughness));
    }
    if (wi.z < lowest) continue;
    const Colour truth = formula(model, g, p, wo, wi);
    if (!of_this_world(truth)) {
      ++worst.beyond;
      continue;
    }
    const Vec3 ours = rendered(model, g, p, wo, wi);
    const double error = difference(ours, truth, floor_of(model, g, p, wo, wi));
    ++worst.compared;
    if (error > worst.error) {
      worst.error = error;
      worst.where = describe(g, p, wo, wi, ours, truth);
    }
  }
  return worst;
}

inline void expect_agreement(const std::string& what, Model model, int count, bool grazing,
                             const Edit& edit) {
  const Worst worst = compare(model, count, grazing, edit);
  std::printf("%-12s %-44s %-8s largest error %.2e of %ld", name(model), what.c_str(),
              grazing ? "grazing" : "", worst.error, worst.compared);
  if (worst.beyond) std::printf(" (%ld beyond 1e30)", worst.beyond);
  std::printf("\n");
  EXPECT_LE(worst.error, tolerance) << name(model) << ", " << what << "\n" << worst.where;
}

inline void everywhere(const std::string& what, Model model, int count, const Edit& edit) {
  expect_agreement(what, model, count, false, edit);
  expect_agreement(what, model, count, true, edit);
}

}  // namespace disney::comparison
