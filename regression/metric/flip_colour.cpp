#include "metric/flip_colour.h"

#include <bit>
#include <cmath>
#include <cstdint>

#include "metric/vector_clones.h"

namespace metric {

namespace {

// log2 of a normal positive number: exponent, and atanh series of the mantissa in [sqrt(1/2), sqrt(2)).
[[gnu::always_inline]] inline float log2_fast(float x) {
  const std::int32_t bits = std::bit_cast<std::int32_t>(x);
  const std::int32_t shifted = bits - 0x3f3504f3;
  const std::int32_t exponent = shifted >> 23;
  const float m = std::bit_cast<float>((shifted & 0x007fffff) + 0x3f3504f3);
  const float s = (m - 1) / (m + 1), s2 = s * s;
  const float series =
      2.88539008f + s2 * (0.961796694f + s2 * (0.577078016f + s2 * (0.412198583f + s2 * 0.320598898f)));
  return static_cast<float>(exponent) + s * series;
}

// 2^y for y in [-126, 127]: Taylor series of the fraction in [-1/2, 1/2].
[[gnu::always_inline]] inline float exp2_fast(float y) {
  constexpr float round = 12582912;  // 1.5 * 2^23: adding it leaves the nearest integer in the low bits
  const float shifted = y + round;
  const float f = y - (shifted - round);
  const float series =
      1 +
      f * (0.693147181f +
           f * (0.240226507f + f * (0.0555041087f +
                                    f * (0.00961812911f +
                                         f * (0.00133335581f + f * (1.54035304e-4f + f * 1.52527338e-5f))))));
  const std::int32_t exponent = std::bit_cast<std::int32_t>(shifted) - std::bit_cast<std::int32_t>(round);
  return series * std::bit_cast<float>((exponent + 127) << 23);
}

// x^p for x >= 0 and p x-exponents within range; 0^p is 0.
[[gnu::always_inline]] inline float pow_fast(float x, float p) {
  float y = p * log2_fast(x);
  y = y < -126 ? -126 : y;
  const float power = exp2_fast(y);
  return x < 1e-30f ? 0 : power;
}

// Cube root of x in about [1e-3, 2]: a guess from the exponent, then two Halley steps, each tripling the
// digits.
[[gnu::always_inline]] inline float cbrt_fast(float x) {
  const std::int32_t bits = std::bit_cast<std::int32_t>(x);
  const auto guess = static_cast<std::int32_t>(static_cast<float>(bits) * (1 / 3.0f)) + 709921077;
  float y = std::bit_cast<float>(guess);
  for (int step = 0; step < 2; ++step) {
    const float y3 = y * y * y;
    y = y * (y3 + 2 * x) / (2 * y3 + x);
  }
  return y;
}

[[gnu::always_inline]] inline float clamp01(float v) {
  v = v > 0 ? v : 0;
  return v < 1 ? v : 1;
}

// Linear Rec.709 to XYZ as exact fractions, and the white they imply.
constexpr double x_r = 10135552.0 / 24577794, x_g = 8788810.0 / 24577794, x_b = 4435075.0 / 24577794;
constexpr double y_r = 2613072.0 / 12288897, y_g = 8788810.0 / 12288897, y_b = 887015.0 / 12288897;
constexpr double z_r = 1425312.0 / 73733382, z_g = 8788810.0 / 73733382, z_b = 70074185.0 / 73733382;
constexpr double white_x = x_r + x_g + x_b, white_z = z_r + z_g + z_b;

struct Matrix {
  double m[3][3];
};

// Rows divided by white: (1,1,1) goes to (1,1,1).
constexpr Matrix relative_xyz{{{x_r / white_x, x_g / white_x, x_b / white_x},
                               {y_r, y_g, y_b},
                               {z_r / white_z, z_g / white_z, z_b / white_z}}};

constexpr Matrix inverse(const Matrix& a) {
  Matrix r{};
  double determinant = 0;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) {
      const int j1 = (j + 1) % 3, j2 = (j + 2) % 3, i1 = (i + 1) % 3, i2 = (i + 2) % 3;
      r.m[j][i] = a.m[i1][j1] * a.m[i2][j2] - a.m[i1][j2] * a.m[i2][j1];
    }
  for (int j = 0; j < 3; ++j) determinant += a.m[0][j] * r.m[j][0];
  for (auto& row : r.m)
    for (double& v : row) v /= determinant;
  return r;
}

constexpr Matrix from_relative_xyz = inverse(relative_xyz);

struct MatrixF {
  float m[3][3];
};

constexpr MatrixF to_float(const Matrix& a) {
  MatrixF r{};
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) r.m[i][j] = static_cast<float>(a.m[i][j]);
  return r;
}

constexpr MatrixF to_xyz = to_float(relative_xyz), from_xyz = to_float(from_relative_xyz);

// CIELab's response: cube root, and its tangent-like line below (6/29)^3.
[[gnu::always_inline]] inline float lab_response(float t) {
  constexpr float delta = 6.0f / 29;
  const float line = t * (1 / (3 * delta * delta)) + 4.0f / 29;
  const float root = cbrt_fast(t < 1e-3f ? 1e-3f : t);
  return t > delta * delta * delta ? root : line;
}

// Exponent of the colour difference, and the largest one there is: green against blue, in double precision.
constexpr double exponent = 0.7;

double largest_difference() {
  double lab[2][3];
  for (int i = 0; i < 2; ++i) {
    double f[3];
    for (int j = 0; j < 3; ++j) {
      const double t = relative_xyz.m[j][1 + i], delta = 6.0 / 29;
      f[j] = t > delta * delta * delta ? std::cbrt(t) : t / (3 * delta * delta) + 4.0 / 29;
    }
    lab[i][0] = 116 * f[1] - 16;
    lab[i][1] = 0.01 * lab[i][0] * 500 * (f[0] - f[1]);
    lab[i][2] = 0.01 * lab[i][0] * 200 * (f[1] - f[2]);
  }
  const double hyab =
      std::abs(lab[0][0] - lab[1][0]) + std::hypot(lab[0][1] - lab[1][1], lab[0][2] - lab[1][2]);
  return std::pow(hyab, exponent);
}

// y(x) = (k0 x^2 + k1 x + k2) / (k3 x^2 + k4 x + k5)
struct Curve {
  double k0, k1, k2, k3, k4, k5;
};

Curve curve_of(ToneMapper tone_mapper) {
  switch (tone_mapper) {
    case ToneMapper::aces:  // Narkowicz' fit of ACES, 0.6 times the input folded in
      return {0.6 * 0.6 * 2.51, 0.6 * 0.03, 0, 0.6 * 0.6 * 2.43, 0.6 * 0.59, 0.14};
    case ToneMapper::hable:
      return {0.231683, 0.013791, 0, 0.18, 0.3, 0.018};
    case ToneMapper::reinhard:  // of a grey pixel
      break;
  }
  return {0, 1, 0, 0, 1, 1};
}

// All these curves are flat far below this, and its square is finite.
constexpr float brightest = 1e9f;

}  // namespace

METRIC_VECTOR_CLONES void clamp01(Planes3 rgb, int n) {
  for (float* p : {rgb.r, rgb.g, rgb.b}) {
#pragma omp simd
    for (int x = 0; x < n; ++x) p[x] = clamp01(p[x]);
  }
}

METRIC_VECTOR_CLONES void decode_srgb(Planes3 rgb, int n) {
  for (float* p : {rgb.r, rgb.g, rgb.b}) {
#pragma omp simd
    for (int x = 0; x < n; ++x) {
      const float s = p[x];
      const float power = pow_fast((s + 0.055f) * (1 / 1.055f), 2.4f);
      p[x] = s <= 0.04045f ? s * (1 / 12.92f) : power;
    }
  }
}

METRIC_VECTOR_CLONES void tone_map_rows(Planes3 rgb, ToneMapper tone_mapper, float gain, int n) {
  if (tone_mapper == ToneMapper::reinhard) {
#pragma omp simd
    for (int x = 0; x < n; ++x) {
      float r = rgb.r[x] * gain, g = rgb.g[x] * gain, b = rgb.b[x] * gain;
      r = r < brightest ? r : brightest;
      g = g < brightest ? g : brightest;
      b = b < brightest ? b : brightest;
      const float scale = 1 / (1 + (0.2126f * r + 0.7152f * g + 0.0722f * b));
      rgb.r[x] = clamp01(r * scale);
      rgb.g[x] = clamp01(g * scale);
      rgb.b[x] = clamp01(b * scale);
    }
    return;
  }
  const Curve c = curve_of(tone_mapper);
  const auto k0 = static_cast<float>(c.k0), k1 = static_cast<float>(c.k1), k3 = static_cast<float>(c.k3),
             k4 = static_cast<float>(c.k4), k5 = static_cast<float>(c.k5);
  for (float* p : {rgb.r, rgb.g, rgb.b}) {
#pragma omp simd
    for (int x = 0; x < n; ++x) {
      float v = p[x] * gain;
      v = v < brightest ? v : brightest;
      p[x] = clamp01((k0 * v + k1) * v / ((k3 * v + k4) * v + k5));
    }
  }
}

double tone_mapper_target(ToneMapper tone_mapper) {
  const Curve c = curve_of(tone_mapper);
  constexpr double level = 0.85;
  const double a = c.k0 - level * c.k3, b = c.k1 - level * c.k4, d = c.k2 - level * c.k5;
  return a == 0 ? -d / b : (-b + std::sqrt(b * b - 4 * a * d)) / (2 * a);
}

METRIC_VECTOR_CLONES void to_opponent(Planes3 rgb, int n) {
  constexpr MatrixF m = to_xyz;
#pragma omp simd
  for (int i = 0; i < n; ++i) {
    const float r = rgb.r[i], g = rgb.g[i], b = rgb.b[i];
    const float x = m.m[0][0] * r + m.m[0][1] * g + m.m[0][2] * b;
    const float y = m.m[1][0] * r + m.m[1][1] * g + m.m[1][2] * b;
    const float z = m.m[2][0] * r + m.m[2][1] * g + m.m[2][2] * b;
    rgb.r[i] = y;
    rgb.g[i] = x - y;
    rgb.b[i] = y - z;
  }
}

METRIC_VECTOR_CLONES void opponent_to_hunt_lab(Planes3 opponent, int n) {
  constexpr MatrixF m = to_xyz, inv = from_xyz;
#pragma omp simd
  for (int i = 0; i < n; ++i) {
    const float oy = opponent.r[i], ox = opponent.g[i] + oy, oz = oy - opponent.b[i];
    const float r = clamp01(inv.m[0][0] * ox + inv.m[0][1] * oy + inv.m[0][2] * oz);
    const float g = clamp01(inv.m[1][0] * ox + inv.m[1][1] * oy + inv.m[1][2] * oz);
    const float b = clamp01(inv.m[2][0] * ox + inv.m[2][1] * oy + inv.m[2][2] * oz);
    const float fx = lab_response(m.m[0][0] * r + m.m[0][1] * g + m.m[0][2] * b);
    const float fy = lab_response(m.m[1][0] * r + m.m[1][1] * g + m.m[1][2] * b);
    const float fz = lab_response(m.m[2][0] * r + m.m[2][1] * g + m.m[2][2] * b);
    const float lightness = 116 * fy - 16;
    opponent.r[i] = lightness;
    opponent.g[i] = 5 * lightness * (fx - fy);
    opponent.b[i] = 2 * lightness * (fy - fz);
  }
}

METRIC_VECTOR_CLONES void add(const float* from, float* to, int n) {
#pragma omp simd
  for (int i = 0; i < n; ++i) to[i] += from[i];
}

METRIC_VECTOR_CLONES void magnitude(const float* x, const float* y, float* out, int n) {
#pragma omp simd
  for (int i = 0; i < n; ++i) out[i] = std::sqrt(x[i] * x[i] + y[i] * y[i]);
}

METRIC_VECTOR_CLONES void colour_difference(Planes3 reference, Planes3 test, float* out, int n) {
  // Most of [0,1] goes to the smaller differences: 0.95 at 40 % of the largest.
  static const double largest = largest_difference();
  const auto knee = static_cast<float>(0.4 * largest);
  const auto below = static_cast<float>(0.95 / (0.4 * largest)),
             above = static_cast<float>(0.05 / (0.6 * largest));
#pragma omp simd
  for (int i = 0; i < n; ++i) {
    const float dl = reference.r[i] - test.r[i], da = reference.g[i] - test.g[i],
                db = reference.b[i] - test.b[i];
    const float e = pow_fast(std::abs(dl) + std::sqrt(da * da + db * db), static_cast<float>(exponent));
    out[i] = e < knee ? e * below : 0.95f + (e - knee) * above;
  }
}

METRIC_VECTOR_CLONES void combine(const float* edge_reference, const float* edge_test,
                                  const float* point_reference, const float* point_test, float* error,
                                  int n) {
#pragma omp simd
  for (int i = 0; i < n; ++i) {
    const float edge = std::abs(edge_reference[i] - edge_test[i]);
    const float point = std::abs(point_reference[i] - point_test[i]);
    const float feature = std::sqrt((edge > point ? edge : point) * 0.707106781f);
    error[i] = clamp01(pow_fast(error[i], 1 - feature));
  }
}

}  // namespace metric
