// Which light? Chosen by a bound-like estimate of the irradiance each can cause at the receiver, with costs
// that grow with the logarithm of their number: a binary tree of bounds of position, direction and power, of
// which a cut of some dozens of nodes is weighed whole (so few lights are weighed one by one), and below
// which one child or the other is taken in proportion. Conty Estevez & Kulla 2018, "Importance Sampling of
// Many Lights with Adaptive Tree Splitting": eq. 1 (surface-area orientation heuristic, SAOH), eq. 3
// (importance). Lights that are nowhere (directional, environment) are weighed beside the cut.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "math/vec.h"

namespace light {

// Where light arrives. Sampling a light and asking for its density must see the same receiver.
struct Receiver {
  math::Vec3 from;    // origin of the shadow ray
  math::Vec3 normal;  // shading; lights behind it send nothing
};

// What a light, or a group, sends and from where. Normals lie within `cos_normals` of `axis`, and light
// leaves within `cos_spread` of a normal.
struct Bounds {
  math::Vec3 low, high;
  math::Vec3 axis{0, 0, 1};
  float cos_normals = 1, cos_spread = 0;
  bool two_sided = false;  // the same from the backs
  float intensity = 0;     // of all together, luminance, W/sr in the strongest direction
};
struct Distant {
  float irradiance;     // luminance, on a plane facing it
  math::Vec3 to_light;  // unit; zero: from everywhere
};

class Tree {
 public:
  Tree() = default;
  // Lights are numbered as they come: near ones, then distant ones.
  Tree(std::vector<Bounds> near, std::vector<Distant> distant);

  bool empty() const { return cut_ == 0 && distant_.empty(); }
  struct Choice {
    int light;
    float probability;
  };
  // nullopt: nothing found that could send light (not always that there is none). u in [0,1).
  std::optional<Choice> sample(const Receiver& receiver, double u) const;
  float probability(const Receiver& receiver, int light) const;  // of sample() choosing it

 private:
  bool single() const { return ways_.size() + distant_.size() == 1; }
  // Four nodes side by side, so that they are weighed at once. Lanes without a node have intensity 0.
  struct alignas(16) Four {
    float x[4] = {}, y[4] = {}, z[4] = {}, radius[4] = {};
    float axis_x[4] = {}, axis_y[4] = {}, axis_z[4] = {}, cos_normals[4] = {}, sin_normals[4] = {};
    float cos_spread[4] = {};
    float intensity[4] = {};
    std::int32_t two_sided[4] = {};  // all bits
    std::int32_t child[4] = {};      // another four; of a leaf ~light
    void set(size_t lane, const Bounds& bounds, std::int32_t what);
  };
  struct alignas(16) Weights {
    float of[4];
    float sum() const { return (of[0] + of[1]) + (of[2] + of[3]); }
    size_t take(double& u) const;
  };
  static Weights importance(const Four& nodes, const Receiver& receiver);
  static thread_local std::vector<Weights> scratch;  // what weigh() found
  float weigh(const Receiver& receiver) const;
  struct Builder;

  std::vector<Four> nodes_;  // the first `cut_` are the cut
  size_t cut_ = 0;
  std::vector<Distant> distant_;
  struct Way {                // to a leaf
    std::uint32_t slot = 0;   // four times the place in the cut, plus the lane
    std::uint64_t trail = 0;  // lanes below it, two bits each, the lowest first
  };
  std::vector<Way> ways_;  // of the near lights
};

}  // namespace light
