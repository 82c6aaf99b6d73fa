// What the parts of the loader share: the guarded document, tinygltf's model of it, and the warnings.
#pragma once

#include <tiny_gltf.h>

#include <map>
#include <optional>

#include "gltf/guard.h"
#include "scene/scene.h"

namespace gltf {

struct Before {  // an order of spans by where they lie
  bool operator()(const Span& a, const Span& b) const {
    return std::pair(a.data(), a.size()) < std::pair(b.data(), b.size());
  }
};

struct Source {
  const Document& document;
  const Options& options;
  Warnings& warnings;
  scene::Scene& scene;                          // being filled
  tinygltf::Model model;                        // structure only: no buffers, no images
  std::map<Span, size_t, Before> bitmaps = {};  // encoded image -> index into Scene::bitmaps
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
