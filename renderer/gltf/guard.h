// Everything a hostile file can do wrong, refused before tinygltf sees a byte: GLB framing, JSON nesting and
// types, every reference, every byte range (divisions, so that no check can overflow), the shape of the node
// graph, and which files may be read. Afterwards the document is self-contained.
#pragma once

#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "gltf/load.h"

namespace gltf {

using Bytes = std::vector<unsigned char>;

struct Document {
  std::string file;  // as the user named it
  nlohmann::json
      json;  // checked; each uri of a buffer or image is a key of `files`, animations and skins are gone
  std::map<std::string, Bytes>
      files;                // what the uris, data: URIs and the BIN chunk hold; buffers exactly byteLength
  int scene = -1;           // the one to render; -1: the file has none, all root nodes are rendered
  std::vector<int> roots;   // nodes to start from
  std::string environment;  // path of the environment map, allowed and readable; empty: none
  std::string hash;         // docs/formats.md, "scene hash"
  std::vector<std::string> ignored;  // warnings about what the file holds and nobody reads
};

// A value fit for a one-line message.
std::string shown(const nlohmann::json& value);

// Member `key` of an object; an empty array if there is none.
inline const nlohmann::json& list(const nlohmann::json& object, const std::string& key) {
  static const nlohmann::json empty = nlohmann::json::array();
  const auto found = object.find(key);
  return found == object.end() ? empty : *found;
}

Document guard(const std::string& file, const Limits& limits);

// The extensions that are read; any other in extensionsRequired is refused.
const std::vector<std::string>& supported_extensions();

// --- parts of guard(), in files of their own
// -----------------------------------------------------------------------

// schema.cpp: types, value ranges, references and counts of the whole document.
void check_schema(const Document& document, const Limits& limits);
// ranges.cpp: bufferViews in buffers, accessors and images in bufferViews; the node graph, whose roots it
// returns.
void check_ranges(const Document& document);
std::vector<int> check_nodes(const Document& document, const Limits& limits);

// files.cpp: the folder of the scene file is the only place that is read, and only regular files.
// Path of `uri` (percent-encoded) below the folder of `document.file`, symbolic links resolved.
std::string resolve(const Document& document, const std::string& place, const std::string& uri);
Bytes read_file(const std::string& file, const std::string& path, const std::string& place,
                std::uint64_t limit);
Bytes decode_data_uri(const Document& document, const std::string& place, const std::string& uri);

// Wire sizes; 0 for a type or componentType that glTF does not have.
std::uint64_t component_size(int component_type);
std::uint64_t component_count(const std::string& type);
std::uint64_t element_size(const std::string& type, int component_type);  // matrix columns padded to 4 bytes

}  // namespace gltf
