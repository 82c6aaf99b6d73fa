#include "light/lights.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "math/warp.h"

namespace light {

namespace {

using math::dot;
using math::DVec3;
using math::luminance;
using math::Vec3;

// Emitters nearer than this many of their radii are sampled by solid angle, others by area: there the two
// differ by less than their costs. Measured from 1.5 to 6.
constexpr float near_radii = 3;

// Mean emitted luminance of a triangle: its texture is looked at in 16 points.
float mean_luminance(const surface::Surfaces& surfaces, int instance, int triangle) {
  if (surfaces.material(instance).emissive_texture.bitmap < 0)
    return luminance(surfaces.material(instance).emission);
  float sum = 0;
  for (int i = 0; i < 16; ++i) {
    const int row = i / 4, column = i % 4;
    const Vec3 b =
        math::sample_triangle((static_cast<float>(column) + .5f) / 4, (static_cast<float>(row) + .5f) / 4);
    sum += luminance(surfaces.emission(instance, triangle, b));
  }
  // A texture may hide light from all 16 points: every triangle that might emit keeps a share.
  return sum / 16 + .01f * luminance(surfaces.material(instance).emission);
}

float spot(const scene::Light& l, const Vec3& wi) {
  // KHR_lights_punctual's recommended falloff.
  const float c = -dot(l.direction, wi);
  const float t = math::saturate((c - l.cos_outer) / std::max(.001f, l.cos_inner - l.cos_outer));
  return t * t;
}

// Whether corner + x + y is the far corner, within what the rounding of coordinates leaves of right angles.
bool is_rectangle(const Vec3& x, const Vec3& y, const Vec3& far_from_corner) {
  const float size = math::length(x) + math::length(y);
  return std::fabs(dot(x, y)) <= 1e-5f * math::length(x) * math::length(y) &&
         math::length(x + y - far_from_corner) <= 1e-5f * size;
}

}  // namespace

// The emissive triangles of an instance, those that make a rectangle joined. Two such triangles have their
// right angles opposite the same edge.
std::vector<Lights::Emitter> Lights::find_emitters(int instance) const {
  const auto& mesh = scene_.meshes[static_cast<size_t>(scene_.instances[static_cast<size_t>(instance)].mesh)];
  std::vector<Emitter> found;
  std::map<std::array<float, 6>, size_t> by_hypotenuse;  // its end points -> index into found
  for (size_t t = 0; t < mesh.triangles.size(); ++t) {
    const surface::Triangle shape = surfaces_.triangle(instance, static_cast<int>(t));
    const Vec3 p[3] = {shape.p0, shape.p1, shape.p2};
    // Begin at the corner whose angle is largest.
    int k = 0;
    float longest = 0;
    for (int i = 0; i < 3; ++i) {
      const float side = math::length(p[(i + 1) % 3] - p[(i + 2) % 3]);
      if (side > longest) longest = side, k = i;
    }
    const int k1 = (k + 1) % 3, k2 = (k + 2) % 3;
    const scene::Material& material = surfaces_.material(instance);
    const Vec3 x = p[k1] - p[k], y = p[k2] - p[k];
    Emitter e{p[k],
              x,
              y,
              p[k] + (x + y) * .5f,
              math::sqr(.5f * near_radii) * dot(x - y, x - y),
              math::length(DVec3(x)),
              math::length(DVec3(y)),
              {},
              {},
              shape.normal,
              shape.area,
              instance,
              static_cast<int>(t),
              -1,
              {},
              {},
              material.double_sided};
    if (material.emissive_texture.bitmap < 0 && material.alpha_mode == scene::AlphaMode::opaque)
      e.even = true, e.emission = material.emission;
    e.unit_x = DVec3(x) / e.width, e.unit_y = DVec3(y) / e.height;
    for (int i = 0; i < 3; ++i) {
      e.vertex[i] = static_cast<std::uint8_t>((k + i) % 3);
      e.error = math::larger(e.error, surfaces_.error(instance, e.triangle, Vec3(i == 0, i == 1, i == 2)));
    }

    const auto ends = [](const Vec3& a, const Vec3& b) { return std::array{a.x, a.y, a.z, b.x, b.y, b.z}; };
    if (const auto other = by_hypotenuse.find(ends(p[k2], p[k1])); other != by_hypotenuse.end()) {
      Emitter& first = found[other->second];
      if (first.second < 0 && is_rectangle(first.x, first.y, p[k] - first.corner) &&
          dot(first.normal, e.normal) > .999f) {
        first.second = e.triangle;
        first.area += e.area;
        first.error = math::larger(first.error, e.error);
        first.vertex_second[0] = e.vertex[0];
        first.vertex_second[1] = e.vertex[2];  // this one's sides run the other way
        first.vertex_second[2] = e.vertex[1];
        continue;
      }
    }
    by_hypotenuse.try_emplace(ends(p[k1], p[k2]), found.size());
    found.push_back(e);
  }
  return found;
}

Lights::Lights(const scene::Scene& scene, const surface::Surfaces& surfaces, bool light_sampling_only)
    : scene_(scene), surfaces_(surfaces) {
  std::vector<Bounds> near;
  std::vector<Distant> distant;
  for (const scene::Light& l : scene.lights) {
    const float intensity = luminance(l.intensity);
    if (!(intensity > 0)) continue;
    if (l.kind == scene::LightKind::directional) {
      directional_.push_back(&l);
      distant.push_back({intensity, -l.direction});
      continue;
    }
    near_.push_back(&l);
    const bool spot = l.kind == scene::LightKind::spot;
    near.push_back(
        {l.position, l.position, l.direction, spot ? 1.f : -1.f, spot ? l.cos_outer : 0, false, intensity});
  }
  emitter_of_.resize(scene.instances.size());
  for (size_t i = 0; i < scene.instances.size(); ++i) {
    const int instance = static_cast<int>(i);
    if (math::is_black(surfaces.material(instance).emission)) continue;
    emitter_of_[i].assign(scene.meshes[static_cast<size_t>(scene.instances[i].mesh)].triangles.size(), -1);
    for (const Emitter& e : find_emitters(instance)) {
      const float light = e.second < 0 ? mean_luminance(surfaces, instance, e.triangle)
                                       : .5f * (mean_luminance(surfaces, instance, e.triangle) +
                                                mean_luminance(surfaces, instance, e.second));
      const float flux = light * e.area;
      if (!(flux > 0) || !std::isfinite(flux)) continue;
      for (const int t : {e.triangle, e.second})
        if (t >= 0) emitter_of_[i][static_cast<size_t>(t)] = static_cast<int>(emitters_.size());
      emitters_.push_back(e);
      Bounds b{e.corner, e.corner, e.normal, 1, 0, e.two_sided, flux};
      for (const Vec3& p : {e.corner + e.x, e.corner + e.y, e.corner + (e.second < 0 ? e.x : e.x + e.y)})
        b.low = math::smaller(b.low, p), b.high = math::larger(b.high, p);
      near.push_back(b);
    }
  }
  // A black environment (or strength) is kept for what it shows and never sampled.
  if (scene.environment) environment_.emplace(*scene.environment, light_sampling_only);
  samples_environment_ = environment_ && environment_->sampled() && scene.environment->strength > 0;
  if (samples_environment_)
    distant.push_back({static_cast<float>(environment_->drawn_luminance()) * math::pi, Vec3(0)});
  tree_ = Tree(std::move(near), std::move(distant));
}

std::optional<Sample> Lights::sample(const Receiver& receiver, double u_choice, float u, float v) const {
  const auto choice = tree_.sample(receiver, u_choice);
  if (!choice) return std::nullopt;
  const auto index = static_cast<size_t>(choice->light), emitter = index - near_.size(),
             directional = emitter - emitters_.size();
  std::optional<Sample> s;
  if (index < near_.size()) {
    s = sample_punctual(*near_[index], receiver.from);
  } else if (emitter < emitters_.size()) {
    s = sample_emitter(emitters_[emitter], receiver.from, u, v);
  } else if (directional < directional_.size()) {
    s = sample_punctual(*directional_[directional], receiver.from);
  } else {
    const Environment::Sample e = environment_->sample(u, v);
    s = Sample{e.direction, {}, true, e.seen.radiance, e.seen.pdf, false};
  }
  if (s) s->pdf *= choice->probability;
  if (s && !(s->pdf > 0)) s.reset();
  return s;
}

std::optional<Sample> Lights::sample_punctual(const scene::Light& l, const Vec3& from) const {
  Sample s;
  s.is_delta = true;
  s.pdf = 1;
  if (l.kind == scene::LightKind::directional) {
    s.wi = -l.direction;
    s.infinite = true;
    s.radiance = l.intensity;
    return s;
  }
  s.target = l.position;
  const Vec3 d = l.position - from;
  const float d2 = dot(d, d);
  if (!(d2 > 0)) return std::nullopt;
  s.wi = d / std::sqrt(d2);
  s.radiance = l.intensity / d2;
  if (l.kind == scene::LightKind::spot) s.radiance *= spot(l, s.wi);
  return s;
}

namespace {

// Solid angles below this have lost their last digits.
constexpr double least_solid_angle = 1e-8;

}  // namespace

bool Lights::is_near(const Emitter& e, const Vec3& from) {
  const Vec3 d = e.centre - from;
  return dot(d, d) < e.near2;
}

math::SphericalRectangle Lights::rectangle(const Emitter& e, const Vec3& from) {
  return {DVec3(e.corner) - DVec3(from), e.unit_x, e.unit_y, e.width, e.height};
}

math::SphericalTriangle Lights::triangle(const Emitter& e, const Vec3& from) {
  const DVec3 corner = DVec3(e.corner) - DVec3(from);
  return {corner, corner + DVec3(e.x), corner + DVec3(e.y)};
}

// What the triangle that holds the point corner + a x + b y emits there, looked up.
Vec3 Lights::radiance(const Emitter& e, float a, float b) const {
  const bool second = e.second >= 0 && a + b > 1;
  const float weights[3] = {second ? a + b - 1 : 1 - a - b, second ? 1 - b : a, second ? 1 - a : b};
  const int t = second ? e.second : e.triangle;
  Vec3 barycentric;
  for (int i = 0; i < 3; ++i) barycentric[(second ? e.vertex_second : e.vertex)[i]] = weights[i];
  return surfaces_.emission(e.instance, t, barycentric) * surfaces_.coverage(e.instance, t, barycentric);
}

std::optional<Sample> Lights::sample_emitter(const Emitter& e, const Vec3& from, float u, float v) const {
  // Draw the point corner + a x + b y: by solid angle, or by area, so that pdf stays 0 here.
  float pdf = 0, a = u, b = v;
  if (is_near(e, from) && e.second >= 0) {
    const math::SphericalRectangle shape = rectangle(e, from);
    if (shape.solid_angle() > least_solid_angle) {
      const math::DVec2 p = shape.sample(u, v);
      a = static_cast<float>(p.x), b = static_cast<float>(p.y);
      pdf = static_cast<float>(1 / shape.solid_angle());
    }
  } else if (is_near(e, from)) {
    const math::SphericalTriangle shape = triangle(e, from);
    if (shape.solid_angle() > least_solid_angle) {
      const DVec3 weights = shape.sample(u, v);
      a = static_cast<float>(weights.y), b = static_cast<float>(weights.z);
      pdf = static_cast<float>(1 / shape.solid_angle());
    }
  }
  if (pdf == 0 && e.second < 0) {
    const Vec3 weights = math::sample_triangle(u, v);
    a = weights.y, b = weights.z;
  }

  Sample s;
  const Vec3 p = e.corner + e.x * a + e.y * b, d = p - from;
  const float d2 = dot(d, d);
  if (!(d2 > 0)) return std::nullopt;
  s.wi = d * (1 / std::sqrt(d2));
  const float cosine = -dot(e.normal, s.wi);
  if (cosine == 0 || (!e.two_sided && cosine < 0)) return std::nullopt;
  s.pdf = pdf > 0 ? pdf : d2 / (std::fabs(cosine) * e.area);
  if (!std::isfinite(s.pdf)) return std::nullopt;

  s.radiance = e.even ? e.emission : radiance(e, a, b);
  // The shadow ray ends just in front of the light, on the side it is seen from.
  s.target = surface::offset(p, e.error, cosine < 0 ? -e.normal : e.normal);
  return s;
}

float Lights::pdf(const Receiver& receiver, const surface::Point& p) const {
  const auto& table = emitter_of_[static_cast<size_t>(p.instance)];
  if (table.empty()) return 0;
  const int index = table[static_cast<size_t>(p.triangle)];
  if (index < 0) return 0;
  const Emitter& e = emitters_[static_cast<size_t>(index)];
  float pdf = 0;
  if (is_near(e, receiver.from)) {
    const double solid_angle =
        e.second >= 0 ? rectangle(e, receiver.from).solid_angle() : triangle(e, receiver.from).solid_angle();
    if (solid_angle > least_solid_angle) pdf = static_cast<float>(1 / solid_angle);
  }
  if (pdf == 0) {
    const Vec3 d = p.position - receiver.from;
    const float d2 = dot(d, d);
    const float cosine = std::fabs(dot(e.normal, d)) / std::sqrt(d2);
    pdf = d2 / (cosine * e.area);
    if (!std::isfinite(pdf)) return 0;
  }
  return pdf * tree_.probability(receiver, static_cast<int>(near_.size()) + index);
}

Environment::Seen Lights::environment(const Receiver& receiver, const Vec3& wi) const {
  Environment::Seen seen = environment_->look(wi);
  const size_t index = near_.size() + emitters_.size() + directional_.size();
  seen.pdf *= samples_environment_ ? tree_.probability(receiver, static_cast<int>(index)) : 0;
  return seen;
}

}  // namespace light
