// path_disney with a constant of the user's choice is not normalised and may reflect more than it receives;
// such a picture need not converge.
#pragma once

#include <string>

#include "integrator/render.h"
#include "scene/scene.h"

namespace app {

// Reflected over received power of a material lit from the direction at `cos_theta` to the normal (by
// reciprocity also its reflectance seen from there under a white sky), largest channel, without its textures.
double directional_albedo(const scene::Material& material, float d_gamma, float d_constant, float cos_theta);

// One line about the material in use that creates most energy; empty if none does.
std::string energy_warning(const scene::Scene& scene, const integrator::Settings& settings);

}  // namespace app
