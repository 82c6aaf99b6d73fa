// What the tests of this room see of a BRDF: the renderer's two functions at one point and one wo, behind
// std::function, so that a test can put a faulty pair in their place (faults.h) and see itself fail.
//
// Directions as in renderer/bsdf: unit, in the shading frame, pointing away from the surface.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "bsdf/disney.h"

namespace sampling {

using bsdf::Bsdf;
using bsdf::Value;
using math::Vec3;

struct Subject {
  Vec3 wo;
  Bsdf bsdf;  // the true one: tells cells.h where the lobes are, and no more
  std::function<Value(const Vec3& wi)> eval;
  std::function<std::optional<bsdf::Sample>(float u_lobe, float u, float v)> sample;
};

// The renderer's own functions.
Subject honest(const Bsdf& b, const Vec3& wo);

// A row of the table of materials.
enum Lobes : unsigned { all = 0, diffuse = 1, specular = 2, clearcoat = 4 };
struct Material {
  std::string name;
  bsdf::Model model;
  bsdf::Parameters parameters;
  bsdf::Gtr gtr = {};
  unsigned lobes = all;  // others are taken out, so that one lobe stands alone
};
Bsdf at(const Material& material, const Vec3& wo);

// 45 materials of all four models: alpha from .0003 to 3.16, each lobe alone and mixed.
const std::vector<Material>& materials();
const Material& material(const std::string& name);

// Eight: cosines 1, .95, .7, .5, .3, .1, .05, .02, each at another azimuth.
inline constexpr int direction_count = 8;
Vec3 direction(int which);
// The unit vector of a cosine and an azimuth.
Vec3 direction(double cosine, double azimuth);

// Random numbers that are the same with every standard library, 24 bits each, as the renderer's: SplitMix64.
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

 private:
  std::uint64_t state_;
};

}  // namespace sampling
