// Saved scenes, read back: every edited value bit by bit, and everything else as it was.
#include "view/gltf_file.h"

#include <algorithm>
#include <cmath>
#include <random>

#include "gltf/sample_test.h"

namespace view {
namespace {

using math::Vec3;
using nlohmann::json;
namespace sample = gltf::sample;
namespace fs = std::filesystem;

std::string read(const std::string& file) {
  std::ifstream stream(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

// The JSON of a .gltf or .glb, and the rest of the .glb.
json json_of(const std::string& file, std::string* binary = nullptr) {
  const std::string bytes = read(file);
  if (!bytes.starts_with("glTF")) return json::parse(bytes);
  std::uint32_t length;
  std::memcpy(&length, &bytes[12], 4);
  if (binary != nullptr) *binary = bytes.substr(20 + length);
  return json::parse(bytes.substr(20, length));
}

std::vector<std::string> scenes() {
  std::vector<std::string> files;
  for (const auto& entry : fs::directory_iterator(ASSAY_SOURCE_DIR "/regression/scenes"))
    if (entry.path().extension() == ".glb") files.push_back(entry.path().string());
  std::sort(files.begin(), files.end());
  return files;
}

// Any edit a person could make, and more: every value of every material and light, a camera, a sky.
Edits random_edits(scene::Scene& scene, std::mt19937& random) {
  std::uniform_real_distribution<float> unit(0, 1);
  const auto u = [&] { return unit(random); };
  const auto colour = [&](float most) {
    const float x = u(), y = u(), z = u();
    return Vec3(x, y, z) * most;
  };
  Edits edits;
  for (size_t i = 0; i < scene.materials.size(); ++i) {
    scene::Material& m = scene.materials[i];
    const scene::Material before = m;
    m.base_color = colour(1);
    for (float* value : {&m.alpha, &m.metallic, &m.roughness, &m.specular, &m.specular_tint, &m.anisotropic,
                         &m.anisotropic_rotation, &m.sheen, &m.sheen_tint, &m.clearcoat,
                         &m.clearcoat_roughness, &m.alpha_cutoff})
      *value = u();
    m.emission = i % 3 == 0 ? Vec3(0) : colour(i % 3 == 1 ? 1.f : 1e4f);
    if (m.normal_texture.bitmap >= 0) m.normal_scale = 2 * u();
    m.double_sided = i % 2 == 0;
    m.alpha_mode = static_cast<scene::AlphaMode>(i % 3);
    edits.materials.push_back({i, before, m});
  }
  for (scene::Light& light : scene.lights) {
    light.intensity = colour(1000);
    const float x = u(), y = u(), z = u();
    light.position += Vec3(x, y, z);
    if (light.kind == scene::LightKind::spot) {
      const float angle = u();
      light.cos_outer = std::cos(angle + .1f);
      light.cos_inner = std::cos(angle);
    }
    edits.lights.push_back(light);
  }
  CameraEdit& camera = edits.camera.emplace();
  camera.to_world =
      math::DMat4(math::DMat4::col_type(.8, 0, .6, 0), math::DMat4::col_type(.1, .9, -.1, 0),
                  math::DMat4::col_type(-.6, .2, .8, 0), math::DMat4::col_type(u(), u(), u(), 1));
  camera.camera.name = "view";
  camera.camera.yfov = .3f + u();
  camera.camera.aspect = 2.35f;
  camera.camera.to_world = *gltf::camera_frame(camera.to_world);
  scene.cameras.push_back(camera.camera);
  EnvironmentEdit& sky = edits.environment.emplace();
  sky.rotation_degrees = 360 * u();
  sky.environment = {{"", 4, 2, {}}, 2 * u(), sky.rotation_degrees * math::pi / 180};
  for (int i = 0; i < 8; ++i) sky.environment.map.texels.push_back(math::Vec4(colour(5), 1));
  scene.environment = sky.environment;
  return edits;
}

void expect_same(const scene::Scene& saved, scene::Scene edited) {
  ASSERT_EQ(saved.materials.size(), edited.materials.size());
  for (size_t i = 0; i < saved.materials.size(); ++i) {
    edited.materials[i].name = saved.materials[i].name;  // "(glTF default)" gets one
    EXPECT_EQ(saved.materials[i], edited.materials[i]) << saved.materials[i].name;
  }
  ASSERT_EQ(saved.lights.size(), edited.lights.size());
  for (size_t i = 0; i < saved.lights.size(); ++i) {
    edited.lights[i].node = saved.lights[i].node;
    EXPECT_EQ(saved.lights[i].intensity, edited.lights[i].intensity);
    EXPECT_EQ(saved.lights[i].position, edited.lights[i].position);
    EXPECT_EQ(saved.lights[i], edited.lights[i]) << i;
  }
  EXPECT_EQ(saved.cameras, edited.cameras);
  ASSERT_EQ(saved.environment.has_value(), edited.environment.has_value());
  if (saved.environment) {
    EXPECT_EQ(saved.environment->map.texels, edited.environment->map.texels);
    EXPECT_EQ(saved.environment->strength, edited.environment->strength);
    EXPECT_EQ(saved.environment->rotation, edited.environment->rotation);
  }
  ASSERT_EQ(saved.meshes.size(), edited.meshes.size());
  for (size_t i = 0; i < saved.meshes.size(); ++i) {
    EXPECT_EQ(saved.meshes[i].positions, edited.meshes[i].positions);
    EXPECT_EQ(saved.meshes[i].triangles, edited.meshes[i].triangles);
    EXPECT_EQ(saved.meshes[i].material, edited.meshes[i].material);
  }
  ASSERT_EQ(saved.bitmaps.size(), edited.bitmaps.size());
  for (size_t i = 0; i < saved.bitmaps.size(); ++i)
    EXPECT_EQ(saved.bitmaps[i].texels, edited.bitmaps[i].texels);
}

TEST(GltfFile, every_edited_value_of_every_scene_of_the_suite_reads_back_bit_by_bit) {
  std::mt19937 random(1);
  for (const std::string& file : scenes()) {
    SCOPED_TRACE(file);
    const sample::Folder folder;
    for (const char* name : {"saved.glb", "saved.gltf"}) {
      scene::Scene edited = gltf::load(file);
      const std::string hash = edited.hash;
      const Edits edits = random_edits(edited, random);
      write_gltf(file, hash, folder / name, edits);
      expect_same(gltf::load(folder / name), edited);
    }
  }
}

TEST(GltfFile, without_edits_everything_stays) {
  for (const std::string& file : scenes()) {
    SCOPED_TRACE(file);
    const sample::Folder folder;
    const scene::Scene scene = gltf::load(file);
    write_gltf(file, scene.hash, folder / "saved.glb", {});
    std::string before, after;
    json was = json_of(file, &before);
    const json is = json_of(folder / "saved.glb", &after);
    if (was["scenes"][0].contains("extras") && was["scenes"][0]["extras"].contains("environment"))
      was["scenes"][0]["extras"]["environment"] = is["scenes"][0]["extras"]["environment"];  // its copy
    EXPECT_EQ(was, is);
    EXPECT_EQ(before, after);
    expect_same(gltf::load(folder / "saved.glb"), scene);
  }
}

TEST(GltfFile, one_edit_touches_its_material_alone) {
  const std::string file = ASSAY_SOURCE_DIR "/regression/scenes/khr_layers.glb";
  const sample::Folder folder;
  const scene::Scene scene = gltf::load(file);
  MaterialEdit edit{1, scene.materials[1], scene.materials[1]};
  edit.after.roughness = .125f;
  write_gltf(file, scene.hash, folder / "saved.glb", {{edit}, {}, {}, {}});
  json was = json_of(file), is = json_of(folder / "saved.glb");
  EXPECT_EQ(is["materials"][1]["pbrMetallicRoughness"]["roughnessFactor"], .125);
  EXPECT_EQ(is["materials"][1]["extensions"], was["materials"][1]["extensions"]) << "no coat was edited";
  was["materials"][1] = is["materials"][1] = nullptr;
  was["scenes"][0]["extras"]["environment"] = is["scenes"][0]["extras"]["environment"];  // its copy
  EXPECT_EQ(was, is);
}

TEST(GltfFile, extensions_that_approximate_an_edited_parameter_go_and_the_coat_is_said_in_its_own) {
  sample::File f = sample::triangle();
  f.root["materials"] = json::parse(R"([{"extensions": {
    "KHR_materials_specular": {"specularFactor": 0.5}, "KHR_materials_sheen": {"sheenColorFactor": [0.5, 0.2, 0.1]},
    "KHR_materials_unlit": {}}, "extras": {"disney_clearcoat_gloss": 0.5, "mine": [1, 2]}}])");
  f.root["meshes"][0]["primitives"][0]["material"] = 0;
  const sample::Folder folder;
  const std::string file = folder.write("a.glb", f.to_glb());
  const scene::Scene scene = gltf::load(file);
  MaterialEdit edit{0, scene.materials[0], scene.materials[0]};
  edit.after.sheen = 1;
  edit.after.clearcoat_roughness = .2f;
  write_gltf(file, scene.hash, folder / "b.glb", {{edit}, {}, {}, {}});
  const json material = json_of(folder / "b.glb")["materials"][0];
  EXPECT_EQ(material["extensions"], json::parse(R"({"KHR_materials_specular": {"specularFactor": 0.5},
    "KHR_materials_unlit": {}, "KHR_materials_clearcoat": {"clearcoatFactor": 0.0, "clearcoatRoughnessFactor": 0.2}})"));
  EXPECT_EQ(material["extras"]["mine"], json::parse("[1, 2]"));
  EXPECT_FALSE(material["extras"].contains("disney_clearcoat_gloss"));
  EXPECT_EQ(gltf::load(folder / "b.glb").materials[0], edit.after);
}

// Blender's files are in candela and lux.
TEST(GltfFile, a_light_under_a_turned_and_scaled_parent_goes_where_it_was_put_in_the_files_units) {
  for (const char* generator : {"hand", "Khronos glTF Blender I/O v3.4"}) {
    sample::File f = sample::triangle();
    f.root["asset"]["generator"] = generator;
    f.root["extensions"] = json::parse(
        R"({"KHR_lights_punctual": {"lights": [{"type": "spot", "intensity": 5, "spot": {}}, {"type": "point"}]}})");
    f.root["nodes"] = json::parse(R"([
      {"scale": [2, 1, 0.5], "rotation": [0.5, 0.5, 0.5, 0.5], "translation": [3, 1, 2], "children": [1, 2]},
      {"mesh": 0, "rotation": [0, 0.6, 0, 0.8], "extensions": {"KHR_lights_punctual": {"light": 0}}, "children": [3]},
      {"extensions": {"KHR_lights_punctual": {"light": 0}}},
      {"extensions": {"KHR_lights_punctual": {"light": 1}}}])");
    f.root["scenes"] = json::parse(R"([{"nodes": [0]}])");
    const sample::Folder folder;
    const std::string file = folder.write("a.glb", f.to_glb());
    scene::Scene scene = gltf::load(file);
    ASSERT_EQ(scene.lights.size(), 3u);
    scene.lights[0].position = {.1f, -.7f, 12.3f};
    scene.lights[0].intensity = {.3f, .1f, 7};
    scene.lights[1].intensity = Vec3(0);
    write_gltf(file, scene.hash, folder / "b.glb", {{}, {scene.lights[0], scene.lights[1]}, {}, {}});
    expect_same(gltf::load(folder / "b.glb"), scene);
  }
}

// Cosines of every size, also those whose angle is 0 or a right one; what stays is not written.
TEST(GltfFile, the_cones_of_a_spot_read_back_bit_by_bit) {
  sample::File f = sample::triangle();
  f.root["extensions"] = json::parse(
      R"({"KHR_lights_punctual": {"lights": [{"type": "spot", "spot": {"innerConeAngle": 0.3, "mine": 1}}]}})");
  f.root["nodes"] = json::parse(R"([{"mesh": 0, "extensions": {"KHR_lights_punctual": {"light": 0}}}])");
  const sample::Folder folder;
  const std::string file = folder.write("a.glb", f.to_glb());
  scene::Scene scene = gltf::load(file);
  ASSERT_EQ(scene.lights.size(), 1u);
  scene::Light& light = scene.lights[0];
  std::mt19937 random(3);
  std::uniform_real_distribution<float> unit(0, 1);
  for (int i = 0; i < 200; ++i) {
    light.cos_inner = i == 0 ? 1 : 1 - std::pow(unit(random), 8.f);
    light.cos_outer =
        i == 0 ? static_cast<float>(std::cos(std::acos(-1.) / 2)) : light.cos_inner * unit(random);
    if (light.cos_outer >= light.cos_inner) continue;
    write_gltf(file, scene.hash, folder / "b.glb", {{}, {light}, {}, {}});
    ASSERT_EQ(gltf::load(folder / "b.glb").lights[0], light) << light.cos_inner << ' ' << light.cos_outer;
  }
  light = gltf::load(file).lights[0];
  light.intensity = Vec3(.5f);
  write_gltf(file, scene.hash, folder / "c.glb", {{}, {light}, {}, {}});
  EXPECT_EQ(json_of(folder / "c.glb")["extensions"]["KHR_lights_punctual"]["lights"][0]["spot"],
            json::parse(R"({"innerConeAngle": 0.3, "mine": 1})"));
}

// A .gltf that names a buffer and an image.
std::string write_loose(const sample::Folder& folder) {
  sample::File f = sample::triangle();
  const std::string picture = read(ASSAY_SOURCE_DIR "/renderer/image/testdata/baseline.jpg");
  folder.write("my picture.jpg", picture);
  folder.write("data.bin", {reinterpret_cast<const char*>(f.binary.data()), f.binary.size()});
  f.root["buffers"][0]["uri"] = "data.bin";
  f.root["images"] = json::parse(R"([{"uri": "my%20picture.jpg"}])");
  f.root["textures"] = json::parse(R"([{"source": 0}])");
  f.root["materials"] = json::parse(R"([{"emissiveTexture": {"index": 0}, "emissiveFactor": [1, 1, 1]}])");
  f.root["meshes"][0]["primitives"][0]["material"] = 0;
  return folder.write("loose.gltf", f.root.dump());
}

TEST(GltfFile, a_glb_holds_what_a_gltf_only_names) {
  const sample::Folder folder, other;
  const std::string file = write_loose(folder);
  const scene::Scene scene = gltf::load(file);
  ASSERT_EQ(scene.bitmaps.size(), 1u);
  write_gltf(file, scene.hash, other / "packed.glb", {});
  expect_same(gltf::load(other / "packed.glb"), scene);
  write_gltf(file, scene.hash, folder / "beside.gltf", {});
  EXPECT_EQ(json_of(folder / "beside.gltf"), json_of(file));
}

TEST(GltfFile, refuses_in_one_line_what_cannot_be) {
  const sample::Folder folder, other;
  const std::string file = write_loose(folder);
  const std::string hash = gltf::load(file).hash;
  const auto complaint = [&](const std::string& target, const std::string& known_hash) -> std::string {
    try {
      write_gltf(file, known_hash, target, {});
    } catch (const base::Error& error) {
      return error.what();
    }
    return "";
  };
  sample::expect_refused(complaint(file, hash), "another file than the scene");
  sample::expect_refused(complaint(other / "b.gltf", hash), "which names files there");
  sample::expect_refused(complaint(folder / "b.obj", hash), ".gltf or .glb");
  sample::expect_refused(complaint(folder / "b.glb", std::string(64, '0')), "changed since");
  sample::expect_refused(complaint(folder / "no/folder/b.glb", hash), "cannot write");
  EXPECT_EQ(complaint(folder / "b.glb", hash), "");
}

TEST(GltfFile, any_colour_of_any_brightness_reads_back) {
  std::mt19937 random(2);
  std::uniform_real_distribution<float> unit(0, 1), exponent(-30, 30);
  sample::File f = sample::triangle();
  f.root["materials"] = json::array();
  for (int i = 0; i < 1000; ++i) f.root["materials"].push_back({{"name", "m"}});
  const sample::Folder folder;
  const std::string file = folder.write("a.glb", f.to_glb());
  scene::Scene scene = gltf::load(file);
  Edits edits;
  for (size_t i = 0; i < 1000; ++i) {
    scene::Material& m = scene.materials[i];
    const float x = unit(random), y = unit(random), z = unit(random);
    m.emission = Vec3(x, y, z) * std::exp2(exponent(random));
    edits.materials.push_back({i, {}, m});
  }
  write_gltf(file, scene.hash, folder / "b.glb", edits);
  expect_same(gltf::load(folder / "b.glb"), scene);
}

}  // namespace
}  // namespace view
