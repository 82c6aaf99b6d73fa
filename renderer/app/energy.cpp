#include "app/energy.h"

#include <cstdio>
#include <set>

#include "bsdf/disney.h"

namespace app {

double directional_albedo(const scene::Material& material, float d_gamma, float d_constant, float cos_theta) {
  bsdf::Parameters parameters;
  parameters.base_color = material.base_color;
  parameters.metallic = material.metallic;
  parameters.roughness = material.roughness;
  parameters.specular = material.specular;
  parameters.specular_tint = material.specular_tint;
  const math::Vec3 wo{std::sqrt(1 - cos_theta * cos_theta), 0, cos_theta};
  const bsdf::Bsdf brdf = bsdf::prepare(bsdf::Model::path_disney, {d_gamma, d_constant}, parameters, {}, wo);

  // The mean of f_cos / pdf over a regular grid of the sampler's square, lobe by lobe in proportion.
  constexpr int grid = 32;
  constexpr float step = 1.f / grid;
  double sum[3] = {0, 0, 0};
  for (int i = 0; i < grid; ++i)
    for (int j = 0; j < grid; ++j)
      for (int k = 0; k < grid; ++k) {
        const float u_lobe = (static_cast<float>(i) + .5f) * step;
        const float u = (static_cast<float>(j) + .5f) * step, v = (static_cast<float>(k) + .5f) * step;
        const std::optional<bsdf::Sample> sample = bsdf::sample(brdf, wo, u_lobe, u, v);
        if (!sample || !(sample->pdf > 0)) continue;
        for (int c = 0; c < 3; ++c) sum[c] += static_cast<double>(sample->f_cos[c]) / sample->pdf;
      }
  return std::fmax(sum[0], std::fmax(sum[1], sum[2])) * step * step * step;
}

std::optional<std::string> energy_warning(const scene::Scene& scene, float d_gamma, float d_constant) {
  std::set<int> used;
  for (const scene::Instance& instance : scene.instances)
    used.insert(scene.meshes[static_cast<size_t>(instance.mesh)].material);

  double worst = 1.01;  // the integral is good to a per cent
  const scene::Material* culprit = nullptr;
  for (int index : used)
    for (float cos_theta : {1.f, .7f, .3f}) {
      const scene::Material& material = scene.materials[static_cast<size_t>(index)];
      const double albedo = directional_albedo(material, d_gamma, d_constant, cos_theta);
      if (albedo <= worst) continue;
      worst = albedo;
      culprit = &material;
    }
  if (culprit == nullptr) return {};
  char text[320];
  std::snprintf(text, sizeof text,
                "--d-constant %g with --d-gamma %g is not normalised: material '%.100s' (roughness %g) "
                "reflects up to %.3g "
                "times the light it gets; --d-constant auto is normalised",
                static_cast<double>(d_constant), static_cast<double>(d_gamma), culprit->name.c_str(),
                static_cast<double>(culprit->roughness), worst);
  return text;
}

}  // namespace app
