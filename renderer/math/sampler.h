// Stateless random numbers: a function of (pixel, replicate, sample index, group of four dimensions, seed),
// so that no thread, tile order or pass can change them.
//
// Kind sobol: the first four dimensions of Sobol's sequence (direction numbers of Joe & Kuo 2008),
// Owen-scrambled by hashing and with hashed, independently shuffled index for each group of four: Burley
// 2020, "Practical Hash-based Owen Scrambling", JCGT 9(4), with the better permutation of Vegdahl 2021,
// "Building a Better LK Hash". There is no last group. Samples 0 .. 2^n - 1 of any group are stratified: each
// dimension into 2^n intervals, dimensions 0 and 1 together into every elementary interval, (0,2); dimensions
// 2 and 3 together nearly as well. So a two-dimensional choice (a direction, a point on a light) is made with
// 0 and 1.
//
// Kind random: a hash of the same arguments.
#pragma once

#include <array>
#include <bit>
#include <cstdint>

#include "math/vec.h"

namespace math {

// A bijection of 64 bits in which every output bit depends on every input bit: the finaliser of splitmix64
// (Steele et al. 2014, constants by Stafford, variant 13).
inline constexpr std::uint64_t hash64(std::uint64_t v) {
  v = (v ^ (v >> 30)) * 0xbf58476d1ce4e5b9;
  v = (v ^ (v >> 27)) * 0x94d049bb133111eb;
  return v ^ (v >> 31);
}

// The largest float below 1 that has 24 bits: every number drawn is at most this.
inline constexpr float largest_u = 0x1.fffffep-1f;

// 32 random bits to [0, 1 - 2^-24]: the low bits are cut, never rounded up to 1.
inline float to_unit_float(std::uint32_t bits) { return static_cast<float>(bits >> 8) * 0x1p-24f; }

// Also of each of several numbers at once (detail::Four).
template <typename Bits>
constexpr Bits reverse_bits(Bits v) {
  v = ((v >> 1) & 0x55555555) | ((v & 0x55555555) << 1);
  v = ((v >> 2) & 0x33333333) | ((v & 0x33333333) << 2);
  v = ((v >> 4) & 0x0f0f0f0f) | ((v & 0x0f0f0f0f) << 4);
  v = ((v >> 8) & 0x00ff00ff) | ((v & 0x00ff00ff) << 8);
  return (v >> 16) | (v << 16);
}

namespace detail {

using Sobol4 = std::array<std::uint32_t, 4>;

// Four numbers in one register (an extension that g++ and clang share): two and a half times as fast as one
// by one.
typedef std::uint32_t Four __attribute__((vector_size(16)));
typedef float FourFloats __attribute__((vector_size(16)));
typedef std::int32_t FourSigned __attribute__((vector_size(16)));
inline FourFloats to_unit_floats(Four bits) {
  return __builtin_convertvector(std::bit_cast<FourSigned>(bits >> 8), FourFloats) * 0x1p-24f;
}
inline Four load(const Sobol4& v) { return std::bit_cast<Four>(v); }

// [k][n][d]: dimension d of the points whose index has nibble k equal to n and all others zero; index and
// value both with their bits reversed. Any point is the exclusive or of eight entries: 2 KiB, always in the
// cache.
using SobolTable = std::array<std::array<Sobol4, 16>, 8>;
constexpr SobolTable make_sobol_table() {
  // Direction numbers m_k << (32 - k), by the recurrence of each dimension's primitive polynomial.
  struct Polynomial {
    int degree;
    unsigned coefficients;
    unsigned first[3];
  };
  constexpr Polynomial polynomials[4] = {{0, 0, {}}, {1, 0, {1}}, {2, 1, {1, 3}}, {3, 1, {1, 3, 1}}};
  std::uint32_t direction[4][32] = {};
  for (int d = 0; d < 4; ++d) {
    const Polynomial& p = polynomials[d];
    for (int k = 0; k < 32; ++k) {
      std::uint32_t m = 1;  // dimension 0: van der Corput
      if (d > 0 && k < p.degree) m = p.first[k];
      if (d > 0 && k >= p.degree) {
        // In terms of v = m << (31 - k): v_k = v_{k-s} ^ (v_{k-s} >> s) ^ sum of a_i v_{k-i}.
        const std::uint32_t v = direction[d][k - p.degree];
        std::uint32_t next = v ^ (v >> p.degree);
        for (int i = 1; i < p.degree; ++i)
          if ((p.coefficients >> (p.degree - 1 - i)) & 1) next ^= direction[d][k - i];
        direction[d][k] = next;
        continue;
      }
      direction[d][k] = m << (31 - k);
    }
  }
  SobolTable table = {};
  for (int nibble = 0; nibble < 8; ++nibble)
    for (unsigned n = 0; n < 16; ++n)
      for (int bit = 0; bit < 4; ++bit)
        if ((n >> bit) & 1)
          for (int d = 0; d < 4; ++d)
            table[nibble][n][d] ^= reverse_bits(direction[d][31 - (4 * nibble + bit)]);
  return table;
}
alignas(64) inline constexpr SobolTable sobol_table = make_sobol_table();

// Owen scrambling of a number whose bits are reversed: each bit is flipped or not by a hash of the bits below
// it.
template <typename Bits>
Bits scramble_reversed(Bits v, Bits key) {
  v ^= v * 0x3d20adea;
  v += key;
  v *= (key >> 16) | 1;
  v ^= v * 0x05526c56;
  v ^= v * 0x53a22864;
  return v;
}

}  // namespace detail

// The numbers of one sample of one pixel.
class Sampler {
 public:
  enum class Kind { sobol, random };

  // x, y: pixel of the full image (not of a crop). index: of the sample within its replicate.
  Sampler(Kind kind, std::uint32_t seed, int x, int y, int replicate, std::uint32_t index) : kind_(kind) {
    const std::uint64_t pixel = static_cast<std::uint64_t>(static_cast<std::uint32_t>(x)) |
                                static_cast<std::uint64_t>(static_cast<std::uint32_t>(y)) << 32;
    key_ = hash64(pixel ^
                  hash64(seed | static_cast<std::uint64_t>(static_cast<std::uint32_t>(replicate)) << 32));
    if (kind == Kind::random)
      key_ = hash64(key_ + index);
    else
      reversed_index_ = reverse_bits(index);
  }

  // Four numbers in [0, 1 - 2^-24].
  Vec4 get(std::uint32_t group) const {
    // Hash the group to the bits that scramble it (or are the numbers themselves).
    constexpr std::uint64_t golden = 0x9e3779b97f4a7c15;
    const std::uint64_t first = key_ + (3 * static_cast<std::uint64_t>(group) + 1) * golden;
    const std::uint64_t a = hash64(first), b = hash64(first + golden);
    if (kind_ == Kind::random)
      return {to_unit_float(low(a)), to_unit_float(high(a)), to_unit_float(low(b)), to_unit_float(high(b))};
    const std::uint64_t c = hash64(first + 2 * golden);

    // Shuffle the index, look up Sobol's point, scramble it.
    const std::uint32_t index = detail::scramble_reversed(reversed_index_, low(c));
    const auto entry = [index](unsigned k) {
      return detail::load(detail::sobol_table[k][(index >> (4 * k)) & 15]);
    };
    detail::Four v =
        ((entry(0) ^ entry(1)) ^ (entry(2) ^ entry(3))) ^ ((entry(4) ^ entry(5)) ^ (entry(6) ^ entry(7)));
    v = reverse_bits(detail::scramble_reversed(v, detail::Four{low(a), high(a), low(b), high(b)}));
    const detail::FourFloats u = detail::to_unit_floats(v);
    return {u[0], u[1], u[2], u[3]};
  }

  // Hash number n of this sample, apart from all groups: for decisions that need no stratification.
  std::uint32_t bits(std::uint32_t n) const {
    return high(hash64(key_ + hash64(static_cast<std::uint64_t>(reversed_index_) << 32 | n)));
  }

 private:
  static std::uint32_t low(std::uint64_t v) { return static_cast<std::uint32_t>(v); }
  static std::uint32_t high(std::uint64_t v) { return static_cast<std::uint32_t>(v >> 32); }
  Kind kind_;
  std::uint32_t reversed_index_ = 0;
  std::uint64_t key_ = 0;
};

}  // namespace math
