// D, G and the densities made of them against closed forms and quadrature: rows B03, B04, B05, B13 and B19 of
// docs/bsdf-tests.md.
#include "bsdf/microfacet.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "bsdf/testing.h"

namespace bsdf {
namespace {

using testing::direction;
using testing::Random;

// Integral over the hemisphere of half vectors of g(h) dh, in slopes stretched by ax and ay:
// dh = ax ay cos^3 rho drho dpsi with rho = tan q.
template <typename G>
double integrate_half_vectors(const G& g, double ax, double ay, int n_q = 2000, int n_psi = 64) {
  double sum = 0;
  for (int i = 0; i < n_q; ++i) {
    const double q = pi / 2 * (i + .5) / n_q, rho = std::tan(q), drho = (1 + rho * rho) * pi / 2 / n_q;
    for (int j = 0; j < n_psi; ++j) {
      const double psi = 2 * pi * (j + .5) / n_psi;
      const double x = ax * rho * std::cos(psi), y = ay * rho * std::sin(psi);
      const double scale = 1 / std::sqrt(x * x + y * y + 1);
      const Vec3 h(static_cast<float>(x * scale), static_cast<float>(y * scale), static_cast<float>(scale));
      sum += g(h) * ax * ay * scale * scale * scale * rho * drho * 2 * pi / n_psi;
    }
  }
  return sum;
}

TEST(GtrConstant, normalises_every_gamma) {
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

// B04: float vectors, half vector at up to 10 alpha, against the same formulas in long double.
TEST(D, keeps_its_precision_at_small_alpha) {
  for (const double alpha : {1e-3, 1e-2, .1, .5, 1.})
    for (int i = 0; i <= 2000; ++i) {
      const double theta = std::min(1.5, 10 * alpha * i / 2000);
      const Vec3 h = direction(std::cos(theta), 1);
      const HalfVector half(h, h);
      const long double x = h.x, y = h.y, z = h.z, n = x * x + y * y + z * z;
      const long double s2 = (x * x + y * y) / n, c2 = z * z / n,
                        a2 = static_cast<long double>(alpha) * alpha;
      const long double t = s2 + a2 * c2, exact2 = a2 / (static_cast<long double>(pi) * t * t);
      EXPECT_NEAR(static_cast<double>(d_gtr2(half, alpha, alpha) / exact2), 1, 2e-6);
      const long double exact1 = alpha < 1 ? (a2 - 1) / (static_cast<long double>(pi) * std::log(a2) * t)
                                           : 1 / static_cast<long double>(pi);
      EXPECT_NEAR(
          static_cast<double>(d_gtr1(half.sin2_h(), half.cos2_h(), alpha, 2 * std::log(alpha)) / exact1), 1,
          2e-6);
      const long double b = 3 * static_cast<long double>(alpha),
                        q = (x * x / a2 + y * y / (b * b) + z * z) / n;
      EXPECT_NEAR(static_cast<double>(d_gtr2(half, alpha, 3 * alpha) * pi * alpha * b * q * q), 1, 2e-6);
    }
}

// B03
TEST(D, of_gtr1_is_continuous_and_finite_at_alpha_one) {
  for (const double alpha : {1 - 0x1p-24, 1., 1 + 0x1p-23, 2.})
    for (int i = 0; i <= 100; ++i) {
      const double c2 = i / 100.;
      EXPECT_NEAR(d_gtr1(1 - c2, c2, alpha, 2 * std::log(alpha)), 1 / pi, 1e-6);
    }
  EXPECT_NEAR(d_gtr1(.3, .7, 1 - 1e-4, 2 * std::log(1 - 1e-4)) * pi, 1, 1e-3);
}

// B03: a coat's roughness out of range is clamped. NaN counts as 0, and so does what is below.
TEST(D, of_a_coat_out_of_range_is_that_of_the_nearest_in_range) {
  const Vec3 wo = direction(.6, 0), wi = direction(.6, 3);
  const auto value = [&](float roughness) {
    Parameters p = testing::black();
    p.clearcoat = 1;
    p.clearcoat_roughness = roughness;
    return eval(prepare(Model::disney, {}, p, {}, wo), wo, wi).f_cos.x;
  };
  for (const float low : {-9.f, -1.f, -0.f, NAN}) EXPECT_EQ(value(low), value(0));
  for (const float high : {1 + 0x1p-23f, 2.f, INFINITY}) EXPECT_EQ(value(high), value(1));
  EXPECT_GT(value(1), 0);
  EXPECT_TRUE(std::isfinite(value(0)));
}

// B05
TEST(D, times_the_cosine_integrates_to_one) {
  for (const double a : {.001, .01, .1, .5, .999})
    EXPECT_NEAR(integrate_half_vectors(
                    [&](const Vec3& v) {
                      const HalfVector h(v, v);
                      return d_gtr1(h.sin2_h(), h.cos2_h(), a, 2 * std::log(a)) * std::sqrt(h.cos2_h());
                    },
                    a, a, 20000, 1),
                1, 1e-4)
        << "GTR1 " << a;
  for (const double ax : {.001, .01, .1, 1.})
    for (const double ay : {.001, .01, .1, 1.})
      EXPECT_NEAR(integrate_half_vectors(
                      [&](const Vec3& v) {
                        const HalfVector h(v, v);
                        return d_gtr2(h, ax, ay) * std::sqrt(h.cos2_h());
                      },
                      ax, ay),
                  1, 1e-4)
          << "GTR2 " << ax << " " << ay;
}

// B05: what is visible of the facets from wo covers as much as the surface, int G1 D max(0, wo.h) dh = wo.z.
TEST(G1, of_all_facets_covers_the_surface) {
  for (const double ax : {.001, .1, 1.})
    for (const double ay : {.001, .1, 1.})
      for (const double cosine : {1., .7, .3, .05}) {
        const Vec3 wo = direction(cosine, .4);
        const double g1 = 2. * wo.z * g1_over_2cos(wo, static_cast<float>(ax), static_cast<float>(ay));
        const double visible = integrate_half_vectors(
            [&](const Vec3& h) {
              const double cos_d = static_cast<double>(wo.x) * h.x + static_cast<double>(wo.y) * h.y +
                                   static_cast<double>(wo.z) * h.z;
              return d_gtr2(HalfVector(h, h), ax, ay) * std::max(0., cos_d);
            },
            ax, ay, 1000, 128);
        EXPECT_NEAR(g1 * visible, wo.z, 1e-3 * cosine) << ax << " " << ay << " at cos " << cosine;
      }
}

// B13: pdf 4 (wo.h) = G1 D (wo.h) / wo.z, with G1 from its own formula, 2 / (1 + sqrt(1 + alpha^2 tan^2)).
TEST(VisibleNormals, density_is_that_of_the_paper) {
  Random random(2);
  for (int i = 0; i < 100000; ++i) {
    Parameters p;
    p.metallic = 1;
    p.roughness = random.uniform();
    p.anisotropic = i % 2 ? random.uniform() : 0;
    const float a = random.uniform(), b = random.uniform(), u = random.uniform(), v = random.uniform();
    const Vec3 wo = direction(.01 + .99 * static_cast<double>(a), 6.283 * static_cast<double>(b));
    const Bsdf bsdf = prepare(Model::disney, {}, p, {}, wo);
    const auto s = sample(bsdf, wo, .5f, u, v);
    if (!s) continue;
    const HalfVector h(wo, s->wi);
    const double ax = bsdf.specular.ax, ay = bsdf.specular.ay;
    const double x = wo.x * ax, y = wo.y * ay, z = wo.z;
    const double g1 = 2 / (1 + std::sqrt(1 + (x * x + y * y) / (z * z)));
    const double hx = h.x / ax, hy = h.y / ay, q = (hx * hx + hy * hy + h.z * h.z) / h.length_squared;
    EXPECT_NEAR(s->pdf * 4 / (g1 / (pi * ax * ay * q * q) / z), 1, 1e-5);
  }
}

// B19: no alpha below .001, and D of the normal is 1 / (pi ax ay).
TEST(Anisotropy, at_its_ends_keeps_both_alphas_and_the_peak) {
  const Vec3 n(0, 0, 1);
  for (const float anisotropic : {0.f, .5f, 1.f})
    for (const float roughness : {0.f, .03f, 1.f}) {
      Parameters p;
      p.anisotropic = anisotropic;
      p.roughness = roughness;
      const Specular s = prepare(Model::disney, {}, p, {}, n).specular;
      const double aspect = std::sqrt(1 - .9 * anisotropic),
                   alpha = static_cast<double>(roughness) * roughness;
      EXPECT_NEAR(s.ax / std::max(.001, alpha / aspect), 1, 1e-6);
      EXPECT_NEAR(s.ay / std::max(.001, alpha * aspect), 1, 1e-6);
      EXPECT_NEAR(s.d(HalfVector(n, n)) * pi * s.ax * s.ay, 1, 1e-6);
    }
}

}  // namespace
}  // namespace bsdf
