// Edited values into the JSON of a glTF document, so that the loader reads them back bit by bit: a float is
// written as the shortest decimal that reads back, and where the loader multiplies (colour times intensity,
// emission times strength) the factors are doubles whose product rounds to the float.
#pragma once

#include <nlohmann/json.hpp>

#include "gltf/guard.h"
#include "view/gltf_file.h"

namespace view {

// The shortest decimal that reads back as this float.
nlohmann::ordered_json decimal(float value);

class Editor {
 public:
  using Json = nlohmann::ordered_json;

  // Edits `root`, the JSON as it stands in the file; `document` is the same, guarded.
  Editor(Json& root, const gltf::Document& document, gltf::PunctualUnits units);

  void write(const MaterialEdit& edit);
  void write(const scene::Light& light);
  void add(const CameraEdit& edit);
  Json& extras();  // of the scene that is rendered

 private:
  Json& material(size_t index);
  Json& scene();
  size_t add_node(const Json& node);
  void uses(const char* extension);
  math::DMat4 to_world(size_t node) const;

  Json& root_;
  const gltf::Document& document_;
  double lumens_per_watt_;  // by which the loader divides
};

}  // namespace view
