#include "light/lights.h"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "math/warp.h"

namespace light {

namespace {

using math::dot;
using math::luminance;
using math::Vec3;

// Up to this many lights, all are weighed by what they can send to the point; above it, by power alone.
// Weighing all 64 quads of a room against choosing by power doubled the efficiency; the cost grows with the
// number.
constexpr int exhaustive_limit = 128;

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

}  // namespace

Lights::Lights(const scene::Scene& scene, const surface::Surfaces& surfaces)
    : scene_(scene), surfaces_(surfaces) {
  emitter_of_.resize(scene.instances.size());
  Vec3 low(3e38f), high(-3e38f);
  for (size_t i = 0; i < scene.instances.size(); ++i) {
    const int instance = static_cast<int>(i);
    const auto& mesh = scene.meshes[static_cast<size_t>(scene.instances[i].mesh)];
    const scene::Material& material = surfaces.material(instance);
    for (const Vec3& p : mesh.positions) {
      const Vec3 w = math::transform_point(scene.instances[i].to_world, p);
      low = glm::vec3(std::min(low.x, w.x), std::min(low.y, w.y), std::min(low.z, w.z));
      high = glm::vec3(std::max(high.x, w.x), std::max(high.y, w.y), std::max(high.z, w.z));
    }
    if (math::is_black(material.emission)) continue;
    emitter_of_[i].assign(mesh.triangles.size(), -1);
    for (size_t t = 0; t < mesh.triangles.size(); ++t) {
      Emitter e{instance, static_cast<int>(t),  surfaces.triangle(instance, static_cast<int>(t)), {}, 0,
                0,        material.double_sided};
      e.flux = e.shape.area * mean_luminance(surfaces, instance, e.triangle);
      if (!(e.flux > 0) || !std::isfinite(e.flux)) continue;
      e.centre = (e.shape.p0 + e.shape.p1 + e.shape.p2) / 3.f;
      e.radius = std::max({math::length(e.shape.p0 - e.centre), math::length(e.shape.p1 - e.centre),
                           math::length(e.shape.p2 - e.centre)});
      emitter_of_[i][t] = static_cast<int>(emitters_.size());
      emitters_.push_back(e);
    }
  }
  scene_radius_ = low.x <= high.x ? .5f * math::length(high - low) : 1;
  if (scene.environment) {
    environment_.emplace(*scene.environment);
    // A black environment (or strength) is kept for what it shows and never sampled.
  }
  const bool sample_environment = environment_ && !environment_->black() && scene.environment->strength > 0;
  count_ = static_cast<int>(scene.lights.size() + emitters_.size()) + (sample_environment ? 1 : 0);

  if (count_ > exhaustive_limit) {
    const double disk = 3.14159265358979 * scene_radius_ * scene_radius_;
    std::vector<double> power;
    for (const scene::Light& l : scene.lights)
      power.push_back(luminance(l.intensity) *
                      (l.kind == scene::LightKind::directional ? disk : 12.566370614359172));
    for (const Emitter& e : emitters_) power.push_back(e.flux * 3.14159265358979 * (e.two_sided ? 2 : 1));
    if (sample_environment) power.push_back(environment_->mean_luminance() * 3.14159265358979 * 4 * disk);
    by_power_ = math::Distribution1D(power);
    if (by_power_.empty()) count_ = 0;
  }
}

// Bound-like estimate of the irradiance a light can cause at `from`; 0 only if it sends nothing there.
float Lights::importance(const Vec3& from, int index) const {
  const int punctual = static_cast<int>(scene_.lights.size());
  if (index < punctual) {
    const scene::Light& l = scene_.lights[static_cast<size_t>(index)];
    if (l.kind == scene::LightKind::directional) return luminance(l.intensity);
    const Vec3 d = l.position - from;
    const float d2 = std::max(dot(d, d), 1e-20f);
    return luminance(l.intensity) / d2 * (l.kind == scene::LightKind::spot ? spot(l, d / std::sqrt(d2)) : 1);
  }
  if (index == punctual + static_cast<int>(emitters_.size()))
    return static_cast<float>(environment_->mean_luminance()) * math::pi;
  const Emitter& e = emitters_[static_cast<size_t>(index - punctual)];
  const Vec3 d = from - e.centre;
  const float height = dot(e.shape.normal, d);  // above the triangle's plane
  if (!e.two_sided && height <= 0) return 0;
  const float d2 = std::max(dot(d, d), e.radius * e.radius);
  const float cosine = std::min(1.f, (std::fabs(height) + .1f * e.radius) / std::sqrt(d2));
  return e.flux * cosine / std::max(d2, 1e-30f);
}

float Lights::probability(const Vec3& from, int index) const {
  if (!by_power_.empty()) return by_power_.probability(static_cast<std::uint32_t>(index));
  if (count_ == 1) return 1;
  float sum = 0, own = 0;
  for (int i = 0; i < count_; ++i) {
    const float w = importance(from, i);
    sum += w;
    if (i == index) own = w;
  }
  return sum > 0 ? own / sum : 0;
}

std::optional<Sample> Lights::sample(const Vec3& from, float u_choice, float u, float v) const {
  if (count_ == 0) return std::nullopt;
  int index = 0;
  float chance = 1;
  if (!by_power_.empty()) {
    const auto choice = by_power_.sample(u_choice);
    index = static_cast<int>(choice.index);
    chance = choice.probability;
  } else if (count_ > 1) {
    float weights[exhaustive_limit];
    float sum = 0;
    for (int i = 0; i < count_; ++i) sum += weights[i] = importance(from, i);
    if (!(sum > 0) || !std::isfinite(sum)) return std::nullopt;
    float rest = u_choice * sum;
    int last = -1;
    for (index = 0; index < count_; ++index) {
      if (!(weights[index] > 0)) continue;
      last = index;
      if (rest < weights[index]) break;
      rest -= weights[index];
    }
    assert(last >= 0);  // the sum is positive
    index = last;
    chance = weights[index] / sum;
  }

  const int punctual = static_cast<int>(scene_.lights.size());
  std::optional<Sample> s;
  if (index < punctual) {
    s = sample_punctual(scene_.lights[static_cast<size_t>(index)], from);
  } else if (index < punctual + static_cast<int>(emitters_.size())) {
    s = sample_emitter(emitters_[static_cast<size_t>(index - punctual)], from, u, v);
  } else {
    const Environment::Sample e = environment_->sample(u, v);
    s = Sample{e.direction, {}, true, environment_->radiance(e.direction), e.pdf, false};
  }
  if (s) s->pdf *= chance;
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

std::optional<Sample> Lights::sample_emitter(const Emitter& e, const Vec3& from, float u, float v) const {
  const Vec3 b = math::sample_triangle(u, v);
  const Vec3 p = e.shape.p0 * b.x + e.shape.p1 * b.y + e.shape.p2 * b.z;
  const Vec3 d = p - from;
  const float d2 = dot(d, d);
  if (!(d2 > 0)) return std::nullopt;
  Sample s;
  s.wi = d / std::sqrt(d2);
  const float cosine = -dot(e.shape.normal, s.wi);
  if (cosine == 0 || (!e.two_sided && cosine < 0)) return std::nullopt;
  s.pdf = d2 / (std::fabs(cosine) * e.shape.area);
  if (!std::isfinite(s.pdf)) return std::nullopt;
  s.radiance = surfaces_.emission(e.instance, e.triangle, b) * surfaces_.coverage(e.instance, e.triangle, b);
  // The shadow ray ends just in front of the light, on the side it is seen from.
  s.target = surface::offset(p, surfaces_.error(e.instance, e.triangle, b),
                             cosine < 0 ? -e.shape.normal : e.shape.normal);
  return s;
}

float Lights::pdf(const Vec3& from, const surface::Point& p) const {
  const auto& table = emitter_of_[static_cast<size_t>(p.instance)];
  if (table.empty()) return 0;
  const int index = table[static_cast<size_t>(p.triangle)];
  if (index < 0) return 0;
  const Emitter& e = emitters_[static_cast<size_t>(index)];
  const Vec3 d = p.position - from;
  const float d2 = dot(d, d);
  const float cosine = std::fabs(dot(e.shape.normal, d)) / std::sqrt(d2);
  const float area_pdf = d2 / (cosine * e.shape.area);
  if (!std::isfinite(area_pdf)) return 0;
  return area_pdf * probability(from, static_cast<int>(scene_.lights.size()) + index);
}

float Lights::pdf_environment(const Vec3& from, const Vec3& wi) const {
  const int index = static_cast<int>(scene_.lights.size() + emitters_.size());
  if (index >= count_) return 0;
  return environment_->pdf(wi) * probability(from, index);
}

}  // namespace light
