// Byte ranges and the node graph. Every comparison is a subtraction or division of values already known to be
// in order, so nothing can wrap around.
#include "gltf/guard.h"

namespace gltf {
using nlohmann::json;

namespace {

// Bytes of one element; the columns of matrices are padded to 4 bytes.
size_t element_size(const std::string& type, size_t component) {
  const size_t rows = type == "SCALAR" ? 1 : static_cast<size_t>(type.back() - '0');
  return type[0] == 'M' ? rows * ((rows * component + 3) / 4 * 4) : rows * component;
}

}  // namespace

void check_ranges(const Document& document) {
  const json &views = list(document.json, "bufferViews"), &accessors = list(document.json, "accessors");
  for (size_t i = 0; i < views.size(); ++i) {
    const size_t offset = views[i].value("byteOffset", size_t{0}), length = views[i]["byteLength"],
                 total = document.json["buffers"][views[i]["buffer"].get<size_t>()]["byteLength"];
    document.want(offset <= total && length <= total - offset, at("bufferViews", i),
                  "a range inside the buffer's " + std::to_string(total) + " bytes",
                  std::to_string(length) + " bytes at " + std::to_string(offset));
  }
  // `count` elements of `size` bytes: the last one may end short of a whole stride.
  const auto check = [&](const std::string& place, const json& range, size_t count, size_t size,
                         bool strided) {
    const json& view = views[range["bufferView"].get<size_t>()];
    const size_t offset = range.value("byteOffset", size_t{0}), length = view["byteLength"],
                 stride = strided ? view.value("byteStride", size) : size;
    document.want(stride >= size, place, "a byteStride of at least " + std::to_string(size), stride);
    if (count == 0) return;
    document.want(
        offset <= length && size <= length - offset && count - 1 <= (length - offset - size) / stride, place,
        "elements inside the bufferView's " + std::to_string(length) + " bytes",
        std::to_string(count) + " of " + std::to_string(size) + " bytes, " + std::to_string(stride) +
            " apart, from " + std::to_string(offset));
  };
  for (size_t i = 0; i < accessors.size(); ++i) {
    const json& accessor = accessors[i];
    const std::string place = at("accessors", i);
    const size_t count = accessor["count"],
                 size = element_size(accessor["type"], component_size(accessor["componentType"]));
    if (accessor.contains("bufferView")) check(place, accessor, count, size, true);
    if (!accessor.contains("sparse")) continue;
    const json& sparse = accessor["sparse"];
    const size_t replaced = sparse["count"], index_size = component_size(sparse["indices"]["componentType"]);
    document.want(replaced <= count, place + ".sparse.count", at_most(count), replaced);
    check(place + ".sparse.indices", sparse["indices"], replaced, index_size, false);
    check(place + ".sparse.values", sparse["values"], replaced, size, false);
  }
}

// glTF's node graph is a set of disjoint trees: at most one parent each, and every node reached from some
// root.
std::vector<int> check_nodes(const Document& document, const Limits& limits) {
  const json& nodes = list(document.json, "nodes");
  constexpr int none = -1, listed = -2;
  std::vector<int> parent(nodes.size(), none);
  for (size_t i = 0; i < nodes.size(); ++i)
    for (const size_t child : list(nodes[i], "children")) {
      if (parent[child] != none)
        document.fail(at("nodes", child), "one parent",
                      "both " + at("nodes", static_cast<size_t>(parent[child])) + " and " + at("nodes", i));
      parent[child] = static_cast<int>(i);
    }

  // Walk up from each: to a root, or for ever.
  std::vector<int> roots;
  for (size_t i = 0; i < nodes.size(); ++i) {
    if (parent[i] == none) roots.push_back(static_cast<int>(i));
    int levels = 1;
    for (int up = parent[i]; up != none; up = parent[static_cast<size_t>(up)], ++levels) {
      if (static_cast<size_t>(up) == i) document.fail("nodes", "trees", "a cycle");
      if (levels >= limits.node_depth)
        document.fail(at("nodes", i),
                      at_most(static_cast<std::uint64_t>(limits.node_depth)) + " levels of nodes", "more");
    }
  }
  if (document.scene < 0) return roots;

  const size_t scene = static_cast<size_t>(document.scene);
  const std::vector<int> chosen = list(document.json["scenes"][scene], "nodes");
  for (const int node : chosen) {
    int& above = parent[static_cast<size_t>(node)];
    document.want(above == none, at("scenes", scene) + ".nodes", "root nodes, each once", node);
    above = listed;
  }
  return chosen;
}

}  // namespace gltf
