// The per-pixel arithmetic of FLIP, over rows of samples in separate arrays. Plain loops without calls, so
// that the compiler turns them into vector code; powers and cube roots are therefore our own (relative error
// below 1e-6), which also makes the maps independent of the C library.
//
// FLIP's opponent space YCxCz is an affine map of (Y, X/Xn - Y, Y - Z/Zn), X Y Z being relative to white;
// filters of sum 1 commute with it, so we filter the latter, and its first component is already what feature
// detection wants.
#pragma once

#include "metric/flip.h"

namespace metric {

struct Planes3 {
  float *r, *g, *b;  // or any other three
};

// Cuts to [0,1]; NaN becomes 0.
void clamp01(Planes3 rgb, int n);
// IEC 61966-2-1, of values already cut.
void decode_srgb(Planes3 rgb, int n);
// Times 2^exposure, tone mapped, cut to [0,1]. Values must be finite and not negative.
void tone_map_rows(Planes3 rgb, ToneMapper tone_mapper, float gain, int n);
// Linear light to (Y, X/Xn - Y, Y - Z/Zn), in place.
void to_opponent(Planes3 rgb, int n);
// Back to linear light, cut to [0,1], CIELab with the Hunt effect: L, 0.01 L a, 0.01 L b; in place.
void opponent_to_hunt_lab(Planes3 opponent, int n);
// to += from
void add(const float* from, float* to, int n);
// out = sqrt(x^2 + y^2)
void magnitude(const float* x, const float* y, float* out, int n);
// Colour difference in [0,1] of two rows of Hunt-adjusted Lab.
void colour_difference(Planes3 reference, Planes3 test, float* out, int n);
// FLIP: colour^(1 - feature difference); edges and points are magnitudes. `error` holds the colour difference
// and receives the result.
void combine(const float* edge_reference, const float* edge_test, const float* point_reference,
             const float* point_test, float* error, int n);

// x with tone mapper(x) = 0.85 on grey, the level automatic exposures aim at.
double tone_mapper_target(ToneMapper tone_mapper);

}  // namespace metric
