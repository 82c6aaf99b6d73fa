#include "metric/flip_filter.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <numbers>

#include "metric/vector_clones.h"

namespace metric {

namespace {

// A kernel from its values in double, padded with zeros to a whole number of steps.
HalfKernel padded(const std::vector<double>& weights) {
  const std::size_t pairs = weights.size() - 1;
  HalfKernel kernel((pairs + pairs_per_step - 1) / pairs_per_step * pairs_per_step + 1, 0.0f);
  std::transform(weights.begin(), weights.end(), kernel.begin(),
                 [](double w) { return static_cast<float>(w); });
  return kernel;
}

// Sum over both sides.
double sum(const std::vector<double>& weights) {
  double total = weights[0];
  for (std::size_t k = 1; k < weights.size(); ++k) total += 2 * weights[k];
  return total;
}

std::vector<double> scaled(std::vector<double> weights, double factor) {
  for (double& w : weights) w *= factor;
  return weights;
}

// exp(-pi^2 d^2 / b), d in degrees: the Fourier transform of a Gaussian sensitivity.
std::vector<double> sensitivity(double b, int radius, double pixels_per_degree) {
  std::vector<double> weights(radius + 1);
  for (int k = 0; k <= radius; ++k) {
    const double degrees = k / pixels_per_degree;
    weights[k] = std::exp(-std::numbers::pi * std::numbers::pi * degrees * degrees / b);
  }
  return weights;
}

// Passes over the rows in steps of a few pairs, so that one loop over x has its weights in registers and
// still many operations for each sum it loads and stores. `centred` works on differences to the centre pixel,
// which changes nothing in a kernel of sum 0 or 1 but its rounding: a flat image then has derivatives of
// exactly 0, and FLIP takes a square root of those.
template <int even, int odd, bool centred>
[[gnu::always_inline]] inline void run(Rows rows, const HalfKernel* const (&kernels)[even + odd],
                                       float* const (&outs)[even + odd],
                                       const float (&centre_weights)[even + odd], int n) {
  constexpr int count = even + odd;
  const int pairs = static_cast<int>(kernels[0]->size()) - 1;
  const float* const centre = rows[0];
  for (int i = 0; i < count; ++i) {
    float* const out = outs[i];
    const float w = centre_weights[i];
#pragma omp simd
    for (int x = 0; x < n; ++x) out[x] = w * centre[x];
  }
  for (int first = 1; first <= pairs; first += pairs_per_step) {
    const float *minus[pairs_per_step], *plus[pairs_per_step];
    float w[count][pairs_per_step];
    for (int j = 0; j < pairs_per_step; ++j) {
      minus[j] = rows[-(first + j)];
      plus[j] = rows[first + j];
      for (int i = 0; i < count; ++i) w[i][j] = (*kernels[i])[first + j];
    }
    float* out[count];
    for (int i = 0; i < count; ++i) out[i] = outs[i];
#pragma omp simd
    for (int x = 0; x < n; ++x) {
      float sums[count];
      for (int i = 0; i < count; ++i) sums[i] = out[i][x];
      const float twice = centred ? 2 * centre[x] : 0;
      for (int j = 0; j < pairs_per_step; ++j) {
        const float m = minus[j][x], p = plus[j][x];
        float both = m + p;
        if (centred) both -= twice;
        for (int i = 0; i < even; ++i) sums[i] += w[i][j] * both;
        for (int i = even; i < count; ++i) sums[i] += w[i][j] * (p - m);
      }
      for (int i = 0; i < count; ++i) out[i][x] = sums[i];
    }
  }
}

}  // namespace

FlipKernels::FlipKernels(double pixels_per_degree) {
  constexpr double pi = std::numbers::pi;

  // Contrast sensitivity: A (1, 0.0047), RG (1, 0.0053), BY (34.1, 0.04) + (13.5, 0.025) as (a, b) of
  // a sqrt(pi/b) exp(-pi^2 d^2 / b); one radius for all, 3 standard deviations of the widest.
  const int csf_radius = static_cast<int>(std::ceil(3 * std::sqrt(0.04 / (2 * pi * pi)) * pixels_per_degree));
  const std::vector<double> wa = sensitivity(0.0047, csf_radius, pixels_per_degree);
  const std::vector<double> wrg = sensitivity(0.0053, csf_radius, pixels_per_degree);
  a = padded(scaled(wa, 1 / sum(wa)));
  rg = padded(scaled(wrg, 1 / sum(wrg)));
  const std::vector<double> w1 =
      scaled(sensitivity(0.04, csf_radius, pixels_per_degree), std::sqrt(34.1 * std::sqrt(pi / 0.04)));
  const std::vector<double> w2 =
      scaled(sensitivity(0.025, csf_radius, pixels_per_degree), std::sqrt(13.5 * std::sqrt(pi / 0.025)));
  const double both = std::hypot(sum(w1), sum(w2));
  by1 = padded(scaled(w1, 1 / both));
  by2 = padded(scaled(w2, 1 / both));

  // Feature detection: Gaussian of 0.041 degrees, its derivatives normalised so that positive and negative
  // weights sum to 1 and -1 each.
  const double sigma = 0.5 * 0.082 * pixels_per_degree;
  const int feature_radius = static_cast<int>(std::ceil(3 * sigma));
  std::vector<double> wg(feature_radius + 1), wedge(feature_radius + 1), wpoint(feature_radius + 1);
  double edge_sum = 0, positive = 0, negative = 0;
  for (int k = 0; k <= feature_radius; ++k) {
    const double gauss = std::exp(-k * k / (2 * sigma * sigma));
    wg[k] = gauss;
    wedge[k] = -k * gauss;
    wpoint[k] = (k * k / (sigma * sigma) - 1) * gauss;
    const int sides = k == 0 ? 1 : 2;
    edge_sum += k * gauss;
    (wpoint[k] > 0 ? positive : negative) += sides * std::abs(wpoint[k]);
  }
  for (double& w : wpoint) w /= w > 0 ? positive : negative;
  g = padded(scaled(wg, 1 / sum(wg)));
  edge = padded(edge_sum > 0 ? scaled(wedge, 1 / edge_sum) : wedge);
  point = padded(wpoint);

  // Kernels that share rows share their length.
  radius = std::max(csf_radius, feature_radius);
  const std::size_t longest = std::max(a.size(), g.size());
  for (HalfKernel* kernel : {&a, &g, &edge, &point}) kernel->resize(longest, 0.0f);
}

METRIC_VECTOR_CLONES void filter(Rows rows, const HalfKernel& kernel, float* out, int n) {
  run<1, 0, false>(rows, {&kernel}, {out}, {kernel[0]}, n);
}

METRIC_VECTOR_CLONES void filter_two(Rows rows, const HalfKernel& k0, const HalfKernel& k1, float* out0,
                                     float* out1, int n) {
  run<2, 0, false>(rows, {&k0, &k1}, {out0, out1}, {k0[0], k1[0]}, n);
}

METRIC_VECTOR_CLONES void filter_derivatives(Rows rows, const HalfKernel& even, const HalfKernel& odd,
                                             float* out_even, float* out_odd, int n) {
  run<1, 1, true>(rows, {&even, &odd}, {out_even, out_odd}, {0, 0}, n);
}

METRIC_VECTOR_CLONES void filter_luminance(Rows rows, const HalfKernel& k0, const HalfKernel& k1,
                                           const HalfKernel& even, const HalfKernel& odd, float* out0,
                                           float* out1, float* out_even, float* out_odd, int n) {
  run<3, 1, true>(rows, {&k0, &k1, &even, &odd}, {out0, out1, out_even, out_odd}, {1, 1, 0, 0}, n);
}

}  // namespace metric
