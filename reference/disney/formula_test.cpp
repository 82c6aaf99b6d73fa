// The published formulas in double against values by hand, Disney's shader in 50 decimal digits, and
// quadrature.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <numbers>

#include "disney/disney.h"
#include "disney/frozen_values.h"

namespace {

using disney::Colour;
using disney::Material;
using disney::Vector;

constexpr double pi = std::numbers::pi;

// l = v = n: Fd = 1, F is F0, D = 1/(pi alpha^2), G = 1; base .5, roughness .5, so alpha^2 = 1/16:
// f = .5/pi + .04 (16/pi) / 4 = .66/pi. A coat of alpha 1/4 adds (1/4) .04 D / 4, D = (15/16) 16 / (pi ln
// 16).
TEST(FormulaByHand, AtNormalIncidence) {
  Material m;
  m.base = {.5, .5, .5};
  const Vector n{0, 0, 1};
  EXPECT_NEAR(disney::burley_2012(m, n, n).r, .66 / pi, 1e-15);
  EXPECT_NEAR(disney::blender_341(m, n, n).r, .66 / pi, 1e-15);
  EXPECT_NEAR(disney::lambert_ggx(m, n, n).r, .66 / pi, 1e-15);
  EXPECT_NEAR(disney::report_2018(m, 2, {}, n, n).r, .66 / pi, 1e-15);
  m.clearcoat = 1;
  m.clearcoat_roughness = .5;
  const double coat = .01 / 4 * 15 / (pi * std::log(16.));
  EXPECT_NEAR(disney::burley_2012(m, n, n).r, .66 / pi + coat, 1e-15);
  EXPECT_NEAR(disney::blender_341(m, n, n).r, .66 / pi + coat, 1e-15);
}

// l and v opposite at 60 degrees: h = n, every cosine 1/2, Schlick's weight 1/32. Roughness 1/2: FD90 = 3/4,
// Fd = (127/128)^2; G1 = 2/(1 + sqrt(1 + 3/16)); F = .04 31/32 + 1/32; D = 16/pi; 4 (n.l)(n.v) = 1.
TEST(FormulaByHand, AtSixtyDegrees) {
  Material m;
  m.base = {.5, .5, .5};
  m.sheen = 1;
  const Vector v{std::sqrt(.75), 0, .5}, l{-std::sqrt(.75), 0, .5};
  const double diffuse = .5 / pi * std::pow(127. / 128, 2), g1 = 2 / (1 + std::sqrt(19. / 16));
  const double specular = 16 / pi * g1 * g1 * (.04 * 31 / 32 + 1. / 32), sheen = 1. / 32;
  EXPECT_NEAR(disney::burley_2012(m, v, l).r, (diffuse + specular + sheen) / 2, 1e-15);
}

TEST(FormulaAgainstDecimals, DisneysShader) {
  double worst = 0;
  const auto* value = disney::frozen::values;
  for (const auto& m : disney::frozen::materials)
    for (const auto& d : disney::frozen::pairs) {
      const Material material{{m[0], m[1], m[2]}, m[3], m[4], m[5], m[6], m[7], m[8], m[9], m[10],
                              std::sqrt(m[11])};
      const double v = std::hypot(d[0], d[1], d[2]), l = std::hypot(d[3], d[4], d[5]);
      const Colour f =
          disney::burley_2012(material, {d[0] / v, d[1] / v, d[2] / v}, {d[3] / l, d[4] / l, d[5] / l});
      const double got[3] = {f.r, f.g, f.b};
      for (int c = 0; c < 3; ++c) {
        EXPECT_NEAR(got[c], (*value)[c], 1e-12 * (*value)[c]);
        worst = std::fmax(worst, std::fabs(got[c] / (*value)[c] - 1));
      }
      ++value;
    }
  std::printf("largest relative error %.2e\n", worst);
}

// The half sphere of half vectors holds one surface's worth of facets. With s = sin^2, D cos dw = pi D ds;
// s = a^2 (e^t - 1) spreads the peak out.
TEST(FormulaByQuadrature, TheNormalisedDIntegratesToOne) {
  for (const double alpha : {.001, .01, .1, .5, .9, .999999, 1.})
    for (const double gamma : {.01, .5, 1., 1.0000001, 1.5, 2., 5., 10.}) {
      const double a2 = alpha * alpha, end = std::log1p(1 / a2);
      constexpr int n = 20000;
      double sum = 0;
      for (int i = 0; i < n; ++i) {
        const double t = end * (i + .5) / n, s = a2 * std::expm1(t);
        sum += std::pow(a2 * (1 - s) + s, -gamma) * a2 * std::exp(t);
      }
      EXPECT_NEAR(disney::gtr_constant(gamma, alpha) * pi * sum * end / n, 1, 1e-5) << alpha << " " << gamma;
    }
}

}  // namespace
