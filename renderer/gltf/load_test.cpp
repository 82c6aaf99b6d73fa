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

constexpr float not_a_number = std::numeric_limits<float>::quiet_NaN(),
                inf = std::numeric_limits<float>::infinity();
// 2 x 2 RGBA: red, half-transparent green / (51, 102, 153) with alpha 0, white.
const std::string png =
    "iVBORw0KGgoAAAANSUhEUgAAAAIAAAACCAYAAABytg0kAAAAF0lEQVR42mP4z8DwHwgbGIzTZjL8BwIAQdUIrMbWMH4AAAAASUVORK5C"
    "YII=";

// The triangle sample with one more attribute of the given type.
template <typename T>
File with_attribute(const std::string& name, const std::string& type, int component_type,
                    std::initializer_list<T> values, bool normalized = false) {
  File f = triangle();
  f.root["meshes"][0]["primitives"][0]["attributes"][name] =
      f.data(type, component_type, 3, values, normalized);
  return f;
}

scene::Mesh mesh_of(const File& f) { return load_file(f).meshes.at(0); }

// Six vertices and the given indices and mode.
std::vector<UVec3> triangles_of(int mode, std::initializer_list<std::uint8_t> indices) {
  File f;
  f.data<float>("VEC3", 5126, 6, {0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0, 0, 2, 0, 1, 2, 0});
  f.data<std::uint8_t>("SCALAR", 5121, indices.size(), indices);
  f.root["meshes"] = json::parse(R"([{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}])");
  f.root["meshes"][0]["primitives"][0]["mode"] = mode;
  f.root["nodes"] = json::parse(R"([{"mesh": 0}])");
  f.root["scenes"] = json::parse(R"([{"nodes": [0]}])");
  const scene::Scene scene = load_file(f);
  return scene.meshes.empty() ? std::vector<UVec3>() : scene.meshes[0].triangles;
}

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

TEST(Load, reads_indices_of_every_width_and_none) {
  File f = triangle();
  for (const int type : {5121, 5125}) {
    const size_t accessor = type == 5121 ? f.data<std::uint8_t>("SCALAR", type, 3, {2, 0, 1})
                                         : f.data<std::uint32_t>("SCALAR", type, 3, {2, 0, 1});
    f.root["meshes"][0]["primitives"][0]["indices"] = accessor;
    EXPECT_EQ(mesh_of(f).triangles, std::vector<UVec3>{UVec3(2, 0, 1)}) << type;
  }
  f.root["meshes"][0]["primitives"][0].erase("indices");
  EXPECT_EQ(mesh_of(f).triangles, std::vector<UVec3>{UVec3(0, 1, 2)});
}

TEST(Load, refuses_indices_past_the_last_vertex_and_other_types) {
  File f = triangle();
  const auto with = [&](size_t accessor) {
    f.root["meshes"][0]["primitives"][0]["indices"] = accessor;
    return complaint(f);
  };
  expect_refused(with(f.data<std::uint8_t>("SCALAR", 5121, 3, {0, 1, 3})),
                 "indices[2]: wanted a vertex below 3, found 3");
  expect_refused(with(f.data<std::uint16_t>("SCALAR", 5123, 3, {65535, 1, 2})), "indices[0]");
  expect_refused(with(f.data<std::uint32_t>("SCALAR", 5125, 3, {0, 0xffffffff, 2})), "indices[1]");
  expect_refused(with(f.data<float>("SCALAR", 5126, 3, {0, 1, 2})), "indices");
  expect_refused(with(f.data<std::int16_t>("SCALAR", 5122, 3, {0, 1, 2})), "indices");
  expect_refused(with(f.data<std::uint8_t>("SCALAR", 5121, 3, {0, 1, 2}, true)), "indices");
}

TEST(Load, makes_triangles_of_lists_strips_and_fans_dropping_degenerate_indices) {
  using Triangles = std::vector<UVec3>;
  EXPECT_EQ(triangles_of(4, {0, 1, 2, 2, 1, 3}), (Triangles{{0, 1, 2}, {2, 1, 3}}));
  EXPECT_EQ(triangles_of(4, {0, 1, 2, 3, 4}), (Triangles{{0, 1, 2}}));
  EXPECT_EQ(triangles_of(4, {0, 0, 1, 0, 1, 2, 3, 4, 3}), (Triangles{{0, 1, 2}}));
  EXPECT_EQ(triangles_of(5, {0, 1, 2, 3, 4}), (Triangles{{0, 1, 2}, {1, 3, 2}, {2, 3, 4}}));
  EXPECT_EQ(triangles_of(5, {0, 1, 2, 2, 3, 4}), (Triangles{{0, 1, 2}, {2, 4, 3}}));
  EXPECT_EQ(triangles_of(6, {0, 1, 2, 3}), (Triangles{{1, 2, 0}, {2, 3, 0}}));
  for (const int mode : {5, 6}) EXPECT_EQ(triangles_of(mode, {0, 1}), Triangles());
  for (const int mode : {0, 1, 2, 3}) EXPECT_EQ(triangles_of(mode, {0, 1, 2}), Triangles());
}

TEST(Load, reads_texture_coordinates_as_floats_and_normalized_integers) {
  const std::vector<Vec2> expected = {{0, 0}, {1, 0}, {1, .2f}};
  EXPECT_EQ(mesh_of(with_attribute<float>("TEXCOORD_0", "VEC2", 5126, {0, 0, 1, 0, 1, .2f})).texcoords[0],
            expected);
  EXPECT_EQ(mesh_of(with_attribute<std::uint8_t>("TEXCOORD_0", "VEC2", 5121, {0, 0, 255, 0, 255, 51}, true))
                .texcoords[0],
            expected);
  EXPECT_EQ(
      mesh_of(with_attribute<std::uint16_t>("TEXCOORD_1", "VEC2", 5123, {0, 0, 65535, 0, 65535, 13107}, true))
          .texcoords[1],
      expected);
  expect_refused(complaint(with_attribute<std::uint8_t>("TEXCOORD_0", "VEC2", 5121, {0, 0, 255, 0, 255, 51})),
                 "TEXCOORD_0");
  const File bad = with_attribute<float>("TEXCOORD_0", "VEC2", 5126, {0, 0, not_a_number, 0, inf, .2f});
  EXPECT_EQ(mesh_of(bad).texcoords[0], (std::vector<Vec2>(3)));
  EXPECT_TRUE(warned(load_file(bad), "not finite"));
}

TEST(Load, reads_colours_of_three_and_four_channels) {
  EXPECT_EQ(mesh_of(with_attribute<float>("COLOR_0", "VEC3", 5126, {1, 0, 0, 0, 1, 0, 0, 0, .5f})).colors,
            (std::vector<Vec4>{{1, 0, 0, 1}, {0, 1, 0, 1}, {0, 0, .5f, 1}}));
  EXPECT_EQ(mesh_of(with_attribute<std::uint16_t>("COLOR_0", "VEC4", 5123,
                                                  {65535, 0, 0, 13107, 0, 0, 0, 0, 0, 0, 65535, 0}, true))
                .colors,
            (std::vector<Vec4>{{1, 0, 0, .2f}, {0, 0, 0, 0}, {0, 0, 1, 0}}));
  const File bad = with_attribute<float>("COLOR_0", "VEC3", 5126, {2, -1, not_a_number, 0, 1, 0, 0, 0, .5f});
  EXPECT_EQ(mesh_of(bad).colors[0], Vec4(1, 0, 0, 1));
  EXPECT_TRUE(warned(load_file(bad), "colours outside [0,1]"));
}

TEST(Load, refuses_attributes_of_another_length_or_type) {
  for (const size_t count : {2u, 4u}) {
    File f = triangle();
    f.root["meshes"][0]["primitives"][0]["attributes"]["NORMAL"] =
        f.data<float>("VEC3", 5126, count, {0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1});
    expect_refused(complaint(f), "meshes[0].primitives[0].attributes.NORMAL: wanted 3 elements");
  }
  expect_refused(complaint(with_attribute<float>("NORMAL", "VEC2", 5126, {0, 0, 0, 0, 0, 0})), "NORMAL");
  expect_refused(complaint(with_attribute<float>("TANGENT", "VEC3", 5126, {1, 0, 0, 1, 0, 0, 1, 0, 0})),
                 "TANGENT");
  expect_refused(
      complaint(with_attribute<std::int8_t>("NORMAL", "VEC3", 5120, {0, 0, 127, 0, 0, 127, 0, 0, 127}, true)),
      "NORMAL");
  expect_refused(
      complaint(with_attribute<std::uint8_t>("POSITION", "VEC3", 5121, {0, 0, 0, 1, 0, 0, 0, 1, 0})),
      "POSITION");
}

TEST(Load, reads_interleaved_attributes) {
  File f;
  Bytes bytes;
  append<float>(bytes, {0, 0, 0, 0, 0, 1, .1f, .2f, 1, 0, 0, 0, 1, 0, .3f, .4f, 0, 1, 0, 1, 0, 0, .5f, .6f});
  f.view(bytes);
  f.root["bufferViews"][0]["byteStride"] = 32;
  f.root["accessors"] = json::parse(R"([
    {"bufferView": 0, "byteOffset": 0, "componentType": 5126, "count": 3, "type": "VEC3"},
    {"bufferView": 0, "byteOffset": 12, "componentType": 5126, "count": 3, "type": "VEC3"},
    {"bufferView": 0, "byteOffset": 24, "componentType": 5126, "count": 3, "type": "VEC2"}])");
  f.root["meshes"] =
      json::parse(R"([{"primitives": [{"attributes": {"POSITION": 0, "NORMAL": 1, "TEXCOORD_0": 2}}]}])");
  f.root["nodes"] = json::parse(R"([{"mesh": 0}])");
  f.root["scenes"] = json::parse(R"([{"nodes": [0]}])");
  const scene::Mesh mesh = mesh_of(f);
  EXPECT_EQ(mesh.positions, (std::vector<Vec3>{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}));
  EXPECT_EQ(mesh.normals, (std::vector<Vec3>{{0, 0, 1}, {0, 1, 0}, {1, 0, 0}}));
  EXPECT_EQ(mesh.texcoords[0], (std::vector<Vec2>{{.1f, .2f}, {.3f, .4f}, {.5f, .6f}}));
}

TEST(Load, puts_sparse_values_in_place_packed_whatever_the_base_stride) {
  File f;
  f.data<float>("VEC3", 5126, 3, {0, 0, 0, 9, 1, 0, 0, 9, 0, 1, 0});
  f.root["bufferViews"][0]["byteStride"] = 16;
  Bytes indices, values;
  append<std::uint16_t>(indices, {1, 2});
  append<float>(values, {2, 3, 4, 5, 6, 7});
  f.view(indices), f.view(values);
  f.root["accessors"][0]["sparse"] = json::parse(
      R"({"count": 2, "indices": {"bufferView": 1, "componentType": 5123}, "values": {"bufferView": 2}})");
  f.root["meshes"] = json::parse(R"([{"primitives": [{"attributes": {"POSITION": 0}}]}])");
  f.root["nodes"] = json::parse(R"([{"mesh": 0}])");
  f.root["scenes"] = json::parse(R"([{"nodes": [0]}])");
  EXPECT_EQ(mesh_of(f).positions, (std::vector<Vec3>{{0, 0, 0}, {2, 3, 4}, {5, 6, 7}}));
  // Without a base the rest is zeros.
  File zeros = f;
  zeros.root["accessors"][0].erase("bufferView");
  EXPECT_EQ(mesh_of(zeros).positions, (std::vector<Vec3>{{0, 0, 0}, {2, 3, 4}, {5, 6, 7}}));
  // Indices out of range, out of order, too many, negative.
  for (const std::vector<std::uint16_t>& bad :
       std::vector<std::vector<std::uint16_t>>{{1, 3}, {2, 1}, {1, 1}, {65535, 0}}) {
    File g = f;
    std::memcpy(&g.binary[g.root["bufferViews"][1]["byteOffset"].get<size_t>()], bad.data(), 4);
    expect_refused(complaint(g), "accessors[0].sparse.indices");
  }
  for (const char* count : {"4", "3", "0", "-1", "2147483647", "9223372036854775807"}) {
    File g = f;
    g.root["accessors"][0]["sparse"]["count"] = json::parse(count);
    expect_refused(complaint(g), "accessors[0].sparse");
  }
}

TEST(Load, keeps_unit_normals_normalises_others_and_replaces_useless_ones) {
  const scene::Mesh mesh =
      mesh_of(with_attribute<float>("NORMAL", "VEC3", 5126, {0, 3, 4, 1, 0, 0, 0, 0, .001f}));
  EXPECT_EQ(mesh.normals, (std::vector<Vec3>{{0, .6f, .8f}, {1, 0, 0}, {0, 0, 1}}));
  // The triangle lies in z = 0, so its geometric normal is +z.
  for (const float bad : {0.0f, 1e-30f, 1e30f, not_a_number, inf}) {
    const File f = with_attribute<float>("NORMAL", "VEC3", 5126, {1, 0, 0, bad, 0, 0, 0, bad, 0});
    EXPECT_EQ(mesh_of(f).normals, (std::vector<Vec3>{{1, 0, 0}, {0, 0, 1}, {0, 0, 1}})) << bad;
    EXPECT_TRUE(warned(load_file(f), "2 normals")) << bad;
    const File all = with_attribute<float>("NORMAL", "VEC3", 5126, {bad, 0, 0, bad, 0, 0, 0, bad, 0});
    EXPECT_TRUE(mesh_of(all).normals.empty()) << bad;
  }
}

TEST(Load, keeps_good_tangents_and_drops_all_if_one_is_bad) {
  const auto with = [](std::initializer_list<float> tangents) {
    File f = with_attribute<float>("NORMAL", "VEC3", 5126, {0, 0, 1, 0, 0, 1, 0, 0, 1});
    f.root["meshes"][0]["primitives"][0]["attributes"]["TANGENT"] = f.data("VEC4", 5126, 3, tangents);
    return mesh_of(f).tangents;
  };
  EXPECT_EQ(with({1, 0, 0, 1, 0, 2, 0, -1, 1, 0, 0, 0}),
            (std::vector<Vec4>{{1, 0, 0, 1}, {0, 1, 0, -1}, {1, 0, 0, 1}}));
  EXPECT_TRUE(with({1, 0, 0, 1, 0, 0, 0, -1, 1, 0, 0, 1}).empty());  // zero
  EXPECT_TRUE(with({1, 0, 0, 1, 0, 0, 1, -1, 1, 0, 0, 1}).empty());  // along the normal
  EXPECT_TRUE(with({1, 0, 0, 1, not_a_number, 0, 1, -1, 1, 0, 0, 1}).empty());
  EXPECT_TRUE(mesh_of(with_attribute<float>("TANGENT", "VEC4", 5126, {1, 0, 0, 1, 1, 0, 0, 1, 1, 0, 0, 1}))
                  .tangents.empty());
}

TEST(Load, leaves_out_triangles_with_useless_positions_and_keeps_the_others) {
  for (const float bad : {not_a_number, inf, -inf, 3e38f, 1e30f}) {
    File f;
    f.data<float>("VEC3", 5126, 4, {0, 0, 0, 1, 0, 0, 0, 1, 0, bad, 0, 0});
    f.data<std::uint8_t>("SCALAR", 5121, 6, {0, 1, 3, 0, 1, 2});
    f.root["meshes"] = json::parse(R"([{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}])");
    f.root["nodes"] = json::parse(R"([{"mesh": 0}])");
    f.root["scenes"] = json::parse(R"([{"nodes": [0]}])");
    const scene::Scene scene = load_file(f);
    EXPECT_EQ(scene.meshes.at(0).triangles, std::vector<UVec3>{UVec3(0, 1, 2)});
    EXPECT_EQ(scene.meshes[0].positions[3], Vec3(0, 0, 0));  // inside the bounds of the rest
    EXPECT_TRUE(warned(scene, "1 triangles with positions")) << bad;
  }
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
  const scene::Scene flat = load_file(node("\"scale\": [1, 0, 1]"));
  EXPECT_TRUE(flat.instances.empty());
  EXPECT_TRUE(warned(flat, "scaled to nothing"));
  EXPECT_EQ(load_file(node("\"scale\": [1e-6, 1e-6, 1e-6]")).instances.size(), 1u);
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

TEST(Load, decodes_each_used_image_once_with_its_sampler) {
  File f = triangle();
  f.root["images"] = json::parse(
      R"([{"uri": "data:image/png;base64,AAAA"}, {"name": "checker", "uri": "data:image/png;base64,)" + png +
      "\"}]");
  f.root["samplers"] = json::parse(R"([{"wrapS": 33071, "wrapT": 33648, "magFilter": 9728}])");
  f.root["textures"] = json::parse(R"([{"source": 1, "sampler": 0}, {"source": 1}, {"source": 0}])");
  f.root["materials"] = json::parse(R"([{"emissiveTexture": {"index": 1, "texCoord": 1},
    "pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}])");
  f.root["meshes"][0]["primitives"][0]["material"] = 0;
  const scene::Scene scene = load_file(f);
  ASSERT_EQ(scene.bitmaps.size(), 1u);
  EXPECT_EQ(scene.bitmaps[0].name, "checker");
  EXPECT_EQ(scene.bitmaps[0].width, 2);
  // Unassociated alpha, and no sRGB decoding: 51/255 stays .2 where alpha is 0.
  EXPECT_EQ(scene.bitmaps[0].texels,
            (std::vector<Vec4>{{1, 0, 0, 1}, {0, 1, 0, 128 / 255.0f}, {.2f, .4f, .6f, 0}, {1, 1, 1, 1}}));
  const scene::Texture &base = scene.materials[0].base_color_texture,
                       &emissive = scene.materials[0].emissive_texture;
  EXPECT_EQ(base.bitmap, 0);
  EXPECT_EQ(base.wrap_u, scene::Wrap::clamp);
  EXPECT_EQ(base.wrap_v, scene::Wrap::mirror);
  EXPECT_EQ(base.filter, scene::Filter::nearest);
  EXPECT_EQ(emissive.bitmap, 0);
  EXPECT_EQ(emissive.texcoord_set, 1);
  EXPECT_EQ(emissive.wrap_u, scene::Wrap::repeat);
  EXPECT_EQ(emissive.filter, scene::Filter::linear);
  EXPECT_TRUE(warned(scene, "lacks TEXCOORD_1"));

  f.root["materials"][0]["emissiveTexture"]["index"] = 2;
  expect_refused(complaint(f), "images[0]");
  Options options;
  options.limits.image_pixels = 3;
  f.root["materials"][0].erase("emissiveTexture");
  expect_refused(complaint(f, options), "images[1]");
}

TEST(Load, refuses_other_image_formats_by_their_first_bytes_and_warns_of_wrong_labels) {
  const auto with = [](const std::string& mime, const Bytes& bytes) {
    File f = triangle();
    f.view(bytes);
    f.root["images"] = json::parse("[{\"bufferView\": 2, \"mimeType\": \"" + mime + "\"}]");
    f.root["textures"] = json::parse(R"([{"source": 0}])");
    f.root["materials"] = json::parse(R"([{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}])");
    return f;
  };
  for (const std::string magic : {"GIF89a", "BM......", "8BPS\0\1..", "#?RADIANCE\n", "<svg>", "v/1\1....",
                                  "RIFF....WEBP", "P6 1 1 255 "})
    expect_refused(complaint(with("image/png", Bytes(magic.begin(), magic.end()))), "images[0]");
  File f = triangle();
  f.root["images"] =
      json::parse(R"([{"mimeType": "image/jpeg", "uri": "data:image/png;base64,)" + png + "\"}]");
  f.root["textures"] = json::parse(R"([{"source": 0}])");
  f.root["materials"] = json::parse(R"([{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}])");
  EXPECT_TRUE(warned(load_file(f), "says image/jpeg and is a PNG"));
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

TEST(Load, hashes_the_scene_file_and_what_it_names_in_order) {
  // A self-contained file hashes as sha256sum prints it: `printf '{"asset":{"version":"2.0"}}' | sha256sum`.
  EXPECT_EQ(load_bytes(R"({"asset":{"version":"2.0"}})").hash,
            "f74cabc3532658af0aa3e7abdd6939d22aa5cd78849dc06e3817248fe1c3788d");
  // And with external files: cat scene.gltf b.bin a.png | sha256sum.
  const Folder folder;
  folder.write("b.bin", "0123456789abcdef");
  folder.write("a.png", "not decoded");
  const std::string text =
      R"({"asset":{"version":"2.0"},"buffers":[{"byteLength":4,"uri":"b.bin"}],"images":[{"uri":"a.png"}]})";
  EXPECT_EQ(load(folder.write("scene.gltf", text)).hash,
            "ce8003dcf71154022d5009294087e3a869652c8e01a0185001c45678549b162f");
}
