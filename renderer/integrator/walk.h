// One path, step by step, for those who follow it to its end (path.cpp) or share it on the way (reuse.cpp).
// Path tracing with next-event estimation and multiple importance sampling (Veach 1997, chapters 8 to 10).
#pragma once

#include <algorithm>
#include <cmath>
#include <optional>

#include "integrator/path.h"

namespace integrator {

// Groups of four random numbers: 0 has the camera ray and the first direction, then two for each bounce.
inline constexpr std::uint32_t first_bounce_group = 1, groups_per_bounce = 2;

// Paths shorter than this are never ended by roulette.
inline constexpr int roulette_start = 3;
static_assert(roulette_start > 2, "reuse.cpp knows of no roulette at the second surface");

// Power heuristic, exponent 2 (Veach 1997, eq. 9.13), by ratio so that huge densities do not overflow.
inline float power_heuristic(float pdf, float other) {
  if (pdf == 0) return 0;
  const float ratio = other / pdf;
  return 1 / (1 + ratio * ratio);
}

// A ray's own random bits, by which surfaces that are partly transparent decide whether it passes.
inline std::uint32_t key(const World& w, const math::Sampler& sampler, std::uint32_t ray_number) {
  return w.blended ? sampler.bits(ray_number) : 0;
}

// Where a ray from `p` along `direction` starts, given where one along the geometric normal does.
inline math::Vec3 origin(const surface::Point& p, const math::Vec3& direction, const math::Vec3& outside) {
  return math::dot(direction, p.geometric_normal) < 0 ? surface::origin(p, direction) : outside;
}

// What each lobe contributes to f_cos, per channel, in [0,1].
using Shares = std::array<math::Vec3, bsdf::eval_lobe_count>;
inline Shares shares_of(const bsdf::Bsdf& bsdf, const math::Vec3& wo, const math::Vec3& wi) {
  Shares f = bsdf::eval_lobes(bsdf, wo, wi);
  math::Vec3 sum(0);
  for (const math::Vec3& lobe : f) sum += lobe;
  for (math::Vec3& lobe : f)
    for (int c = 0; c < 3; ++c) lobe[c] = sum[c] > 0 ? lobe[c] / sum[c] : 0;
  return f;
}

// Light that a ray met, and the density with which a light sample would have drawn its direction.
struct Found {
  math::Vec3 radiance{0};
  float pdf = 0;
};
// A light sample that is not in shadow: from `wi` (shading frame), with its density and the BRDF's value.
struct Lit {
  math::Vec3 wi, radiance;
  float pdf;
  bool is_delta;
  bsdf::Value f;
};

// Their weights against each other, given the density with which the BRDF draws the direction. Not of light
// that no light sample could have found.
inline float found_weight(const World& w, const Found& found, float pdf) {
  if (w.light_sampling_only) return found.pdf > 0 ? 0.f : 1.f;
  return power_heuristic(pdf, found.pdf);
}
inline float lit_weight(const World& w, const Lit& lit, float pdf) {
  return lit.is_delta || w.light_sampling_only ? 1 : power_heuristic(lit.pdf, pdf);
}

inline void add_parts(Parts& parts, const math::Vec3& light, const Shares& lobes, bool indirect) {
  for (size_t i = 0; i < lobes.size(); ++i) parts[1 + 2 * i + (indirect ? 1 : 0)] += light * lobes[i];
}

class Walk {
 public:
  using Vec3 = math::Vec3;

  Walk(const World& world, const First& first, math::Sampler& sampler, std::uint64_t& rays, Parts* wanted)
      : ray(first.ray), parts(wanted), w_(world), first_(first), sampler_(sampler), rays_(rays) {
    if (parts) parts->fill(Vec3(0));
  }

  // --- what the steps leave

  Vec3 sum{0}, throughput{1};
  Vec3 before{1};  // what roulette takes the throughput times, where a walk's own has started anew
  accel::Ray ray;
  light::Receiver
      receiver;          // where the ray was drawn: everything is seen from the offset origin of shadow rays
  bool only_way = true;  // no light sample could have found what this ray finds: camera rays, mirrors
  Vec3 wo;               // at the surface that was prepared
  bsdf::Bsdf bsdf;
  bsdf::Sample drawn;
  Shares shares{};  // of the first surface's lobes in the throughput; kept for `parts` only
  Parts* parts;     // if asked for

  const surface::Point& point(int bounce) const { return bounce > 0 ? next_ : first_.point; }

  // --- the steps

  // Finds the next surface: point(bounce). False if there is none.
  bool trace(int bounce) {
    if (bounce == 0) return first_.found;
    accel::Hit hit;
    ++rays_;
    const bool found = w_.accel.closest(ray, key(w_, sampler_, ray_number_++), hit);
    if (found) next_ = w_.surfaces.at(ray, hit);
    return found;
  }

  // The light there, or of the environment.
  Found light(int bounce, bool found) const {
    if (bounce == 0) return {first_.light, 0};
    if (!found) {
      if (!w_.lights.has_environment()) return {};
      if (only_way) return {w_.lights.environment(ray.direction), 0};
      if (w_.light_sampling_only) return {};
      const light::Environment::Seen seen = w_.lights.environment(receiver, ray.direction);
      return {seen.radiance, seen.pdf};
    }
    const surface::Point& p = point(bounce);
    if (math::is_black(p.emission)) return {};
    return {p.emission, only_way ? 0 : w_.lights.pdf(receiver, p)};
  }

  void add_found(int bounce, bool found) {
    const Found light = this->light(bounce, found);
    if (math::is_black(light.radiance)) return;
    const Vec3 added = throughput * light.radiance * (only_way ? 1 : found_weight(w_, light, drawn.pdf));
    add(added, shares, bounce > 1);
    if (parts && bounce == 0) (*parts)[0] += added;
  }

  // The BRDF at point(bounce).
  void prepare(int bounce) {
    const surface::Point& p = point(bounce);
    wo = p.frame.to_local(-ray.direction);
    if (p.plain_material < 0) {
      bsdf = bsdf::prepare(w_.model, w_.gtr, p.material, p.normals, wo);
    } else {
      bsdf = w_.plain[static_cast<size_t>(p.plain_material)];
      bsdf::orient(bsdf, p.normals, wo);
    }
    receiver = {surface::origin(p, p.geometric_normal), p.frame.normal};
  }

  // Light that arrives directly from one sampled light.
  std::optional<Lit> lit(int bounce) {
    const std::uint32_t ray_number = ray_number_++;
    if (bsdf.only_delta || w_.lights.empty()) return std::nullopt;
    const surface::Point& p = point(bounce);
    const math::Vec4 u = sampler_.get(group_of(bounce) + 1);
    const auto light = w_.lights.sample(receiver, math::join(u.z, u.w), u.x, u.y);
    if (!light) return std::nullopt;
    const Vec3 wi = p.frame.to_local(light->wi);
    const bsdf::Value f = bsdf::eval(bsdf, wo, wi);
    if (math::is_black(f.f_cos)) return std::nullopt;

    accel::Ray shadow{origin(p, light->wi, receiver.from), light->wi};
    if (!light->infinite) {
      shadow.direction = light->target - shadow.origin;
      shadow.t_max = 1;
    }
    ++rays_;
    if (w_.accel.occluded(shadow, key(w_, sampler_, ray_number))) return std::nullopt;
    return Lit{wi, light->radiance, light->pdf, light->is_delta, f};
  }
  void add_direct(int bounce) {
    const std::optional<Lit> l = lit(bounce);
    if (!l) return;
    add(throughput * (l->f.f_cos * l->radiance * (lit_weight(w_, *l, l->f.pdf) / l->pdf)),
        parts && bounce == 0 ? shares_of(bsdf, wo, l->wi) : shares, bounce > 0);
  }

  // Draws a direction from the BRDF: `drawn`, and the ray. False if the path ends.
  bool draw(int bounce) {
    // What a camera ray and the first direction do together is most of the noise where textures or edges
    // cross a pixel: their numbers are of one point, which has none to spare for the lobe.
    const bool with_camera = bounce == 0 && first_.direction;
    const math::Vec4 u = with_camera ? math::Vec4(0) : sampler_.get(group_of(bounce));
    const auto s = with_camera ? bsdf::sample(bsdf, wo, first_.direction->x, first_.direction->y)
                               : bsdf::sample(bsdf, wo, u.z, u.x, u.y);
    if (!s || math::is_black(s->f_cos)) return false;
    drawn = *s;
    roulette_ = u.w;
    if (parts && bounce == 0) {
      if (s->is_delta)
        shares[s->lobe == bsdf::Lobe::specular ? 2 : 3] = Vec3(1);
      else
        shares = shares_of(bsdf, wo, s->wi);
    }
    only_way = s->is_delta;
    const surface::Point& p = point(bounce);
    ray.direction = math::renormalize(p.frame.to_world(s->wi));
    ray.origin = origin(p, ray.direction, receiver.from);
    return true;
  }

  // Ends weak paths by chance, the survivors carrying their share. The throughput itself or its square root
  // would end more of them and add more noise than that time is worth (docs/speed-notes.md).
  bool survives(int bounce) {
    if (bounce + 1 < roulette_start) return true;
    const float survival = std::min(1.f, std::sqrt(std::sqrt(math::max_component(throughput * before))));
    if (roulette_ >= survival) return false;
    throughput /= survival;
    return true;
  }

  // All that follows what trace(bounce) found.
  void go_on(int bounce, bool found) {
    for (; found && bounce < w_.depth; ++bounce) {
      prepare(bounce);
      if (!scatter(bounce, found)) return;
    }
  }
  // The same where the BRDF is prepared.
  void go_on_prepared(int bounce) {
    bool found = true;
    if (scatter(bounce, found)) go_on(bounce + 1, found);
  }
  // From one surface to the next, with the light of both. False if the path ends.
  bool scatter(int bounce, bool& found) {
    add_direct(bounce);
    if (!draw(bounce)) return false;
    throughput *= drawn.f_cos * (1 / drawn.pdf);
    if (!survives(bounce)) return false;
    found = trace(bounce + 1);
    add_found(bounce + 1, found);
    return true;
  }

  void add(const Vec3& light, const Shares& lobes, bool indirect) {
    sum += light;
    if (parts) add_parts(*parts, light, lobes, indirect);
  }

 private:
  static std::uint32_t group_of(int bounce) {
    return first_bounce_group + groups_per_bounce * static_cast<std::uint32_t>(bounce);
  }

  const World& w_;
  const First& first_;
  math::Sampler& sampler_;
  std::uint64_t& rays_;
  surface::Point next_;
  std::uint32_t ray_number_ = 1;  // 0 was the camera's
  float roulette_ = 0;
};

}  // namespace integrator
