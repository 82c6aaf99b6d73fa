#include "light/tree.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <span>

#include "math/lanes.h"
#include "math/transcendental.h"

namespace light {

namespace {

using math::all;
using math::dot;
using math::Lanes;
using math::Mask;
using math::Vec3;

// Nodes weighed whole: more cost time at every point, fewer cost noise.
constexpr size_t cut_size = 32;

// Planes tried along each axis when a node is split, and the depth from which it is halved instead, so that
// the trail fits its 64 bits.
constexpr int buckets = 12;
constexpr int halve_from = 16;

// Smallest cone around two.
void join_cones(Bounds& a, const Bounds& b) {
  const double wide_a = math::acos(static_cast<double>(a.cos_normals)),
               wide_b = math::acos(static_cast<double>(b.cos_normals));
  Vec3 other = b.axis;
  if (a.two_sided && b.two_sided && dot(a.axis, other) < 0) other = -other;
  const double between = math::acos(static_cast<double>(dot(a.axis, other)));
  if (between + wide_b <= wide_a) return;
  if (between + wide_a <= wide_b) {
    a.axis = other, a.cos_normals = b.cos_normals;
    return;
  }
  const double wide = (wide_a + between + wide_b) / 2;
  const Vec3 across = math::normalize(other - a.axis * dot(a.axis, other), Vec3(0));
  if (wide >= static_cast<double>(math::pi) || math::is_black(across)) {
    a.cos_normals = -1;
    return;
  }
  double s = 0, c = 0;
  math::sin_cos(wide - wide_a, s, c);
  a.axis = math::normalize(a.axis * static_cast<float>(c) + across * static_cast<float>(s));
  math::sin_cos(wide, s, c);
  a.cos_normals = std::max(-1.f, static_cast<float>(c) - 1e-6f);
}

void join(Bounds& a, const Bounds& b) {
  if (a.intensity == 0) {
    a = b;
    return;
  }
  a.low = math::smaller(a.low, b.low), a.high = math::larger(a.high, b.high);
  join_cones(a, b);
  a.cos_spread = std::min(a.cos_spread, b.cos_spread);
  a.two_sided = a.two_sided || b.two_sided;
  a.intensity += b.intensity;
}

// The paper's M_Omega (eq. 1): how many directions the light leaves in.
double directions(const Bounds& b) {
  const double o = math::acos(static_cast<double>(b.cos_normals)), cos_o = b.cos_normals;
  const double w = std::min(o + math::acos(static_cast<double>(b.cos_spread)), static_cast<double>(math::pi));
  double sin_o = 0, c = 0, s = 0, cos_ow = 0;
  math::sin_cos(o, sin_o, c);
  math::sin_cos(o - 2 * w, s, cos_ow);
  constexpr double pi = 3.141592653589793;
  const double once = 2 * pi * (1 - cos_o) + pi / 2 * (2 * w * sin_o - cos_ow - 2 * o * sin_o + cos_o);
  return b.two_sided ? 2 * once : once;
}

double cost(const Bounds& b) {
  if (b.intensity == 0) return 0;
  const Vec3 d = b.high - b.low;
  const double area =
      static_cast<double>(d.x) * d.y + static_cast<double>(d.y) * d.z + static_cast<double>(d.z) * d.x;
  return b.intensity * directions(b) * area;
}

Lanes load(const float* v) { return *reinterpret_cast<const Lanes*>(v); }
Mask load(const std::int32_t* v) { return *reinterpret_cast<const Mask*>(v); }
void store(float* to, Lanes v) { *reinterpret_cast<Lanes*>(to) = v; }
Lanes choose(Mask m, Lanes a, Lanes b) { return m ? a : b; }
Lanes least(Lanes a, Lanes b) { return a < b ? a : b; }
Lanes most(Lanes a, Lanes b) { return a > b ? a : b; }
Lanes root(Lanes v) { return _mm_sqrt_ps(v); }
Lanes sine(Lanes cosine) { return root(most(all(1) - cosine * cosine, all(0))); }
// cos(max(0, a - b)) from cosines and sines.
Lanes cosine_less(Lanes cos_a, Lanes sin_a, Lanes cos_b, Lanes sin_b) {
  return choose(cos_a >= cos_b, all(1), cos_a * cos_b + sin_a * sin_b);
}

float importance(const Distant& light, const Receiver& r) {
  if (math::is_black(light.to_light)) return light.irradiance;
  return light.irradiance * std::max(0.f, dot(light.to_light, r.normal));
}

}  // namespace

void Tree::Four::set(size_t k, const Bounds& b, std::int32_t what) {
  const Vec3 centre = (b.low + b.high) * .5f, half = math::larger(b.high - centre, centre - b.low);
  x[k] = centre.x, y[k] = centre.y, z[k] = centre.z;
  radius[k] = math::length(half) * (1 + 1e-5f);
  axis_x[k] = b.axis.x, axis_y[k] = b.axis.y, axis_z[k] = b.axis.z;
  cos_normals[k] = b.cos_normals,
  sin_normals[k] = std::sqrt(std::max(0.f, 1 - b.cos_normals * b.cos_normals));
  cos_spread[k] = b.cos_spread;
  intensity[k] = b.intensity;
  two_sided[k] = b.two_sided ? -1 : 0;
  child[k] = what;
}

// The paper's eq. 3 with the sphere around the bounds: cosines at both ends, each at the best angle that the
// sphere's width allows. 0 only if nothing arrives.
Tree::Weights Tree::importance(const Four& n, const Receiver& r) {
  const Lanes zero = all(0), one = all(1);
  const Lanes dx = load(n.x) - all(r.from.x), dy = load(n.y) - all(r.from.y), dz = load(n.z) - all(r.from.z);
  const Lanes d2 = dx * dx + dy * dy + dz * dz, radius = load(n.radius);
  const Lanes r2 = radius * radius, intensity = load(n.intensity);
  const Mask inside = d2 <= r2;
  const Lanes inverse = one / root(most(d2, all(1e-30f)));
  const Lanes sin_u = least(radius * inverse, one), cos_u = root(most(one - sin_u * sin_u, zero));

  const Lanes cos_i = (dx * all(r.normal.x) + dy * all(r.normal.y) + dz * all(r.normal.z)) * inverse;
  const Lanes receive = cosine_less(cos_i, sine(cos_i), cos_u, sin_u);

  Lanes cos_w = -(dx * load(n.axis_x) + dy * load(n.axis_y) + dz * load(n.axis_z)) * inverse;
  cos_w = choose(load(n.two_sided), most(cos_w, -cos_w), cos_w);
  const Lanes sin_w = sine(cos_w), cos_n = load(n.cos_normals), sin_n = load(n.sin_normals);
  const Lanes cos_x = cos_w * cos_n + sin_w * sin_n, sin_x = sin_w * cos_n - cos_w * sin_n;
  const Lanes send = choose(cos_w >= cos_n, one, cosine_less(cos_x, sin_x, cos_u, sin_u));

  const Lanes outside = choose((receive > zero) & (send > load(n.cos_spread)),
                               intensity * receive * send * inverse * inverse, zero);
  Weights w;
  store(w.of, choose(inside, intensity / most(r2, all(1e-30f)), outside));
  return w;
}

struct Tree::Builder {
  Tree& tree;
  const std::vector<Bounds>& lights;
  using Lights = std::span<std::int32_t>;  // by number

  Vec3 centre(std::int32_t i) const {
    const Bounds& b = lights[static_cast<size_t>(i)];
    return (b.low + b.high) * .5f;
  }
  // Orders `part` so that its first `n` lights are one child; returns n.
  size_t split(Lights part, int depth) const {
    Vec3 low(3e38f), high(-3e38f);
    for (const std::int32_t i : part)
      low = math::smaller(low, centre(i)), high = math::larger(high, centre(i));
    const Vec3 extent = high - low;
    const float longest = math::max_component(extent);
    double best = 3e300;
    int best_axis = -1, best_plane = 0;
    const auto bucket = [&](std::int32_t i, int axis) {
      return std::clamp(static_cast<int>((centre(i)[axis] - low[axis]) / extent[axis] * buckets), 0,
                        buckets - 1);
    };
    for (int axis = 0; axis < 3 && depth < halve_from; ++axis) {
      if (!(extent[axis] > 0) || !std::isfinite(extent[axis])) continue;
      std::array<Bounds, buckets> held{}, above{};
      for (const std::int32_t i : part)
        join(held[static_cast<size_t>(bucket(i, axis))], lights[static_cast<size_t>(i)]);
      for (size_t k = buckets - 1; k > 0; --k) {
        above[k - 1] = above[k];
        if (held[k].intensity > 0) join(above[k - 1], held[k]);
      }
      Bounds below{};
      for (size_t k = 0; k + 1 < buckets; ++k) {
        if (held[k].intensity > 0) join(below, held[k]);
        if (below.intensity == 0 || above[k].intensity == 0) continue;
        const double c = (cost(below) + cost(above[k])) * (longest / extent[axis]);
        if (c < best) best = c, best_axis = axis, best_plane = static_cast<int>(k);
      }
    }
    if (best_axis < 0) return part.size() / 2;
    const auto middle = std::stable_partition(
        part.begin(), part.end(), [&](std::int32_t i) { return bucket(i, best_axis) <= best_plane; });
    return static_cast<size_t>(middle - part.begin());
  }

  struct Part {
    Lights lights;
    Bounds bounds;
    double cost;  // 0: cannot be split
  };
  Part part(Lights of) const {
    Bounds all;
    for (const std::int32_t i : of) join(all, lights[static_cast<size_t>(i)]);
    return {of, all, of.size() > 1 ? cost(all) + 1e-300 : 0};
  }
  // Splits the costliest part again and again, until there are `count` or nothing is left to split.
  std::vector<Part> parts(Lights of, size_t count, int depth) const {
    std::vector<Part> found = {part(of)};
    while (found.size() < count) {
      const auto costliest = std::max_element(found.begin(), found.end(),
                                              [](const Part& a, const Part& b) { return a.cost < b.cost; });
      if (costliest->cost == 0) break;
      const Lights whole = costliest->lights;
      const size_t n = split(whole, depth);
      *costliest = part(whole.first(n));
      found.push_back(part(whole.subspan(n)));
    }
    return found;
  }

  // Fills lane `lane` of nodes_[four] with a part, and what is below it.
  void place(const Part& p, size_t four, size_t lane, int depth, Way way) {
    if (p.lights.size() == 1) {
      tree.nodes_[four].set(lane, p.bounds, ~p.lights[0]);
      tree.ways_[static_cast<size_t>(p.lights[0])] = way;
      return;
    }
    const size_t child = tree.nodes_.size();
    tree.nodes_[four].set(lane, p.bounds, static_cast<std::int32_t>(child));
    tree.nodes_.emplace_back();
    const std::vector<Part> children = parts(p.lights, 4, depth);
    for (size_t i = 0; i < children.size(); ++i)
      place(children[i], child, i, depth + 1,
            {way.slot, way.trail | static_cast<std::uint64_t>(i) << (2 * depth)});
  }
};

Tree::Tree(std::vector<Bounds> near, std::vector<Distant> distant)
    : distant_(std::move(distant)), ways_(near.size()) {
  if (near.empty()) return;
  Builder builder{*this, near};
  std::vector<std::int32_t> order(near.size());
  for (size_t i = 0; i < order.size(); ++i) order[i] = static_cast<std::int32_t>(i);
  const std::vector<Builder::Part> slots = builder.parts(order, cut_size, 0);
  cut_ = (slots.size() + 3) / 4;
  nodes_.resize(cut_);
  for (size_t i = 0; i < slots.size(); ++i)
    builder.place(slots[i], i / 4, i % 4, 0, {static_cast<std::uint32_t>(i), 0});
}

thread_local std::vector<Tree::Weights> Tree::scratch;

// The importance of the cut's nodes, then of the distant lights, four by four; returns their sum.
float Tree::weigh(const Receiver& r) const {
  scratch.clear();
  for (size_t i = 0; i < cut_; ++i) scratch.push_back(importance(nodes_[i], r));
  for (size_t i = 0; i < distant_.size(); ++i) {
    if (i % 4 == 0) scratch.push_back({});
    scratch.back().of[i % 4] = light::importance(distant_[i], r);
  }
  float sum = 0;
  for (const Weights& w : scratch) sum += w.sum();
  return std::isfinite(sum) ? sum : 0;
}

// Takes a lane in proportion to its weight; u becomes what is left of it.
size_t Tree::Weights::take(double& u) const {
  double rest = u * sum();
  size_t lane = 0;
  for (size_t i = 0; i < 4; ++i) {
    if (!(of[i] > 0)) continue;
    lane = i;
    if (rest < of[i]) break;
    rest -= of[i];
  }
  u = std::clamp(rest / of[lane], 0., 1 - 0x1p-53);
  return lane;
}

std::optional<Tree::Choice> Tree::sample(const Receiver& r, double u) const {
  if (single()) return Choice{0, 1};
  const float sum = weigh(r);
  if (!(sum > 0)) return std::nullopt;
  double rest = u * sum;
  size_t four = 0;
  for (size_t i = 0; i < scratch.size(); ++i) {
    if (!(scratch[i].sum() > 0)) continue;
    four = i;
    if (rest < scratch[i].sum()) break;
    rest -= scratch[i].sum();
  }
  u = std::clamp(rest / scratch[four].sum(), 0., 1 - 0x1p-53);
  size_t lane = scratch[four].take(u);
  float probability = scratch[four].of[lane] / sum;
  if (four >= cut_) return Choice{static_cast<int>(ways_.size() + 4 * (four - cut_) + lane), probability};

  std::int32_t child = nodes_[four].child[lane];
  while (child >= 0) {
    const Four& nodes = nodes_[static_cast<size_t>(child)];
    const Weights w = importance(nodes, r);
    if (!(w.sum() > 0)) return std::nullopt;
    lane = w.take(u);
    probability *= w.of[lane] / w.sum();
    child = nodes.child[lane];
  }
  return Choice{~child, probability};
}

float Tree::probability(const Receiver& r, int light) const {
  if (single()) return 1;
  const float sum = weigh(r);
  if (!(sum > 0)) return 0;
  const auto index = static_cast<size_t>(light);
  if (index >= ways_.size()) {
    const size_t i = index - ways_.size();
    return scratch[cut_ + i / 4].of[i % 4] / sum;
  }
  const Way& way = ways_[index];
  float probability = scratch[way.slot / 4].of[way.slot % 4] / sum;
  std::int32_t child = nodes_[way.slot / 4].child[way.slot % 4];
  for (std::uint64_t trail = way.trail; child >= 0 && probability > 0; trail >>= 2) {
    const Four& nodes = nodes_[static_cast<size_t>(child)];
    const Weights w = importance(nodes, r);
    probability *= w.sum() > 0 ? w.of[trail & 3] / w.sum() : 0;
    child = nodes.child[trail & 3];
  }
  return probability;
}

}  // namespace light
