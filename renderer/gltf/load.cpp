// The guarded document through tinygltf into a Scene: instances, cameras and lights by one walk over the
// nodes, then images and environment.
#include "gltf/load.h"

#include <algorithm>
#include <array>
#include <cfloat>
#include <cmath>

#include "gltf/reader.h"
#include "image/decode.h"

namespace gltf {
using math::DMat4;
using math::Vec3;
using math::Vec4;
using nlohmann::json;

namespace {

constexpr double pi = 3.14159265358979323846;
constexpr double lumens_per_watt = 683;  // Blender's exporter

// What is built over the scene, measured: Embree's share of a triangle and of an instance, and that of the
// lights in an emissive triangle wherever it is placed.
constexpr std::uint64_t triangle_bytes = 120, instance_bytes = 1500, emitter_bytes = 320,
                        environment_bytes = 64;

double determinant(const DMat4& m) {
  return m[0][0] * (m[1][1] * m[2][2] - m[2][1] * m[1][2]) -
         m[1][0] * (m[0][1] * m[2][2] - m[2][1] * m[0][2]) +
         m[2][0] * (m[0][1] * m[1][2] - m[1][1] * m[0][2]);
}

// tinygltf sees the structure alone: no byte of data and no name of a file.
tinygltf::Model parse(const Document& document) {
  tinygltf::Model model;
  std::string error, warning;
  const std::string text = document.json.dump();
  try {
    if (tinygltf::TinyGLTF().LoadASCIIFromString(&model, &error, &warning, text.data(),
                                                 static_cast<unsigned>(text.size()), ""))
      return model;
  } catch (const std::exception& exception) {
    error = exception.what();
  }
  base::fail(document.file, ": not glTF 2.0: ", error.substr(0, 200));
}

class Loader {
 public:
  explicit Loader(Source& source)
      : source_(source), document_(source.document), options_(source.options), out_(source.scene) {}

  void load() {
    for (size_t i = 0; i < document_.materials.size(); ++i)
      out_.materials.push_back(read_material(source_, i));
    for (const int root : document_.roots) visit(static_cast<size_t>(root), DMat4(1));
    take_copies();
    check_texcoords();
    read_environment();
  }

 private:
  // The guard has bounded the depth.
  void visit(size_t index, const DMat4& parent) {
    const tinygltf::Node& node = source_.model.nodes[index];
    const std::string place = at("nodes", index);
    const DMat4 to_world = parent * local_matrix(node, place);
    for (int i = 0; i < 16; ++i)
      if (const double x = to_world[i / 4][i % 4]; !(std::fabs(x) < FLT_MAX))
        document_.fail(place, "a finite transform", x);
    if (node.mesh >= 0) add_instances(node, to_world, place);
    if (node.camera >= 0) add_camera(node, to_world, place);
    const json& light = list(list(document_.json["nodes"][index], "extensions"), "KHR_lights_punctual");
    if (!light.empty()) add_light(light["light"], to_world, index);
    for (const int child : node.children) visit(static_cast<size_t>(child), to_world);
  }

  DMat4 local_matrix(const tinygltf::Node& node, const std::string& place) {
    DMat4 m(1);
    if (!node.matrix.empty()) {
      for (int i = 0; i < 16; ++i) m[i / 4][i % 4] = node.matrix[static_cast<size_t>(i)];
      document_.want(m[0][3] == 0 && m[1][3] == 0 && m[2][3] == 0 && m[3][3] == 1, place + ".matrix",
                     "a last row of 0 0 0 1", "another");
      return m;
    }
    if (!node.rotation.empty()) {
      double x = node.rotation[0], y = node.rotation[1], z = node.rotation[2], w = node.rotation[3];
      const double length = std::hypot(std::hypot(x, y, z), w);
      document_.want(length > 0, place + ".rotation", "a quaternion with a length", "0");
      if (std::fabs(length - 1) > 1e-3)
        source_.warnings.add(place + ".rotation is not a unit quaternion: normalised");
      x /= length, y /= length, z /= length, w /= length;
      m[0] = {1 - 2 * (y * y + z * z), 2 * (x * y + z * w), 2 * (x * z - y * w), 0};
      m[1] = {2 * (x * y - z * w), 1 - 2 * (x * x + z * z), 2 * (y * z + x * w), 0};
      m[2] = {2 * (x * z + y * w), 2 * (y * z - x * w), 1 - 2 * (x * x + y * y), 0};
    }
    for (int i = 0; i < 3; ++i) {
      if (!node.scale.empty()) m[i] *= node.scale[static_cast<size_t>(i)];
      if (!node.translation.empty()) m[3][i] = node.translation[static_cast<size_t>(i)];
    }
    return m;
  }

  void add_instances(const tinygltf::Node& node, const DMat4& to_world, const std::string& place) {
    if (!(std::fabs(determinant(to_world)) >= FLT_MIN) || !(math::growth(glm::inverse(to_world)) < 5e11))
      return source_.warnings.add(place + " is scaled to nothing: left out");
    const auto& primitives = source_.model.meshes[static_cast<size_t>(node.mesh)].primitives;
    for (size_t p = 0; p < primitives.size(); ++p) {
      const int mesh = mesh_of({node.mesh, p}, primitives[p].material);
      if (mesh < 0) continue;
      for (int row = 0; row < 3; ++row) {
        const double stretch =
            std::fabs(to_world[0][row]) + std::fabs(to_world[1][row]) + std::fabs(to_world[2][row]);
        document_.want(stretch * extents_[static_cast<size_t>(mesh)] + std::fabs(to_world[3][row]) <= 1e18,
                       place, "a mesh within 1e18 metres", "one beyond");
      }
      const scene::Mesh& placed = out_.meshes[static_cast<size_t>(mesh)];
      document_.take(place, 1, instance_bytes);
      if (!math::is_black(out_.materials[static_cast<size_t>(placed.material)].emission))
        document_.take(place, placed.triangles.size(), emitter_bytes);
      out_.instances.push_back({mesh, math::Mat4(to_world)});
    }
  }

  // Reads a primitive when it is first used; -1 if there is nothing in it.
  int mesh_of(const std::pair<int, size_t>& key, int material) {
    const auto [known, fresh] = meshes_.try_emplace(key, -1);
    if (!fresh) return known->second;
    auto mesh = read_primitive(source_, static_cast<size_t>(key.first), key.second);
    if (!mesh) return -1;
    document_.take(at("meshes", static_cast<size_t>(key.first)), mesh->triangles.size(), triangle_bytes);
    mesh->material = material;
    if (material < 0) {  // glTF's default material, behind the file's own
      mesh->material = static_cast<int>(document_.materials.size());
      out_.materials.resize(document_.materials.size() + 1);
      out_.materials.back().name = "(glTF default)";
    }
    float extent = 0;
    for (const Vec3& p : mesh->positions) extent = std::max(extent, math::max_component(math::abs(p)));
    extents_.push_back(extent);
    out_.meshes.push_back(std::move(*mesh));
    return known->second = static_cast<int>(out_.meshes.size()) - 1;
  }

  void add_camera(const tinygltf::Node& node, const DMat4& to_world, const std::string& place) {
    const tinygltf::Camera& from = source_.model.cameras[static_cast<size_t>(node.camera)];
    scene::Camera camera;
    camera.name = node.name.empty() ? from.name : node.name;
    camera.orthographic = from.type == "orthographic";
    if (camera.orthographic) {
      camera.ymag = static_cast<float>(from.orthographic.ymag);
      camera.aspect = static_cast<float>(from.orthographic.xmag / from.orthographic.ymag);
    } else {
      camera.yfov = static_cast<float>(from.perspective.yfov);
      camera.aspect = static_cast<float>(from.perspective.aspectRatio);
    }
    const std::optional<math::Mat4> frame = camera_frame(to_world);
    document_.want(frame.has_value(), place, "a camera with a direction", "a transform that scales it away");
    camera.to_world = *frame;
    out_.cameras.push_back(camera);
  }

  void add_light(size_t number, const DMat4& to_world, size_t node) {
    const tinygltf::Light& from = source_.model.lights[number];
    const std::string place = at("lights", number);
    scene::Light light;
    light.name = from.name;
    light.node = static_cast<int>(node);
    light.kind = from.type == "directional" ? scene::LightKind::directional
                 : from.type == "spot"      ? scene::LightKind::spot
                                            : scene::LightKind::point;
    const bool guess = options_.punctual_units == PunctualUnits::automatic;
    const bool candela = guess ? source_.model.asset.generator.find("Blender") != std::string::npos
                               : options_.punctual_units == PunctualUnits::candela;
    if (candela)
      source_.warnings.add(std::string("punctual lights are taken as candela and lux and divided by 683") +
                           (guess ? ": the file was written by Blender" : ""));
    for (int c = 0; c < 3; ++c) {
      const double value =
          from.color[static_cast<size_t>(c)] * from.intensity / (candela ? lumens_per_watt : 1);
      document_.want(value <= FLT_MAX, place, "an intensity in [0, 3.4e38]", value);
      light.intensity[c] = static_cast<float>(value);
    }
    light.position = Vec3(to_world[3]);
    light.direction = -math::normalize(Vec3(to_world[2]), {0, 0, 0});
    document_.want(!math::is_black(light.direction) || light.kind == scene::LightKind::point,
                   at("nodes", node), "a light with a direction", "a transform that scales it away");
    if (light.kind == scene::LightKind::spot) {
      const double inner = from.spot.innerConeAngle, outer = from.spot.outerConeAngle;
      document_.want(inner < outer && outer <= pi / 2 + 1e-6, place + ".spot",
                     "0 <= innerConeAngle < outerConeAngle <= pi/2",
                     std::to_string(inner) + " and " + std::to_string(outer));
      light.cos_inner = static_cast<float>(std::cos(inner));
      light.cos_outer = static_cast<float>(std::cos(outer));
    }
    out_.lights.push_back(light);
  }

  // What Embree is given more than once.
  void take_copies() {
    const std::vector<size_t> copies = scene::copies(out_);
    for (size_t m = 0; m < copies.size(); ++m)
      if (copies[m] > 1)
        document_.take("copies of mesh " + out_.meshes[m].name,
                       (copies[m] - 1) * out_.meshes[m].triangles.size(), triangle_bytes);
  }

  void check_texcoords() {
    for (const scene::Mesh& mesh : out_.meshes) {
      const scene::Material& m = out_.materials[static_cast<size_t>(mesh.material)];
      for (const scene::Texture* t :
           {&m.base_color_texture, &m.metallic_roughness_texture, &m.normal_texture, &m.emissive_texture})
        if (t->bitmap >= 0 && mesh.texcoords[t->texcoord_set].empty())
          source_.warnings.add("mesh " + mesh.name + " lacks TEXCOORD_" + std::to_string(t->texcoord_set) +
                               ", with which its material looks a texture up");
    }
  }

  void read_environment() {
    const json& extras = document_.extras();
    scene::Environment environment;
    if (extras.contains("environment_color")) {
      const std::array<float, 3> color = extras["environment_color"];
      environment.map = {"environment_color", 1, 1, {{color[0], color[1], color[2], 1}}};
    } else if (!document_.environment.empty()) {
      image::Limits limits;
      limits.pixels = static_cast<std::int64_t>(document_.memory_left / environment_bytes);
      const image::Image image = image::read_environment(document_.environment, limits);
      document_.take(document_.environment, image.pixels.size(), environment_bytes);
      environment.map = {extras["environment"], image.width, image.height, {}};
      for (const Vec3& pixel : image.pixels) environment.map.texels.push_back(Vec4(pixel, 1));
    } else {
      return;
    }
    environment.strength = extras["environment_strength"];
    environment.rotation = extras["environment_rotation"].get<float>() * math::pi / 180;
    out_.environment = std::move(environment);
  }

  Source& source_;
  const Document& document_;
  const Options& options_;
  scene::Scene& out_;
  std::map<std::pair<int, size_t>, int> meshes_;  // glTF primitive -> index into Scene::meshes
  std::vector<double> extents_;                   // of those, largest coordinate
};

}  // namespace

std::optional<math::Mat4> camera_frame(const DMat4& to_world) {
  const Vec3 nothing{0, 0, 0}, back = math::normalize(Vec3(to_world[2]), nothing);
  const Vec3 right = math::normalize(math::cross(math::normalize(Vec3(to_world[1]), nothing), back), nothing);
  if (math::is_black(back) || math::is_black(right)) return std::nullopt;
  return math::Mat4(Vec4(right, 0), Vec4(math::cross(back, right), 0), Vec4(back, 0),
                    Vec4(Vec3(to_world[3]), 1));
}

scene::Scene load(const std::string& file, const Options& options) {
  scene::Scene out;
  out.file = file;
  Warnings warnings(out.warnings);
  const Document document = guard(file, options.limits, warnings);
  out.hash = document.hash;
  Source source{document, options, warnings, out, parse(document)};
  Loader(source).load();
  return out;
}

}  // namespace gltf
