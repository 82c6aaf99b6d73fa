// path_disney's distribution, GTR of any real gamma in (0, 10], at the edges of gamma and alpha: its
// normalisation, its sampling and its density against the closed forms in long double.
//
// With t = sin^2 + alpha^2 cos^2, s = ln alpha^2 and k = 1 - gamma, D = c t^-gamma, and the share of D cos
// within an angle is (t^k - e^(k s)) / (1 - e^(k s)), ln t / -s + 1 for k = 0 (Burley 2012, appendix B.2).
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <random>

#include "bsdf/disney.h"

namespace bsdf {
namespace {

constexpr float smallest = 0x1p-149f;
const float gammas[] = {smallest,  1e-30f,  1e-6f, .01f, .5f, .99f, .9999f, 1 - 0x1p-24f, 1, 1 + 0x1p-23f,
                        1.000001f, 1.0001f, 1.01f, 1.5f, 2,   2.5f, 5,      7.5f,         10};
const float alphas[] = {.001f, .0025f, .01f, .0625f, .1f, .5f, .9f, .999f, .99999f, 1 - 0x1p-24f, 1};

// expm1(k x) / k, also for k = 0.
long double expm1_over(long double k, long double x) { return k == 0 ? x : std::expm1(k * x) / k; }

// c in long double.
long double exact_constant(long double alpha, long double gamma) {
  const long double s = 2 * std::log(alpha), k = 1 - gamma;
  const long double one_over_pi = 1 / 3.14159265358979323846264338327950288L;
  return s == 0 ? one_over_pi : one_over_pi * std::expm1(s) / expm1_over(k, s);
}

// Share of the half vectors whose sin^2 is below `sin2`: (e^(k (ln t - s)) - 1) / (e^(-k s) - 1).
long double share_below(long double sin2, long double alpha, long double gamma) {
  const long double s = 2 * std::log(alpha), k = 1 - gamma, a2 = alpha * alpha;
  if (s == 0) return sin2;
  const long double x = std::log1p(sin2 * (1 - a2) / a2);  // ln t - s
  return expm1_over(k, x) / expm1_over(k, -s);
}

Specular lobe_of(float alpha, float gamma, std::optional<float> constant = {}) {
  Specular lobe = prepare(Model::path_disney, {gamma, constant}, {}, {}, {0, 0, 1}).specular;
  lobe.ax = lobe.ay = alpha;  // any float, which roughness squared is not
  lobe.normalised_constant = gtr_constant(alpha, lobe.gamma);
  lobe.constant = constant ? *constant : lobe.normalised_constant;
  return lobe;
}

TEST(Gtr, constant_equals_its_closed_form_at_every_gamma_and_alpha) {
  for (const float alpha : alphas)
    for (const float gamma : gammas) {
      const double c = gtr_constant(alpha, gamma);
      EXPECT_NEAR(c / static_cast<double>(exact_constant(alpha, gamma)), 1, 1e-12) << alpha << ' ' << gamma;
    }
}

TEST(Gtr, constant_is_that_of_the_reports_materials) {
  // c of the red, green and blue shape: roughness .25, .1, .05.
  const double roughness[] = {.25, .1, .05};
  const double gamma_2[] = {1.243e-3, 3.183e-5, 1.989e-6}, gamma_1[] = {.05718, .03456, .02656};
  for (int i = 0; i < 3; ++i) {
    const double alpha = roughness[i] * roughness[i];
    EXPECT_NEAR(gtr_constant(alpha, 2) / gamma_2[i], 1, 5e-4);
    EXPECT_NEAR(gtr_constant(alpha, 1) / gamma_1[i], 1, 5e-4);
  }
}

TEST(Gtr, constant_and_samples_do_not_jump_at_gamma_one) {
  // One step of float on either side of 1 changes D's logarithm by at most 6e-8 * 14.
  for (const float alpha : alphas)
    for (const float gamma : {1 - 0x1p-24f, 1 + 0x1p-23f}) {
      EXPECT_NEAR(gtr_constant(alpha, gamma) / gtr_constant(alpha, 1), 1, 2e-6) << alpha;
      for (const float u : {.01f, .5f, .99f}) {
        const Vec3 a = lobe_of(alpha, gamma).sample_half({0, 0, 1}, u, 0);
        const Vec3 b = lobe_of(alpha, 1).sample_half({0, 0, 1}, u, 0);
        EXPECT_NEAR(a.x / b.x, 1, 2e-6) << alpha << ' ' << u;
      }
    }
}

TEST(Gtr, sample_inverts_the_cumulative_distribution_of_every_gamma_and_alpha) {
  for (const float alpha : alphas)
    for (const float gamma : gammas) {
      const Specular lobe = lobe_of(alpha, gamma);
      double worst = 0;
      for (int i = 0; i <= 1000; ++i) {
        const float u = std::min(static_cast<float>(i) / 1000, 1 - 0x1p-24f);
        const Vec3 h = lobe.sample_half({0, 0, 1}, u, .125f);
        ASSERT_GT(h.z, 0);
        const long double sin2 = static_cast<long double>(h.x) * h.x + static_cast<long double>(h.y) * h.y;
        worst = std::max(worst, static_cast<double>(std::fabs(share_below(sin2, alpha, gamma) - u)));
      }
      // sin^2 of a float vector is good to 2e-7 relative; the share grows by at most gamma e^-1 times that.
      EXPECT_LT(worst, 1e-6) << "alpha " << alpha << " gamma " << gamma;
    }
}

TEST(Gtr, density_of_half_vectors_is_the_slope_of_that_distribution) {
  // pdf 4 (wi.wh) is D cos of the half vector; over d(sin^2) that is pi D.
  for (const float alpha : alphas)
    for (const float gamma : gammas) {
      const Specular lobe = lobe_of(alpha, gamma);
      for (const double u : {.02, .3, .7, .98}) {
        const Vec3 wh = lobe.sample_half({0, 0, 1}, static_cast<float>(u), .125f);
        const HalfVector h(wh, wh);
        const long double x = static_cast<long double>(h.sin2_h()), step = x * 1e-5L;
        const long double slope =
            (share_below(x + step, alpha, gamma) - share_below(x - step, alpha, gamma)) / (2 * step);
        const double density = static_cast<double>(lobe.eval(wh, wh, h).pdf) * 4 * h.cos_d / std::sqrt(h.cos2_h());
        EXPECT_NEAR(density * pi / static_cast<double>(slope), 1, 2e-6)
            << "alpha " << alpha << " gamma " << gamma << " u " << u;
      }
    }
}

TEST(Gtr, normalised_lobe_stays_finite_and_bounded_at_every_edge) {
  std::mt19937 rng(2);
  std::uniform_real_distribution<float> uniform(0, 1 - 0x1p-24f);
  const float edges[] = {0, 0x1p-24f, 1 - 0x1p-24f};
  float largest = 0;
  for (const float gamma : gammas)
    for (const float roughness : {0.f, .0316f, .05f, .1f, .25f, .5f, .9f, 1 - 0x1p-24f, 1.f})
      for (int i = 0; i < 2000; ++i) {
        Parameters p;
        p.roughness = roughness;
        p.metallic = static_cast<float>(i % 2);
        const float cosine = i % 4 ? uniform(rng) : .001f;
        const Vec3 wo{std::sqrt(1 - cosine * cosine), 0, cosine};
        const Bsdf b = prepare(Model::path_disney, {gamma, {}}, p, {}, wo);
        const float lobe = uniform(rng);
        const float u = i % 5 ? uniform(rng) : edges[rng() % 3], v = i % 7 ? uniform(rng) : edges[rng() % 3];
        const auto s = sample(b, wo, lobe, u, v);
        if (!s) continue;
        ASSERT_TRUE(math::is_finite(s->f_cos) && std::isfinite(s->pdf) && s->pdf > 0)
            << "gamma " << gamma << " roughness " << roughness;
        largest = std::max(largest, math::max_component(s->f_cos) / s->pdf);
      }
  // f_cos / pdf of the lobe is F g(wo) g(wi) 4 cos(wi) (wi.wh) / cos(wh), g = G1 / (2 cos) <= 1/alpha_g <= 4
  // and cos(wi) <= 2 (wi.wh) cos(wh).
  EXPECT_LT(largest, 128);
  std::printf("largest sample weight %.3f\n", static_cast<double>(largest));
}

TEST(Gtr, constant_of_the_report_scales_the_lobe_and_leaves_its_sampling_alone) {
  const Vec3 wo{.6f, 0, .8f}, wi{-.5f, .1f, std::sqrt(1 - .26f)};
  Parameters p;
  p.base_color = Vec3(0);
  p.roughness = .25f;
  for (const float gamma : {.5f, 1.f, 2.f, 10.f}) {
    const Value normal = eval(prepare(Model::path_disney, {gamma, {}}, p, {}, wo), wo, wi);
    const double c = gtr_constant(.0625, gamma);
    for (const float constant : {0.f, .005f, .3f, 10.f}) {
      const Value value = eval(prepare(Model::path_disney, {gamma, constant}, p, {}, wo), wo, wi);
      EXPECT_EQ(value.pdf, normal.pdf);
      EXPECT_NEAR(value.f_cos.x, normal.f_cos.x * constant / c, 1e-6 * value.f_cos.x) << gamma;
    }
  }
}

}  // namespace
}  // namespace bsdf
