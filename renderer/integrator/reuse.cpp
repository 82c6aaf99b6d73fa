#include "integrator/reuse.h"

#include <array>
#include <cassert>
#include <numeric>

#include "integrator/walk.h"

namespace integrator {

namespace {

using math::Vec3;

// Where a path left the camera's surface.
struct Start {
  bool there = false;  // and could have gone anywhere
  bsdf::Bsdf bsdf;
  Vec3 wo, from;
};

// What a path met at its second surface.
struct Second {
  bool shared = false;  // and the others may use it
  surface::Point point;
  bsdf::Bsdf bsdf;
  Vec3 direction;        // of the ray that found it
  bsdf::Sample arrived;  // how that was drawn
  Shares shares;         // of the first surface's lobes in it
  std::optional<Lit> lit;
  std::optional<bsdf::Sample> next;  // where it went on to, ...
  Found found;                       // ... the light there, ...
  Vec3 beyond{0};                    // ... and what is reflected there
};

// Mirrors send nothing elsewhere, and a bent normal makes another BRDF.
bool can_share(const surface::Point& p, const bsdf::Bsdf& b) {
  const bool mirror =
      (b.probability[1] > 0 && b.specular.is_delta) || (b.probability[2] > 0 && b.clearcoat.is_delta);
  return !b.only_delta && !mirror && p.frame.normal == p.normal;
}

// A second surface as one of the pixels sees it.
struct View {
  bool there = false;
  double cosine_per_square;  // |cosine| at the surface over the squared distance
  double density;            // with which this pixel's paths arrive there, per area
  Vec3 f_cos;                // at the pixel's first surface
  Shares shares;             // of its lobes in that; for `parts` only
  bsdf::Value lit, next;     // at the second, of these directions
};

class Block {
 public:
  Block(const World& w, std::span<const First> first, std::uint64_t& rays, std::span<Reused> paths,
        std::span<Parts> parts)
      : w_(w), first_(first), rays_(rays), paths_(paths), parts_(parts) {}

  // Follows path j to its end. What it met at its second surface is not added to its radiance if the others
  // may use it.
  void follow(size_t j, math::Sampler& sampler) {
    Walk walk(w_, first_[j], sampler, rays_, parts_.empty() ? nullptr : &parts_[j]);
    paths_[j] = {};
    follow(walk, starts_[j], seconds_[j], paths_[j].alone);
    paths_[j].own = walk.sum;
  }

  // Adds what path j met to the radiance of all that see it.
  void share(size_t j) {
    const Second& y = seconds_[j];
    if (!y.shared) return;
    std::array<View, block_size> views;
    double sum = 0, lit_pdf = 0, next_pdf = 0;
    for (size_t k = 0; k < first_.size(); ++k) {
      View& v = views[k];
      v = k == j ? own_view(y) : view(k, y);
      if (!v.there) continue;
      sum += v.density;
      lit_pdf += v.density * static_cast<double>(v.lit.pdf);
      next_pdf += v.density * static_cast<double>(v.next.pdf);
    }
    if (!(sum > 0)) return;
    // The directions' densities are the means of the pixels', by their densities at the surface.
    Vec3 lit(0), next(0);
    if (y.lit)
      lit = y.lit->radiance * (lit_weight(w_, *y.lit, static_cast<float>(lit_pdf / sum)) / y.lit->pdf);
    if (y.next) {
      const float pdf = static_cast<float>(next_pdf / sum);
      next = (y.found.radiance * found_weight(w_, y.found, pdf) + y.beyond) * (1 / pdf);
    }
    for (size_t k = 0; k < first_.size(); ++k) {
      const View& v = views[k];
      if (!v.there) continue;
      const Vec3 light =
          v.f_cos * (v.lit.f_cos * lit + v.next.f_cos * next) * static_cast<float>(v.cosine_per_square / sum);
      paths_[k].shared += light;
      if (!parts_.empty()) add_parts(parts_[k], light, v.shares, true);
    }
  }

 private:
  // Up to the second surface, and beyond it. `alone`: what is not yet in the walk's sum.
  void follow(Walk& walk, Start& start, Second& y, Vec3& alone) {
    bool found = walk.trace(0);
    walk.add_found(0, found);
    if (!found || w_.depth == 0) return;
    walk.prepare(0);
    start = {!walk.bsdf.only_delta, walk.bsdf, walk.wo, walk.receiver.from};
    walk.add_direct(0);
    if (!walk.draw(0)) return;
    walk.throughput *= walk.drawn.f_cos * (1 / walk.drawn.pdf);
    found = walk.trace(1);
    walk.add_found(1, found);
    if (!found || w_.depth == 1) return;

    y.arrived = walk.drawn;
    y.direction = walk.ray.direction;
    y.point = walk.point(1);
    walk.prepare(1);
    if (walk.drawn.is_delta || !can_share(y.point, walk.bsdf)) {
      walk.go_on_prepared(1);
      return;
    }
    const Vec3 sum = walk.sum, throughput = walk.throughput;
    y.bsdf = walk.bsdf;
    y.shares = walk.shares;
    y.lit = walk.lit(1);
    if (walk.draw(1)) {
      y.next = walk.drawn;
      walk.before = throughput * walk.drawn.f_cos * (1 / walk.drawn.pdf);
      walk.throughput = Vec3(1);
      walk.sum = Vec3(0);
      walk.parts = nullptr;
      found = walk.trace(2);
      y.found = walk.light(2, found);
      walk.go_on(2, found);
      y.beyond = walk.sum;
    }
    walk.sum = sum;
    if (y.next && math::is_black(y.found.radiance) && math::is_black(y.beyond)) y.next.reset();
    y.shared = y.lit || y.next;
    if (y.lit)
      alone += y.lit->f.f_cos * y.lit->radiance * (lit_weight(w_, *y.lit, y.lit->f.pdf) / y.lit->pdf);
    if (y.next)
      alone += y.next->f_cos * (y.found.radiance * found_weight(w_, y.found, y.next->pdf) + y.beyond) *
               (1 / y.next->pdf);
    alone *= throughput;
  }

  View own_view(const Second& y) const {
    View v;
    v.there = true;
    v.cosine_per_square = -static_cast<double>(math::dot(y.point.geometric_normal, y.direction)) /
                          math::sqr(static_cast<double>(y.point.distance));
    v.density = static_cast<double>(y.arrived.pdf) * v.cosine_per_square;
    v.f_cos = y.arrived.f_cos;
    v.shares = y.shares;
    if (y.lit) v.lit = y.lit->f;
    if (y.next) v.next = {y.next->f_cos, y.next->pdf};
    return v;
  }

  // As the paths of pixel k would have found it: not there if they could not, or could not share it.
  View view(size_t k, const Second& y) {
    View v;
    const Start& start = starts_[k];
    if (!start.there) return v;
    const surface::Point& x = first_[k].point;
    const Vec3 to = y.point.position - start.from, direction = math::normalize(to);
    const float cosine = -math::dot(direction, y.point.geometric_normal);
    if (!(cosine > 0)) return v;
    const Vec3 wi = x.frame.to_local(direction), wo = y.point.frame.to_local(-direction);
    const bsdf::Value f = bsdf::eval(start.bsdf, start.wo, wi);
    if (!(f.pdf > 0) || !(wo.z > 0)) return v;
    if (surface::bend_normal(y.point.geometric_normal, -direction, y.point.normal) != y.point.normal)
      return v;

    accel::Ray shadow{origin(x, direction, start.from), {}, 1};
    shadow.direction = surface::origin(y.point, -direction) - shadow.origin;
    ++rays_;
    if (w_.accel.occluded(shadow, 0)) return v;
    v.there = true;
    v.cosine_per_square = static_cast<double>(cosine) / math::dot(math::DVec3(to), math::DVec3(to));
    v.density = static_cast<double>(f.pdf) * v.cosine_per_square;
    v.f_cos = f.f_cos;
    if (!parts_.empty()) v.shares = shares_of(start.bsdf, start.wo, wi);
    bsdf::Bsdf b = y.bsdf;
    bsdf::orient(b, y.point.normals, wo);
    if (y.lit) v.lit = bsdf::eval(b, wo, y.lit->wi);
    if (y.next) v.next = bsdf::eval(b, wo, y.next->wi);
    return v;
  }

  const World& w_;
  std::span<const First> first_;
  std::uint64_t& rays_;
  std::span<Reused> paths_;
  std::span<Parts> parts_;
  std::array<Start, block_size> starts_;
  std::array<Second, block_size> seconds_;
};

}  // namespace

std::uint64_t radiance(const World& w, std::span<const First> first, std::span<math::Sampler> samplers,
                       std::uint64_t& rays, std::span<Reused> paths, std::span<Parts> parts) {
  assert(first.size() <= block_size && !w.blended);
  Block block(w, first, rays, paths, parts);
  for (size_t j = 0; j < first.size(); ++j) block.follow(j, samplers[j]);
  const std::uint64_t before = rays;
  for (size_t j = 0; j < first.size(); ++j) block.share(j);
  return rays - before;
}

}  // namespace integrator
