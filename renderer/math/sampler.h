// Stateless random numbers: a function of (pixel, replicate, sample index, group of four dimensions, seed),
// so that no thread, tile order or pass can change them.
//
// Kind sobol: digital sequences, Owen-scrambled by hashing and with hashed, independently shuffled index for
// each group of four: Burley 2020, "Practical Hash-based Owen Scrambling", JCGT 9(4), with the better
// permutation of Vegdahl 2021, "Building a Better LK Hash". There is no last group. Samples 0 .. 2^n - 1 of
// any group are stratified: each dimension into 2^n intervals, dimensions 0 and 1 together into every
// elementary interval, (0,2); so a two-dimensional choice (a direction, a point on a light) is made with 0
// and 1. All groups but the first are Sobol's first four dimensions (direction numbers of Joe & Kuo 2008), of
// which 2 and 3 together are nearly as good. The first is for two such choices whose product is the noise: a
// (0,4)-sequence in base 4 (Niederreiter 1987, "Point sets and sequences with small discrepancy", over the
// field of four elements). Samples 0 .. 4^n - 1 of its four dimensions together fill every elementary
// interval in base 4, and dimensions 2 and 3 every one in base 2 as well.
//
// Kind random: a hash of the same arguments.
#pragma once

#ifdef __SSSE3__
#include <tmmintrin.h>
#endif

#include <array>
#include <bit>
#include <cstdint>

#include "math/lanes.h"
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

// Also of each of several numbers at once (math::Bits).
template <typename T>
constexpr T reverse_bits(T v) {
  v = ((v >> 1) & 0x55555555) | ((v & 0x55555555) << 1);
  v = ((v >> 2) & 0x33333333) | ((v & 0x33333333) << 2);
  v = ((v >> 4) & 0x0f0f0f0f) | ((v & 0x0f0f0f0f) << 4);
  v = ((v >> 8) & 0x00ff00ff) | ((v & 0x00ff00ff) << 8);
  return (v >> 16) | (v << 16);
}
#ifdef __SSSE3__
// Bytes by one shuffle, each half of a byte by another, which looks it up: a third of the instructions.
template <>
inline Bits reverse_bits(Bits v) {
  const __m128i bytes = _mm_shuffle_epi8(std::bit_cast<__m128i>(v),
                                         _mm_setr_epi8(3, 2, 1, 0, 7, 6, 5, 4, 11, 10, 9, 8, 15, 14, 13, 12));
  const __m128i reversed = _mm_setr_epi8(0, 8, 4, 12, 2, 10, 6, 14, 1, 9, 5, 13, 3, 11, 7, 15);
  const __m128i half = _mm_set1_epi8(15);
  const __m128i low = _mm_and_si128(bytes, half), high = _mm_and_si128(_mm_srli_epi16(bytes, 4), half);
  return std::bit_cast<Bits>(
      _mm_or_si128(_mm_shuffle_epi8(_mm_slli_epi16(reversed, 4), low), _mm_shuffle_epi8(reversed, high)));
}
#endif

namespace detail {

using Sobol4 = std::array<std::uint32_t, 4>;

// Four numbers in one register: two and a half times as fast as one by one.
inline Lanes to_unit_floats(Bits bits) {
  return __builtin_convertvector(std::bit_cast<Mask>(bits >> 8), Lanes) * 0x1p-24f;
}
inline Bits load(const Sobol4& v) { return std::bit_cast<Bits>(v); }

// [d][k]: what bit k of the index adds, by exclusive or, to dimension d.
using Directions = std::array<std::array<std::uint32_t, 32>, 4>;

constexpr Directions sobol_directions() {
  // Direction numbers m_k << (31 - k), by the recurrence of each dimension's primitive polynomial.
  struct Polynomial {
    int degree;
    unsigned coefficients;
    unsigned first[3];
  };
  constexpr Polynomial polynomials[4] = {{0, 0, {}}, {1, 0, {1}}, {2, 1, {1, 3}}, {3, 1, {1, 3, 1}}};
  Directions direction = {};
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
  return direction;
}

// The (0,4)-sequence in base 4. Of a field's element a the generator matrix has binom(j, i) a^(j - i) in row
// i and column j, of digits in base 4; two bits are a digit, and the field's elements 0, 1, w and w + 1 are
// matrices of 2 x 2 bits. Multiplying those of dimensions 1 and 3 by a matrix from the left keeps every
// interval in base 4 and brings those in base 2.
constexpr Directions base4_directions() {
  using Matrix = std::array<unsigned, 4>;  // by rows
  constexpr Matrix one = {1, 0, 0, 1}, w = {0, 1, 1, 1}, left = {1, 1, 0, 1};
  const auto times = [](const Matrix& a, const Matrix& b) {
    return Matrix{(a[0] & b[0]) ^ (a[1] & b[2]), (a[0] & b[1]) ^ (a[1] & b[3]), (a[2] & b[0]) ^ (a[3] & b[2]),
                  (a[2] & b[1]) ^ (a[3] & b[3])};
  };
  const std::array<Matrix, 4> elements = {Matrix{0, 0, 0, 0}, one, w, times(w, w)};
  Directions direction = {};
  for (int d = 0; d < 4; ++d)
    for (int j = 0; j < 16; ++j) {
      Matrix m = d % 2 == 1 ? left : one;  // times a^(j - i)
      for (int i = j; i >= 0; --i) {
        if ((i & j) == i)  // binom(j, i) is odd
          for (int row = 0; row < 2; ++row)
            for (int column = 0; column < 2; ++column)
              direction[d][2 * j + column] |= m[2 * row + column] << (31 - 2 * i - row);
        m = times(m, elements[d]);
      }
    }
  return direction;
}

// [k][n][d]: dimension d of the points whose index has nibble k equal to n and all others zero; index and
// value both with their bits reversed. Any point is the exclusive or of eight entries: 2 KiB, always in the
// cache.
using Table = std::array<std::array<Sobol4, 16>, 8>;
constexpr Table table_of(const Directions& direction) {
  Table table = {};
  for (int nibble = 0; nibble < 8; ++nibble)
    for (unsigned n = 0; n < 16; ++n)
      for (int bit = 0; bit < 4; ++bit)
        if ((n >> bit) & 1)
          for (int d = 0; d < 4; ++d)
            table[nibble][n][d] ^= reverse_bits(direction[d][31 - (4 * nibble + bit)]);
  return table;
}
alignas(64) inline constexpr Table sobol_table = table_of(sobol_directions());
alignas(64) inline constexpr Table base4_table = table_of(base4_directions());

// Owen scrambling of a number whose bits are reversed: each bit is flipped or not by a hash of the bits below
// it.
template <typename T>
T scramble_reversed(T v, T key) {
  v ^= v * 0x3d20adea;
  v += key;
  v *= (key >> 16) | 1;
  v ^= v * 0x05526c56;
  v ^= v * 0x53a22864;
  return v;
}

}  // namespace detail

// The numbers of one sample of one pixel, then of another.
class Sampler {
 public:
  enum class Kind { sobol, random };

  // x, y: pixel of the full image (not of a crop). index: of the sample within its replicate.
  Sampler(Kind kind, std::uint32_t seed, int x, int y, int replicate, std::uint32_t index)
      : kind_(kind), index_(~index) {
    const std::uint64_t pixel = static_cast<std::uint64_t>(static_cast<std::uint32_t>(x)) |
                                static_cast<std::uint64_t>(static_cast<std::uint32_t>(y)) << 32;
    pixel_key_ = hash64(
        pixel ^ hash64(seed | static_cast<std::uint64_t>(static_cast<std::uint32_t>(replicate)) << 32));
    set_index(index);
  }
  // Another sample of the same pixel and replicate. What only depends on these is not hashed again.
  void set_index(std::uint32_t index) {
    if (index == index_) return;
    index_ = index;
    if (kind_ == Kind::random)
      key_ = hash64(pixel_key_ + index);
    else
      key_ = pixel_key_, reversed_index_ = reverse_bits(index);
  }

  // Four numbers in [0, 1 - 2^-24].
  Vec4 get(std::uint32_t group) {
    if (kind_ == Kind::random) {
      const Hashes h = hash(group);
      return {to_unit_float(low(h.a)), to_unit_float(high(h.a)), to_unit_float(low(h.b)),
              to_unit_float(high(h.b))};
    }
    if (group >= kept_.size()) return point(group, hash(group));
    if (!((is_kept_ >> group) & 1)) {
      kept_[group] = hash(group);
      is_kept_ |= std::uint32_t{1} << group;
    }
    return point(group, kept_[group]);
  }

  // Hash number n of this sample, apart from all groups: for decisions that need no stratification.
  std::uint32_t bits(std::uint32_t n) const {
    return high(hash64(key_ + hash64(static_cast<std::uint64_t>(reversed_index_) << 32 | n)));
  }

 private:
  // Random bits of a group of numbers: those that scramble it, or the numbers themselves.
  struct Hashes {
    std::uint64_t a, b, c;
  };
  Hashes hash(std::uint32_t group) const {
    constexpr std::uint64_t golden = 0x9e3779b97f4a7c15;
    const std::uint64_t first = key_ + (3 * static_cast<std::uint64_t>(group) + 1) * golden;
    return {hash64(first), hash64(first + golden), hash64(first + 2 * golden)};
  }

  // Shuffles the index, looks the point up, scrambles it.
  Vec4 point(std::uint32_t group, const Hashes& h) const {
    const detail::Table& table = group == 0 ? detail::base4_table : detail::sobol_table;
    const std::uint32_t index = detail::scramble_reversed(reversed_index_, low(h.c));
    const auto entry = [&](unsigned k) { return detail::load(table[k][(index >> (4 * k)) & 15]); };
    Bits v =
        ((entry(0) ^ entry(1)) ^ (entry(2) ^ entry(3))) ^ ((entry(4) ^ entry(5)) ^ (entry(6) ^ entry(7)));
    v = reverse_bits(detail::scramble_reversed(v, Bits{low(h.a), high(h.a), low(h.b), high(h.b)}));
    const Lanes u = detail::to_unit_floats(v);
    return {u[0], u[1], u[2], u[3]};
  }

  static std::uint32_t low(std::uint64_t v) { return static_cast<std::uint32_t>(v); }
  static std::uint32_t high(std::uint64_t v) { return static_cast<std::uint32_t>(v >> 32); }

  Kind kind_;
  std::uint32_t index_;                             // at first another than set_index is given
  std::uint32_t reversed_index_ = 0, is_kept_ = 0;  // bits: which of kept_ are there
  std::uint64_t pixel_key_, key_;
  std::array<Hashes, 20> kept_;  // of the first groups, all that nine bounces need
};

}  // namespace math
