// The filters of FLIP as one-dimensional kernels, and the loop that applies them. Both of FLIP's stages are
// sums of products k(x) k(y), so each 2D filter is a pass along x and one along y: about 600 multiply-adds a
// pixel instead of 16000. Kernels are even or odd, so pixels are taken in pairs at distance k on either side
// of the centre.
#pragma once

#include <vector>

namespace metric {

// Weights of distance 0, 1, ..., pairs(); for an odd kernel those of the + side. Zero beyond the true radius,
// up to a multiple of pairs_per_step.
using HalfKernel = std::vector<float>;
inline constexpr int pairs_per_step = 5;

struct FlipKernels {
  explicit FlipKernels(double pixels_per_degree);

  int radius = 0;             // of the widest
  HalfKernel a, rg;           // contrast sensitivity, sum 1
  HalfKernel by1, by2;        // by1 x by1 + by2 x by2 sums to 1
  HalfKernel g, edge, point;  // feature detection: Gaussian (sum 1), odd first and even second derivative
};

// Row `k` of rows[-pairs .. pairs] holds what stands at distance k from the output; n samples each.
using Rows = const float* const*;

// out = even kernel over rows
void filter(Rows rows, const HalfKernel& kernel, float* out, int n);
// the same for two even kernels over the same rows
void filter_two(Rows rows, const HalfKernel& k0, const HalfKernel& k1, float* out0, float* out1, int n);
// an even kernel whose sum is 0, and an odd one
void filter_derivatives(Rows rows, const HalfKernel& even, const HalfKernel& odd, float* out_even,
                        float* out_odd, int n);
// two even kernels of sum 1, an even one whose sum is 0, and an odd one
void filter_luminance(Rows rows, const HalfKernel& k0, const HalfKernel& k1, const HalfKernel& even,
                      const HalfKernel& odd, float* out0, float* out1, float* out_even, float* out_odd,
                      int n);

}  // namespace metric
