// The types, value ranges and references of a glTF document as one table. Only what some later code reads is
// in it. What sits in extras and in material extensions is checked where it is read (material.cpp, load.cpp).
#include <cfloat>
#include <cmath>
#include <sstream>

#include "base/error.h"
#include "gltf/guard.h"

namespace gltf {
using nlohmann::json;

namespace {

enum class Kind {
  is,       // of JSON's type `of`
  number,   // in [low, high], which are finite as float
  numbers,  // `low` of them
  integer,  // in [low, high]
  choice,   // an integer or string out of `of`
  index,    // of an element of the array at `of`
  texture,  // {index: of `textures`, texCoord: 0 or 1}
};

// A path is a list of member names; "a,b" is both members, "*" every element of an array, "@" every member of
// an object. What is not there is fine unless it is `needed`.
struct Rule {
  const char* path;
  Kind kind;
  const char* of = "";
  double low = -FLT_MAX, high = FLT_MAX;
  bool needed = false;
};

constexpr bool needed = true;
constexpr double tiny = 1e-6, any = FLT_MAX, big = 9007199254740992.0;  // 2^53

#define LIGHTS "extensions/KHR_lights_punctual/lights"  // a macro, for it is pasted into paths
const Rule rules[] = {
    {"asset", Kind::is, "object", 0, 0, needed},
    {"asset/version", Kind::is, "string", 0, 0, needed},
    {"asset/minVersion,generator", Kind::is, "string"},
    {"extensionsUsed,extensionsRequired/*", Kind::is, "string"},
    {"extensions", Kind::is, "object"},
    {"extensions/KHR_lights_punctual", Kind::is, "object"},
    {LIGHTS "/*", Kind::is, "object"},
    {LIGHTS "/*/type", Kind::choice, "directional point spot", 0, 0, needed},
    {LIGHTS "/*/color", Kind::numbers, "", 3},
    {LIGHTS "/*/intensity", Kind::number, "", 0, any},
    {LIGHTS "/*/spot", Kind::is, "object"},
    {LIGHTS "/*/spot/innerConeAngle,outerConeAngle", Kind::number, "", 0, any},
    {"scene", Kind::index, "scenes"},
    {"scenes,nodes,cameras,meshes,materials,textures,samplers,images,accessors,bufferViews,buffers/*",
     Kind::is, "object"},
    {"scenes/*/nodes/*", Kind::index, "nodes"},
    {"nodes/*/children/*", Kind::index, "nodes"},
    {"nodes/*/mesh", Kind::index, "meshes"},
    {"nodes/*/camera", Kind::index, "cameras"},
    {"nodes/*/matrix", Kind::numbers, "", 16},
    {"nodes/*/translation,scale", Kind::numbers, "", 3},
    {"nodes/*/rotation", Kind::numbers, "", 4},
    {"nodes,materials/*/extensions", Kind::is, "object"},
    {"nodes/*/extensions/KHR_lights_punctual", Kind::is, "object"},
    {"nodes/*/extensions/KHR_lights_punctual/light", Kind::index, LIGHTS, 0, 0, needed},
    {"cameras/*/type", Kind::choice, "perspective orthographic", 0, 0, needed},
    {"cameras/*/perspective,orthographic", Kind::is, "object"},
    {"cameras/*/perspective/yfov", Kind::number, "", tiny, 3.141592, needed},
    {"cameras/*/perspective/znear", Kind::number, "", 0, any, needed},
    {"cameras/*/perspective/aspectRatio", Kind::number, "", tiny, any},
    {"cameras/*/orthographic/xmag,ymag", Kind::number, "", tiny, any, needed},
    {"cameras/*/orthographic/znear,zfar", Kind::number, "", 0, any, needed},
    {"meshes/*/primitives", Kind::is, "array", 0, 0, needed},
    {"meshes/*/primitives/*", Kind::is, "object"},
    {"meshes/*/primitives/*/attributes", Kind::is, "object", 0, 0, needed},
    {"meshes/*/primitives/*/attributes/@", Kind::index, "accessors"},
    {"meshes/*/primitives/*/targets/*/@", Kind::index, "accessors"},
    {"meshes/*/primitives/*/indices", Kind::index, "accessors"},
    {"meshes/*/primitives/*/material", Kind::index, "materials"},
    {"meshes/*/primitives/*/mode", Kind::integer, "", 0, 6},
    {"materials/*/pbrMetallicRoughness", Kind::is, "object"},
    {"materials/*/pbrMetallicRoughness/baseColorFactor", Kind::numbers, "", 4},
    {"materials/*/pbrMetallicRoughness/metallicFactor,roughnessFactor", Kind::number},
    {"materials/*/pbrMetallicRoughness/baseColorTexture,metallicRoughnessTexture", Kind::texture},
    {"materials/*/normalTexture,occlusionTexture,emissiveTexture", Kind::texture},
    {"materials/*/normalTexture/scale", Kind::number},
    {"materials/*/emissiveFactor", Kind::numbers, "", 3},
    {"materials/*/alphaMode", Kind::choice, "OPAQUE MASK BLEND"},
    {"materials/*/alphaCutoff", Kind::number, "", 0, any},
    {"materials/*/doubleSided", Kind::is, "boolean"},
    {"textures/*/source", Kind::index, "images"},
    {"textures/*/sampler", Kind::index, "samplers"},
    {"samplers/*/wrapS,wrapT", Kind::choice, "10497 33071 33648"},
    {"samplers/*/magFilter", Kind::choice, "9728 9729"},
    {"samplers/*/minFilter", Kind::choice, "9728 9729 9984 9985 9986 9987"},
    {"images/*/uri,mimeType", Kind::is, "string"},
    {"images,accessors/*/bufferView", Kind::index, "bufferViews"},
    {"accessors,bufferViews/*/byteOffset", Kind::integer, "", 0, big},
    {"accessors/*/componentType", Kind::choice, "5120 5121 5122 5123 5125 5126", 0, 0, needed},
    {"accessors/*/normalized", Kind::is, "boolean"},
    {"accessors/*/count", Kind::integer, "", 0, big, needed},
    {"accessors/*/type", Kind::choice, "SCALAR VEC2 VEC3 VEC4 MAT2 MAT3 MAT4", 0, 0, needed},
    {"accessors/*/sparse", Kind::is, "object"},
    {"accessors/*/sparse/count", Kind::integer, "", 1, big, needed},
    {"accessors/*/sparse/indices,values", Kind::is, "object", 0, 0, needed},
    {"accessors/*/sparse/indices,values/bufferView", Kind::index, "bufferViews", 0, 0, needed},
    {"accessors/*/sparse/indices,values/byteOffset", Kind::integer, "", 0, big},
    {"accessors/*/sparse/indices/componentType", Kind::choice, "5121 5123 5125", 0, 0, needed},
    {"bufferViews/*/buffer", Kind::index, "buffers", 0, 0, needed},
    {"bufferViews/*/byteLength", Kind::integer, "", 1, big, needed},
    {"bufferViews/*/byteStride", Kind::integer, "", 4, 252},
    {"buffers/*/uri", Kind::is, "string"},
    {"buffers/*/byteLength", Kind::integer, "", 1, 2147483647, needed},
};
#undef LIGHTS

// Takes the part before the first `separator` off `text`.
std::string_view take(std::string_view& text, char separator) {
  const size_t end = text.find(separator);
  const std::string_view first = text.substr(0, end);
  text = end == std::string_view::npos ? std::string_view() : text.substr(end + 1);
  return first;
}

struct Checker {
  const Document& document;

  void want(bool holds, const std::string& place, const std::string& wanted, const json& found) const {
    if (!holds) base::fail_in(document.file, place, wanted, shown(found));
  }

  // Applies `rule` to every value that the rest of its path leads to from `value` at `place`.
  void check(const json& value, std::string_view path, const std::string& place, const Rule& rule) const {
    if (path.empty()) return apply(value, place, rule);
    std::string_view names = take(path, '/');
    if (names == "*") {
      want(value.is_array(), place, "an array", value);
      for (size_t i = 0; i < value.size(); ++i)
        check(value[i], path, place + '[' + std::to_string(i) + ']', rule);
      return;
    }
    const std::string prefix = place.empty() ? "" : place + '.';
    if (names == "@") {
      want(value.is_object(), place, "an object", value);
      for (const auto& [key, member] : value.items()) check(member, path, prefix + key, rule);
      return;
    }
    while (!names.empty()) {
      const std::string name(take(names, ','));
      const auto found = value.find(name);
      if (found != value.end())
        check(*found, path, prefix + name, rule);
      else
        want(!path.empty() || !rule.needed, prefix + name, "it, for it is required", nullptr);
    }
  }

  void apply(const json& value, const std::string& place, const Rule& rule) const {
    std::ostringstream wanted;
    switch (rule.kind) {
      case Kind::is:
        if (value.type_name() == std::string_view(rule.of)) return;
        wanted << "the JSON type " << rule.of;
        break;
      case Kind::number:
      case Kind::integer: {
        const bool whole = rule.kind == Kind::integer;
        const double x = (whole ? value.is_number_integer() : value.is_number()) ? value.get<double>() : NAN;
        if (x >= rule.low && x <= rule.high) return;
        wanted << (whole ? "an integer in [" : "a number in [") << rule.low << ", " << rule.high << ']';
        break;
      }
      case Kind::numbers:
        wanted << rule.low << " numbers";
        want(value.is_array() && value.size() == static_cast<size_t>(rule.low), place, wanted.str(), value);
        return check(value, "*", place, {"", Kind::number});
      case Kind::choice: {
        const std::string one = value.is_string() ? value.get<std::string>() : shown(value);
        const bool words = rule.of[0] > '9';
        for (std::string_view choices = rule.of; words == value.is_string() && !choices.empty();)
          if (take(choices, ' ') == one) return;
        wanted << "one of " << rule.of;
        break;
      }
      case Kind::index: {
        const json* array = &document.json;
        for (std::string_view path = rule.of; !path.empty();)
          array = &list(*array, std::string(take(path, '/')));
        if (value.is_number_unsigned() && array->is_array() && value.get<std::uint64_t>() < array->size())
          return;
        wanted << "an index below " << array->size() << " (of " << rule.of << ')';
        break;
      }
      case Kind::texture:
        want(value.is_object(), place, "an object", value);
        check(value, "index", place, {"", Kind::index, "textures", 0, 0, needed});
        return check(value, "texCoord", place, {"", Kind::integer, "", 0, 1});
    }
    want(false, place, wanted.str(), value);
  }
};

}  // namespace

std::string shown(const json& value) {
  return value.is_null() ? "nothing" : value.is_structured() ? value.type_name() : value.dump().substr(0, 60);
}

void check_schema(const Document& document, const Limits& limits) {
  const Checker checker{document};
  checker.want(document.json.is_object(), "JSON", "an object", document.json);
  for (const Rule& rule : rules) checker.check(document.json, rule.path, "", rule);
  const auto at_most = [&](const char* array, std::uint64_t limit) {
    const size_t count = list(document.json, array).size();
    checker.want(count <= limit, array, "at most " + std::to_string(limit), count);
  };
  at_most("nodes", limits.nodes);
  at_most("accessors", limits.accessors);
  at_most("images", limits.images);
}

}  // namespace gltf
