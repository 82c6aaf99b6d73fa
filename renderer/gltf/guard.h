// Everything a hostile file can do wrong, refused before tinygltf sees a byte: GLB framing, JSON nesting and
// types, every reference, every byte range (divisions, so that no check can overflow), the shape of the node
// graph, and which files may be read. Afterwards the document is self-contained and complete.
#pragma once

#include <memory>
#include <nlohmann/json.hpp>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "base/error.h"
#include "gltf/load.h"

namespace gltf {

using Bytes = std::vector<unsigned char>;
using Span = std::span<const unsigned char>;

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

// A value fit for a one-line message; strings without quotation marks, control characters escaped.
std::string shown(const nlohmann::json& value);

// "at most N", as messages say it.
inline std::string at_most(std::uint64_t limit) { return "at most " + std::to_string(limit); }

// "array[i]", as messages name places.
inline std::string at(const std::string& array, size_t i) { return array + '[' + std::to_string(i) + ']'; }

// Member `key` of an object; an empty array if there is none.
inline const nlohmann::json& list(const nlohmann::json& object, const std::string& key) {
  static const nlohmann::json empty = nlohmann::json::array();
  const auto found = object.find(key);
  return found == object.end() ? empty : *found;
}

struct Image {
  Span bytes;  // encoded, unseen
  std::string name, mime_type;
};

struct Document {
  std::string file;     // as the user named it
  nlohmann::json json;  // checked, with defaults filled in; without materials, buffers and images:
  nlohmann::json materials;
  std::vector<std::unique_ptr<const Bytes>> files;  // the scene file and all others; what spans point into
  std::vector<Span> buffers;                        // exactly byteLength
  std::vector<Image> images;
  int scene = -1;           // the one to render; -1: the file has none, all root nodes are rendered
  std::vector<int> roots;   // nodes to start from
  std::string environment;  // path of the environment map, allowed and readable; empty: none
  std::string hash;         // docs/formats.md, "scene hash"
  // What is left of Limits::memory: whoever allocates because the file says so takes it from here, first.
  mutable std::uint64_t memory_left = 0;

  void take(const std::string& place, std::uint64_t count, std::uint64_t bytes_each) const {
    want(count <= memory_left / bytes_each, place,
         "no more memory than " + std::to_string(memory_left) + " bytes for it (see --max-memory)",
         std::to_string(count) + " times " + std::to_string(bytes_each));
    memory_left -= count * bytes_each;
  }

  // Of the scene that is rendered.
  const nlohmann::json& extras() const {
    static const nlohmann::json none;
    return scene < 0 ? none : list(json["scenes"][static_cast<size_t>(scene)], "extras");
  }
  [[noreturn]] void fail(const std::string& place, const std::string& wanted,
                         const nlohmann::json& found) const {
    base::fail_in(file, place, wanted, shown(found));
  }
  void want(bool holds, const std::string& place, const std::string& wanted,
            const nlohmann::json& found) const {
    if (!holds) fail(place, wanted, found);
  }
};

// A name that is no string is none.
inline std::string name_of(const nlohmann::json& object) {
  const nlohmann::json& name = list(object, "name");
  return name.is_string() ? name : "";
}

Document guard(const std::string& file, const Limits& limits, Warnings& warnings);

// The extensions that are read; any other in extensionsRequired is refused.
std::vector<std::string> supported_extensions();

// --- parts of guard(), in files of their own ---

// schema.cpp: types, value ranges and references of the whole document, by schema.json; fills in defaults,
// clamps, takes out what is knowingly not rendered.
void check_schema(Document& document, Warnings& warnings);
// ranges.cpp: bufferViews in buffers, accessors in bufferViews; the node graph, whose roots it returns.
void check_ranges(const Document& document);
std::vector<int> check_nodes(const Document& document, const Limits& limits);

// files.cpp: the folder of the scene file is the only place that is read, and only regular files.
// Path of `uri` (percent-encoded) below the folder of `document.file`, symbolic links resolved.
std::string resolve(const Document& document, const std::string& place, const std::string& uri);
Bytes read_file(const Document& document, const std::string& path, const std::string& place);
Bytes decode_data_uri(const Document& document, const std::string& place, const std::string& uri);

// Bytes of one component; the type is one that glTF has.
inline size_t component_size(int type) { return type < 5122 ? 1 : type < 5124 ? 2 : 4; }

}  // namespace gltf
