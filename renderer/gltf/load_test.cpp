// Good files: the exact scene they become. Expected numbers are written by hand from the glTF 2.0
// specification.
#include "gltf/load.h"

#include <cmath>

#include "gltf/sample_test.h"

using namespace gltf;
using namespace gltf::sample;
using math::UVec3;
using math::Vec2;
using math::Vec3;
using math::Vec4;

namespace {

void expect_near(const Vec3& a, const Vec3& b, float tolerance = 1e-6f) {
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(a[c], b[c], tolerance) << "component " << c;
}

scene::Scene with_nodes(const std::string& nodes, const Options& options = {},
                        const std::string& generator = "hand") {
  File f = triangle();
  f.root["asset"]["generator"] = generator;
  f.root["nodes"] = json::parse(nodes);
  f.root["cameras"] = json::parse(R"([{"type": "perspective", "perspective": {"yfov": 0.5, "znear": 0.1}},
    {"type": "orthographic", "orthographic": {"xmag": 2, "ymag": 3, "znear": 0, "zfar": 9}}])");
  f.root["extensions"] = json::parse(R"({"KHR_lights_punctual": {"lights": [
    {"type": "point", "color": [1, 0.5, 0], "intensity": 1366},
    {"type": "directional", "intensity": 2},
    {"type": "spot", "spot": {"innerConeAngle": 0.25, "outerConeAngle": 0.5}}]}})");
  return load_file(f, options);
}

}  // namespace

TEST(Load, gives_a_triangle_as_it_stands_with_the_default_material) {
  const scene::Scene scene = load_file(triangle());
  ASSERT_EQ(scene.meshes.size(), 1u);
  const scene::Mesh& mesh = scene.meshes[0];
  EXPECT_EQ(mesh.name, "tri");
  EXPECT_EQ(mesh.positions, (std::vector<Vec3>{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}));
  EXPECT_EQ(mesh.triangles, std::vector<UVec3>{UVec3(0, 1, 2)});
  EXPECT_TRUE(mesh.normals.empty() && mesh.tangents.empty() && mesh.texcoords[0].empty() &&
              mesh.colors.empty());
  ASSERT_EQ(scene.materials.size(), 1u);
  EXPECT_EQ(scene.materials[0].metallic, 1);
  EXPECT_EQ(scene.materials[0].roughness, 1);
  EXPECT_EQ(scene.materials[0].base_color, Vec3(1, 1, 1));
  EXPECT_FALSE(scene.materials[0].double_sided);
  ASSERT_EQ(scene.instances.size(), 1u);
  EXPECT_EQ(scene.instances[0].to_world, math::Mat4(1.0f));
  EXPECT_TRUE(scene.cameras.empty() && scene.lights.empty() && !scene.environment && scene.warnings.empty());
}

TEST(Load, shares_one_mesh_between_the_nodes_that_show_it) {
  const scene::Scene scene =
      with_nodes(R"([{"children": [1, 2], "translation": [1, 0, 0]}, {"mesh": 0, "scale": [2, 2, 2]},
    {"mesh": 0, "rotation": [0, 0, 0.70710678, 0.70710678], "translation": [0, 5, 0]}])");
  EXPECT_EQ(scene.meshes.size(), 1u);
  ASSERT_EQ(scene.instances.size(), 2u);
  EXPECT_EQ(math::transform_point(scene.instances[0].to_world, {1, 1, 1}), Vec3(3, 2, 2));
  expect_near(math::transform_point(scene.instances[1].to_world, {1, 0, 0}), {1, 6, 0});  // +x turns to +y
}

TEST(Load, multiplies_matrices_from_the_root_and_keeps_mirroring) {
  const scene::Scene scene =
      with_nodes(R"([{"matrix": [0,0,-1,0, 0,1,0,0, 1,0,0,0, 10,20,30,1], "children": [1]},
    {"mesh": 0, "scale": [-1, 1, 3]}])");
  const math::Mat4& m = scene.instances.at(0).to_world;
  EXPECT_EQ(math::transform_point(m, {1, 0, 0}), Vec3(10, 20, 31));
  EXPECT_EQ(math::transform_point(m, {0, 0, 1}), Vec3(13, 20, 30));
  EXPECT_LT(math::dot(math::cross(Vec3(m[0]), Vec3(m[1])), Vec3(m[2])), 0);
}

TEST(Load, judges_transforms_by_the_written_rules) {
  const auto node = [](const std::string& text) {
    File f = triangle();
    f.root["nodes"][0] = json::parse("{\"mesh\": 0, " + text + "}");
    return f;
  };
  expect_refused(complaint(node("\"matrix\": [1,0,0,0, 0,1,0,0, 0,0,1,0, 0,0,0]")), "nodes[0].matrix");
  expect_refused(complaint(node("\"matrix\": [1,0,0,1, 0,1,0,0, 0,0,1,0, 0,0,0,1]")), "nodes[0].matrix");
  expect_refused(complaint(node("\"matrix\": [1,0,0,0, 0,1,0,0, 0,0,1,0, 0,0,0,1], \"scale\": [1,1,1]")),
                 "nodes[0]");
  expect_refused(complaint(node("\"rotation\": [0,0,0,0]")), "nodes[0].rotation");
  expect_refused(complaint(node("\"translation\": [0,1e300,0]")), "nodes[0].translation[1]");
  expect_refused(complaint(node("\"translation\": [0,1e30,0]")), "nodes[0]: wanted a mesh within 1e18");
  for (const std::string size : {"1e-20", "1e20"}) {
    const scene::Scene scene = load_file(node("\"rotation\": [0, 0, " + size + ", " + size + "]"));
    expect_near(math::transform_vector(scene.instances.at(0).to_world, {1, 0, 0}), {0, 1, 0});
    EXPECT_TRUE(warned(scene, "unit quaternion"));
  }
  for (const std::string thickness : {"0", "1e-30", "1e-12"}) {
    const scene::Scene flat = load_file(node("\"scale\": [1, " + thickness + ", 1]"));
    EXPECT_TRUE(flat.instances.empty());
    EXPECT_TRUE(warned(flat, "scaled to nothing"));
  }
  EXPECT_EQ(load_file(node("\"scale\": [1e-6, 1e-6, 1e-6]")).instances.size(), 1u);
  EXPECT_EQ(load_file(node("\"scale\": [1, 1e-11, 1]")).instances.size(), 1u);
}

TEST(Load, makes_cameras_rigid) {
  File f = triangle();
  f.root["nodes"] = json::parse(R"([{"scale": [2, 3, 2], "children": [1]},
    {"name": "eye", "camera": 0, "translation": [1, 2, 3], "rotation": [0, 0.70710678, 0, 0.70710678]}, {"camera": 1}])");
  f.root["cameras"] = json::parse(R"([{"type": "perspective", "perspective": {"yfov": 0.5, "znear": 0.1}},
    {"type": "orthographic", "orthographic": {"xmag": 2, "ymag": 3, "znear": 0, "zfar": 9}}])");
  f.root["scenes"][0]["nodes"] = json::parse("[0, 2]");
  const scene::Scene s = load_file(f);
  ASSERT_EQ(s.cameras.size(), 2u);
  EXPECT_EQ(s.cameras[0].name, "eye");
  EXPECT_FALSE(s.cameras[0].orthographic);
  EXPECT_EQ(s.cameras[0].yfov, .5f);
  const math::Mat4& m = s.cameras[0].to_world;
  expect_near(Vec3(m[3]), {2, 6, 6});
  expect_near(math::transform_vector(m, {0, 0, -1}), {-1, 0, 0});  // a quarter turn about +y: -z becomes -x
  expect_near(math::transform_vector(m, {0, 1, 0}), {0, 1, 0});
  expect_near(math::transform_vector(m, {1, 0, 0}), {0, 0, -1});
  EXPECT_TRUE(s.cameras[1].orthographic);
  EXPECT_EQ(s.cameras[1].ymag, 3);
}

TEST(Load, refuses_cameras_that_see_nothing) {
  for (const char* yfov : {"0", "-1", "3.15", "1e300", "null"}) {
    File f = triangle();
    f.root["cameras"] = json::parse(
        "[{\"type\": \"perspective\", \"perspective\": {\"znear\": 0.1, \"yfov\": " + std::string(yfov) +
        "}}]");
    expect_refused(complaint(f), "cameras[0].perspective.yfov");
  }
  File f = triangle();
  f.root["cameras"] = json::parse(R"([{"type": "perspective", "perspective": {"yfov": 1, "znear": 0.1}}])");
  f.root["nodes"][0] = json::parse(R"({"camera": 0, "scale": [0, 0, 0]})");
  expect_refused(complaint(f), "nodes[0]");
}

TEST(Load, reads_punctual_lights_in_watts_unless_blender_wrote_them) {
  const std::string nodes = R"([{"children": [1, 2, 3], "scale": [5, 5, 5]},
    {"translation": [1, 2, 3], "extensions": {"KHR_lights_punctual": {"light": 0}}},
    {"rotation": [-0.70710678, 0, 0, 0.70710678], "extensions": {"KHR_lights_punctual": {"light": 1}}},
    {"extensions": {"KHR_lights_punctual": {"light": 2}}}])";
  const scene::Scene scene = with_nodes(nodes);
  ASSERT_EQ(scene.lights.size(), 3u);
  EXPECT_EQ(scene.lights[0].kind, scene::LightKind::point);
  EXPECT_EQ(scene.lights[0].intensity, Vec3(1366, 683, 0));
  EXPECT_EQ(scene.lights[0].position, Vec3(5, 10, 15));
  EXPECT_EQ(scene.lights[1].kind, scene::LightKind::directional);
  expect_near(scene.lights[1].direction, {0, -1, 0});  // -z turned a quarter about -x
  EXPECT_EQ(scene.lights[1].intensity, Vec3(2, 2, 2));
  EXPECT_EQ(scene.lights[2].kind, scene::LightKind::spot);
  EXPECT_EQ(scene.lights[2].intensity, Vec3(1, 1, 1));
  EXPECT_FLOAT_EQ(scene.lights[2].cos_inner, std::cos(.25f));
  EXPECT_FLOAT_EQ(scene.lights[2].cos_outer, std::cos(.5f));
  EXPECT_TRUE(scene.warnings.empty());

  Options options;
  const std::string blender = "Khronos glTF Blender I/O v3.4.50";
  EXPECT_EQ(with_nodes(nodes, options, blender).lights[0].intensity, Vec3(2, 1, 0));
  EXPECT_TRUE(warned(with_nodes(nodes, options, blender), "divided by 683"));
  options.punctual_units = PunctualUnits::watt;
  EXPECT_EQ(with_nodes(nodes, options, blender).lights[0].intensity, Vec3(1366, 683, 0));
  options.punctual_units = PunctualUnits::candela;
  EXPECT_EQ(with_nodes(nodes, options).lights[0].intensity, Vec3(2, 1, 0));
}

// They light nothing, and the bits are the same without them (reference/robust, Bits), but a viewer can turn
// them up.
TEST(Load, keeps_lights_of_no_intensity) {
  File f = triangle();
  f.root["extensions"] = json::parse(R"({"KHR_lights_punctual": {"lights": [
    {"type": "point", "intensity": 0}, {"type": "point", "color": [0, 0, 0]}, {"type": "point", "name": "lit"}]}})");
  f.root["nodes"] = json::parse(R"([{"mesh": 0, "children": [1, 2, 3]},
    {"extensions": {"KHR_lights_punctual": {"light": 0}}}, {"extensions": {"KHR_lights_punctual": {"light": 1}}},
    {"extensions": {"KHR_lights_punctual": {"light": 2}}}])");
  const scene::Scene s = load_file(f);
  ASSERT_EQ(s.lights.size(), 3u);
  EXPECT_TRUE(math::is_black(s.lights[0].intensity) && math::is_black(s.lights[1].intensity));
  EXPECT_EQ(s.lights[2].name, "lit");
}

TEST(Load, refuses_lights_that_make_no_sense) {
  const auto with = [](const std::string& light) {
    File f = triangle();
    f.root["extensions"] = json::parse(R"({"KHR_lights_punctual": {"lights": [)" + light + "]}}");
    f.root["nodes"] = json::parse(R"([{"extensions": {"KHR_lights_punctual": {"light": 0}}}])");
    return complaint(f);
  };
  EXPECT_EQ(with(R"({"type": "spot", "spot": {}})"), "");
  expect_refused(with(R"({"type": "area"})"), "lights[0].type");
  expect_refused(with(R"({"type": "point", "intensity": -1})"), "lights[0].intensity");
  expect_refused(with(R"({"type": "point", "color": [1, 1]})"), "lights[0].color");
  expect_refused(with(R"({"type": "point", "color": [1, -1, 1]})"), "lights[0]");
  expect_refused(with(R"({"type": "spot", "spot": {"innerConeAngle": 0.5, "outerConeAngle": 0.5}})"),
                 "lights[0].spot");
  expect_refused(with(R"({"type": "spot", "spot": {"outerConeAngle": 2}})"), "lights[0].spot");
}

TEST(Load, renders_the_chosen_scene_or_all_roots_if_there_is_none) {
  File f = triangle();
  f.root["nodes"] = json::parse(
      R"([{"mesh": 0}, {"mesh": 0, "translation": [1, 0, 0]}, {"mesh": 0, "translation": [2, 0, 0]}])");
  f.root["scenes"] = json::parse(R"([{"nodes": [0]}, {"nodes": [2, 1]}])");
  f.root["scene"] = 1;
  const scene::Scene chosen = load_file(f);
  ASSERT_EQ(chosen.instances.size(), 2u);
  EXPECT_EQ(chosen.instances[0].to_world[3].x, 2);
  EXPECT_EQ(chosen.instances[1].to_world[3].x, 1);
  f.root.erase("scene");
  EXPECT_EQ(load_file(f).instances.size(), 1u);
  f.root.erase("scenes");
  EXPECT_EQ(load_file(f).instances.size(), 3u);
}

TEST(Load, names_what_it_does_not_render) {
  File f = triangle();
  f.root["animations"] = json::parse("[{}]");
  f.root["skins"] = json::parse(R"([{"joints": [0]}])");
  f.root["nodes"][0]["skin"] = 0;
  f.root["extensionsUsed"] = json::parse(R"(["KHR_materials_transmission"])");
  f.root["meshes"][0]["primitives"][0]["targets"] = json::parse(R"([{"POSITION": 0}])");
  f.root["meshes"][0]["primitives"].push_back(json::parse(R"({"attributes": {"POSITION": 0}, "mode": 1})"));
  const scene::Scene scene = load_file(f);
  for (const char* text :
       {"animations", "skins", "KHR_materials_transmission", "morph targets", "points and lines"})
    EXPECT_TRUE(warned(scene, text)) << text;
  EXPECT_EQ(scene.instances.size(), 1u);
}

TEST(Load, reads_the_environment_from_the_scene_extras) {
  File f = triangle();
  f.root["scenes"][0]["extras"] = json::parse(
      R"({"environment_color": [1, 2, 3], "environment_strength": 4, "environment_rotation": 90, "note": "mine"})");
  const scene::Scene scene = load_file(f);
  ASSERT_TRUE(scene.environment.has_value());
  EXPECT_EQ(scene.environment->map.width, 1);
  EXPECT_EQ(scene.environment->map.texels, std::vector<Vec4>{Vec4(1, 2, 3, 1)});
  EXPECT_EQ(scene.environment->strength, 4);
  EXPECT_FLOAT_EQ(scene.environment->rotation, math::pi / 2);

  const auto with = [&](const std::string& extras) {
    f.root["scenes"][0]["extras"] = json::parse(extras);
    return complaint(f);
  };
  expect_refused(with(R"({"environment_colour": [1, 1, 1]})"), "environment_color, the nearest known key");
  expect_refused(with(R"({"environment_color": [1, -1, 1]})"), "environment_color");
  expect_refused(with(R"({"environment_color": [1, 1]})"), "environment_color");
  expect_refused(with(R"({"environment_color": [1, 1, 1], "environment_strength": "1"})"),
                 "environment_strength");
  for (const char* name : {"../sky.exr", "/etc/hostname", "missing.exr", ""})
    expect_refused(with(json{{"environment", name}}.dump()), "scenes[0].extras.environment");
}
