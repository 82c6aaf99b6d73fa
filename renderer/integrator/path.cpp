#include "integrator/path.h"

#include "integrator/walk.h"

namespace integrator {

using math::Vec3;

void find_first(const World& w, const accel::Ray& ray, const math::Sampler& sampler, std::uint64_t& rays,
                First& first) {
  accel::Hit hit;
  ++rays;
  first.ray = ray;
  first.found = w.accel.closest(ray, key(w, sampler, 0), hit);
  first.direction.reset();
  if (first.found) {
    first.point = w.surfaces.at(ray, hit);
    first.light = first.point.emission;
  } else {
    first.light = w.hide_environment ? Vec3(0) : w.lights.environment(ray.direction);
  }
}

Vec3 radiance(const World& w, const First& first, math::Sampler& sampler, std::uint64_t& rays, Parts* parts) {
  Walk walk(w, first, sampler, rays, parts);
  const bool found = walk.trace(0);
  walk.add_found(0, found);
  walk.go_on(0, found);
  return walk.sum;
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
