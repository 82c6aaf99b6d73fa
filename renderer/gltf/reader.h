// What the parts of the loader share: the guarded document, tinygltf's model of it, and the warnings.
#pragma once

#include <tiny_gltf.h>

#include <map>
#include <optional>

#include "gltf/guard.h"
#include "scene/scene.h"

namespace gltf {

struct Source {
  const Document& document;
  const Options& options;
  Warnings& warnings;
  scene::Scene& scene;                 // being filled
  tinygltf::Model model;               // structure only: no buffers, no images
  std::map<int, size_t> bitmaps = {};  // glTF image -> index into Scene::bitmaps
  std::int64_t pixels_left = static_cast<std::int64_t>(options.limits.image_pixels);
  std::uint64_t vertices = 0;  // read so far, against limits.vertices
};

// mesh.cpp. Primitive `primitive` of mesh `mesh` without its material; nothing, and a warning saying why, if
// there is nothing to render in it.
std::optional<scene::Mesh> read_primitive(Source& source, size_t mesh, size_t primitive);

// material.cpp. With its textures, whose images are decoded into Scene::bitmaps.
scene::Material read_material(Source& source, size_t material);

// texture.cpp. The textureInfo at `key` of a material or its pbrMetallicRoughness; one without bitmap if
// absent.
scene::Texture read_texture(Source& source, const nlohmann::json& object, const char* key);

}  // namespace gltf
