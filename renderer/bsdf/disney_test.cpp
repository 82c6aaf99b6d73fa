// The BRDF against closed forms and quadrature: normalisations, directional albedos of Burley 2012, and that
// sample(), pdf and eval() describe one and the same function.

#include "bsdf/disney.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "math/warp.h"

namespace bsdf {
namespace {

Vec3 direction(double cosine, double phi) {
  const double s = std::sqrt(1 - cosine * cosine);
  return {static_cast<float>(s * std::cos(phi)), static_cast<float>(s * std::sin(phi)),
          static_cast<float>(cosine)};
}

// Integral over the hemisphere of g(wi) dwi by Gauss-like midpoint rule in (sqrt-stretched) cosine and
// azimuth.
template <typename G>
double integrate(const G& g, int n_cos = 400, int n_phi = 400) {
  double sum = 0;
  for (int i = 0; i < n_cos; ++i) {
    const double s = (i + .5) / n_cos, cosine = s * s;  // fine steps at grazing
    for (int j = 0; j < n_phi; ++j) sum += g(direction(cosine, 2 * pi * (j + .5) / n_phi)) * 2 * s;
  }
  return sum * 2 * pi / n_cos / n_phi;
}

double albedo_by_quadrature(Model model, const Parameters& p, double cos_o) {
  const Vec3 wo = direction(cos_o, .3);
  const Bsdf b = prepare(model, {}, p, {}, wo);
  return integrate([&](const Vec3& wi) { return static_cast<double>(eval(b, wo, wi).f_cos.x); });
}

double albedo_by_sampling(const Bsdf& b, const Vec3& wo, int n, double& error) {
  std::mt19937 rng(7);
  std::uniform_real_distribution<float> u(0, std::nextafter(1.f, 0.f));
  double sum = 0, squares = 0;
  for (int i = 0; i < n; ++i) {
    const float a = u(rng), c = u(rng), d = u(rng);
    const auto s = sample(b, wo, a, c, d);
    const double w = s ? s->f_cos.x / s->pdf : 0;
    sum += w;
    squares += w * w;
  }
  const double mean = sum / n;
  error = std::sqrt((squares / n - mean * mean) / n);
  return mean;
}

Parameters black() {
  Parameters p;
  p.base_color = Vec3(0);
  p.specular = 0;
  return p;
}

TEST(Microfacet, gtr_constant_normalises_every_gamma) {
  for (const double alpha : {.001, .01, .1, .5, .9, 1.})
    for (const double gamma : {.1, .5, .999999, 1., 1.000001, 1.5, 2., 3., 7.5, 10.}) {
      const double c = gtr_constant(alpha, gamma);
      // With t = sin^2 + alpha^2 cos^2 the integral of D cos is pi c / (1 - alpha^2) int t^-gamma dt, here in
      // ln t.
      double integral = 0;
      const int n = 20000;
      const double top = -2 * std::log(alpha);
      if (alpha == 1) {
        integral = pi * c;
      } else {
        for (int i = 0; i < n; ++i) {
          const double log_t = 2 * std::log(alpha) + top * (i + .5) / n;
          integral += std::exp(log_t * (1 - gamma)) * top / n;
        }
        integral *= pi * c / (1 - alpha * alpha);
      }
      EXPECT_NEAR(integral, 1, 1e-4) << "alpha " << alpha << " gamma " << gamma;
    }
  EXPECT_NEAR(gtr_constant(.01, 2), 1e-4 / pi, 1e-15);
  EXPECT_NEAR(gtr_constant(.25, 1), (.0625 - 1) / (pi * std::log(.0625)), 1e-12);
}

TEST(Microfacet, d_keeps_its_precision_at_small_alpha) {
  // B04 of the hard cases: float vectors, half vector at up to 10 alpha, against the same formula in long
  // double.
  for (const double alpha : {1e-3, 1e-2, .1, .5})
    for (int i = 0; i <= 2000; ++i) {
      const double theta = std::min(1.5, 10 * alpha * i / 2000);
      const Vec3 h = direction(std::cos(theta), 1);
      const HalfVector half(h, h);
      const long double x = h.x, y = h.y, z = h.z, n = x * x + y * y + z * z;
      const long double s2 = (x * x + y * y) / n, c2 = z * z / n,
                        a2 = static_cast<long double>(alpha) * alpha;
      const long double t = s2 + a2 * c2;
      EXPECT_NEAR(
          static_cast<double>(d_gtr2(half, alpha, alpha) / (a2 / (static_cast<long double>(pi) * t * t))), 1,
          2e-6);
      EXPECT_NEAR(static_cast<double>(d_gtr1(half.sin2_h(), half.cos2_h(), alpha, 2 * std::log(alpha)) /
                                      ((a2 - 1) / (static_cast<long double>(pi) * std::log(a2) * t))),
                  1, 2e-6);
    }
}

TEST(Microfacet, gtr1_is_continuous_and_finite_at_alpha_one) {
  for (const double alpha : {1 - 0x1p-24, 1., 1 + 0x1p-23, 2.})
    for (int i = 0; i <= 100; ++i) {
      const double c2 = i / 100.;
      EXPECT_NEAR(d_gtr1(1 - c2, c2, alpha, 2 * std::log(alpha)), 1 / pi, 1e-6);
    }
  EXPECT_NEAR(d_gtr1(.3, .7, 1 - 1e-4, 2 * std::log(1 - 1e-4)) * pi, 1, 1e-3);
}

// Directional albedos of the published shader, base colour 1, by double quadrature on two grids that agree to
// 5e-4.
struct AlbedoRow {
  const char* name;
  Parameters parameters;
  double albedo[7];  // at cos = 1, .5, .2, .1, .05, .02, .01
};
std::vector<AlbedoRow> albedo_rows() {
  const auto diffuse = [](float roughness) {
    Parameters p;
    p.base_color = Vec3(1);
    p.roughness = roughness;
    p.specular = 0;
    return p;
  };
  const auto coat = [](float gloss) {
    Parameters p = black();
    p.clearcoat = 1;
    p.clearcoat_roughness = std::sqrt(.1f + (.001f - .1f) * gloss);
    return p;
  };
  const auto metal = [](float roughness) {
    Parameters p;
    p.base_color = Vec3(1);
    p.metallic = 1;
    p.roughness = roughness;
    return p;
  };
  Parameters sheen = black();
  sheen.sheen = 1;
  sheen.sheen_tint = 0;
  return {
      {"sheen", sheen, {.0003, .0156, .0481, .0660, .0766, .0836, .0860}},
      {"clearcoat gloss 0", coat(0), {.0081, .0131, .0305, .0392, .0439, .0468, .0477}},
      {"clearcoat gloss 1", coat(1), {.0094, .0150, .0440, .0421, .0309, .0232, .0215}},
      {"metal .1", metal(.1f), {1.0000, .9999, .9987, .9942, .9761, .9111, .8816}},
      {"metal .5", metal(.5f), {.9158, .8551, .8315, .8543, .8746, .8887, .8936}},
      {"metal 1", metal(1), {.3069, .4091, .5114, .5579, .5845, .6017, .6076}},
      {"diffuse 0", diffuse(0), {.9762, .9609, .8163, .6880, .5985, .5350, .5120}},
      {"diffuse .5", diffuse(.5f), {1.0060, 1.0083, 1.0248, 1.0235, 1.0174, 1.0111, 1.0084}},
      {"diffuse 1", diffuse(1), {1.0357, 1.0569, 1.2453, 1.3801, 1.4636, 1.5188, 1.5380}},
  };
}

TEST(Disney, directional_albedo_is_that_of_the_published_shader) {
  const double cosines[7] = {1, .5, .2, .1, .05, .02, .01};
  for (const AlbedoRow& row : albedo_rows())
    for (int i = 0; i < 7; ++i) {
      const Vec3 wo = direction(cosines[i], .3);
      Bsdf b = prepare(Model::disney, {}, row.parameters, {}, wo);
      // Disney's shader keeps a Schlick edge at specular 0; the table's diffuse, sheen and coat rows are one
      // lobe alone.
      if (row.parameters.metallic == 0) {
        const float rest = 1 - b.probability[1];
        b.probability[1] = 0;
        for (float& p : b.probability) p /= rest;
      }
      double error;
      const double mean = albedo_by_sampling(b, wo, 1 << 18, error);
      // The table has four digits: half a unit of the last is absolute.
      EXPECT_NEAR(mean, row.albedo[i], .005 * row.albedo[i] + 4 * error + 5e-5)
          << row.name << " at " << cosines[i];
    }
}

std::vector<std::pair<Model, Parameters>> some_materials() {
  std::vector<std::pair<Model, Parameters>> list;
  std::mt19937 rng(11);
  std::uniform_real_distribution<float> u(0, 1);
  for (const Model model : {Model::path, Model::path_disney, Model::principled, Model::disney})
    for (int i = 0; i < 8; ++i) {
      Parameters p;
      p.base_color = {u(rng), u(rng), u(rng)};
      p.metallic = u(rng) < .3f ? 1 : u(rng) < .5f ? 0 : u(rng);
      p.roughness = .35f + .65f * u(rng);
      p.specular = u(rng);
      p.specular_tint = u(rng);
      p.anisotropic = i % 2 ? u(rng) : 0;
      p.sheen = u(rng);
      p.clearcoat = u(rng);
      p.clearcoat_roughness = .4f + .5f * u(rng);
      list.emplace_back(model, p);
    }
  return list;
}

TEST(Disney, density_integrates_to_the_share_of_samples_that_succeed) {
  for (const auto& [model, p] : some_materials())
    for (const double cos_o : {.95, .5, .15}) {
      const Vec3 wo = direction(cos_o, .7);
      const Bsdf b = prepare(model, {1.3f, {}}, p, {}, wo);
      const double total =
          integrate([&](const Vec3& wi) { return static_cast<double>(eval(b, wo, wi).pdf); });
      std::mt19937 rng(3);
      std::uniform_real_distribution<float> u(0, std::nextafter(1.f, 0.f));
      int successes = 0;
      const int n = 100000;
      for (int i = 0; i < n; ++i) {
        const float a = u(rng), c = u(rng), d = u(rng);
        successes += sample(b, wo, a, c, d).has_value();
      }
      const double share = static_cast<double>(successes) / n;
      EXPECT_NEAR(total, share, .003 + 4 * std::sqrt(share * (1 - share) / n));
    }
}

TEST(Disney, sampled_albedo_equals_the_integral_of_eval) {
  for (const auto& [model, p] : some_materials())
    for (const double cos_o : {.9, .3}) {
      const Vec3 wo = direction(cos_o, .3);
      const Bsdf b = prepare(model, {}, p, {}, wo);
      double error;
      const double mean = albedo_by_sampling(b, wo, 100000, error);
      const double exact = albedo_by_quadrature(model, p, cos_o);
      EXPECT_NEAR(mean, exact, 4 * error + .002 * exact);
    }
}

TEST(Disney, is_reciprocal) {
  std::mt19937 rng(5);
  std::uniform_real_distribution<double> u(.02, 1), v(0, 6.28);
  for (const auto& [model, p] : some_materials())
    for (int i = 0; i < 200; ++i) {
      const Vec3 a = direction(u(rng), v(rng)), c = direction(u(rng), v(rng));
      const Vec3 forward = eval(prepare(model, {}, p, {}, a), a, c).f_cos / c.z;
      const Vec3 backward = eval(prepare(model, {}, p, {}, c), c, a).f_cos / a.z;
      EXPECT_NEAR(forward.x, backward.x, 2e-6 * forward.x + 1e-7);
    }
}

TEST(Disney, edges_of_every_parameter_and_random_number_stay_finite) {
  // A million draws of the sweep B01: no NaN, no infinity, nothing negative; the largest weight is bounded.
  std::mt19937 rng(1);
  std::uniform_real_distribution<float> u(0, std::nextafter(1.f, 0.f));
  const float edges[] = {0, 1e-7f, .5f, 1 - 0x1p-24f, 1};
  const auto parameter = [&] { return u(rng) < .3f ? edges[rng() % 5] : u(rng); };
  const auto random = [&] { return u(rng) < .1f ? (rng() % 2 ? 0.f : 1 - 0x1p-24f) : u(rng); };
  const auto any_direction = [&] {
    const float cosines[] = {0, 1e-7f, -1e-7f, 1e-4f, 1};
    const double c = u(rng) < .3f ? cosines[rng() % 5] : u(rng);
    return direction(c, 6.2831853 * u(rng));
  };
  float largest[4] = {0, 0, 0, 0};
  for (int i = 0; i < 1000000; ++i) {
    const auto model = static_cast<Model>(rng() % 4);
    Parameters p;
    p.base_color = {parameter(), parameter(), parameter()};
    for (float* x : {&p.metallic, &p.roughness, &p.specular, &p.specular_tint, &p.anisotropic, &p.sheen,
                     &p.sheen_tint, &p.clearcoat, &p.clearcoat_roughness})
      *x = parameter();
    const Vec3 wo = any_direction(), wi = rng() % 8 ? any_direction() : -wo;
    const Bsdf b = prepare(model, {.5f + 4 * u(rng), {}}, p, {}, wo);
    const Value value = eval(b, wo, wi);
    ASSERT_TRUE(math::is_finite(value.f_cos) && value.f_cos.x >= 0 && value.f_cos.y >= 0 &&
                value.f_cos.z >= 0)
        << i;
    ASSERT_TRUE(std::isfinite(value.pdf) && value.pdf >= 0) << i;
    const bool reflects = !math::is_black(value.f_cos);
    ASSERT_TRUE(!reflects || value.pdf > 0) << i;
    const float a = random(), c = random(), d = random();
    const auto s = sample(b, wo, a, c, d);
    if (!s) continue;
    ASSERT_TRUE(math::is_finite(s->wi) && math::is_finite(s->f_cos) && s->pdf > 0) << i;
    ASSERT_NEAR(math::length(s->wi), 1, 1e-5) << i;
    const float weight = math::max_component(s->f_cos) / s->pdf;
    float& most = largest[static_cast<int>(model)];
    most = std::max(most, weight);
  }
  for (const Model model : {Model::path, Model::principled, Model::disney})
    EXPECT_LT(largest[static_cast<int>(model)], 32);
  // path_disney samples a narrow D under a wide G (alpha_g >= 1/4): F g g 4 cos(wi) (wi.wh) / cos(wh) <= 16 *
  // 4 * 2.
  EXPECT_LT(largest[static_cast<int>(Model::path_disney)], 128);
  std::printf("largest sample weights: path %.3f, path_disney %.3f, principled %.3f, disney %.3f\n",
              static_cast<double>(largest[0]), static_cast<double>(largest[1]),
              static_cast<double>(largest[2]), static_cast<double>(largest[3]));
}

TEST(Disney, opposite_and_below_horizon_directions_reflect_nothing) {
  const Vec3 wo(0.381908983f, 0.105378345f, 0.918172538f);  // a vector that gave LuxCore NaNs
  const Bsdf b = prepare(Model::disney, {}, {}, {}, wo);
  EXPECT_EQ(eval(b, wo, -wo).pdf, 0);
  EXPECT_TRUE(math::is_black(eval(b, wo, -wo).f_cos));
  EXPECT_FALSE(sample(b, -wo, .5f, .5f, .5f).has_value());
}

TEST(Disney, nothing_to_reflect_means_no_sample) {
  const Vec3 wo = direction(.5, 0);
  const Bsdf b = prepare(Model::principled, {}, black(), {}, wo);
  EXPECT_FALSE(sample(b, wo, .5f, .5f, .5f).has_value());
  EXPECT_TRUE(b.only_delta);
}

TEST(Principled, turns_into_a_mirror_exactly_below_blenders_threshold) {
  const Vec3 wo = direction(.5, 0);
  Parameters p = black();
  p.base_color = Vec3(1);
  p.metallic = 1;
  p.roughness = .01778f;
  const auto mirror = sample(prepare(Model::principled, {}, p, {}, wo), wo, .5f, .3f, .3f);
  ASSERT_TRUE(mirror && mirror->is_delta);
  EXPECT_EQ(mirror->f_cos.x, mirror->pdf);
  p.roughness = .01779f;
  EXPECT_FALSE(prepare(Model::principled, {}, p, {}, wo).specular.is_delta);
}

TEST(Principled, a_mirror_among_other_lobes_reflects_as_much_as_the_glossy_lobe_just_above_the_threshold) {
  const Vec3 wo = direction(.7, .2);
  Parameters p = black();
  p.base_color = Vec3(.6f);
  p.metallic = .5f;
  p.specular = .5f;
  p.roughness = 0;
  double error = 0, glossy_error = 0;
  const double mirror = albedo_by_sampling(prepare(Model::principled, {}, p, {}, wo), wo, 400000, error);
  p.roughness = .018f;
  const double glossy =
      albedo_by_sampling(prepare(Model::principled, {}, p, {}, wo), wo, 400000, glossy_error);
  EXPECT_NEAR(mirror, glossy, 5 * (error + glossy_error) + .002);
}

}  // namespace
}  // namespace bsdf
