// Statistical tests here: fixed seeds, and limits of 4.5 standard deviations, so each of the some forty of
// them would fail a right warp with probability 7e-6; one per cent, were the seeds fresh, in thirty runs.
#include "math/warp.h"

#include <gtest/gtest.h>

#include <functional>
#include <vector>

#include "math/sampler.h"

using math::Vec2;
using math::Vec3;

namespace {

constexpr double pi = 3.141592653589793;

math::Vec4 random(int i) {
  return math::Sampler(math::Sampler::Kind::random, 3, 0, 0, 0, static_cast<std::uint32_t>(i)).get(0);
}

constexpr float edge_values[] = {0, 0x1p-149f, 0x1p-24f, .25f, .5f - 0x1p-25f, .5f, .75f, math::largest_u};

void at_every_edge(const std::function<void(float, float)>& check) {
  for (float u0 : edge_values)
    for (float u1 : edge_values) check(u0, u1);
}

// How many standard deviations a chi-square of k degrees of freedom is from what chance gives (Wilson &
// Hilferty 1931).
double deviations(double chi_square, double k) {
  return (std::cbrt(chi_square / k) - (1 - 2 / (9 * k))) / std::sqrt(2 / (9 * k));
}

// Deviations of counts from expectations (of the same total), cells below 5 pooled.
double chi_square_test(const std::vector<double>& count, const std::vector<double>& expected) {
  double sum = 0, pooled_count = 0, pooled_expected = 0;
  int cells = 0;
  const auto add = [&](double c, double e) { sum += (c - e) * (c - e) / e, ++cells; };
  for (std::size_t i = 0; i < count.size(); ++i) {
    if (expected[i] >= 5)
      add(count[i], expected[i]);
    else
      pooled_count += count[i], pooled_expected += expected[i];
  }
  if (pooled_expected > 5) add(pooled_count, pooled_expected);
  return deviations(sum, cells - 1);
}

// Deviations from uniform of points in the unit square.
double uniformity(const std::function<Vec2(float, float)>& point) {
  constexpr int side = 32, draws = 400000;
  std::vector<double> count(side * side), expected(side * side, draws / double(side * side));
  for (int i = 0; i < draws; ++i) {
    const math::Vec4 u = random(i);
    const Vec2 p = point(u.x, u.y);
    const auto cell = [](float v) { return std::clamp(static_cast<int>(v * side), 0, side - 1); };
    ++count[static_cast<std::size_t>(cell(p.y) * side + cell(p.x))];
  }
  return chi_square_test(count, expected);
}

// Angle as a share of the circle.
float turn(float y, float x) {
  const double angle = std::atan2(double{y}, double{x}) / (2 * pi);
  return static_cast<float>(angle < 0 ? angle + 1 : angle);
}

}  // namespace

TEST(Warp, DiskStaysInsideAndIsUniform) {
  at_every_edge([](float u0, float u1) {
    const Vec2 p = math::sample_disk(u0, u1);
    EXPECT_LE(p.x * p.x + p.y * p.y, 1 + 1e-6f) << u0 << " " << u1;
  });
  EXPECT_EQ(math::sample_disk(.5f, .5f), Vec2(0, 0));
  // By area, radius squared and angle are independent and uniform.
  const auto coordinates = [](float u0, float u1) {
    const Vec2 p = math::sample_disk(u0, u1);
    return Vec2(p.x * p.x + p.y * p.y, turn(p.y, p.x));
  };
  EXPECT_LT(uniformity(coordinates), 4.5);
}

TEST(Warp, CosineHemisphereFollowsItsDensityAndNeverHasOneOfZero) {
  at_every_edge([](float u0, float u1) {
    const Vec3 d = math::sample_cosine_hemisphere(u0, u1);
    EXPECT_NEAR(math::length(d), 1, 1e-6);
    EXPECT_GT(math::pdf_cosine_hemisphere(d.z), 0);
  });
  // The density cos/pi integrates to sin^2 theta.
  EXPECT_LT(uniformity([](float u0, float u1) {
              const Vec3 d = math::sample_cosine_hemisphere(u0, u1);
              return Vec2(1 - d.z * d.z, turn(d.y, d.x));
            }),
            4.5);
  double integral = 0;
  for (int i = 0; i < 10000; ++i)
    integral += 2 * pi / 10000 * math::pdf_cosine_hemisphere((static_cast<float>(i) + .5f) / 10000);
  EXPECT_NEAR(integral, 1, 1e-6);
  EXPECT_EQ(math::pdf_cosine_hemisphere(-.5f), 0);
}

TEST(Warp, SphereIsUniform) {
  at_every_edge([](float u0, float u1) { EXPECT_NEAR(math::length(math::sample_sphere(u0, u1)), 1, 1e-6); });
  EXPECT_LT(uniformity([](float u0, float u1) {
              const Vec3 d = math::sample_sphere(u0, u1);
              return Vec2((d.z + 1) / 2, turn(d.y, d.x));
            }),
            4.5);
  EXPECT_NEAR(math::pdf_sphere * 4 * pi, 1, 1e-6);
}

TEST(Warp, TriangleIsUniformAndKeepsItsWeights) {
  at_every_edge([](float u0, float u1) {
    const Vec3 b = math::sample_triangle(u0, u1);
    EXPECT_TRUE(b.x >= 0 && b.y >= 0 && b.z >= 0) << u0 << " " << u1;
    EXPECT_NEAR(b.x + b.y + b.z, 1, 1e-6);
  });
  // Inverse of the classic map: sqrt of one number against the ratio of the others.
  EXPECT_LT(uniformity([](float u0, float u1) {
              const Vec3 b = math::sample_triangle(u0, u1);
              const float s = b.x + b.y;
              return Vec2(s * s, s > 0 ? b.x / s : 0);
            }),
            4.5);
}

TEST(Warp, VisibleNormalsAreUnitAndFaceUpwardsForEveryEdgeAndRoughness) {
  for (float ax : {1e-4f, 1e-3f, .05f, 1.f})
    for (float ay : {1e-4f, .2f, 1.f})
      for (float cos : {0.f, 1e-30f, 1e-7f, 1e-3f, .5f, 1 - 0x1p-24f, 1.f})
        for (float phi : {0.f, 1.f, 3.14159f, 4.7f}) {
          const float sin = std::sqrt(1 - cos * cos);
          const Vec3 wo{sin * std::cos(phi), sin * std::sin(phi), cos};
          at_every_edge([&](float u0, float u1) {
            const Vec3 h = math::sample_visible_normal(wo, ax, ay, u0, u1);
            EXPECT_NEAR(math::length(h), 1, 1e-6);
            EXPECT_GE(h.z, 0);
            EXPECT_GE(math::dot(h, wo), -1e-6f) << ax << " " << ay << " " << cos << " " << u0 << " " << u1;
          });
        }
}

namespace {

// Deviations of sampled normals from the density D G1 (wo.h) / wo.z of roughness (ax, ay). Cells are equal
// shares of the *whole* distribution D(h) h.z, in closed form t = 1 / (1 + tan^2) and an angle, both of the
// stretched normal: so they are fine where the lobe is, and the density relative to it is G1 (wo.h) / (wo.z
// h.z).
double visible_normal_deviations(const Vec3& wo, float ax, float ay, float sampled_ax) {
  constexpr int rows = 24, columns = 48, draws = 400000, inner = 16;
  std::vector<double> count(rows * columns), expected(rows * columns);
  for (int i = 0; i < draws; ++i) {
    const math::Vec4 u = random(i);
    const Vec3 h = math::sample_visible_normal(wo, sampled_ax, ay, u.x, u.y);
    const double x = double{h.x} / ax, y = double{h.y} / ay, z = h.z;
    const double t = z * z / (x * x + y * y + z * z), angle = std::atan2(y, x) / (2 * pi);
    const int row = std::min(static_cast<int>(t * rows), rows - 1);
    const int column = std::min(static_cast<int>((angle < 0 ? angle + 1 : angle) * columns), columns - 1);
    ++count[static_cast<std::size_t>(row * columns + column)];
  }
  const double a2 = math::sqr(double{ax} * wo.x) + math::sqr(double{ay} * wo.y), cos = wo.z;
  const double g1 = 2 * cos / (cos + std::sqrt(cos * cos + a2));
  double total = 0;
  for (int i = 0; i < rows * inner; ++i)
    for (int j = 0; j < columns * inner; ++j) {
      // The density grows as 1 / sqrt(t) at t = 0: integrate over v = sqrt(t), dt = 2 v dv.
      const double v0 = std::sqrt(i / inner / double(rows)), v1 = std::sqrt((i / inner + 1) / double(rows));
      const double v = v0 + (v1 - v0) * (i % inner + .5) / inner;
      const double angle = 2 * pi * (j + .5) / (columns * inner), tangent = std::sqrt(1 / (v * v) - 1);
      const double facing =
          wo.x * ax * tangent * std::cos(angle) + wo.y * ay * tangent * std::sin(angle) + cos;
      const double share = 2 * v * (v1 - v0) / inner / (columns * inner);
      const double count_here = g1 * std::max(0., facing) / cos * share * draws;
      expected[static_cast<std::size_t>(i / inner * columns + j / inner)] += count_here;
      total += count_here;
    }
  EXPECT_NEAR(total / draws, 1, 1e-3);
  for (double& e : expected) e *= draws / total;
  return chi_square_test(count, expected);
}

}  // namespace

TEST(Warp, VisibleNormalsFollowTheirDensity) {
  for (const auto& [ax, ay] :
       {std::pair{.5f, .5f}, {.1f, .1f}, {.001f, .001f}, {1.f, 1.f}, {.3f, .05f}, {.02f, .8f}})
    for (float cos : {1.f, .7f, .2f, .05f}) {
      const float sin = std::sqrt(1 - cos * cos);
      EXPECT_LT(visible_normal_deviations({sin * .8f, sin * -.6f, cos}, ax, ay, ax), 4.5)
          << "alpha " << ax << " " << ay << ", cosine " << cos;
    }
}

TEST(Warp, TheTestOfVisibleNormalsNoticesARoughnessThreePerCentOff) {
  EXPECT_GT(visible_normal_deviations({.48f, -.36f, .8f}, .1f, .1f, .103f), 4.5);
  EXPECT_GT(visible_normal_deviations({.48f, -.36f, .8f}, .3f, .05f, .309f), 4.5);
}

TEST(Warp, TriangleFilterInvertsItsDistribution) {
  for (int i = 0; i <= 4096; ++i) {
    const float u = std::min(static_cast<float>(i) / 4096, math::largest_u);
    const double x = math::sample_triangle_filter(u);
    const double cdf = x < 0 ? math::sqr(1 + x) / 2 : 1 - math::sqr(1 - x) / 2;
    EXPECT_NEAR(cdf, u, 2e-7);
  }
  EXPECT_EQ(math::pdf_triangle_filter(0), 1);
  EXPECT_EQ(math::pdf_triangle_filter(1.5f), 0);
}

TEST(Warp, BlackmanHarrisInvertsItsDistribution) {
  using math::BlackmanHarris;
  const BlackmanHarris filter;
  for (int i = 0; i <= 100000; ++i) {
    const float u = std::min(static_cast<float>(i) / 100000, math::largest_u);
    EXPECT_NEAR(BlackmanHarris::cdf(filter.sample(u)), u, 2e-6) << u;
  }
  for (float u : edge_values) EXPECT_LE(std::fabs(filter.sample(u)), 1.5f);
  EXPECT_NEAR(filter.sample(.5f), 0, 1e-9);

  // The distribution function is the integral of the published window, which ends near zero.
  double integral = 0, variance = 0, sampled = 0;
  for (int i = 0; i < 30000; ++i) {
    const double x = -1.5 + (i + .5) * 1e-4, angle = 2 * pi * (x + 1.5) / 3;
    const double window =
        .35875 - .48829 * std::cos(angle) + .14128 * std::cos(2 * angle) - .01168 * std::cos(3 * angle);
    EXPECT_NEAR(BlackmanHarris::pdf(x), window / (3 * .35875), 1e-12);
    integral += BlackmanHarris::pdf(x) * 1e-4;
    variance += BlackmanHarris::pdf(x) * x * x * 1e-4;
    sampled += math::sqr(filter.sample((static_cast<float>(i) + .5f) / 30000)) / 30000;
    if (i % 1000 == 0) {
      EXPECT_NEAR(BlackmanHarris::cdf(x + .5e-4), integral, 1e-7);
    }
  }
  EXPECT_NEAR(integral, 1, 1e-9);
  EXPECT_NEAR(sampled, variance, 1e-4 * variance);
}
