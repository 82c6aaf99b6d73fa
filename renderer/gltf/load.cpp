// The guarded document through tinygltf into a Scene: instances, cameras and lights by one walk over the
// nodes, then images and environment.
#include "gltf/load.h"

#include <algorithm>
#include <array>
#include <cfloat>
#include <cmath>

#include "base/error.h"
#include "gltf/reader.h"
#include "image/decode.h"

namespace gltf {
using base::fail_in;
using nlohmann::json;

namespace {

constexpr double pi = 3.14159265358979323846;
constexpr double lumens_per_watt = 683;  // Blender's exporter

using Matrix = std::array<double, 16>;  // column-major; products of many nodes need more than float

Matrix multiply(const Matrix& a, const Matrix& b) {
  Matrix out{};
  for (size_t column = 0; column < 4; ++column)
    for (size_t row = 0; row < 4; ++row)
      for (size_t k = 0; k < 4; ++k) out[column * 4 + row] += a[k * 4 + row] * b[column * 4 + k];
  return out;
}

double determinant(const Matrix& m) {
  return m[0] * (m[5] * m[10] - m[6] * m[9]) - m[4] * (m[1] * m[10] - m[2] * m[9]) +
         m[8] * (m[1] * m[6] - m[2] * m[5]);
}

math::Vec3 column(const Matrix& m, size_t i) {
  return {static_cast<float>(m[4 * i]), static_cast<float>(m[4 * i + 1]), static_cast<float>(m[4 * i + 2])};
}

math::Mat4 to_float(const Matrix& m) {
  math::Mat4 out(1.0f);
  for (int i = 0; i < 16; ++i) out[i / 4][i % 4] = static_cast<float>(m[static_cast<size_t>(i)]);
  return out;
}

class Loader {
 public:
  Loader(Source& source, const Options& options, scene::Scene& out)
      : source_(source), options_(options), out_(out) {}

  void load() {
    for (size_t i = 0; i < list(json(), "materials").size(); ++i)
      out_.materials.push_back(read_material(source_, i));
    walk();
    check_texcoords();
    read_images();
    read_environment();
  }

 private:
  using MeshKey = std::pair<int, size_t>;
  static std::string node_place(int node) { return "nodes[" + std::to_string(node) + ']'; }
  const nlohmann::json& json() const { return source_.document.json; }
  const std::string& file() const { return source_.document.file; }

  void walk() {
    struct Visit {
      int node;
      Matrix parent;
    };
    std::vector<Visit> stack;
    const auto push = [&](const std::vector<int>& nodes,
                          const Matrix& parent) {  // in reverse: visited in file order
      for (auto i = nodes.rbegin(); i != nodes.rend(); ++i) stack.push_back({*i, parent});
    };
    push(source_.document.roots, {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1});
    while (!stack.empty()) {
      const Visit visit = stack.back();
      stack.pop_back();
      const tinygltf::Node& node = source_.model.nodes[static_cast<size_t>(visit.node)];
      const Matrix to_world = multiply(visit.parent, local_matrix(visit.node, node));
      for (const double x : to_world)
        if (!(std::fabs(x) < FLT_MAX))
          fail_in(file(), node_place(visit.node), "a finite transform", std::to_string(x));
      if (node.mesh >= 0) add_instances(visit.node, node, to_world);
      if (node.camera >= 0) add_camera(visit.node, node, to_world);
      const nlohmann::json& extensions = list(json()["nodes"][static_cast<size_t>(visit.node)], "extensions");
      if (extensions.contains("KHR_lights_punctual"))
        add_light(visit.node, extensions["KHR_lights_punctual"]["light"], to_world);
      if (extensions.contains("EXT_mesh_gpu_instancing"))
        source_.warnings.add("extension EXT_mesh_gpu_instancing is not rendered");
      push(node.children, to_world);
    }
  }

  Matrix local_matrix(int index, const tinygltf::Node& node) {
    const nlohmann::json& raw = json()["nodes"][static_cast<size_t>(index)];
    Matrix m{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
    if (!node.matrix.empty()) {
      if (raw.contains("translation") || raw.contains("rotation") || raw.contains("scale"))
        fail_in(file(), node_place(index), "either a matrix or translation, rotation, scale", "both");
      std::copy(node.matrix.begin(), node.matrix.end(), m.begin());
      if (m[3] != 0 || m[7] != 0 || m[11] != 0 || m[15] != 1)
        fail_in(file(), node_place(index) + ".matrix", "a last row of 0 0 0 1", "another");
      return m;
    }
    if (!node.rotation.empty()) {
      double x = node.rotation[0], y = node.rotation[1], z = node.rotation[2], w = node.rotation[3];
      const double length = std::hypot(std::hypot(x, y, z), w);
      if (!(length > 0)) fail_in(file(), node_place(index) + ".rotation", "a quaternion with a length", "0");
      if (std::fabs(length - 1) > 1e-3)
        source_.warnings.add(node_place(index) + ".rotation is not a unit quaternion: normalised");
      x /= length, y /= length, z /= length, w /= length;
      m = {1 - 2 * (y * y + z * z),
           2 * (x * y + z * w),
           2 * (x * z - y * w),
           0,
           2 * (x * y - z * w),
           1 - 2 * (x * x + z * z),
           2 * (y * z + x * w),
           0,
           2 * (x * z + y * w),
           2 * (y * z - x * w),
           1 - 2 * (x * x + y * y),
           0,
           0,
           0,
           0,
           1};
    }
    for (size_t i = 0; i < 12 && !node.scale.empty(); ++i) m[i] *= node.scale[i / 4];
    for (size_t i = 0; i < 3 && !node.translation.empty(); ++i) m[12 + i] = node.translation[i];
    return m;
  }

  void add_instances(int index, const tinygltf::Node& node, const Matrix& to_world) {
    if (!(std::fabs(determinant(to_world)) >= FLT_MIN)) {
      source_.warnings.add(node_place(index) + " is scaled to nothing: left out");
      return;
    }
    const auto& primitives = source_.model.meshes[static_cast<size_t>(node.mesh)].primitives;
    for (size_t p = 0; p < primitives.size(); ++p) {
      const int mesh = mesh_of({node.mesh, p}, primitives[p].material);
      if (mesh < 0) continue;
      for (size_t row = 0; row < 3; ++row) {
        const double reach =
            std::fabs(to_world[row]) + std::fabs(to_world[4 + row]) + std::fabs(to_world[8 + row]);
        if (reach * extents_[static_cast<size_t>(mesh)] + std::fabs(to_world[12 + row]) > 1e18)
          fail_in(file(), node_place(index), "a mesh within 1e18 metres", "one beyond");
      }
      triangles_ += out_.meshes[static_cast<size_t>(mesh)].triangles.size();
      if (triangles_ > options_.limits.triangles || out_.instances.size() >= options_.limits.instances)
        fail_in(file(), node_place(index),
                "at most " + std::to_string(options_.limits.triangles) + " triangles in " +
                    std::to_string(options_.limits.instances) + " instances",
                "more");
      out_.instances.push_back({mesh, to_float(to_world)});
    }
  }

  // Reads a primitive when it is first used; -1 if there is nothing in it.
  int mesh_of(const MeshKey& key, int material) {
    const auto [known, fresh] = meshes_.try_emplace(key, -1);
    if (!fresh) return known->second;
    auto mesh = read_primitive(source_, static_cast<size_t>(key.first), key.second);
    if (!mesh) return -1;
    mesh->material = material >= 0 ? material : default_material();
    float extent = 0;
    for (const math::Vec3& p : mesh->positions) extent = std::max(extent, math::max_component(math::abs(p)));
    extents_.push_back(extent);
    out_.meshes.push_back(std::move(*mesh));
    return known->second = static_cast<int>(out_.meshes.size()) - 1;
  }

  int default_material() {
    if (default_material_ < 0) {
      default_material_ = static_cast<int>(out_.materials.size());
      out_.materials.emplace_back().name = "(glTF default)";
    }
    return default_material_;
  }

  // A rigid frame: viewing direction kept, up made perpendicular to it, scale, shear and mirroring removed.
  void add_camera(int index, const tinygltf::Node& node, const Matrix& to_world) {
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
    const math::Vec3 nothing{0, 0, 0}, back = math::normalize(column(to_world, 2), nothing);
    const math::Vec3 right =
        math::normalize(math::cross(math::normalize(column(to_world, 1), nothing), back), nothing);
    const math::Vec3 up = math::cross(back, right);
    if (math::is_black(back) || math::is_black(right))
      fail_in(file(), node_place(index), "a camera with a direction", "a transform that scales it away");
    camera.to_world = math::Mat4(math::Vec4(right, 0), math::Vec4(up, 0), math::Vec4(back, 0),
                                 math::Vec4(column(to_world, 3), 1));
    out_.cameras.push_back(camera);
  }

  void add_light(int index, size_t number, const Matrix& to_world) {
    const tinygltf::Light& from = source_.model.lights[number];
    const std::string place = "lights[" + std::to_string(number) + ']';
    scene::Light light;
    light.name = from.name;
    light.kind = from.type == "directional" ? scene::LightKind::directional
                 : from.type == "spot"      ? scene::LightKind::spot
                                            : scene::LightKind::point;
    const bool blender = source_.model.asset.generator.find("Blender") != std::string::npos;
    const bool candela = options_.punctual_units == PunctualUnits::candela ||
                         (options_.punctual_units == PunctualUnits::automatic && blender);
    if (candela)
      source_.warnings.add(
          std::string("punctual lights are taken as candela and lux and divided by 683") +
          (options_.punctual_units == PunctualUnits::automatic ? ": the file was written by Blender" : ""));
    for (int c = 0; c < 3; ++c) {
      const double color = from.color.empty() ? 1 : from.color[static_cast<size_t>(c)];
      const double value = color * from.intensity / (candela ? lumens_per_watt : 1);
      if (!(value >= 0 && value <= FLT_MAX))
        fail_in(file(), place, "an intensity in [0, 3.4e38]", std::to_string(value));
      light.intensity[c] = static_cast<float>(value);
    }
    light.position = column(to_world, 3);
    light.direction = -math::normalize(column(to_world, 2), {0, 0, 0});
    if (math::is_black(light.direction) && light.kind != scene::LightKind::point)
      fail_in(file(), node_place(index), "a light with a direction", "a transform that scales it away");
    if (light.kind == scene::LightKind::spot) {
      const double inner = from.spot.innerConeAngle, outer = from.spot.outerConeAngle;
      if (!(inner >= 0 && inner < outer && outer <= pi / 2 + 1e-6))
        fail_in(file(), place + ".spot", "0 <= innerConeAngle < outerConeAngle <= pi/2",
                std::to_string(inner) + " and " + std::to_string(outer));
      light.cos_inner = static_cast<float>(std::cos(inner));
      light.cos_outer = static_cast<float>(std::cos(outer));
    }
    if (from.range > 0)
      source_.warnings.add(place + ".range is ignored: light falls off with the square of the distance");
    out_.lights.push_back(light);
  }

  static std::array<scene::Texture*, 4> textures_of(scene::Material& m) {
    return {&m.base_color_texture, &m.metallic_roughness_texture, &m.normal_texture, &m.emissive_texture};
  }

  void check_texcoords() {
    for (const scene::Mesh& mesh : out_.meshes)
      for (const scene::Texture* t : textures_of(out_.materials[static_cast<size_t>(mesh.material)]))
        if (t->bitmap >= 0 && mesh.texcoords[t->texcoord_set].empty())
          source_.warnings.add("mesh " + mesh.name + " lacks TEXCOORD_" + std::to_string(t->texcoord_set) +
                               ", with which its material looks a texture up");
  }

  // Decodes each image that a material uses, once, and points the textures at the bitmaps.
  void read_images() {
    std::vector<int> bitmap_of(source_.model.images.size(), -1);
    std::int64_t left = static_cast<std::int64_t>(options_.limits.image_pixels);
    for (scene::Material& material : out_.materials)
      for (scene::Texture* t : textures_of(material)) {
        if (t->bitmap < 0) continue;
        int& known = bitmap_of[static_cast<size_t>(t->bitmap)];
        if (known < 0) {
          known = static_cast<int>(out_.bitmaps.size());
          out_.bitmaps.push_back(read_image(static_cast<size_t>(t->bitmap), left));
          left -= static_cast<std::int64_t>(out_.bitmaps.back().texels.size());
        }
        t->bitmap = known;
      }
  }

  scene::Bitmap read_image(size_t index, std::int64_t left) {
    const tinygltf::Image& from = source_.model.images[index];
    const std::string what = file() + ": images[" + std::to_string(index) + ']';
    image::Limits limits;
    limits.pixels = std::min(limits.pixels, left);
    image::Decoded decoded = image::decode(from.image.data(), from.image.size(), what, limits);
    const bool png = from.image[0] == 0x89;
    const nlohmann::json& raw = json()["images"][index];
    if (const std::string mime = raw.value("mimeType", "");
        !mime.empty() && mime != (png ? "image/png" : "image/jpeg"))
      source_.warnings.add("images[" + std::to_string(index) + "] says " + mime.substr(0, 40) + " and is a " +
                           (png ? "PNG" : "JPEG"));
    scene::Bitmap bitmap;
    bitmap.name = from.name.empty() ? "images[" + std::to_string(index) + ']' : from.name;
    bitmap.width = decoded.width;
    bitmap.height = decoded.height;
    bitmap.texels = std::move(decoded.texels);
    return bitmap;
  }

  void read_environment() {
    if (source_.document.scene < 0) return;
    const std::string place = "scenes[" + std::to_string(source_.document.scene) + "].extras";
    const nlohmann::json& extras =
        list(json()["scenes"][static_cast<size_t>(source_.document.scene)], "extras");
    if (!extras.is_object()) return;
    static const std::vector<std::string> known = {"environment", "environment_strength",
                                                   "environment_rotation", "environment_color"};
    for (const auto& [key, value] : extras.items())
      if (key.rfind("environment", 0) == 0 && std::find(known.begin(), known.end(), key) == known.end())
        fail_unknown(file(), place, key, known);
    const auto number = [&](const nlohmann::json& value, const std::string& key, double low) {
      if (!value.is_number() || !(value.get<double>() >= low && value.get<double>() <= FLT_MAX))
        fail_in(file(), place + '.' + key, low < 0 ? "a finite number" : "a number that is not negative",
                shown(value));
      return static_cast<float>(value.get<double>());
    };
    scene::Environment environment;
    environment.strength = number(extras.value("environment_strength", nlohmann::json(1)), known[1], 0);
    environment.rotation =
        number(extras.value("environment_rotation", nlohmann::json(0)), known[2], -FLT_MAX) * math::pi / 180;
    if (extras.contains("environment_color")) {
      const nlohmann::json& color = extras["environment_color"];
      if (!source_.document.environment.empty())
        fail_in(file(), place, "environment or environment_color", "both");
      if (!color.is_array() || color.size() != 3)
        fail_in(file(), place + ".environment_color", "3 numbers", shown(color));
      math::Vec4 texel(1.0f);
      for (int c = 0; c < 3; ++c) texel[c] = number(color[static_cast<size_t>(c)], known[3], 0);
      environment.map = {known[3], 1, 1, {texel}};
    } else if (!source_.document.environment.empty()) {
      const image::Image image = image::read_environment(source_.document.environment);
      environment.map = {extras["environment"], image.width, image.height, {}};
      for (const math::Vec3& pixel : image.pixels) environment.map.texels.push_back(math::Vec4(pixel, 1));
    } else {
      return;
    }
    out_.environment = std::move(environment);
  }

  Source& source_;
  const Options& options_;
  scene::Scene& out_;
  std::map<MeshKey, int> meshes_;  // glTF primitive -> index into Scene::meshes
  std::vector<double> extents_;    // of those, largest coordinate
  std::uint64_t triangles_ = 0;    // instanced
  int default_material_ = -1;
};

}  // namespace

scene::Scene load(const std::string& file, const Options& options) {
  Document document = guard(file, options.limits);
  scene::Scene out;
  out.file = file;
  out.hash = document.hash;
  tinygltf::Model model = parse(document);
  Source source{document, options.limits, std::move(model), Warnings(out.warnings)};
  for (const std::string& line : document.ignored) source.warnings.add(line);
  Loader(source, options, out).load();
  return out;
}

}  // namespace gltf
