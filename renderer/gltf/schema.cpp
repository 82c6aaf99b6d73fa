// The types, value ranges, references and counts of a glTF document as one table. A path is a list of member
// names;
// `*` stands for every element of an array. Only what some later code reads is in the table. What sits in
// extras and in material extensions is checked where it is read (material.cpp).
#include <cfloat>

#include "base/error.h"
#include "gltf/guard.h"

namespace gltf {
using nlohmann::json;

namespace {

enum class Kind {
  object,   // {}
  objects,  // [{}...]
  string,   //
  strings,  // ["..."...]
  boolean,  //
  number,   // finite as a float, in [low, high]
  numbers,  // `low` of them
  integer,  // in [low, high]
  choice,   // an integer or string out of `of`
  index,    // of an element of the array `of`
  indices,  // [index...]
  map,      // {name: index...}
  maps,     // [map...]
  texture,  // {index: of `textures`, texCoord: 0 or 1}
};

struct Rule {
  const char* path;
  Kind kind;
  const char* of = "";
  double low = -FLT_MAX, high = FLT_MAX;
  bool needed = false;
};

constexpr bool needed = true;
constexpr double tiny = 1e-6, any = FLT_MAX, big = 9007199254740992.0;  // 2^53
constexpr const char* lights = "extensions/KHR_lights_punctual/lights";
constexpr const char* component_types = "5120 5121 5122 5123 5125 5126";

const Rule rules[] = {
    {"asset", Kind::object, "", 0, 0, needed},
    {"asset/version", Kind::string, "", 0, 0, needed},
    {"asset/minVersion", Kind::string},
    {"asset/generator", Kind::string},
    {"extensionsUsed", Kind::strings},
    {"extensionsRequired", Kind::strings},
    {"extensions", Kind::object},
    {"extensions/KHR_lights_punctual", Kind::object},
    {lights, Kind::objects},
    {"extensions/KHR_lights_punctual/lights/*/type", Kind::choice, "directional point spot", 0, 0, needed},
    {"extensions/KHR_lights_punctual/lights/*/color", Kind::numbers, "", 3},
    {"extensions/KHR_lights_punctual/lights/*/intensity", Kind::number, "", 0, any},
    {"extensions/KHR_lights_punctual/lights/*/spot", Kind::object},
    {"extensions/KHR_lights_punctual/lights/*/spot/innerConeAngle", Kind::number, "", 0, any},
    {"extensions/KHR_lights_punctual/lights/*/spot/outerConeAngle", Kind::number, "", 0, any},
    {"scene", Kind::index, "scenes"},
    {"scenes", Kind::objects},
    {"scenes/*/nodes", Kind::indices, "nodes"},
    {"nodes", Kind::objects},
    {"nodes/*/children", Kind::indices, "nodes"},
    {"nodes/*/mesh", Kind::index, "meshes"},
    {"nodes/*/camera", Kind::index, "cameras"},
    {"nodes/*/skin", Kind::index, "skins"},
    {"nodes/*/matrix", Kind::numbers, "", 16},
    {"nodes/*/translation", Kind::numbers, "", 3},
    {"nodes/*/rotation", Kind::numbers, "", 4},
    {"nodes/*/scale", Kind::numbers, "", 3},
    {"nodes/*/extensions", Kind::object},
    {"nodes/*/extensions/KHR_lights_punctual", Kind::object},
    {"nodes/*/extensions/KHR_lights_punctual/light", Kind::index, lights, 0, 0, needed},
    {"skins", Kind::objects},
    {"skins/*/joints", Kind::indices, "nodes"},
    {"skins/*/skeleton", Kind::index, "nodes"},
    {"skins/*/inverseBindMatrices", Kind::index, "accessors"},
    {"cameras", Kind::objects},
    {"cameras/*/type", Kind::choice, "perspective orthographic", 0, 0, needed},
    {"cameras/*/perspective", Kind::object},
    {"cameras/*/perspective/yfov", Kind::number, "", tiny, 3.141592, needed},
    {"cameras/*/perspective/znear", Kind::number, "", 0, any, needed},
    {"cameras/*/perspective/aspectRatio", Kind::number, "", tiny, any},
    {"cameras/*/orthographic", Kind::object},
    {"cameras/*/orthographic/xmag", Kind::number, "", tiny, any, needed},
    {"cameras/*/orthographic/ymag", Kind::number, "", tiny, any, needed},
    {"cameras/*/orthographic/znear", Kind::number, "", 0, any, needed},
    {"cameras/*/orthographic/zfar", Kind::number, "", 0, any, needed},
    {"meshes", Kind::objects},
    {"meshes/*/primitives", Kind::objects, "", 0, 0, needed},
    {"meshes/*/primitives/*/attributes", Kind::map, "accessors", 0, 0, needed},
    {"meshes/*/primitives/*/indices", Kind::index, "accessors"},
    {"meshes/*/primitives/*/material", Kind::index, "materials"},
    {"meshes/*/primitives/*/mode", Kind::integer, "", 0, 6},
    {"meshes/*/primitives/*/targets", Kind::maps, "accessors"},
    {"materials", Kind::objects},
    {"materials/*/pbrMetallicRoughness", Kind::object},
    {"materials/*/pbrMetallicRoughness/baseColorFactor", Kind::numbers, "", 4},
    {"materials/*/pbrMetallicRoughness/metallicFactor", Kind::number},
    {"materials/*/pbrMetallicRoughness/roughnessFactor", Kind::number},
    {"materials/*/pbrMetallicRoughness/baseColorTexture", Kind::texture},
    {"materials/*/pbrMetallicRoughness/metallicRoughnessTexture", Kind::texture},
    {"materials/*/normalTexture", Kind::texture},
    {"materials/*/normalTexture/scale", Kind::number},
    {"materials/*/occlusionTexture", Kind::texture},
    {"materials/*/emissiveTexture", Kind::texture},
    {"materials/*/emissiveFactor", Kind::numbers, "", 3},
    {"materials/*/alphaMode", Kind::choice, "OPAQUE MASK BLEND"},
    {"materials/*/alphaCutoff", Kind::number, "", 0, any},
    {"materials/*/doubleSided", Kind::boolean},
    {"materials/*/extensions", Kind::object},
    {"textures", Kind::objects},
    {"textures/*/source", Kind::index, "images"},
    {"textures/*/sampler", Kind::index, "samplers"},
    {"samplers", Kind::objects},
    {"samplers/*/wrapS", Kind::choice, "10497 33071 33648"},
    {"samplers/*/wrapT", Kind::choice, "10497 33071 33648"},
    {"samplers/*/magFilter", Kind::choice, "9728 9729"},
    {"samplers/*/minFilter", Kind::choice, "9728 9729 9984 9985 9986 9987"},
    {"images", Kind::objects},
    {"images/*/uri", Kind::string},
    {"images/*/bufferView", Kind::index, "bufferViews"},
    {"images/*/mimeType", Kind::string},
    {"accessors", Kind::objects},
    {"accessors/*/bufferView", Kind::index, "bufferViews"},
    {"accessors/*/byteOffset", Kind::integer, "", 0, big},
    {"accessors/*/componentType", Kind::choice, component_types, 0, 0, needed},
    {"accessors/*/normalized", Kind::boolean},
    {"accessors/*/count", Kind::integer, "", 0, big, needed},
    {"accessors/*/type", Kind::choice, "SCALAR VEC2 VEC3 VEC4 MAT2 MAT3 MAT4", 0, 0, needed},
    {"accessors/*/sparse", Kind::object},
    {"accessors/*/sparse/count", Kind::integer, "", 1, big, needed},
    {"accessors/*/sparse/indices", Kind::object, "", 0, 0, needed},
    {"accessors/*/sparse/indices/bufferView", Kind::index, "bufferViews", 0, 0, needed},
    {"accessors/*/sparse/indices/byteOffset", Kind::integer, "", 0, big},
    {"accessors/*/sparse/indices/componentType", Kind::choice, "5121 5123 5125", 0, 0, needed},
    {"accessors/*/sparse/values", Kind::object, "", 0, 0, needed},
    {"accessors/*/sparse/values/bufferView", Kind::index, "bufferViews", 0, 0, needed},
    {"accessors/*/sparse/values/byteOffset", Kind::integer, "", 0, big},
    {"bufferViews", Kind::objects},
    {"bufferViews/*/buffer", Kind::index, "buffers", 0, 0, needed},
    {"bufferViews/*/byteOffset", Kind::integer, "", 0, big},
    {"bufferViews/*/byteLength", Kind::integer, "", 1, big, needed},
    {"bufferViews/*/byteStride", Kind::integer, "", 4, 252},
    {"buffers", Kind::objects},
    {"buffers/*/uri", Kind::string},
    {"buffers/*/byteLength", Kind::integer, "", 1, 2147483647, needed},
};

// Takes the first step off `path`.
std::string_view step(std::string_view& path) {
  const size_t slash = path.find('/');
  const std::string_view first = path.substr(0, slash);
  path = slash == std::string_view::npos ? std::string_view() : path.substr(slash + 1);
  return first;
}

// Applies the rules to one document, keeping the way to the value at hand for messages.
class Checker {
 public:
  explicit Checker(const Document& document) : document_(document) {}

  void check(const Rule& rule) { visit(document_.json, rule.path, rule); }

 private:
  struct Place {
    std::string_view key;
    size_t index;
  };

  [[noreturn]] void fail(const std::string& wanted, const json& found) const {
    std::string text;
    for (const Place& place : way_)
      if (place.key.empty())
        text += '[' + std::to_string(place.index) + ']';
      else
        (text += text.empty() ? "" : ".") += place.key;
    std::string value = found.is_structured() ? found.type_name() : found.dump().substr(0, 60);
    base::fail_in(document_.file, text, wanted, found.is_null() ? "nothing" : value);
  }

  void visit(const json& at, std::string_view path, const Rule& rule) {
    if (path.empty()) return apply(at, rule);
    std::string_view rest = path;
    const std::string_view key = step(rest);
    if (key == "*") {
      for (size_t i = 0; i < at.size(); ++i) {
        way_.push_back({{}, i});
        visit(at[i], rest, rule);
        way_.pop_back();
      }
      return;
    }
    const auto found = at.find(key);
    way_.push_back({key, 0});
    if (found != at.end())
      visit(*found, rest, rule);
    else if (rest.empty() && rule.needed)
      fail("it, for it is required", json());
    way_.pop_back();
  }

  void apply(const json& value, const Rule& rule) {
    switch (rule.kind) {
      case Kind::object:
        return want(value.is_object(), "an object", value);
      case Kind::objects:
        return each(value, [&](const json& one) { want(one.is_object(), "an object", one); });
      case Kind::string:
        return want(value.is_string(), "a string", value);
      case Kind::strings:
        return each(value, [&](const json& one) { want(one.is_string(), "a string", one); });
      case Kind::boolean:
        return want(value.is_boolean(), "true or false", value);
      case Kind::number:
        return number(value, rule.low, rule.high);
      case Kind::numbers:
        want(value.is_array() && value.size() == static_cast<size_t>(rule.low),
             std::to_string(static_cast<int>(rule.low)) + " numbers", value);
        return each(value, [&](const json& one) { number(one, -FLT_MAX, FLT_MAX); });
      case Kind::integer:
        want(value.is_number_integer(), "an integer", value);
        return number(value, rule.low, rule.high);
      case Kind::choice: {
        const std::string text = value.is_string()           ? value.get<std::string>()
                                 : value.is_number_integer() ? value.dump()
                                                             : "";
        const bool words = rule.of[0] > '9';
        const std::string all = ' ' + std::string(rule.of) + ' ';
        return want(words == value.is_string() && !text.empty() && text.find(' ') == std::string::npos &&
                        all.find(' ' + text + ' ') != std::string::npos,
                    "one of " + std::string(rule.of), value);
      }
      case Kind::index:
        return index(value, rule.of);
      case Kind::indices:
        return each(value, [&](const json& one) { index(one, rule.of); });
      case Kind::map:
        return map(value, rule.of);
      case Kind::maps:
        return each(value, [&](const json& one) { map(one, rule.of); });
      case Kind::texture:
        want(value.is_object(), "an object", value);
        visit(value, "index", {"", Kind::index, "textures", 0, 0, needed});
        return visit(value, "texCoord", {"", Kind::integer, "", 0, 1});
    }
  }

  void want(bool holds, const std::string& wanted, const json& value) const {
    if (!holds) fail(wanted, value);
  }

  template <typename Check>
  void each(const json& value, const Check& check) {
    want(value.is_array(), "an array", value);
    for (size_t i = 0; i < value.size(); ++i) {
      way_.push_back({{}, i});
      check(value[i]);
      way_.pop_back();
    }
  }

  void number(const json& value, double low, double high) {
    if (value.is_number() && value.get<double>() >= low && value.get<double>() <= high) return;
    std::ostringstream wanted;
    wanted << (value.is_number_integer() ? "an integer" : "a number") << " in [" << low << ", " << high
           << ']';
    fail(wanted.str(), value);
  }

  void index(const json& value, const char* of) {
    const json* array = &document_.json;
    for (std::string_view path = of; !path.empty() && array->is_object();) {
      const auto found = array->find(step(path));
      static const json none;
      array = found == array->end() ? &none : &*found;
    }
    const size_t count = array->is_array() ? array->size() : 0;
    want(value.is_number_unsigned() && value.get<std::uint64_t>() < count,
         "an index below " + std::to_string(count) + " (of " + of + ")", value);
  }

  void map(const json& value, const char* of) {
    want(value.is_object(), "an object", value);
    for (const auto& [key, one] : value.items()) {
      way_.push_back({key, 0});
      index(one, of);
      way_.pop_back();
    }
  }

  const Document& document_;
  std::vector<Place> way_;
};

}  // namespace

void check_schema(const Document& document, const Limits& limits) {
  if (!document.json.is_object())
    base::fail_in(document.file, "JSON", "an object", document.json.type_name());
  Checker checker(document);
  for (const Rule& rule : rules) checker.check(rule);
  const auto at_most = [&](const char* array, std::uint64_t limit) {
    if (const std::uint64_t count = list(document.json, array).size(); count > limit)
      base::fail_in(document.file, array, "at most " + std::to_string(limit), std::to_string(count));
  };
  at_most("nodes", limits.nodes);
  at_most("accessors", limits.accessors);
  at_most("images", limits.images);
}

}  // namespace gltf
