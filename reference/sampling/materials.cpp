// The table of materials and directions that the sampling is tested with.
#include <cmath>
#include <stdexcept>

#include "sampling/subject.h"

namespace sampling {
namespace {

using bsdf::Gtr;
using bsdf::Model;
using bsdf::Parameters;

Parameters black() {
  Parameters p;
  p.base_color = Vec3(0);
  p.specular = 0;
  return p;
}
Parameters plastic(float roughness, float specular = .5f) {
  Parameters p;
  p.base_color = {.8f, .5f, .2f};
  p.roughness = roughness;
  p.specular = specular;
  return p;
}
Parameters metal(float roughness, float anisotropic = 0) {
  Parameters p = plastic(roughness);
  p.metallic = 1;
  p.anisotropic = anisotropic;
  return p;
}
Parameters coat(float roughness) {
  Parameters p = black();
  p.clearcoat = 1;
  p.clearcoat_roughness = roughness;
  return p;
}
// Burley's gloss, whose alpha runs from .1 to .001.
Parameters glossy_coat(float gloss) { return coat(std::sqrt(.1f + (.001f - .1f) * gloss)); }
Parameters coated(Parameters p, float roughness) {
  p.clearcoat = 1;
  p.clearcoat_roughness = roughness;
  return p;
}
Parameters cloth() {
  Parameters p = plastic(.9f, 0);
  p.base_color = {.1f, .02f, .05f};
  p.sheen = p.sheen_tint = 1;
  return p;
}
Parameters everything(float roughness, float coat_roughness) {
  Parameters p = coated(plastic(roughness, 1), coat_roughness);
  p.metallic = .3f;
  p.anisotropic = .8f;
  p.specular_tint = p.sheen = 1;
  return p;
}

std::vector<Material> table() {
  const Model d = Model::disney, b = Model::principled, r = Model::path_disney, g = Model::path;
  return {
      {"disney plastic", d, plastic(.5f)},
      {"disney diffuse alone, smooth", d, plastic(0), {}, diffuse},
      {"disney diffuse alone, rough", d, plastic(1), {}, diffuse},
      {"disney plastic of alpha .001", d, plastic(0, 1)},
      {"disney metal of roughness 1", d, metal(1)},
      {"disney metal of roughness .7", d, metal(.7f)},
      {"disney metal of roughness .3", d, metal(.3f)},
      {"disney metal of alpha .01", d, metal(.1f)},
      {"disney metal of alpha .001", d, metal(0)},
      {"disney metal, all anisotropic, roughness .3", d, metal(.3f, 1)},
      {"disney metal, all anisotropic, roughness 1", d, metal(1, 1)},
      {"disney metal, all anisotropic, roughness .03", d, metal(.03f, 1)},
      {"disney metal, half anisotropic, roughness .1", d, metal(.1f, .5f)},
      {"disney clearcoat alone, gloss 0", d, glossy_coat(0), {}, clearcoat},
      {"disney clearcoat alone, gloss .5", d, glossy_coat(.5f), {}, clearcoat},
      {"disney clearcoat alone, gloss 1", d, glossy_coat(1), {}, clearcoat},
      {"disney clearcoat alone, alpha 1", d, coat(1), {}, clearcoat},
      {"disney plastic under a coat of gloss 1", d, coated(plastic(.4f), .0316f)},
      {"disney sheen and diffuse", d, cloth(), {}, diffuse},
      {"disney cloth", d, cloth()},
      {"disney everything, glossy", d, everything(.25f, .1f)},
      {"principled plastic", b, plastic(.5f)},
      {"principled metal of roughness .2", b, metal(.2f)},
      {"principled metal just above a mirror", b, metal(.018f)},
      {"principled metal, all anisotropic, roughness .3", b, metal(.3f, 1)},
      {"principled metal, all anisotropic, roughness 1", b, metal(1, 1)},
      {"principled clearcoat alone, roughness .03", b, coat(.03f), {}, clearcoat},
      {"principled clearcoat alone, roughness 1", b, coat(1), {}, clearcoat},
      {"principled everything", b, everything(.6f, .2f)},
      {"principled mirror among other lobes", b, everything(0, .3f)},
      {"path_disney plastic, gamma 2", r, plastic(.5f), {2, {}}},
      {"path_disney metal, gamma 2, alpha .001", r, metal(0), {2, {}}},
      {"path_disney metal, gamma 2, constant .03", r, metal(.5f), {2, .03f}},
      {"path_disney metal, gamma 1, roughness .3", r, metal(.3f), {1, {}}},
      {"path_disney metal, gamma 1.5, roughness .1", r, metal(.1f), {1.5f, {}}},
      {"path_disney metal, gamma .5, roughness .2", r, metal(.2f), {.5f, {}}},
      {"path_disney metal, gamma .05, alpha .001", r, metal(0), {.05f, {}}},
      {"path_disney metal, gamma 5, roughness .6", r, metal(.6f), {5, {}}},
      {"path_disney metal, gamma 10, roughness .9", r, metal(.9f), {10, {}}},
      {"path_disney metal, gamma 10, alpha .001", r, metal(0), {10, {}}},
      {"path Lambert", g, plastic(.5f, 0)},
      {"path plastic", g, plastic(.3f)},
      {"path metal of roughness 1", g, metal(1)},
      {"path metal of roughness .2", g, metal(.2f)},
      {"path metal of alpha .001", g, metal(0)},
  };
}

}  // namespace

const std::vector<Material>& materials() {
  static const std::vector<Material> list = table();
  return list;
}

const Material& material(const std::string& name) {
  for (const Material& m : materials())
    if (m.name == name) return m;
  throw std::invalid_argument("no material is called " + name);
}

Bsdf at(const Material& m, const Vec3& wo) {
  Bsdf b = bsdf::prepare(m.model, m.gtr, m.parameters, {}, wo);
  if (m.lobes == all) return b;
  float left = 0;
  for (int i = 0; i < bsdf::lobe_count; ++i) {
    if (!(m.lobes >> i & 1)) b.probability[i] = 0;
    left += b.probability[i];
  }
  for (float& p : b.probability) p /= left;
  return b;
}

Subject honest(const Bsdf& b, const Vec3& wo) {
  return {wo, b, [b, wo](const Vec3& wi) { return bsdf::eval(b, wo, wi); },
          [b, wo](float u_lobe, float u, float v) { return bsdf::sample(b, wo, u_lobe, u, v); }};
}

Vec3 direction(double cosine, double azimuth) {
  const double sine = std::sqrt((1 - cosine) * (1 + cosine));
  return {static_cast<float>(sine * std::cos(azimuth)), static_cast<float>(sine * std::sin(azimuth)),
          static_cast<float>(cosine)};
}

Vec3 direction(int which) {
  constexpr double cosines[direction_count] = {1, .95, .7, .5, .3, .1, .05, .02};
  return direction(cosines[which], .3 + .9 * which);
}

}  // namespace sampling
