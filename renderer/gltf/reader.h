// What the parts of the loader share: the guarded document, tinygltf's model of it, and the warnings.
#pragma once

#include <tiny_gltf.h>

#include <optional>
#include <set>

#include "gltf/guard.h"
#include "scene/scene.h"

namespace gltf {

// Collects warnings, each line once, and no more than a reader would read.
class Warnings {
 public:
  explicit Warnings(std::vector<std::string>& lines) : lines_(lines) {}
  void add(const std::string& line) {
    if (lines_.size() > 100 || !seen_.insert(line).second) return;
    lines_.push_back(lines_.size() < 100 ? line : "more warnings of this kind are left out");
  }

 private:
  std::vector<std::string>& lines_;
  std::set<std::string> seen_;
};

struct Source {
  const Document& document;
  const Limits& limits;
  tinygltf::Model model;
  Warnings warnings;
  std::uint64_t vertices = 0;  // read so far, against limits.vertices
};

// parse.cpp. Takes the bytes in `document.files` with it.
tinygltf::Model parse(Document& document);

// accessor.cpp. All elements of an accessor, components side by side; integers scaled to [0,1] or [-1,1] if
// the accessor is `normalized`. An accessor without bufferView is zeros; sparse values are put in place.
std::vector<float> read_floats(const Source& source, int accessor);
// Of an accessor with unsigned, not normalized SCALARs.
std::vector<std::uint32_t> read_indices(const Source& source, int accessor);

// mesh.cpp. Primitive `primitive` of mesh `mesh` without its material; nothing, and a warning saying why, if
// there is nothing to render in it.
std::optional<scene::Mesh> read_primitive(Source& source, size_t mesh, size_t primitive);

// material.cpp. The textures' `bitmap` is still an index into glTF's images.
scene::Material read_material(Source& source, size_t material);
// The mapping of every glTF material parameter that is read or knowingly ignored, as the Markdown table of
// docs/gltf.md.
std::string material_table();

// Ends with the error that `key` is none of `known`, naming the one nearest to it.
[[noreturn]] void fail_unknown(const std::string& file, const std::string& place, const std::string& key,
                               const std::vector<std::string>& known);

}  // namespace gltf
