// Path tracing with next-event estimation and multiple importance sampling (Veach 1997, chapters 8 to 10).

#include "integrator/path.h"

#include <algorithm>
#include <cmath>

namespace integrator {

namespace {

using math::Vec3;
using math::Vec4;

// Groups of four random numbers: 0 has the camera ray and the first direction, then two for each bounce.
constexpr std::uint32_t first_bounce_group = 1, groups_per_bounce = 2;

// Paths shorter than this are never ended by roulette.
constexpr int roulette_start = 3;
static_assert(roulette_start > 1, "the first direction leaves no number for roulette");

// Power heuristic, exponent 2 (Veach 1997, eq. 9.13), by ratio so that huge densities do not overflow.
float power_heuristic(float pdf, float other) {
  if (pdf == 0) return 0;
  const float ratio = other / pdf;
  return 1 / (1 + ratio * ratio);
}

// A ray's own random bits, by which surfaces that are partly transparent decide whether it passes.
std::uint32_t key(const World& w, const math::Sampler& sampler, std::uint32_t ray_number) {
  return w.blended ? sampler.bits(ray_number) : 0;
}

// Where a ray from `p` along `direction` starts, given where one along the geometric normal does.
Vec3 origin(const surface::Point& p, const Vec3& direction, const Vec3& outside) {
  return math::dot(direction, p.geometric_normal) < 0 ? surface::origin(p, direction) : outside;
}

bsdf::Bsdf prepare(const World& w, const surface::Point& p, const Vec3& wo) {
  if (p.plain_material < 0) return bsdf::prepare(w.model, w.gtr, p.material, p.normals, wo);
  bsdf::Bsdf bsdf = w.plain[static_cast<size_t>(p.plain_material)];
  bsdf::orient(bsdf, p.normals, wo);
  return bsdf;
}

// Light that arrives directly from one sampled light, from `wi` (shading frame), times the BRDF.
Vec3 direct_light(const World& w, const surface::Point& p, const light::Receiver& receiver,
                  const bsdf::Bsdf& bsdf, const Vec3& wo, const Vec4& u, std::uint32_t ray_key,
                  std::uint64_t& rays, Vec3& wi) {
  const auto light = w.lights.sample(receiver, math::join(u.z, u.w), u.x, u.y);
  if (!light) return Vec3(0);
  wi = p.frame.to_local(light->wi);
  const bsdf::Value f = bsdf::eval(bsdf, wo, wi);
  if (math::is_black(f.f_cos)) return Vec3(0);

  accel::Ray shadow{origin(p, light->wi, receiver.from), light->wi};
  if (!light->infinite) {
    shadow.direction = light->target - shadow.origin;
    shadow.t_max = 1;
  }
  ++rays;
  if (w.accel.occluded(shadow, ray_key)) return Vec3(0);
  const float weight = light->is_delta || w.light_sampling_only ? 1 : power_heuristic(light->pdf, f.pdf);
  return f.f_cos * light->radiance * (weight / light->pdf);
}

// What each lobe contributes to f_cos, per channel, in [0,1].
using Shares = std::array<Vec3, bsdf::eval_lobe_count>;
Shares shares_of(const bsdf::Bsdf& bsdf, const Vec3& wo, const Vec3& wi) {
  Shares f = bsdf::eval_lobes(bsdf, wo, wi);
  Vec3 sum(0);
  for (const Vec3& lobe : f) sum += lobe;
  for (Vec3& lobe : f)
    for (int c = 0; c < 3; ++c) lobe[c] = sum[c] > 0 ? lobe[c] / sum[c] : 0;
  return f;
}

}  // namespace

First first_of(const World& w, const accel::Ray& ray, const math::Sampler& sampler, std::uint64_t& rays) {
  accel::Hit hit;
  ++rays;
  if (!w.accel.closest(ray, key(w, sampler, 0), hit)) return {ray, false, {}, {}};
  return {ray, true, w.surfaces.at(ray, hit), {}};
}

Vec3 radiance(const World& w, const First& first, math::Sampler& sampler, std::uint64_t& rays, Parts* parts) {
  Vec3 sum(0), throughput(1);
  float bsdf_pdf = 0;        // density of the direction the ray was drawn with
  light::Receiver receiver;  // where it was drawn: everything is seen from the offset origin of shadow rays
  bool only_way = true;      // no light sample could have found what this ray finds: camera rays, mirrors
  std::uint32_t ray_number = 1;  // 0 was the camera's
  accel::Ray ray = first.ray;
  surface::Point next;
  Shares shares{};  // of the first surface's lobes in the throughput; kept for `parts` only
  if (parts) parts->fill(Vec3(0));
  const auto add = [&](const Vec3& light, const Shares& lobes, bool indirect) {
    sum += light;
    if (!parts) return;
    for (size_t i = 0; i < lobes.size(); ++i) (*parts)[1 + 2 * i + (indirect ? 1 : 0)] += light * lobes[i];
  };
  const auto add_found = [&](const Vec3& light, int bounce) {
    add(light, shares, bounce > 1);
    if (parts && bounce == 0) (*parts)[0] += light;
  };

  for (int bounce = 0;; ++bounce) {
    // Find the next surface.
    bool found = first.found;
    if (bounce > 0) {
      accel::Hit hit;
      ++rays;
      found = w.accel.closest(ray, key(w, sampler, ray_number++), hit);
      if (found) next = w.surfaces.at(ray, hit);
    }

    // Add the light the ray found, weighted against the chance that a light sample finds it too.
    if (!found) {
      if (w.lights.has_environment() && !(bounce == 0 && w.hide_environment)) {
        if (only_way) {
          add_found(throughput * w.lights.environment(ray.direction), bounce);
        } else if (!w.light_sampling_only) {
          const light::Environment::Seen seen = w.lights.environment(receiver, ray.direction);
          const float weight = power_heuristic(bsdf_pdf, seen.pdf);
          if (weight > 0) add_found(throughput * seen.radiance * weight, bounce);
        }
      }
      break;
    }
    const surface::Point& p = bounce > 0 ? next : first.point;
    if (!math::is_black(p.emission)) {
      float weight = 1;
      if (!only_way) {
        const float light_pdf = w.lights.pdf(receiver, p);
        weight = w.light_sampling_only ? (light_pdf > 0 ? 0.f : 1.f) : power_heuristic(bsdf_pdf, light_pdf);
      }
      add_found(throughput * p.emission * weight, bounce);
    }
    if (bounce == w.depth) break;

    // Prepare the BRDF.
    const Vec3 wo = p.frame.to_local(-ray.direction);
    const bsdf::Bsdf bsdf = prepare(w, p, wo);
    const std::uint32_t group = first_bounce_group + groups_per_bounce * static_cast<std::uint32_t>(bounce);

    receiver = {surface::origin(p, p.geometric_normal), p.frame.normal};

    // Add direct light from one light sample.
    if (!bsdf.only_delta && !w.lights.empty()) {
      Vec3 wi(0);
      const Vec3 light = throughput * direct_light(w, p, receiver, bsdf, wo, sampler.get(group + 1),
                                                   key(w, sampler, ray_number), rays, wi);
      add(light, parts && bounce == 0 ? shares_of(bsdf, wo, wi) : shares, bounce > 0);
    }
    ++ray_number;

    // Continue in a direction drawn from the BRDF. What a camera ray and the first direction do together is
    // most of the noise where textures or edges cross a pixel: their numbers are of one point, which has none
    // to spare for the lobe.
    const bool with_camera = bounce == 0 && first.direction;
    const Vec4 u = with_camera ? Vec4(0) : sampler.get(group);
    const auto s = with_camera ? bsdf::sample(bsdf, wo, first.direction->x, first.direction->y)
                               : bsdf::sample(bsdf, wo, u.z, u.x, u.y);
    if (!s || math::is_black(s->f_cos)) break;
    throughput *= s->f_cos * (1 / s->pdf);
    if (parts && bounce == 0) {
      if (s->is_delta)
        shares[s->lobe == bsdf::Lobe::specular ? 2 : 3] = Vec3(1);
      else
        shares = shares_of(bsdf, wo, s->wi);
    }
    bsdf_pdf = s->pdf;
    only_way = s->is_delta;
    ray.direction = math::renormalize(p.frame.to_world(s->wi));
    ray.origin = origin(p, ray.direction, receiver.from);

    // End weak paths by chance, the survivors carrying their share. The throughput itself or its square root
    // would end more of them and add more noise than that time is worth (docs/speed-notes.md).
    if (bounce + 1 >= roulette_start) {
      const float survival = std::min(1.f, std::sqrt(std::sqrt(math::max_component(throughput))));
      if (u.w >= survival) break;
      throughput /= survival;
    }
  }
  return sum;
}

Vec3 shade(const World& w, Shader shader, const accel::Ray& ray, const math::Sampler& sampler,
           std::uint64_t& rays) {
  accel::Hit hit;
  ++rays;
  if (!w.accel.closest(ray, key(w, sampler, 0), hit)) return Vec3(0);
  const surface::Point p = w.surfaces.at(ray, hit);
  switch (shader) {
    case Shader::normal:
      return p.normal;
    case Shader::texcoord:
      return {p.texcoord.x, p.texcoord.y, 0};
    case Shader::position:
      return p.position;
    case Shader::albedo: {
      const bsdf::Bsdf b =
          bsdf::prepare(w.model, w.gtr, p.material, p.normals, p.frame.to_local(-ray.direction));
      return bsdf::albedo(b);
    }
    case Shader::eyelight: {
      // A light at the eye that gives irradiance pi whatever the distance.
      const Vec3 wo = p.frame.to_local(-ray.direction);
      const bsdf::Bsdf b = bsdf::prepare(w.model, w.gtr, p.material, p.normals, wo);
      return p.emission + bsdf::eval(b, wo, wo).f_cos * math::pi;
    }
    default:
      return Vec3(0);
  }
}

}  // namespace integrator
