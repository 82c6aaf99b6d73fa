#include "app/describe.h"

#include <CLI/StringTools.hpp>

#include "app/text.h"
#include "gltf/parameters.h"

namespace app {
namespace {

using json = nlohmann::ordered_json;
using scene::Material;

json decimals(const math::Vec3& v) { return {decimal(v.x), decimal(v.y), decimal(v.z)}; }

json describe_material(const Material& m) {
  static const Material standard;
  json out = {{"name", m.name},
              {"base_color", decimals(m.base_color)},
              {"metallic", decimal(m.metallic)},
              {"roughness", decimal(m.roughness)}};
  // What is as Disney's defaults is not worth a word.
  for (const auto& [name, member] : gltf::disney_parameters)
    if (m.*member != standard.*member) out[name] = decimal(m.*member);
  if (!math::is_black(m.emission)) out["emission"] = decimals(m.emission);
  if (m.alpha_mode != scene::AlphaMode::opaque)
    out["alpha"] = m.alpha_mode == scene::AlphaMode::mask ? "mask" : "blend";
  if (m.double_sided) out["double_sided"] = true;
  const std::pair<const char*, const scene::Texture&> textures[] = {
      {"base color", m.base_color_texture},
      {"metallic and roughness", m.metallic_roughness_texture},
      {"normal", m.normal_texture},
      {"emission", m.emissive_texture}};
  for (const auto& [name, texture] : textures)
    if (texture.bitmap >= 0) out["textures"].push_back(name);
  return out;
}

json describe_light(const scene::Light& light) {
  static const char* const kinds[] = {"directional", "point", "spot"};
  const bool directional = light.kind == scene::LightKind::directional;
  return {{"name", light.name},
          {"kind", kinds[static_cast<int>(light.kind)]},
          {directional ? "irradiance" : "intensity", decimals(light.intensity)}};
}

json describe_camera(const scene::Camera& camera) {
  json out = {{"name", camera.name}, {"kind", camera.orthographic ? "orthographic" : "perspective"}};
  if (camera.orthographic) out["view_height"] = decimal(2 * camera.ymag);
  if (!camera.orthographic) out["yfov_degrees"] = decimal(camera.yfov * 180 / math::pi);
  return out;
}

template <typename Bitmap>
json describe_bitmap(const Bitmap& bitmap) {
  return {{"name", bitmap.name}, {"size", json::array({bitmap.width, bitmap.height})}};
}

template <typename Item>
json list(const std::vector<Item>& items, json (*describe_item)(const Item&)) {
  json out = json::array();
  for (const Item& item : items) out.push_back(describe_item(item));
  return out;
}

// "key value, key value"; of an object with a name "'name': key value, key value".
std::string one_line(const json& value) {
  if (!value.is_object()) return value.is_string() ? value.get<std::string>() : value.dump();
  std::vector<std::string> parts;
  for (const auto& [key, part] : value.items())
    if (key != "name" && part != false) parts.push_back(part == true ? key : key + " " + one_line(part));
  std::string name = value.value("name", "");
  if (value.contains("name")) name = name.empty() ? "(no name): " : "'" + name + "': ";
  return name + CLI::detail::join(parts, ", ");
}

}  // namespace

json describe(const Options& options, const scene::Scene& scene, const std::string& reduced) {
  size_t triangles = 0, instanced = 0;
  for (const scene::Mesh& mesh : scene.meshes) triangles += mesh.triangles.size();
  for (const scene::Instance& i : scene.instances)
    instanced += scene.meshes[static_cast<size_t>(i.mesh)].triangles.size();
  json out = {{"scene", scene.file},
              {"hash", scene.hash},
              {"meshes", scene.meshes.size()},
              {"triangles", triangles},
              {"instances", scene.instances.size()},
              {"instanced_triangles", instanced},
              {"materials", list(scene.materials, describe_material)},
              {"textures", list(scene.bitmaps, describe_bitmap<scene::EncodedBitmap>)},
              {"lights", list(scene.lights, describe_light)},
              {"cameras", list(scene.cameras, describe_camera)},
              {"rendered_as", CLI::detail::split(reduced, '\n')},
              {"added", options.notes},
              {"chosen", options.choices},
              {"warnings", scene.warnings},
              {"options", decisive(options)}};
  if (scene.environment) {
    out["environment"] = describe_bitmap(scene.environment->map);
    out["environment"]["strength"] = decimal(scene.environment->strength);
    out["environment"]["rotation_degrees"] = decimal(scene.environment->rotation * 180 / math::pi);
  }
  return out;
}

std::string describe_text(const json& description) {
  std::string text;
  for (const auto& [key, value] : description.items()) {
    if (value.is_array()) {
      text += key + " " + std::to_string(value.size()) + "\n";
      for (size_t i = 0; i < value.size(); ++i)
        text += "  " + (value[i].is_object() ? std::to_string(i) + " " : "") + one_line(value[i]) + "\n";
    } else {
      text += key + " " + one_line(value) + "\n";
    }
  }
  return text;
}

}  // namespace app
