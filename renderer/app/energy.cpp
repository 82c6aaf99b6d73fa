#include "app/energy.h"

#include <algorithm>
#include <set>
#include <sstream>

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

  // The mean of f_cos / pdf over a regular grid of the sampler's cube.
  constexpr int grid = 32, cells = grid * grid * grid;
  const auto centre = [](int i) { return (static_cast<float>(i % grid) + .5f) / grid; };
  double sum[3] = {0, 0, 0};
  for (int i = 0; i < cells; ++i) {
    const auto sample = bsdf::sample(brdf, wo, centre(i / grid / grid), centre(i / grid), centre(i));
    for (int c = 0; c < 3 && sample && sample->pdf > 0; ++c)
      sum[c] += static_cast<double>(sample->f_cos[c]) / sample->pdf;
  }
  return std::max({sum[0], sum[1], sum[2]}) / cells;
}

std::string energy_warning(const scene::Scene& scene, const integrator::Settings& settings) {
  if (settings.shader != integrator::Shader::path_disney || !settings.d_constant) return "";
  double worst = 1.01;  // the integral is good to a per cent
  const scene::Material* culprit = nullptr;
  std::set<int> seen;
  for (const scene::Instance& instance : scene.instances) {
    const int index = scene.meshes[static_cast<size_t>(instance.mesh)].material;
    if (!seen.insert(index).second) continue;
    const scene::Material& material = scene.materials[static_cast<size_t>(index)];
    for (const float cos_theta : {1.f, .7f, .3f}) {
      const double albedo = directional_albedo(material, settings.d_gamma, *settings.d_constant, cos_theta);
      if (albedo <= worst) continue;
      worst = albedo;
      culprit = &material;
    }
  }
  if (culprit == nullptr) return "";
  std::ostringstream text;
  text.precision(3);
  text << "--d-constant " << *settings.d_constant << " with --d-gamma " << settings.d_gamma
       << " is not normalised: material '" << culprit->name << "' (roughness " << culprit->roughness
       << ") reflects up to " << worst << " times the light it gets; --d-constant auto is normalised";
  return text.str();
}

}  // namespace app
