// What the tests of this room share.
#pragma once

#include <cmath>
#include <cstdint>

#include "bsdf/disney.h"

namespace bsdf::testing {

inline Vec3 direction(double cosine, double azimuth) {
  const double s = std::sqrt(std::fmax(0, (1 - cosine) * (1 + cosine)));
  return {static_cast<float>(s * std::cos(azimuth)), static_cast<float>(s * std::sin(azimuth)),
          static_cast<float>(cosine)};
}

// The same random numbers with every standard library: SplitMix64, 24 bits as the renderer's.
class Random {
 public:
  explicit Random(std::uint64_t seed) : state_(seed * 0xd1342543de82ef95 + 1) {}
  std::uint64_t bits() {
    std::uint64_t z = state_ += 0x9e3779b97f4a7c15;
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9;
    z = (z ^ (z >> 27)) * 0x94d049bb133111eb;
    return z ^ (z >> 31);
  }
  float uniform() { return static_cast<float>(bits() >> 40) * 0x1p-24f; }
  int below(int n) { return static_cast<int>((bits() >> 33) % static_cast<std::uint64_t>(n)); }

 private:
  std::uint64_t state_;
};

// The BRDF with one lobe left.
inline Bsdf alone(Bsdf b, Lobe lobe) {
  for (float& p : b.probability) p = 0;
  b.probability[static_cast<int>(lobe)] = 1;
  return b;
}

inline Parameters black() {
  Parameters p;
  p.base_color = Vec3(0);
  p.specular = 0;
  return p;
}

}  // namespace bsdf::testing
