// Byte ranges and the node graph. Every comparison is a subtraction or division of values already known to be
// in order, so nothing can wrap around.
#include <algorithm>

#include "base/error.h"
#include "gltf/guard.h"

namespace gltf {
using base::fail_in;
using nlohmann::json;

namespace {

std::string at(const char* array, size_t i) { return std::string(array) + '[' + std::to_string(i) + ']'; }

}  // namespace

std::uint64_t component_size(int component_type) {
  switch (component_type) {
    case 5120:
    case 5121:
      return 1;
    case 5122:
    case 5123:
      return 2;
    case 5125:
    case 5126:
      return 4;
  }
  return 0;
}

std::uint64_t component_count(const std::string& type) {
  static const std::map<std::string, std::uint64_t> counts = {
      {"SCALAR", 1}, {"VEC2", 2}, {"VEC3", 3}, {"VEC4", 4}, {"MAT2", 4}, {"MAT3", 9}, {"MAT4", 16}};
  const auto found = counts.find(type);
  return found == counts.end() ? 0 : found->second;
}

std::uint64_t element_size(const std::string& type, int component_type) {
  const std::uint64_t size = component_size(component_type);
  if (type == "MAT2") return 2 * ((2 * size + 3) / 4 * 4);
  if (type == "MAT3") return 3 * ((3 * size + 3) / 4 * 4);
  return component_count(type) * size;
}

void check_ranges(const Document& document) {
  const json& views = list(document.json, "bufferViews");
  for (size_t i = 0; i < views.size(); ++i) {
    const std::uint64_t offset = views[i].value("byteOffset", std::uint64_t{0}),
                        length = views[i]["byteLength"];
    const std::uint64_t total = document.json["buffers"][views[i]["buffer"].get<size_t>()]["byteLength"];
    if (offset > total || length > total - offset)
      fail_in(document.file, at("bufferViews", i),
              "a range inside the buffer's " + std::to_string(total) + " bytes",
              std::to_string(length) + " bytes at " + std::to_string(offset));
  }

  // `count` elements of `size` bytes: the last one may end short of a whole stride.
  const auto check = [&](const std::string& place, const json& range, std::uint64_t count, std::uint64_t size,
                         bool strided) {
    const json& view = views[range["bufferView"].get<size_t>()];
    const std::uint64_t offset = range.value("byteOffset", std::uint64_t{0}), length = view["byteLength"];
    const std::uint64_t stride = strided ? view.value("byteStride", size) : size;
    if (stride < size)
      fail_in(document.file, place, "a byteStride of at least " + std::to_string(size),
              std::to_string(stride));
    if (count == 0) return;
    if (offset > length || size > length - offset || count - 1 > (length - offset - size) / stride)
      fail_in(document.file, place, "elements inside the bufferView's " + std::to_string(length) + " bytes",
              std::to_string(count) + " of " + std::to_string(size) + " bytes, " + std::to_string(stride) +
                  " apart, from " + std::to_string(offset));
  };
  const json& accessors = list(document.json, "accessors");
  for (size_t i = 0; i < accessors.size(); ++i) {
    const json& accessor = accessors[i];
    const std::uint64_t count = accessor["count"],
                        size = element_size(accessor["type"], accessor["componentType"]);
    if (accessor.contains("bufferView")) check(at("accessors", i), accessor, count, size, true);
    if (!accessor.contains("sparse")) continue;
    const json& sparse = accessor["sparse"];
    const std::uint64_t replaced = sparse["count"];
    if (replaced > count)
      fail_in(document.file, at("accessors", i) + ".sparse.count", "at most " + std::to_string(count),
              std::to_string(replaced));
    check(at("accessors", i) + ".sparse.indices", sparse["indices"], replaced,
          component_size(sparse["indices"]["componentType"]), false);
    check(at("accessors", i) + ".sparse.values", sparse["values"], replaced, size, false);
  }
}

// glTF's node graph is a set of disjoint trees: at most one parent each, and every node reached from some
// root.
std::vector<int> check_nodes(const Document& document, const Limits& limits) {
  const json& nodes = list(document.json, "nodes");
  std::vector<int> parent(nodes.size(), -1);
  for (size_t i = 0; i < nodes.size(); ++i)
    for (const json& child : list(nodes[i], "children")) {
      int& known = parent[child.get<size_t>()];
      if (known != -1)
        fail_in(document.file, at("nodes", child.get<size_t>()), "one parent",
                "both nodes[" + std::to_string(known) + "] and nodes[" + std::to_string(i) + ']');
      known = static_cast<int>(i);
    }

  struct Visit {
    int node, depth;
  };
  std::vector<Visit> stack;
  std::vector<int> roots;
  size_t reached = 0;
  for (size_t i = 0; i < nodes.size(); ++i)
    if (parent[i] == -1) stack.push_back({static_cast<int>(i), 1}), roots.push_back(static_cast<int>(i));
  while (!stack.empty()) {
    const Visit visit = stack.back();
    stack.pop_back();
    ++reached;
    if (visit.depth > limits.node_depth)
      fail_in(document.file, at("nodes", static_cast<size_t>(visit.node)),
              "at most " + std::to_string(limits.node_depth) + " levels of nodes", "more");
    for (const json& child : list(nodes[static_cast<size_t>(visit.node)], "children"))
      stack.push_back({child.get<int>(), visit.depth + 1});
  }
  if (reached != nodes.size()) fail_in(document.file, "nodes", "trees", "a cycle");
  if (document.scene < 0) return roots;

  const std::string place = at("scenes", static_cast<size_t>(document.scene)) + ".nodes";
  std::vector<int> listed;
  for (const json& node : list(document.json["scenes"][static_cast<size_t>(document.scene)], "nodes"))
    listed.push_back(node);
  for (const int node : listed)
    if (parent[static_cast<size_t>(node)] != -1)
      fail_in(document.file, place, "root nodes", std::to_string(node));
  std::vector<int> sorted = listed;
  std::sort(sorted.begin(), sorted.end());
  if (std::adjacent_find(sorted.begin(), sorted.end()) != sorted.end())
    fail_in(document.file, place, "each node once", "one twice");
  return listed;
}

}  // namespace gltf
