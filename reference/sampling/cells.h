// Cells of directions in half-vector space, and integrals over them.
//
// A lobe of alpha = .001 is .06 degrees wide: no grid of directions resolves it. So wi is binned by its half
// vector's slopes, divided by the lobe's alphas, in polar coordinates:
//
//   wh = (s_x rho cos psi, s_y rho sin psi, 1) / |...|,  dwi = 4 (wo.wh) dwh,
//   dwh = s_x s_y cos^3(wh) rho drho dpsi
//
// The edges in rho are quantiles of a mixture of curves t / (t + scale), t = rho^2, with a scale for each
// lobe and one per decade between them. The cells know where lobes are, not what any pdf says of them: the
// expected content of a cell is always an integral of the density under test.
//
// Directions below the horizon are no part of any cell: for each psi the horizon is at a rho that solves a
// quadratic equation, and integration stops there. So the integrand has no jumps.
#pragma once

#include <vector>

#include "sampling/subject.h"

namespace sampling {

class Cells {
 public:
  static constexpr int radial = 28, angular = 24, count = radial * angular;

  Cells(const Bsdf& b, const Vec3& wo);

  // The cell of wi, wi.z > 0.
  int of(const Vec3& wi) const;

  // Integral over each cell of g(wi) dwi. Gauss-Legendre with 5 x 5 against 8 x 8 nodes; where these differ
  // by more than 2e-4 of the cell and 1e-8 of the whole, the cell is quartered, up to 7 times.
  std::vector<double> integrate(const std::function<double(const Vec3& wi)>& g) const;

 private:
  using Integrand = std::function<double(const Vec3& wi)>;
  double horizon(double psi) const;  // asinh(rho) where wi.z = 0
  Vec3 wi_of(double q, double psi, double& measure) const;
  template <int n>
  double gauss(const Integrand& g, double q0, double q1, double psi0, double psi1) const;
  double adaptive(const Integrand& g, double q0, double q1, double psi0, double psi1, double floor,
                  int depth) const;

  double o_[3];       // wo, of unit length
  double sx_, sy_;    // scale of the slopes
  double t_[radial];  // upper edges, rho^2; the last is infinite
};

}  // namespace sampling
