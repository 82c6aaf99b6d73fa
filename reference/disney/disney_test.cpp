// The renderer's BRDF (float) against the published formulas in double and against Disney's shader in 50
// digits. How they are compared: compare.h.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <numbers>
#include <string>

#include "disney/compare.h"
#include "disney/frozen_values.h"

namespace {

using namespace disney::comparison;
using disney::Colour;
using disney::Material;

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
    everywhere("diffuse", model, 100000,
               [](Parameters& p, Gtr&) { p.metallic = p.specular = p.sheen = p.clearcoat = 0; });
}

TEST(RendererAgainstFormula, SheenAndItsTint) {
  for (const Model model : {Model::disney, Model::principled})
    everywhere("sheen", model, 100000, [](Parameters& p, Gtr&) {
      p.metallic = p.specular = p.clearcoat = 0;
      p.base_color *= .01f;  // the hue is of any colour, however dark
    });
}

TEST(RendererAgainstFormula, IsotropicSpecularOnly) {
  for (const Model model : models)
    everywhere("specular, isotropic", model, 100000, [](Parameters& p, Gtr&) {
      only_specular(p);
      p.anisotropic = p.metallic = 0;
    });
}

TEST(RendererAgainstFormula, AnisotropicSpecularOnly) {
  for (const Model model : models)
    everywhere("specular, anisotropic", model, 100000, [](Parameters& p, Gtr&) {
      only_specular(p);
      p.metallic = 0;
    });
}

TEST(RendererAgainstFormula, ClearcoatOnly) {
  for (const Model model : {Model::disney, Model::principled})
    everywhere("clearcoat", model, 100000, [](Parameters& p, Gtr&) {
      const float clearcoat = p.clearcoat;
      only_specular(p);
      p.specular = p.metallic = 0;
      p.clearcoat = clearcoat;
    });
}

// Hard case B08: metallic blends reflectances at normal incidence, not what comes of them.
TEST(RendererAgainstFormula, EachShareOfMetal) {
  for (const Model model : models)
    for (const float metallic : {0.f, .25f, .5f, .75f, 1.f})
      everywhere("metallic " + std::to_string(metallic), model, 100000,
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

// Hard case B22: ten materials at twenty pairs of directions.
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
