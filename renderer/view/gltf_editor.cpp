#include "view/gltf_editor.h"

#include <charconv>
#include <cmath>

#include "gltf/parameters.h"

namespace view {

namespace {

using Json = nlohmann::ordered_json;
using math::DMat4;
using math::DVec3;
using math::Vec3;

DVec3 cross(const DVec3& a, const DVec3& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
double dot(const DVec3& a, const DVec3& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }

Json decimals(const Vec3& v) { return {decimal(v.x), decimal(v.y), decimal(v.z)}; }

// Member `key`, an object even if there was none.
Json& member(Json& object, const char* key) {
  Json& value = object[key];
  if (!value.is_object()) value = Json::object();
  return value;
}

// v = scale * factors, factors in [0, 1]: the largest component is the scale where it is above `least`.
struct Scaled {
  double scale;
  Json factors;
};
Scaled scaled(const Vec3& v, double least) {
  const double scale = std::max(static_cast<double>(math::max_component(v)), least);
  if (!(scale > 0)) return {0, {1, 1, 1}};
  if (scale == 1) return {1, decimals(v)};
  Json factors;
  for (int c = 0; c < 3; ++c) factors.push_back(v[c] / scale);
  return {scale, factors};
}

// The angle with this cosine, unless the one there, or the default, has it already.
void write_angle(Json& spot, const char* key, double standard, float cosine) {
  if (static_cast<float>(std::cos(spot.value(key, standard))) != cosine)
    spot[key] = std::acos(static_cast<double>(cosine));
}

// A node's own transform; the guard has checked the shapes.
DMat4 local_matrix(const Json& node) {
  DMat4 m(1);
  if (node.contains("matrix")) {
    for (int i = 0; i < 16; ++i) m[i / 4][i % 4] = node["matrix"][static_cast<size_t>(i)];
    return m;
  }
  if (node.contains("rotation")) {
    const std::array<double, 4> q = node["rotation"];
    const double n = std::hypot(std::hypot(q[0], q[1], q[2]), q[3]);
    const double x = q[0] / n, y = q[1] / n, z = q[2] / n, w = q[3] / n;
    m[0] = {1 - 2 * (y * y + z * z), 2 * (x * y + z * w), 2 * (x * z - y * w), 0};
    m[1] = {2 * (x * y - z * w), 1 - 2 * (x * x + z * z), 2 * (y * z + x * w), 0};
    m[2] = {2 * (x * z + y * w), 2 * (y * z - x * w), 1 - 2 * (x * x + y * y), 0};
  }
  for (int i = 0; i < 3; ++i) {
    if (node.contains("scale")) m[i] *= node["scale"][static_cast<size_t>(i)].get<double>();
    if (node.contains("translation")) m[3][i] = node["translation"][static_cast<size_t>(i)];
  }
  return m;
}

}  // namespace

Json decimal(float value) {
  char text[32];
  const auto [end, error] = std::to_chars(text, text + sizeof text, value);
  const Json json = Json::parse(text, end);
  return json.get<float>() == value ? json : Json(static_cast<double>(value));
}

Editor::Editor(Json& root, const gltf::Document& document, gltf::PunctualUnits units)
    : root_(root), document_(document) {
  const bool guess = units == gltf::PunctualUnits::automatic;
  const bool candela = guess ? root["asset"].value("generator", "").find("Blender") != std::string::npos
                             : units == gltf::PunctualUnits::candela;
  lumens_per_watt_ = candela ? 683 : 1;
}

void Editor::uses(const char* extension) {
  Json& used = root_["extensionsUsed"];
  if (std::find(used.begin(), used.end(), extension) == used.end()) used.push_back(extension);
}

Editor::Json& Editor::scene() {
  if (document_.scene >= 0) return root_["scenes"][static_cast<size_t>(document_.scene)];
  if (!root_.contains("scenes")) {  // then all root nodes are rendered
    root_["scenes"] = Json::array({{{"nodes", document_.roots}}});
    root_["scene"] = 0;
  }
  return root_["scenes"][0];
}

Editor::Json& Editor::extras() { return member(scene(), "extras"); }

// glTF's default material, which the loader puts behind the file's own, is given to its primitives by name.
Editor::Json& Editor::material(size_t index) {
  Json& materials = root_["materials"];
  if (index == materials.size()) {
    materials.push_back({{"name", "default"}});
    for (Json& mesh : root_["meshes"])
      for (Json& primitive : mesh["primitives"])
        if (!primitive.contains("material")) primitive["material"] = index;
  }
  return materials[index];
}

void Editor::write(const MaterialEdit& edit) {
  const scene::Material &before = edit.before, &m = edit.after;
  Json& json = material(edit.index);

  // Core glTF.
  Json& pbr = json["pbrMetallicRoughness"];
  pbr["baseColorFactor"] = decimals(m.base_color);
  pbr["baseColorFactor"].push_back(decimal(m.alpha));
  pbr["metallicFactor"] = decimal(m.metallic);
  pbr["roughnessFactor"] = decimal(m.roughness);
  if (m.normal_scale != before.normal_scale && json.contains("normalTexture"))
    json["normalTexture"]["scale"] = decimal(m.normal_scale);
  if (m.double_sided != before.double_sided) json["doubleSided"] = m.double_sided;
  if (m.alpha_mode != before.alpha_mode)
    json["alphaMode"] = m.alpha_mode == scene::AlphaMode::opaque ? "OPAQUE"
                        : m.alpha_mode == scene::AlphaMode::mask ? "MASK"
                                                                 : "BLEND";
  if (m.alpha_cutoff != before.alpha_cutoff) json["alphaCutoff"] = decimal(m.alpha_cutoff);
  if (m.emission != before.emission) {
    const auto [strength, factors] = scaled(m.emission, 1);
    json["emissiveFactor"] = factors;
    if (json.contains("extensions")) json["extensions"].erase("KHR_materials_emissive_strength");
    if (strength != 1) {
      json["extensions"]["KHR_materials_emissive_strength"]["emissiveStrength"] = strength;
      uses("KHR_materials_emissive_strength");
    }
  }

  // Disney's parameters, all of them, in the extras, which win over extensions.
  Json& extras = member(json, "extras");
  extras.erase("disney_clearcoat_gloss");
  for (const auto& [name, member] : gltf::disney_parameters)
    extras[std::string("disney_") + name] = decimal(m.*member);

  // Extensions, for readers that know no extras.
  const auto changed = [&](auto... parameter) { return ((m.*parameter != before.*parameter) || ...); };
  using scene::Material;
  if (changed(&Material::clearcoat, &Material::clearcoat_roughness)) {
    Json& coat = json["extensions"]["KHR_materials_clearcoat"];
    coat["clearcoatFactor"] = decimal(m.clearcoat);
    coat["clearcoatRoughnessFactor"] = decimal(m.clearcoat_roughness);
    uses("KHR_materials_clearcoat");
  }
  if (!json.contains("extensions")) return;
  Json& extensions = json["extensions"];
  if (changed(&Material::specular, &Material::specular_tint))
    for (const char* name : {"KHR_materials_specular", "KHR_materials_ior"}) extensions.erase(name);
  if (changed(&Material::sheen, &Material::sheen_tint)) extensions.erase("KHR_materials_sheen");
  if (changed(&Material::anisotropic, &Material::anisotropic_rotation))
    extensions.erase("KHR_materials_anisotropy");
  if (extensions.empty()) json.erase("extensions");
}

void Editor::write(const scene::Light& light) {
  const auto node = static_cast<size_t>(light.node);
  const auto light_of = [](Json& n) -> Json& { return n["extensions"]["KHR_lights_punctual"]; };
  const auto has_light = [](const Json& n) {
    return n.contains("extensions") && n["extensions"].contains("KHR_lights_punctual");
  };

  // A definition that other nodes share gets a copy.
  Json& definitions = root_["extensions"]["KHR_lights_punctual"]["lights"];
  size_t definition = light_of(root_["nodes"][node])["light"];
  int users = 0;
  for (Json& other : root_["nodes"]) users += has_light(other) && light_of(other)["light"] == definition;
  if (users > 1) {
    definitions.push_back(Json(definitions[definition]));
    definition = definitions.size() - 1;
    light_of(root_["nodes"][node])["light"] = definition;
  }
  const auto [intensity, color] = scaled(light.intensity, 0);
  definitions[definition]["color"] = color;
  definitions[definition]["intensity"] = intensity * lumens_per_watt_;
  if (light.kind == scene::LightKind::spot) {
    Json& spot = member(definitions[definition], "spot");
    write_angle(spot, "innerConeAngle", 0, light.cos_inner);
    write_angle(spot, "outerConeAngle", std::acos(-1.) / 4, light.cos_outer);
  }

  // A light that moved goes into a node of its own, the first child of the old one: their order stays.
  const DMat4 world = to_world(node);
  if (Vec3(DVec3(world[3])) == light.position) return;
  const DVec3 a(world[0]), b(world[1]), c(world[2]), way = DVec3(light.position) - DVec3(world[3]);
  const DVec3 local =
      DVec3(dot(cross(b, c), way), dot(cross(c, a), way), dot(cross(a, b), way)) / dot(cross(a, b), c);
  Json child = {{"translation", {local.x, local.y, local.z}},
                {"extensions", {{"KHR_lights_punctual", {{"light", definition}}}}}};
  if (!light.name.empty()) child["name"] = light.name;
  const size_t index = add_node(child);
  Json& old = root_["nodes"][node];
  old["extensions"].erase("KHR_lights_punctual");
  if (old["extensions"].empty()) old.erase("extensions");
  if (!old.contains("children")) old["children"] = Json::array();
  old["children"].insert(old["children"].begin(), index);
}

void Editor::add(const CameraEdit& edit) {
  Json camera = {{"name", edit.camera.name}};
  if (edit.camera.orthographic) {
    const double ymag = decimal(edit.camera.ymag).get<double>();
    camera["type"] = "orthographic";
    camera["orthographic"] = {
        {"xmag", ymag * edit.camera.aspect}, {"ymag", ymag}, {"znear", 0}, {"zfar", 1000}};
  } else {
    camera["type"] = "perspective";
    camera["perspective"] = {
        {"aspectRatio", decimal(edit.camera.aspect)}, {"yfov", decimal(edit.camera.yfov)}, {"znear", .01}};
  }
  root_["cameras"].push_back(camera);
  Json matrix;
  for (int i = 0; i < 16; ++i) matrix.push_back(edit.to_world[i / 4][i % 4]);
  scene()["nodes"].push_back(
      add_node({{"name", edit.camera.name}, {"camera", root_["cameras"].size() - 1}, {"matrix", matrix}}));
}

size_t Editor::add_node(const Json& node) {
  root_["nodes"].push_back(node);
  return root_["nodes"].size() - 1;
}

DMat4 Editor::to_world(size_t node) const {
  const Json& nodes = root_["nodes"];
  DMat4 m = local_matrix(nodes[node]);
  for (size_t i = 0; i < nodes.size(); ++i) {
    const Json children = nodes[i].value("children", Json::array());
    if (std::find(children.begin(), children.end(), Json(node)) != children.end()) return to_world(i) * m;
  }
  return m;
}

}  // namespace view
