#include "sampling/cells.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace sampling {
namespace {

constexpr double pi = std::numbers::pi;

// Gauss-Legendre nodes on [0,1] by Newton's method on the polynomial.
template <int n>
struct Gauss {
  double x[n], w[n];
  Gauss() {
    for (int i = 0; i < n; ++i) {
      double z = std::cos(pi * (i + .75) / (n + .5)), slope = 1;
      for (int k = 0; k < 50; ++k) {
        double p0 = 1, p1 = z;
        for (int j = 2; j <= n; ++j) {
          const double p2 = ((2 * j - 1) * z * p1 - (j - 1) * p0) / j;
          p0 = p1;
          p1 = p2;
        }
        slope = n * (z * p1 - p0) / (z * z - 1);
        z -= p1 / slope;
      }
      x[i] = (1 - z) / 2;
      w[i] = 1 / ((1 - z * z) * slope * slope);
    }
  }
};
template <int n>
const Gauss<n>& rule() {
  static const Gauss<n> r;
  return r;
}

}  // namespace

Cells::Cells(const Bsdf& b, const Vec3& wo) {
  const double x = wo.x, y = wo.y, z = wo.z, length = std::sqrt(x * x + y * y + z * z);
  o_[0] = x / length, o_[1] = y / length, o_[2] = z / length;

  const bool glossy = b.probability[1] > 0 && !b.specular.is_delta;
  const bool coated = b.probability[2] > 0 && !b.clearcoat.is_delta;
  sx_ = glossy ? b.specular.ax : coated ? b.clearcoat.alpha : 1;
  sy_ = glossy ? b.specular.ay : sx_;
  const double unit = 1 / (sx_ * sy_);  // tan^2 of 45 degrees in units of the lobe

  // Where the lobes are, and how many cells each deserves.
  struct Scale {
    double t, weight;
  };
  std::vector<Scale> scales{{unit, b.probability[0] > 0 ? 3. : 1.}};
  if (glossy) scales.push_back({b.specular.gtr ? 1 / std::max(1., b.specular.gamma - 1) : 1, 3});
  if (coated) scales.push_back({b.clearcoat.alpha * b.clearcoat.alpha * unit, 3});
  double least = unit, most = unit;
  for (const Scale& s : scales) least = std::min(least, s.t), most = std::max(most, s.t);
  for (double t = 10 * least; t < most; t *= 10) scales.push_back({t, .5});
  double sum = 0;
  for (const Scale& s : scales) sum += s.weight;

  for (int i = 0; i < radial - 1; ++i) {
    double low = std::log(least) - 20, high = std::log(most) + 20;
    for (int k = 0; k < 60; ++k) {
      const double middle = (low + high) / 2, t = std::exp(middle);
      double share = 0;
      for (const Scale& s : scales) share += s.weight / sum * t / (t + s.t);
      (share < (i + 1.) / radial ? low : high) = middle;
    }
    t_[i] = std::exp(low);
  }
  t_[radial - 1] = std::numeric_limits<double>::infinity();
}

int Cells::of(const Vec3& wi) const {
  const double x = wi.x, y = wi.y, z = wi.z, scale = 1 / std::sqrt(x * x + y * y + z * z);
  const double hz = z * scale + o_[2];
  const double a = (x * scale + o_[0]) / (hz * sx_), b = (y * scale + o_[1]) / (hz * sy_);
  const auto i = std::upper_bound(t_, t_ + radial - 1, a * a + b * b) - t_;
  const double turn = std::atan2(b, a) / (2 * pi);
  const int j = static_cast<int>((turn < 0 ? turn + 1 : turn) * angular);
  return static_cast<int>(i) * angular + std::min(j, angular - 1);
}

// wi.z > 0 is o.z + 2 rho B - o.z rho^2 A > 0, which holds from rho = 0 up to the only positive root.
double Cells::horizon(double psi) const {
  const double x = sx_ * std::cos(psi), y = sy_ * std::sin(psi);
  const double a = x * x + y * y, b = o_[0] * x + o_[1] * y;
  const double root = std::sqrt(b * b + o_[2] * o_[2] * a);
  return std::asinh(b > 0 ? (b + root) / (o_[2] * a) : o_[2] / (root - b));
}

Vec3 Cells::wi_of(double q, double psi, double& measure) const {
  const double rho = std::sinh(q);
  const double mx = sx_ * rho * std::cos(psi), my = sy_ * rho * std::sin(psi);
  const double m2 = mx * mx + my * my + 1;
  const double o_m = o_[0] * mx + o_[1] * my + o_[2];
  const double twice = 2 * o_m / m2;
  // 4 (wo.wh) cos^3(wh) s_x s_y rho drho, with drho = cosh q dq.
  measure = 4 * o_m / (m2 * m2) * sx_ * sy_ * rho * std::cosh(q);
  return {static_cast<float>(twice * mx - o_[0]), static_cast<float>(twice * my - o_[1]),
          static_cast<float>(twice - o_[2])};
}

template <int n>
double Cells::gauss(const Integrand& g, double q0, double q1, double psi0, double psi1) const {
  const Gauss<n>& r = rule<n>();
  double sum = 0;
  for (int j = 0; j < n; ++j) {
    const double psi = psi0 + (psi1 - psi0) * r.x[j];
    const double end = std::min(q1, horizon(psi));
    if (!(end > q0)) continue;
    double line = 0;
    for (int i = 0; i < n; ++i) {
      double measure = 0;
      const Vec3 wi = wi_of(q0 + (end - q0) * r.x[i], psi, measure);
      line += r.w[i] * g(wi) * measure;
    }
    sum += r.w[j] * line * (end - q0);
  }
  return sum * (psi1 - psi0);
}

double Cells::adaptive(const Integrand& g, double q0, double q1, double psi0, double psi1, double floor,
                       int depth) const {
  const double coarse = gauss<5>(g, q0, q1, psi0, psi1), fine = gauss<8>(g, q0, q1, psi0, psi1);
  if (depth == 0 || std::fabs(coarse - fine) <= floor + 2e-4 * std::fabs(fine)) return fine;
  const double q = (q0 + q1) / 2, psi = (psi0 + psi1) / 2;
  return adaptive(g, q0, q, psi0, psi, floor, depth - 1) + adaptive(g, q0, q, psi, psi1, floor, depth - 1) +
         adaptive(g, q, q1, psi0, psi, floor, depth - 1) + adaptive(g, q, q1, psi, psi1, floor, depth - 1);
}

std::vector<double> Cells::integrate(const Integrand& g) const {
  struct Box {
    double q0, q1, psi0, psi1;
  };
  std::vector<Box> boxes(count);
  double whole = 0;
  for (int j = 0; j < angular; ++j) {
    const double psi0 = 2 * pi * j / angular, psi1 = 2 * pi * (j + 1) / angular;
    // The last ring ends at the farthest horizon of this sector.
    double far = 0;
    for (int k = 0; k <= 64; ++k) far = std::max(far, horizon(psi0 + (psi1 - psi0) * k / 64));
    double q0 = 0;
    for (int i = 0; i < radial; ++i) {
      const double q1 = i == radial - 1 ? std::max(q0, far + .1) : std::asinh(std::sqrt(t_[i]));
      boxes[static_cast<std::size_t>(i * angular + j)] = {q0, q1, psi0, psi1};
      whole += gauss<5>(g, q0, q1, psi0, psi1);
      q0 = q1;
    }
  }
  std::vector<double> contents;
  for (const Box& b : boxes) contents.push_back(adaptive(g, b.q0, b.q1, b.psi0, b.psi1, 1e-8 * whole, 7));
  return contents;
}

}  // namespace sampling
