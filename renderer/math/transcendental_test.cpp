#include "math/transcendental.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <vector>

namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

// n points from a to b, in equal steps or equal ratios.
std::vector<double> linear(double a, double b, int n) {
  std::vector<double> points;
  for (int i = 0; i < n; ++i) points.push_back(a + (b - a) * i / (n - 1));
  return points;
}
std::vector<double> geometric(double a, double b, int n) {
  std::vector<double> points;
  for (int i = 0; i < n; ++i) points.push_back(a * std::pow(b / a, i / (n - 1.)));
  return points;
}

// Whether no float is nearer.
bool half_ulp(float ours, double wanted) {
  const float next = std::nextafter(ours, wanted > ours ? 3e38f : -3e38f);
  return std::fabs(ours - wanted) <= std::fabs(next - wanted) * (1 + 1e-6);
}

double worst_relative_error(const std::vector<double>& points, const std::function<double(double)>& ours,
                            const std::function<long double(long double)>& reference) {
  double worst = 0;
  for (double x : points) {
    const long double wanted = reference(x);
    const double error = static_cast<double>(std::fabs(static_cast<long double>(ours(x)) - wanted));
    worst = std::max(worst, wanted == 0 ? error : error / static_cast<double>(std::fabs(wanted)));
  }
  return worst;
}

double sine(double x) {
  double s = 0, c = 0;
  math::sin_cos(x, s, c);
  return s;
}
double cosine(double x) {
  double s = 0, c = 0;
  math::sin_cos(x, s, c);
  return c;
}

}  // namespace

TEST(Transcendental, SineAndCosineAreRightToTheLastBitsUpToAMillionRadians) {
  for (const auto& points : {linear(-7, 7, 200001), linear(-1e6, 1e6, 200001), geometric(1e-30, 1, 20001),
                             geometric(-1e-30, -1, 20001)}) {
    EXPECT_LT(worst_relative_error(points, sine, [](long double x) { return std::sin(x); }), 5e-16);
    EXPECT_LT(worst_relative_error(points, cosine, [](long double x) { return std::cos(x); }), 5e-16);
  }
}

TEST(Transcendental, SineAndCosineOfHugeAnglesStayInRangeAndOfInfinityAreNaN) {
  for (double x : geometric(1e6, 1e300, 10001)) {
    EXPECT_LE(std::fabs(sine(x)), 1);
    EXPECT_LE(std::fabs(cosine(x)), 1);
  }
  for (double x : {infinity, -infinity, std::nan("")}) {
    EXPECT_TRUE(std::isnan(sine(x)));
    EXPECT_TRUE(std::isnan(cosine(x)));
  }
}

TEST(Transcendental, ExpIsRightOverItsWholeRange) {
  EXPECT_LT(worst_relative_error(
                linear(-708, 709.5, 400001), [](double x) { return math::exp(x); },
                [](long double x) { return std::exp(x); }),
            5e-16);
  EXPECT_EQ(math::exp(0.), 1);
  EXPECT_EQ(math::exp(710.), infinity);
  EXPECT_EQ(math::exp(infinity), infinity);
  EXPECT_EQ(math::exp(-709.), 0);
  EXPECT_EQ(math::exp(-infinity), 0);
  EXPECT_TRUE(std::isnan(math::exp(std::nan(""))));
}

TEST(Transcendental, Expm1AndLog1pDoNotCancelNearZero) {
  for (const auto& points :
       {linear(-20, 20, 200001), geometric(1e-300, 1, 20001), geometric(-1e-300, -.99, 20001)})
    EXPECT_LT(
        worst_relative_error(
            points, [](double x) { return math::expm1(x); }, [](long double x) { return std::expm1(x); }),
        1e-15);
  for (const auto& points :
       {linear(-.999, 20, 200001), geometric(1e-300, 1e300, 20001), geometric(-1e-300, -.99, 20001)})
    EXPECT_LT(
        worst_relative_error(
            points, [](double x) { return math::log1p(x); }, [](long double x) { return std::log1p(x); }),
        1e-15);
}

TEST(Transcendental, LogIsRightOverItsWholeRangeAndNearOne) {
  for (const auto& points :
       {geometric(2.3e-308, 1.7e308, 200001), linear(.5, 2, 200001), linear(1 - 1e-9, 1 + 1e-9, 20001)})
    EXPECT_LT(worst_relative_error(
                  points, [](double x) { return math::log(x); }, [](long double x) { return std::log(x); }),
              6e-16);
  EXPECT_EQ(math::log(1.), 0);
  EXPECT_EQ(math::log(0.), -infinity);
  EXPECT_EQ(math::log(infinity), infinity);
  EXPECT_TRUE(std::isnan(math::log(-1.)));
  EXPECT_TRUE(std::isnan(math::log(std::nan(""))));
}

TEST(Transcendental, PowIsRightWithinItsExponentsReach) {
  for (double y : {-100., -2.4, -1., -1 / 2.4, 1e-9, .25, 1 / 2.2, 1., 2., 5., 37.5, 200.})
    EXPECT_LT(worst_relative_error(
                  geometric(.05, 30, 20001), [&](double x) { return math::pow(x, y); },
                  [&](long double x) { return std::pow(x, static_cast<long double>(y)); }),
              5e-13)
        << "exponent " << y;
  EXPECT_EQ(math::pow(0., 2.), 0);
  EXPECT_EQ(math::pow(0., 0.), 1);
  EXPECT_EQ(math::pow(0., -1.), infinity);
  EXPECT_EQ(math::pow(infinity, 0.), 1);
  EXPECT_EQ(math::pow(1., 1e9), 1);
  EXPECT_TRUE(std::isnan(math::pow(-1., 2.)));
}

TEST(Transcendental, WholePowersOfTwoAreExactInFloat) {
  for (int n = -40; n <= 40; ++n) EXPECT_EQ(math::pow(2.f, static_cast<float>(n)), std::ldexp(1.f, n));
}

TEST(Transcendental, Atan2IsRightInEveryQuadrant) {
  double worst = 0;
  for (double small : {1e-300, 1e-12, 1e-3, 1.})
    for (int i = 0; i < 100000; ++i) {
      const double angle = 6.283185307179586 * (i + .3) / 100000;
      const double x = std::cos(angle), y = std::sin(angle) * small;
      const long double wanted = std::atan2(static_cast<long double>(y), static_cast<long double>(x));
      worst = std::max(worst, static_cast<double>(std::fabs((math::atan2(y, x) - wanted) / wanted)));
    }
  EXPECT_LT(worst, 6e-16);
  EXPECT_EQ(math::atan2(0., 0.), 0);
  EXPECT_EQ(math::atan2(0., 1.), 0);
  EXPECT_EQ(math::atan2(0., -1.), 3.141592653589793);
  EXPECT_EQ(math::atan2(1., 0.), 1.5707963267948966);
  EXPECT_EQ(math::atan2(-1., 0.), -1.5707963267948966);
  EXPECT_TRUE(std::isnan(math::atan2(std::nan(""), 1.)));
  EXPECT_TRUE(std::isnan(math::atan2(1., infinity)));
}

TEST(Transcendental, AcosIsRightUpToItsEndsAndClampsBeyondThem) {
  std::vector<double> points = linear(-1, 1, 200001);
  for (double d : geometric(1e-16, 1e-2, 2001)) points.insert(points.end(), {1 - d, -1 + d});
  EXPECT_LT(worst_relative_error(
                points, [](double x) { return math::acos(x); }, [](long double x) { return std::acos(x); }),
            6e-16);
  EXPECT_EQ(math::acos(1.0000001f), 0);
  EXPECT_EQ(math::acos(-1.0000001f), 3.14159265f);
  EXPECT_TRUE(std::isnan(math::acos(std::nan(""))));
}

TEST(Transcendental, FloatVersionsErrByAtMostHalfAnUlp) {
  for (int i = 1; i < 200000; ++i) {
    const float x = static_cast<float>(i) * 1e-4f, unit = static_cast<float>(i) / 200000;
    float s = 0, c = 0;
    math::sin_cos(x, s, c);
    EXPECT_TRUE(half_ulp(s, std::sin(double{x})) && half_ulp(c, std::cos(double{x}))) << x;
    EXPECT_TRUE(half_ulp(math::exp(x), std::exp(double{x}))) << x;
    EXPECT_TRUE(half_ulp(math::log(x), std::log(double{x}))) << x;
    EXPECT_TRUE(half_ulp(math::pow(x, .3f), std::pow(double{x}, double{.3f}))) << x;
    EXPECT_TRUE(half_ulp(math::acos(unit), std::acos(double{unit}))) << unit;
    EXPECT_TRUE(half_ulp(math::atan2(unit, -.3f), std::atan2(double{unit}, double{-.3f}))) << unit;
  }
}

// Its power is not pow()'s, and no worse.
TEST(Transcendental, SrgbIsDecodedToTheNearestFloat) {
  const auto curve = [](float x) { return std::pow((double{x} + .055) / 1.055, 2.4); };
  for (float x = .04046f; x <= 1; x = std::nextafter(x + 1e-6f, 2.f))
    ASSERT_TRUE(half_ulp(math::srgb_to_linear(x), curve(x))) << x;
  EXPECT_EQ(math::srgb_to_linear(1), 1);
  EXPECT_NEAR(math::srgb_to_linear(1.005f), curve(1.005f), 1e-7);  // what rounding may leave above 1
}

// The reason these functions exist: the same bits from every compiler. The number was printed by g++ 12 at
// -O2.
TEST(Transcendental, EveryCompilerGivesTheSameBits) {
  std::uint64_t hash = 0xcbf29ce484222325;
  const auto add = [&](double v) { hash = (hash ^ std::bit_cast<std::uint64_t>(v)) * 0x100000001b3; };
  for (int i = 1; i < 100000; ++i) {
    const double x = i * .00731;
    add(sine(x)), add(cosine(x)), add(math::exp(-x)), add(math::expm1(x / 1000)), add(math::log(x));
    add(math::log1p(x / 1000)), add(math::pow(x, 1.7)), add(math::atan2(x - 300, 77 - x)),
        add(math::acos(1 / (1 + x)));
  }
  EXPECT_EQ(hash, 17227006097232765344u);
}
