// The renderer's BRDF (float) against the published formulas in double and against Disney's shader in 50
// digits.
//
// Both get the same float parameters and vectors. The tolerance is 1e-5 of each channel, with an absolute
// floor, a share of what a white metal of the same roughness reflects. It is for channels that reflect
// nothing at normal incidence. They have only the rise of the Fresnel curve, which is lost to the rounding of
// a float l.h, 3e-8, near l.h = 1:
//   Schlick     (1 - l.h)^5 is off by more than 1e-5 where 1 - l.h < .015, by less than 5 (.015)^4 3e-8 =
//   8e-15; principled  k (1 - l.h)^2, k < 1, where 1 - l.h < .006, by less than 2 (.006) 3e-8 = 4e-10.
#include "bsdf/disney.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <functional>
#include <numbers>
#include <random>
#include <string>

#include "disney/disney.h"
#include "disney/frozen_values.h"

namespace {

using bsdf::Gtr;
using bsdf::Model;
using bsdf::Parameters;
using disney::Colour;
using disney::Material;
using disney::Vector;
using math::Vec3;

constexpr double tolerance = 1e-5;
constexpr double pi = std::numbers::pi;
constexpr Model models[] = {Model::disney, Model::principled, Model::path_disney, Model::path};

const char* name(Model model) {
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

Vector widened(const Vec3& v) { return {v.x, v.y, v.z}; }
// Not inlined: g++ 12 at -O2 drops a double's way through float and back (its SLP vectoriser), and the
// formula would not see what the renderer sees.
[[gnu::noinline]] Vec3 rounded(double x, double y, double z) {
  return {static_cast<float>(x), static_cast<float>(y), static_cast<float>(z)};
}

Material widened(const Parameters& p) {
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

Colour formula(Model model, const Gtr& gtr, const Parameters& p, const Vec3& wo, const Vec3& wi) {
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

Vec3 rendered(Model model, const Gtr& gtr, const Parameters& p, const Vec3& wo, const Vec3& wi) {
  return bsdf::eval(bsdf::prepare(model, gtr, p, {}, wo), wo, wi).f_cos;
}

// path_disney with a number for its constant makes lobes without a bound; past this a float's D overflows
// before F and G have had their say.
bool of_this_world(const Colour& f) { return f.r < 1e30 && f.g < 1e30 && f.b < 1e30; }

double share_of_white_metal(Model model) { return model == Model::principled ? 4e-10 : 1e-14; }

double floor_of(Model model, const Gtr& gtr, Parameters p, const Vec3& wo, const Vec3& wi) {
  p.base_color = {1, 1, 1};
  p.metallic = 1;
  return share_of_white_metal(model) * (1 + formula(model, gtr, p, wo, wi).r);
}

// The largest relative difference of any channel beyond the floor; infinite where not finite.
double difference(const Vec3& ours, const Colour& truth, double floor) {
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

std::string describe(const Gtr& g, const Parameters& p, const Vec3& wo, const Vec3& wi, const Vec3& got,
                     const Colour& wanted) {
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
Worst compare(Model model, int count, bool grazing, const Edit& edit) {
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

void expect_agreement(const std::string& what, Model model, int count, bool grazing, const Edit& edit) {
  const Worst worst = compare(model, count, grazing, edit);
  std::printf("%-12s %-44s %-8s largest error %.2e of %ld", name(model), what.c_str(),
              grazing ? "grazing" : "", worst.error, worst.compared);
  if (worst.beyond) std::printf(" (%ld beyond 1e30)", worst.beyond);
  std::printf("\n");
  EXPECT_LE(worst.error, tolerance) << name(model) << ", " << what << "\n" << worst.where;
}

void everywhere(const std::string& what, Model model, int count, const Edit& edit) {
  expect_agreement(what, model, count, false, edit);
  expect_agreement(what, model, count, true, edit);
}

void only_specular(Parameters& p) {
  p.base_color = {0, 0, 0};
  p.sheen = p.clearcoat = 0;
}

TEST(RendererAgainstFormula, EveryParameterAtRandom) {
  for (const Model model : models) everywhere("everything", model, 100000, [](Parameters&, Gtr&) {});
}

// `disney` keeps Schlick's white edge at specular 0; the others are diffuse alone.
TEST(RendererAgainstFormula, DiffuseOnly) {
  for (const Model model : models)
    everywhere("diffuse", model, 20000,
               [](Parameters& p, Gtr&) { p.metallic = p.specular = p.sheen = p.clearcoat = 0; });
}

TEST(RendererAgainstFormula, SheenAndItsTint) {
  for (const Model model : {Model::disney, Model::principled})
    everywhere("sheen", model, 20000, [](Parameters& p, Gtr&) {
      p.metallic = p.specular = p.clearcoat = 0;
      p.base_color *= .01f;  // the hue is of any colour, however dark
    });
}

TEST(RendererAgainstFormula, IsotropicSpecularOnly) {
  for (const Model model : models)
    everywhere("specular, isotropic", model, 20000, [](Parameters& p, Gtr&) {
      only_specular(p);
      p.anisotropic = p.metallic = 0;
    });
}

TEST(RendererAgainstFormula, AnisotropicSpecularOnly) {
  for (const Model model : models)
    everywhere("specular, anisotropic", model, 20000, [](Parameters& p, Gtr&) {
      only_specular(p);
      p.metallic = 0;
    });
}

TEST(RendererAgainstFormula, ClearcoatOnly) {
  for (const Model model : {Model::disney, Model::principled})
    everywhere("clearcoat", model, 20000, [](Parameters& p, Gtr&) {
      const float clearcoat = p.clearcoat;
      only_specular(p);
      p.specular = p.metallic = 0;
      p.clearcoat = clearcoat;
    });
}

TEST(RendererAgainstFormula, EachShareOfMetal) {
  for (const Model model : models)
    for (const float metallic : {0.f, .25f, .5f, .75f, 1.f})
      everywhere("metallic " + std::to_string(metallic), model, 10000,
                 [=](Parameters& p, Gtr&) { p.metallic = metallic; });
}

TEST(RendererAgainstFormula, EachGammaWithEachConstant) {
  for (const float gamma : {.01f, .5f, 1.f, 1.0000001f, 1.00001f, 1.5f, 2.f, 5.f, 7.5f, 10.f})
    for (const float constant : {-1.f, 0.f, .005f, .03f, .3f, 1.f})
      everywhere("gamma " + std::to_string(gamma) + " constant " +
                     (constant < 0 ? "auto" : std::to_string(constant)),
                 Model::path_disney, 4000, [=](Parameters&, Gtr& g) {
                   g.gamma = gamma;
                   g.constant = constant < 0 ? std::nullopt : std::optional<float>(constant);
                 });
}

// Sampled directions lie where the lobes are. A mirror has no BRDF, its value is its reflectance.
TEST(RendererAgainstFormula, SampledDirectionsAndMirrors) {
  for (const Model model : models) {
    Random random(7);
    double worst = 0, worst_mirror = 0;
    std::string where;
    int mirrors = 0;
    for (int i = 0; i < 100000; ++i) {
      Parameters p = random.parameters();
      if (random.chance(.2)) p.roughness *= .02f, p.clearcoat_roughness *= .02f;
      const Gtr g = random.gtr();
      const Vec3 wo = random.direction(.02, false);
      const auto u_lobe = static_cast<float>(random.uniform() * .9999);
      const auto u = static_cast<float>(random.uniform() * .9999);
      const auto v = static_cast<float>(random.uniform() * .9999);
      const auto s = bsdf::sample(bsdf::prepare(model, g, p, {}, wo), wo, u_lobe, u, v);
      if (!s || s->wi.z < 1e-4f) continue;
      const Material m = widened(p);
      Colour truth;
      if (s->is_delta) {
        ASSERT_EQ(model, Model::principled);
        ++mirrors;
        const double c =
            wo.z / std::sqrt(math::sqr(double{wo.x}) + math::sqr(double{wo.y}) + math::sqr(double{wo.z}));
        const double coat = disney::blender_coat_fresnel(m, c);
        const bool specular = s->lobe == bsdf::Lobe::specular;
        ASSERT_TRUE(specular ? disney::blender_specular_is_mirror(m) : disney::blender_coat_is_mirror(m));
        truth = specular ? disney::blender_specular_fresnel(m, c) : Colour{coat, coat, coat};
        worst_mirror = std::fmax(worst_mirror, difference(s->f_cos, truth, share_of_white_metal(model)));
        continue;
      }
      truth = formula(model, g, p, wo, s->wi);
      if (!of_this_world(truth)) continue;
      const double error = difference(s->f_cos, truth, floor_of(model, g, p, wo, s->wi));
      if (error > worst) worst = error, where = describe(g, p, wo, s->wi, s->f_cos, truth);
    }
    std::printf("%-12s sampled directions: largest error %.2e; %d mirrors: %.2e\n", name(model), worst,
                mirrors, worst_mirror);
    EXPECT_LE(worst, tolerance) << name(model) << "\n" << where;
    EXPECT_LE(worst_mirror, tolerance) << name(model);
    if (model == Model::principled) {
      EXPECT_GT(mirrors, 1000);
    }
  }
}

// Hard case B09: specular says nothing about a metal, in the models whose Fresnel term is Schlick's.
TEST(RendererAgainstFormula, AMetalOfSpecularZeroIsNotBlack) {
  for (const Model model : models) {
    double albedo[2] = {0, 0};  // at cos .5, by the midpoint rule
    for (int which = 0; which < 2; ++which) {
      Parameters p;
      p.base_color = {1, 1, 1};
      p.metallic = 1;
      p.specular = which ? .01f : 0;
      const Vec3 wo = Random::at(.5, 0);
      constexpr int n = 400;
      for (int i = 0; i < n; ++i)
        for (int j = 0; j < n; ++j)
          albedo[which] += rendered(model, {}, p, wo, Random::at((i + .5) / n, 2 * pi * (j + .5) / n)).x;
      albedo[which] *= 2 * pi / (n * n);
    }
    std::printf("%-12s white metal at cos .5: specular 0 %.7f, .01 %.7f\n", name(model), albedo[0],
                albedo[1]);
    EXPECT_NEAR(albedo[0], albedo[1], 1e-6) << name(model);
    // path_disney's G is that of a rougher surface than its D.
    EXPECT_GT(albedo[0], model == Model::path_disney ? .6 : .8) << name(model);
    EXPECT_LT(albedo[0], 1) << name(model);
  }
}

// Hard case B11. A luminance that is not a normal float has too few bits for a hue: the renderer then takes
// white. Whatever the hue, no channel of it exceeds 1/.0721750 (Rec.709's blue), so f is within that of
// white's.
TEST(RendererAgainstFormula, TintsOfBlackAndOfDenormalColours) {
  const Vec3 normal[] = {{0, 0, 0}, {1e-20f, 1e-20f, 1e-20f}, {0, 0, 1e-30f}, {1e-30f, 0, 1e-35f}};
  const Vec3 denormal[] = {{1e-45f, 1e-45f, 1e-45f},
                           {1e-39f, 1e-39f, 1e-39f},
                           {0, 0, 1e-45f},
                           {1e-45f, 0, 0},
                           {0, 3e-39f, 1e-40f}};
  Random random(3);
  for (int i = 0; i < 500; ++i) {
    const Vec3 wo = random.direction(.02, false), wi = random.direction(.02, false);
    Parameters p;
    p.sheen = p.sheen_tint = p.specular_tint = 1;
    for (const Model model : models) {
      for (const Vec3& colour : normal) {
        p.base_color = colour;
        const Vec3 ours = rendered(model, {}, p, wo, wi);
        const Colour truth = formula(model, {}, p, wo, wi);
        EXPECT_LE(difference(ours, truth, floor_of(model, {}, p, wo, wi)), tolerance)
            << name(model) << "\n"
            << describe({}, p, wo, wi, ours, truth);
      }
      p.base_color = {0, 0, 0};  // whose hue is white
      const double white = formula(model, {}, p, wo, wi).r;
      for (const Vec3& colour : denormal) {
        p.base_color = colour;
        const Vec3 ours = rendered(model, {}, p, wo, wi);
        for (const float channel : {ours.x, ours.y, ours.z}) {
          EXPECT_TRUE(std::isfinite(channel)) << name(model);
          EXPECT_GE(channel, 0) << name(model);
          EXPECT_LE(channel, white / .0721750 * (1 + tolerance)) << name(model);
        }
      }
    }
  }
}

TEST(RendererAgainstDecimals, DisneysShader) {
  double worst = 0;
  const auto* value = disney::frozen::values;
  for (const auto& m : disney::frozen::materials)
    for (const auto& d : disney::frozen::pairs) {
      Parameters p;
      p.base_color = rounded(m[0], m[1], m[2]);
      float* const scalars[] = {&p.metallic,    &p.roughness, &p.specular,   &p.specular_tint,
                                &p.anisotropic, &p.sheen,     &p.sheen_tint, &p.clearcoat};
      for (int i = 0; i < 8; ++i) *scalars[i] = static_cast<float>(m[3 + i]);
      p.clearcoat_roughness = static_cast<float>(std::sqrt(m[11]));
      const double v = std::hypot(d[0], d[1], d[2]), l = std::hypot(d[3], d[4], d[5]);
      const Vec3 wo = rounded(d[0] / v, d[1] / v, d[2] / v), wi = rounded(d[3] / l, d[4] / l, d[5] / l);
      const double error =
          difference(rendered(Model::disney, {}, p, wo, wi), {(*value)[0], (*value)[1], (*value)[2]}, 1e-14);
      EXPECT_LE(error, tolerance) << "row " << value - disney::frozen::values;
      worst = std::fmax(worst, error);
      ++value;
    }
  std::printf("largest relative error %.2e\n", worst);
}

}  // namespace
