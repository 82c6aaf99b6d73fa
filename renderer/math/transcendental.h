// Transcendental functions whose result is the same on every compiler, libc and instruction set: only IEEE
// additions, multiplications, divisions and square roots in double precision, in a fixed order (built with
// -ffp-contract=off). libm's differ in the last bit between versions, and one bit of a direction is another
// path.
//
// Call them qualified, math::exp(x), and nothing of <cmath> is meant. The double versions err by less than
// 1e-12 relative, measured 1e-15 but for pow (about 1e-16 |y log x|); the float versions are the double ones
// rounded, so they err by half an ulp.
//
// Method: argument reduction, then the Taylor series itself (no fitted coefficients), cut where the remainder
// falls below 1e-16.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>

namespace math {

namespace detail {

// Two numbers in one register (an extension that g++ and clang share).
typedef double Two __attribute__((vector_size(16)));
typedef std::uint64_t TwoBits __attribute__((vector_size(16)));

// Sine and cosine of k quarters and r, with z = r * r: each is x + x z (series in z), with x one of r, 1, -r,
// -1.
struct Quarter {
  TwoBits r, one;  // bits of r to be kept, then what is to be exclusive-ored: x, of sine and cosine
};
inline constexpr std::uint64_t minus = 1ull << 63, one = std::bit_cast<std::uint64_t>(1.);
inline constexpr Quarter quarters[4] = {{{~0ull, 0}, {0, one}},
                                        {{0, ~0ull}, {one, minus}},
                                        {{~0ull, 0}, {minus, minus | one}},
                                        {{0, ~0ull}, {minus | one, 0}}};
inline constexpr Two sine_cosine[2][8] = {{{-1. / 6, -1. / 2},
                                           {1. / 120, 1. / 24},
                                           {-1. / 5040, -1. / 720},
                                           {1. / 362880, 1. / 40320},
                                           {-1. / 39916800, -1. / 3628800},
                                           {1. / 6227020800, 1. / 479001600},
                                           {-1. / 1307674368000, -1. / 87178291200},
                                           {0, 1. / 20922789888000}},
                                          {{-1. / 2, -1. / 6},
                                           {1. / 24, 1. / 120},
                                           {-1. / 720, -1. / 5040},
                                           {1. / 40320, 1. / 362880},
                                           {-1. / 3628800, -1. / 39916800},
                                           {1. / 479001600, 1. / 6227020800},
                                           {-1. / 87178291200, -1. / 1307674368000},
                                           {1. / 20922789888000, 0}}};

}  // namespace detail

// Sine and cosine. Full accuracy for |angle| up to 1e6; beyond, the phase is lost as the angle's own last
// bits are (results stay in [-1,1]). Non-finite: NaN.
inline void sin_cos(double angle, double& s, double& c) {
  using detail::Two;
  if (!(std::fabs(angle) <= 1e6)) angle = std::fmod(angle, 6.283185307179586);
  // Subtract the nearest multiple of pi/2, in three parts (33 + 33 + 53 bits, so that k * part is exact).
  // Adding and subtracting 1.5 * 2^52 rounds to an integer, which the low bits of the sum are.
  const double sum = angle * 0.6366197723675814 + 0x1.8p52, k = sum - 0x1.8p52;
  const double r = ((angle - k * 0x1.921fb544p0) - k * 0x1.0b4611a6p-34) - k * 0x1.3198a2e037073p-69;
  // Both at once, and by tables what depends on the quarter: a branch nobody could predict.
  const std::uint64_t bits = std::bit_cast<std::uint64_t>(sum);
  const detail::Quarter& quarter = detail::quarters[bits & 3];
  const Two* series = detail::sine_cosine[bits & 1];
  const Two x = std::bit_cast<Two>((std::bit_cast<detail::TwoBits>(Two{r, r}) & quarter.r) ^ quarter.one);
  const Two z = Two{r, r} * Two{r, r};
  const Two both =
      x +
      x * z *
          (series[0] +
           z * (series[1] +
                z * (series[2] +
                     z * (series[3] + z * (series[4] + z * (series[5] + z * (series[6] + z * series[7])))))));
  s = both[0];
  c = both[1];
}
inline void sin_cos(float angle, float& s, float& c) {
  double ds = 0, dc = 0;
  sin_cos(static_cast<double>(angle), ds, dc);
  s = static_cast<float>(ds);
  c = static_cast<float>(dc);
}

namespace detail {

// e^r - 1 for |r| <= ln(2)/2.
inline double expm1_reduced(double r) {
  const double z = r * r;
  // Even and odd terms apart: two short dependency chains instead of a long one.
  const double even =
      1. / 2 + z * (1. / 24 + z * (1. / 720 + z * (1. / 40320 + z * (1. / 3628800 + z * (1. / 479001600)))));
  const double odd =
      1. / 6 +
      z * (1. / 120 + z * (1. / 5040 + z * (1. / 362880 + z * (1. / 39916800 + z * (1. / 6227020800)))));
  return r + z * (even + r * odd);
}

// log((1+s)/(1-s)) for |s| <= 3 - 2 sqrt(2): 2 artanh s.
inline double log_ratio(double s) {
  const double z = s * s, w = z * z;
  const double even = 1. / 3 + w * (1. / 7 + w * (1. / 11 + w * (1. / 15 + w * (1. / 19))));
  const double odd = 1. / 5 + w * (1. / 9 + w * (1. / 13 + w * (1. / 17 + w * (1. / 21))));
  return 2 * s + 2 * s * z * (even + z * odd);
}

inline constexpr double ln2_high = 0x1.62e42feep-1;  // 32 bits, so that k * ln2_high is exact
inline constexpr double ln2_low = 0x1.a39ef35793c76p-33;

}  // namespace detail

// e^x. Above 709.78 infinity, below -708.39 zero (no denormal results); NaN: NaN.
inline double exp(double x) {
  if (!(x <= 709.782712893384)) return x > 0 ? std::numeric_limits<double>::infinity() : x;
  if (x < -708.3964185322641) return 0;
  const double k = (x * 1.4426950408889634 + 0x1.8p52) - 0x1.8p52;
  const double r = (x - k * detail::ln2_high) - k * detail::ln2_low;
  // 2^k in two steps, as 2^1024 does not exist.
  const std::int64_t n = static_cast<std::int64_t>(k) - 1;
  return (1 + detail::expm1_reduced(r)) * std::bit_cast<double>(static_cast<std::uint64_t>(n + 1023) << 52) *
         2;
}
inline float exp(float x) { return static_cast<float>(exp(static_cast<double>(x))); }

// e^x - 1 without cancellation near 0.
inline double expm1(double x) { return std::fabs(x) < .3465 ? detail::expm1_reduced(x) : exp(x) - 1; }

// Natural logarithm. 0 (and denormals): minus infinity; negative or NaN: NaN.
inline double log(double x) {
  constexpr double infinity = std::numeric_limits<double>::infinity();
  if (!(x >= std::numeric_limits<double>::min()))
    return x >= 0 ? -infinity : std::numeric_limits<double>::quiet_NaN();
  if (x == infinity) return x;
  // x = 2^k m with m in [sqrt(1/2), sqrt(2)), so that k = 0 near 1 and nothing cancels.
  const std::uint64_t bits = std::bit_cast<std::uint64_t>(x);
  constexpr std::uint64_t sqrt_half = 0x3fe6a09e667f3bcd;
  const std::int64_t k = static_cast<std::int64_t>(bits - sqrt_half) >> 52;
  const double m = std::bit_cast<double>(bits - (static_cast<std::uint64_t>(k) << 52));
  const double n = static_cast<double>(k);
  return n * detail::ln2_high + (detail::log_ratio((m - 1) / (m + 1)) + n * detail::ln2_low);
}
inline float log(float x) { return static_cast<float>(log(static_cast<double>(x))); }

// log(1 + x) without cancellation near 0. Below -1: NaN.
inline double log1p(double x) { return x > -.29 && x < .41 ? detail::log_ratio(x / (2 + x)) : log(1 + x); }

// x^y for x >= 0. y = 0: 1, also for x = 0; x = 0: 0 for y > 0 and infinity for y < 0; x < 0 or NaN: NaN
// (whatever the exponent, unless it is 0).
inline double pow(double x, double y) { return y == 0 ? 1 : exp(y * log(x)); }
inline float pow(float x, float y) {
  return static_cast<float>(pow(static_cast<double>(x), static_cast<double>(y)));
}

// Angle of the point (x, y), in [-pi, pi], negative where y < 0; both zero: 0. For y = -0 and x < 0: +pi.
// Arguments finite (infinite ones: NaN).
inline double atan2(double y, double x) {
  const double ax = std::fabs(x), ay = std::fabs(y);
  const double big = std::max(ay, ax), small = std::min(ay, ax);
  if (big == 0) return 0;
  if (!(big <= std::numeric_limits<double>::max()) || y != y || x != x)
    return std::numeric_limits<double>::quiet_NaN();
  // atan(t) = atan(c) + atan((t - c) / (1 + t c)) with c the nearest eighth: |argument| <= 1/16.
  static constexpr double eighths[9][2] = {{0, 0},
                                           {.125, 0.12435499454676143503},
                                           {.25, 0.24497866312686415417},
                                           {.375, 0.35877067027057222040},
                                           {.5, 0.46364760900080611621},
                                           {.625, 0.55859931534356243598},
                                           {.75, 0.64350110879328438680},
                                           {.875, 0.71882999962162450542},
                                           {1, 0.78539816339744830962}};
  // Where |y| > |x|, pi/2 less the angle; where x < 0, pi less that; where y < 0, minus that. As sums, and
  // with signs brought to the front: branches nobody could predict.
  constexpr double quarter = 1.5707963267948966, half = 3.1415926535897932;
  static constexpr struct {
    double sign, quarter, half;
  } octants[8] = {{1, 0, 0},      {-1, quarter, 0},   {-1, -0., half}, {1, -quarter, half},
                  {-1, -0., -0.}, {1, -quarter, -0.}, {1, 0, -half},   {-1, quarter, -half}};
  const auto& octant = octants[(ay > ax ? 1 : 0) | (x < 0 ? 2 : 0) | (y < 0 ? 4 : 0)];
  const auto& [c, atan_c] = eighths[static_cast<int>(small / big * 8 + .5)];
  const double t = (octant.sign * small - c * (octant.sign * big)) / (big + c * small);
  const double z = t * t;
  const double series =
      t + t * z * (-1. / 3 + z * (1. / 5 + z * (-1. / 7 + z * (1. / 9 + z * (-1. / 11 + z * (1. / 13))))));
  return octant.half + (octant.quarter + (octant.sign * atan_c + series));
}
inline float atan2(float y, float x) {
  return static_cast<float>(atan2(static_cast<double>(y), static_cast<double>(x)));
}

// Arc cosine in [0, pi]; arguments beyond [-1,1] are clamped (a dot product of unit vectors may
// be 1.0000001).
inline double acos(double x) {
  const double square = (1 - x) * (1 + x);
  return atan2(square < 0 ? 0 : std::sqrt(square), x);
}
inline float acos(float x) { return static_cast<float>(acos(static_cast<double>(x))); }

namespace detail {

// Of the middles of 64 parts of each octave from 1/16 to 1, and of one more.
struct Power24 {
  double reciprocal, power;  // to 2.4
};
inline const std::array<Power24, 4 * 64 + 1> powers_24 = [] {
  std::array<Power24, 4 * 64 + 1> powers;
  for (std::uint64_t k = 0; k < powers.size(); ++k) {
    const double y = std::bit_cast<double>((1019 * 64 + k) << 46 | std::uint64_t{1} << 45);
    powers[k] = {1 / y, pow(y, 2.4)};
  }
  return powers;
}();

}  // namespace detail

// sRGB transfer function (IEC 61966-2-1), encoded value in [0,1] to linear. The power is that of the middle
// of y's part times (1 + d)^2.4, |d| <= 1/128, by the binomial series: it leaves 1e-15.
inline float srgb_to_linear(float encoded) {
  if (encoded <= .04045f) return encoded / 12.92f;
  const double y = (static_cast<double>(encoded) + .055) * (1 / 1.055);
  const std::uint64_t part = (std::bit_cast<std::uint64_t>(y) >> 46) - 1019 * 64;
  const detail::Power24& middle = detail::powers_24[std::min<std::uint64_t>(part, 4 * 64)];
  const double d = y * middle.reciprocal - 1;
  return static_cast<float>(middle.power *
                            (1 + d * (2.4 + d * (1.68 + d * (.224 + d * (-.0336 + d * .010752))))));
}

}  // namespace math
