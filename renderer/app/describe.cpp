#include "app/describe.h"

#include <cstdint>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "app/parse.h"

namespace app {
namespace {

using nlohmann::json;

// A float as the shortest decimal that reads back the same, not as the double next to it.
json decimal(float value) { return json::parse(shortest(value)); }
json decimal(const math::Vec3& v) { return {decimal(v.x), decimal(v.y), decimal(v.z)}; }

json describe_material(const scene::Material& m) {
  static const scene::Material standard;
  json out = {{"name", m.name},
              {"base_color", decimal(m.base_color)},
              {"metallic", decimal(m.metallic)},
              {"roughness", decimal(m.roughness)}};
  // What is as Disney's defaults is not worth a line.
  const auto add = [&](const char* name, float scene::Material::*member) {
    if (m.*member != standard.*member) out[name] = decimal(m.*member);
  };
  add("specular", &scene::Material::specular);
  add("specular_tint", &scene::Material::specular_tint);
  add("anisotropic", &scene::Material::anisotropic);
  add("anisotropic_rotation", &scene::Material::anisotropic_rotation);
  add("sheen", &scene::Material::sheen);
  if (m.sheen > 0) add("sheen_tint", &scene::Material::sheen_tint);
  add("clearcoat", &scene::Material::clearcoat);
  if (m.clearcoat > 0) add("clearcoat_roughness", &scene::Material::clearcoat_roughness);
  if (!math::is_black(m.emission)) out["emission"] = decimal(m.emission);
  if (m.alpha_mode == scene::AlphaMode::mask) out["alpha"] = "mask";
  if (m.alpha_mode == scene::AlphaMode::blend) out["alpha"] = "blend";
  if (m.double_sided) out["double_sided"] = true;
  json textures = json::array();
  if (m.base_color_texture.bitmap >= 0) textures.push_back("base colour");
  if (m.metallic_roughness_texture.bitmap >= 0) textures.push_back("metallic and roughness");
  if (m.normal_texture.bitmap >= 0) textures.push_back("normal");
  if (m.emissive_texture.bitmap >= 0) textures.push_back("emission");
  if (!textures.empty()) out["textures"] = textures;
  return out;
}

json describe_light(const scene::Light& light) {
  static const char* const kinds[] = {"directional", "point", "spot"};
  return {
      {"name", light.name},
      {"kind", kinds[static_cast<int>(light.kind)]},
      {light.kind == scene::LightKind::directional ? "irradiance" : "intensity", decimal(light.intensity)}};
}

std::string plural(std::uint64_t count, const std::string& what) {
  const std::string ending = count == 1 ? "" : what.back() == 'h' ? "es" : "s";
  return std::to_string(count) + " " + what + ending;
}

// "key value, key value": one line of an object, its name and kind aside.
std::string one_line(const json& object) {
  std::string text;
  for (const auto& [key, value] : object.items()) {
    if (key == "name" || key == "kind" || value == false) continue;
    std::string word = key;
    for (char& c : word) c = c == '_' ? ' ' : c;
    text += (text.empty() ? "" : ", ") + word;
    if (!value.is_boolean()) text += " " + (value.is_string() ? value.get<std::string>() : value.dump());
  }
  return text;
}

}  // namespace

json decisive(const Options& o, const scene::Scene& scene) {
  const integrator::Settings& r = o.render;
  static const char* const filters[] = {"box", "triangle", "blackman-harris"};
  static const char* const samplers[] = {"sobol", "random"};
  static const char* const units[] = {"auto", "watt", "candela"};
  json out = {{"scene_hash", scene.hash},
              {"shader", shader_name(r.shader)},
              {"width", r.width},
              {"height", r.height},
              {"camera", r.camera},
              {"depth", r.depth},
              {"spp", r.spp},
              {"replicates", r.replicates},
              {"seed", r.seed},
              {"clamp", decimal(r.clamp)},
              {"filter", filters[static_cast<int>(r.filter)]},
              {"sampler", samplers[static_cast<int>(r.sampler)]},
              {"hide-environment", r.hide_environment},
              {"punctual-units", units[static_cast<int>(o.punctual_units)]},
              {"fastest-isa", r.fastest_isa}};
  if (r.crop_width > 0) out["crop"] = {r.crop_x, r.crop_y, r.crop_width, r.crop_height};
  if (r.shader == integrator::Shader::path_disney) {
    out["d-gamma"] = decimal(r.d_gamma);
    if (r.d_constant)
      out["d-constant"] = decimal(*r.d_constant);
    else
      out["d-constant"] = "auto";
  }
  if (!o.environment.empty()) out["environment"] = std::filesystem::path(o.environment).filename().string();
  if (o.environment_color) out["environment-color"] = decimal(*o.environment_color);
  return out;
}

json describe(const Options& options, const scene::Scene& scene, const std::string& reduced) {
  std::uint64_t triangles = 0, instanced = 0;
  for (const scene::Mesh& mesh : scene.meshes) triangles += mesh.triangles.size();
  for (const scene::Instance& i : scene.instances)
    instanced += scene.meshes[static_cast<size_t>(i.mesh)].triangles.size();

  json out = {{"scene", scene.file},
              {"hash", scene.hash},
              {"meshes", scene.meshes.size()},
              {"triangles", triangles},
              {"instances", scene.instances.size()},
              {"instanced_triangles", instanced},
              {"materials", json::array()},
              {"textures", json::array()},
              {"lights", json::array()},
              {"cameras", json::array()},
              {"warnings", scene.warnings},
              {"notes", options.notes},
              {"choices", options.choices},
              {"options", decisive(options, scene)},
              {"reduced", json::array()}};
  for (const scene::Material& m : scene.materials) out["materials"].push_back(describe_material(m));
  for (const scene::Bitmap& b : scene.bitmaps)
    out["textures"].push_back({{"name", b.name}, {"size", json::array({b.width, b.height})}});
  for (const scene::Light& light : scene.lights) out["lights"].push_back(describe_light(light));
  for (const scene::Camera& camera : scene.cameras) {
    json c = {{"name", camera.name}, {"kind", camera.orthographic ? "orthographic" : "perspective"}};
    if (camera.orthographic)
      c["view_height"] = decimal(2 * camera.ymag);
    else
      c["yfov_degrees"] = decimal(camera.yfov * 180 / math::pi);
    out["cameras"].push_back(c);
  }
  if (scene.environment) {
    const scene::Environment& e = *scene.environment;
    out["environment"] = {{"name", e.map.name},
                          {"size", json::array({e.map.width, e.map.height})},

                          {"strength", decimal(e.strength)},
                          {"rotation_degrees", decimal(e.rotation * 180 / math::pi)}};
  }
  for (const std::string& line : split(reduced, '\n'))
    if (!line.empty()) out["reduced"].push_back(line);
  return out;
}

std::string describe_text(const json& d) {
  const auto count = [&](const char* key) { return d.at(key).get<std::uint64_t>(); };
  std::string text = d.at("scene").get<std::string>() + "\n  sha256 " + d.at("hash").get<std::string>() +
                     "\n\nIn the file\n";
  text += "  " + plural(count("meshes"), "mesh") + " of " + plural(count("triangles"), "triangle") + ", " +
          plural(count("instances"), "instance") + " showing " +
          plural(count("instanced_triangles"), "triangle") + "\n";
  const auto list = [&](const char* key, const char* what) {
    text += "  " + plural(d.at(key).size(), what) + "\n";
    int index = 0;
    for (const json& item : d.at(key)) {
      const std::string name = item.at("name").get<std::string>();
      text += "    " + std::to_string(index++) + " " + (name.empty() ? "(no name)" : "'" + name + "'");
      if (item.contains("kind")) text += " " + item.at("kind").get<std::string>();
      text += ": " + one_line(item) + "\n";
    }
  };
  list("materials", "material");
  list("textures", "texture");
  list("lights", "lamp");
  list("cameras", "camera");
  if (d.contains("environment"))
    text += "  environment: " + d.at("environment").at("name").get<std::string>() + ", " +
            one_line(d.at("environment")) + "\n";
  else
    text += "  no environment\n";

  const auto lines = [&](const char* key, const std::string& title) {
    if (d.at(key).empty()) return;
    text += "\n" + title + "\n";
    for (const json& line : d.at(key)) text += "  " + line.get<std::string>() + "\n";
  };
  lines("reduced", "Rendered as");
  lines("notes", "Added");
  lines("choices", "Chosen");
  lines("warnings", "Not rendered, or approximated");
  text += "\nOptions\n  " + one_line(d.at("options")) + "\n";
  return text;
}

}  // namespace app
