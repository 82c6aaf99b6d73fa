// An edited scene back into glTF: the file it came from with the edited values in it, everything else kept.
// gltf::load() of the result gives the edited values bit by bit.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "gltf/load.h"

namespace view {

struct MaterialEdit {
  size_t index = 0;  // into Scene::materials
  scene::Material before, after;
};

struct CameraEdit {  // becomes a camera of a node of its own, the last of the scene
  scene::Camera camera;
  math::DMat4 to_world{1.0};  // of which gltf::camera_frame() is camera.to_world
};

struct EnvironmentEdit {
  // A map, or a constant one, which needs no file; its rotation is not read:
  scene::Environment environment;
  float rotation_degrees = 0;
};

struct Edits {
  std::vector<MaterialEdit> materials;
  std::vector<scene::Light> lights;  // by their `node`: intensity, position and a spot's cones are written
  std::optional<CameraEdit> camera;
  std::optional<EnvironmentEdit> environment;
};

// `target` is a .gltf or a .glb. A .glb holds everything but the environment map, which stands beside it;
// a .gltf that names files goes only into the folder of the original. Materials get their values in core
// glTF, in the disney_* extras and, where a coat was edited, in KHR_materials_clearcoat; an extension that
// only approximates an edited parameter (KHR_materials_specular, _ior, _sheen, _anisotropy) is taken out.
// `options`: with which it was loaded. `hash`: the scene's, so that a file which changed since it was loaded
// is noticed. Throws base::Error.
void write_gltf(const std::string& original, const std::string& hash, const std::string& target,
                const Edits& edits, const gltf::Options& options = {});

}  // namespace view
