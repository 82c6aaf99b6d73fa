// Arithmetic on four numbers in one register, the same with g++ and clang (an extension that both have).
#pragma once

#include <emmintrin.h>

#include <cstdint>

#include "math/vec.h"

namespace math {

typedef float Lanes __attribute__((vector_size(16)));
typedef std::int32_t Mask __attribute__((vector_size(16)));
typedef std::uint32_t Bits __attribute__((vector_size(16)));

inline Lanes all(float v) { return Lanes{v, v, v, v}; }
inline Lanes load(const Vec4& v) { return _mm_loadu_ps(&v.x); }
inline Lanes load(const U16Vec4& v) {
  const __m128i codes = _mm_loadl_epi64(reinterpret_cast<const __m128i*>(&v));
  return _mm_cvtepi32_ps(_mm_unpacklo_epi16(codes, _mm_setzero_si128()));
}

// Between four values by the fractions a (to the right) and b (downwards).
inline Lanes bilinear(Lanes left, Lanes right, Lanes low_left, Lanes low_right, float a, float b) {
  const Lanes a1 = all(a), a0 = all(1 - a);
  return (left * a0 + right * a1) * all(1 - b) + (low_left * a0 + low_right * a1) * all(b);
}

// The largest integer not above x, for |x| < 2^31: in registers, which a call of std::floor is not.
inline int floor_to_int(float x) {
  const int i = static_cast<int>(x);
  return i - (static_cast<float>(i) > x ? 1 : 0);
}

}  // namespace math
