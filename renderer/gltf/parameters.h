// Disney's parameters beyond glTF's own, by the name that files ("disney_" before it) and --info have for
// them.
#pragma once

#include "scene/scene.h"

namespace gltf {

struct Parameter {
  const char* name;
  float scene::Material::*member;
};
inline constexpr Parameter disney_parameters[] = {
    {"specular", &scene::Material::specular},
    {"specular_tint", &scene::Material::specular_tint},
    {"anisotropic", &scene::Material::anisotropic},
    {"anisotropic_rotation", &scene::Material::anisotropic_rotation},
    {"sheen", &scene::Material::sheen},
    {"sheen_tint", &scene::Material::sheen_tint},
    {"clearcoat", &scene::Material::clearcoat},
    {"clearcoat_roughness", &scene::Material::clearcoat_roughness}};

}  // namespace gltf
