#include "math/warp.h"

namespace math {

namespace {
// Harris 1978, the four-term window of -92 dB.
constexpr double a0 = .35875, a1 = .48829, a2 = .14128, a3 = .01168;
}  // namespace

double BlackmanHarris::pdf(double x) {
  if (!(std::fabs(x) < radius)) return 0;
  // The window is a sum of cosines of multiples of one angle, and its mean over the support is a0.
  double s = 0, c = 0;
  sin_cos(3.141592653589793 * x / radius, s, c);
  const double c2 = 2 * c * c - 1, c3 = c * (4 * c * c - 3);
  return (a0 + a1 * c + a2 * c2 + a3 * c3) / (2 * radius * a0);
}

double BlackmanHarris::cdf(double x) {
  if (x <= -radius) return 0;
  if (x >= radius) return 1;
  const double angle = 3.141592653589793 * x / radius;
  double s = 0, c = 0;
  sin_cos(angle, s, c);
  const double s2 = 2 * s * c, s3 = s * (3 - 4 * s * s);
  return .5 + (a0 * angle + a1 * s + a2 * s2 / 2 + a3 * s3 / 3) / (2 * 3.141592653589793 * a0);
}

BlackmanHarris::BlackmanHarris() {
  for (int i = 0; i <= intervals; ++i) {
    // Bisect: the function is monotone and this runs once.
    const double tail = sqr(static_cast<double>(i) / intervals) / 2;
    double low = 0, high = radius;
    for (int step = 0; step < 60; ++step) {
      const double x = (low + high) / 2;
      (1 - cdf(x) > tail ? low : high) = x;
    }
    inverse_[i] = static_cast<float>((low + high) / 2);
  }
}

}  // namespace math
