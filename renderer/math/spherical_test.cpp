// Against quadrature, against its own parts, and chi-squared tests with fixed seeds and limits of 4.5
// standard deviations: were the seeds fresh, each would fail a right sampler with probability 3e-6.
#include "math/spherical.h"

#include <gtest/gtest.h>

#include <functional>
#include <vector>

#include "math/sampler.h"

namespace {

using math::DVec2;
using math::DVec3;
using math::SphericalRectangle;
using math::SphericalTriangle;

constexpr double pi = 3.141592653589793;
const DVec3 ex(1, 0, 0), ey(0, 1, 0);

// Integral of cos / d^2 over corner + [0,1] x + [0,1] y, by Gauss-Legendre of two points in each of n x n
// cells.
double by_quadrature(const DVec3& corner, const DVec3& x, const DVec3& y, bool triangle, int n) {
  const DVec3 normal = glm::dvec3(x.y * y.z - x.z * y.y, x.z * y.x - x.x * y.z, x.x * y.y - x.y * y.x);
  double sum = 0;
  const double nodes[2] = {.5 - .5 / std::sqrt(3.), .5 + .5 / std::sqrt(3.)};
  for (int j = 0; j < n; ++j)
    for (int i = 0; i < n; ++i)
      for (double t : nodes)
        for (double s : nodes) {
          // A square onto the triangle: (a, b) -> (a (1 - b), b), of Jacobian 1 - b.
          double a = (i + s) / n, b = (j + t) / n, weight = 1;
          if (triangle) weight = 1 - b, a *= weight;
          const DVec3 p = corner + a * x + b * y;
          const double d2 = p.x * p.x + p.y * p.y + p.z * p.z;
          sum += weight * std::fabs(p.x * normal.x + p.y * normal.y + p.z * normal.z) / (d2 * std::sqrt(d2));
        }
  return sum / (4. * n * n);
}

TEST(Spherical, faces_of_a_cube_and_an_octahedron_share_the_sphere) {
  EXPECT_NEAR(SphericalRectangle({-1, -1, -1}, ex, ey, 2, 2).solid_angle(), 4 * pi / 6, 1e-14);
  EXPECT_NEAR(SphericalTriangle({1, 0, 0}, {0, 1, 0}, {0, 0, 1}).solid_angle(), 4 * pi / 8, 1e-14);
}

TEST(Spherical, solid_angles_equal_quadrature) {
  for (const DVec3& corner : {DVec3(-.3, -.4, 1), DVec3(2, 1, .5), DVec3(-5, .1, -3), DVec3(.01, -.3, 20)}) {
    const double width = 1.3, height = .7;
    EXPECT_NEAR(SphericalRectangle(corner, ex, ey, width, height).solid_angle() /
                    by_quadrature(corner, width * ex, height * ey, false, 200),
                1, 1e-9);
    const DVec3 x(1, .2, -.1), y(-.3, .8, .2);
    EXPECT_NEAR(SphericalTriangle(corner, corner + x, corner + y).solid_angle() /
                    by_quadrature(corner, x, y, true, 200),
                1, 1e-9);
  }
}

// From a ten-millionth of its size away, where it fills the view, to where it is a dot.
TEST(Spherical, parts_sum_to_the_whole_from_any_distance) {
  for (double z = 1e-7; z < 2e4; z *= 10)
    for (const DVec2& at : {DVec2(-.3, -.4), DVec2(.2, 1), DVec2(-1.5, -3)}) {
      const DVec3 corner(at.x, at.y, z);
      const SphericalRectangle whole(corner, ex, ey, 1, 2);
      double sum = 0;
      for (int i = 0; i < 4; ++i)
        for (int j = 0; j < 4; ++j)
          sum += SphericalRectangle(corner + ex * (i * .25) + ey * (j * .5), ex, ey, .25, .5).solid_angle();
      EXPECT_NEAR(sum / whole.solid_angle(), 1, 1e-6) << z;
      const DVec3 x = corner + ex, y = corner + 2. * ey;
      EXPECT_NEAR((SphericalTriangle(corner, x, y).solid_angle() +
                   SphericalTriangle(x + 2. * ey, y, x).solid_angle()) /
                      whole.solid_angle(),
                  1, 1e-6)
          << z;
    }
}

// Deviations of counts from n times the expected shares (Wilson & Hilferty 1931); cells below 5 are pooled.
double deviations(const std::vector<double>& count, const std::vector<double>& share, double n) {
  double sum = 0, few_count = 0, few = 0;
  double cells = 0;
  for (size_t i = 0; i < count.size(); ++i) {
    if (share[i] * n < 5)
      few_count += count[i], few += share[i] * n;
    else
      sum += (count[i] - share[i] * n) * (count[i] - share[i] * n) / (share[i] * n), ++cells;
  }
  if (few > 5) sum += (few_count - few) * (few_count - few) / few, ++cells;
  const double k = cells - 1;
  return (std::cbrt(sum / k) - (1 - 2 / (9 * k))) / std::sqrt(2 / (9 * k));
}

constexpr int draws = 200000, side = 12;
math::Vec4 random(int i) {
  return math::Sampler(math::Sampler::Kind::random, 5, 0, 0, 0, static_cast<std::uint32_t>(i)).get(0);
}

TEST(Spherical, a_cell_of_a_rectangle_is_drawn_as_often_as_its_solid_angle_says) {
  for (const DVec3& corner :
       {DVec3(-.3, -.4, .05), DVec3(.5, .2, -.3), DVec3(-.5, -1, 2), DVec3(-8, 3, -.9)}) {
    const double width = 1, height = 2;
    const SphericalRectangle whole(corner, ex, ey, width, height);
    std::vector<double> count(side * side), share;
    for (int j = 0; j < side; ++j)
      for (int i = 0; i < side; ++i)
        share.push_back(SphericalRectangle(corner + ex * (width * i / side) + ey * (height * j / side), ex,
                                           ey, width / side, height / side)
                            .solid_angle() /
                        whole.solid_angle());
    for (int i = 0; i < draws; ++i) {
      const math::Vec4 u = random(i);
      const DVec2 p = whole.sample(u.x, u.y);
      ASSERT_TRUE(p.x >= 0 && p.x <= 1 && p.y >= 0 && p.y <= 1);
      const int a = std::min(static_cast<int>(p.x * side), side - 1),
                b = std::min(static_cast<int>(p.y * side), side - 1);
      ++count[static_cast<size_t>(b * side + a)];
    }
    EXPECT_LT(std::fabs(deviations(count, share, draws)), 4.5) << corner.z;
  }
}

TEST(Spherical, a_cell_of_a_triangle_is_drawn_as_often_as_its_solid_angle_says) {
  const DVec3 x(1, .2, -.1), y(-.3, .8, .4);
  for (const DVec3& corner :
       {DVec3(-.3, -.4, .25), DVec3(.5, .2, -.3), DVec3(-.5, -1, 2), DVec3(-8, 3, -.9)}) {
    const SphericalTriangle whole(corner, corner + x, corner + y);
    std::vector<double> count(2 * side * side), share(2 * side * side);
    for (int j = 0; j < side; ++j)
      for (int i = 0; i + j < side; ++i) {
        const auto at = [&](int a, int b) {
          return corner + x * (double(a) / side) + y * (double(b) / side);
        };
        const auto cell = static_cast<size_t>(2 * (j * side + i));
        share[cell] =
            SphericalTriangle(at(i, j), at(i + 1, j), at(i, j + 1)).solid_angle() / whole.solid_angle();
        if (i + j + 1 < side)
          share[cell + 1] = SphericalTriangle(at(i + 1, j + 1), at(i, j + 1), at(i + 1, j)).solid_angle() /
                            whole.solid_angle();
      }
    for (int i = 0; i < draws; ++i) {
      const math::Vec4 u = random(i);
      const DVec3 p = whole.sample(u.x, u.y);
      ASSERT_TRUE(p.x >= 0 && p.y >= 0 && p.z >= 0 && std::fabs(p.x + p.y + p.z - 1) < 1e-12);
      const double a = p.y * side, b = p.z * side;
      const int c = std::min(static_cast<int>(a), side - 1), d = std::min(static_cast<int>(b), side - 1 - c);
      ++count[static_cast<size_t>(2 * (d * side + c) + ((a - c) + (b - d) > 1 && c + d + 1 < side ? 1 : 0))];
    }
    EXPECT_LT(std::fabs(deviations(count, share, draws)), 4.5) << corner.z;
  }
}

TEST(Spherical, no_number_and_no_distance_gives_a_point_outside) {
  for (double z : {1e-30, 1e-9, 1e-3, 1., 1e4, 1e12})
    for (const DVec2& at : {DVec2(-.3, -.4), DVec2(0, 0), DVec2(0, 1), DVec2(-1.5, -3), DVec2(1e6, 1)})
      for (double u : {0., 1e-9, .5, .999999, 1 - 0x1p-24})
        for (double v : {0., 1e-9, .5, .999999, 1 - 0x1p-24}) {
          const DVec3 corner(at.x, at.y, z);
          const DVec2 p = SphericalRectangle(corner, ex, ey, 1, 2).sample(u, v);
          EXPECT_TRUE(p.x >= 0 && p.x <= 1 && p.y >= 0 && p.y <= 1)
              << z << " " << at.x << " " << u << " " << v;
          const DVec3 b = SphericalTriangle(corner, corner + ex, corner + ey).sample(u, v);
          EXPECT_TRUE(b.x >= 0 && b.y >= 0 && b.z >= -1e-15 && b.x + b.y + b.z < 1 + 1e-12)
              << z << " " << u << " " << v;
        }
}

}  // namespace
