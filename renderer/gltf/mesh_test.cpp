// Primitives: accessors of every kind to the exact triangles they become, and what useless data become.
// Expected numbers are written by hand from the glTF 2.0 specification.
#include <cmath>
#include <limits>

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

}  // namespace

TEST(Mesh, reads_indices_of_every_width_and_none) {
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

TEST(Mesh, refuses_indices_past_the_last_vertex_and_other_types) {
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

TEST(Mesh, makes_triangles_of_lists_strips_and_fans_dropping_degenerate_indices) {
  using Triangles = std::vector<UVec3>;
  EXPECT_EQ(triangles_of(4, {0, 1, 2, 2, 1, 3}), (Triangles{{0, 1, 2}, {2, 1, 3}}));
  EXPECT_EQ(triangles_of(4, {0, 1, 2, 3, 4}), (Triangles{{0, 1, 2}}));
  EXPECT_EQ(triangles_of(4, {0, 0, 1, 0, 1, 2, 3, 4, 3}), (Triangles{{0, 1, 2}}));
  EXPECT_EQ(triangles_of(5, {0, 1, 2, 3, 4}), (Triangles{{0, 1, 2}, {1, 3, 2}, {2, 3, 4}}));
  EXPECT_EQ(triangles_of(5, {0, 1, 2, 2, 3, 4}), (Triangles{{0, 1, 2}, {2, 4, 3}}));
  EXPECT_EQ(triangles_of(6, {0, 1, 2, 3}), (Triangles{{1, 2, 0}, {2, 3, 0}}));
  for (const int mode : {4, 5, 6}) {
    EXPECT_EQ(triangles_of(mode, {0}), Triangles());
    EXPECT_EQ(triangles_of(mode, {0, 1}), Triangles());
  }
  for (const int mode : {0, 1, 2, 3}) EXPECT_EQ(triangles_of(mode, {0, 1, 2}), Triangles());
}

TEST(Mesh, reads_texture_coordinates_as_floats_and_normalized_integers) {
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

TEST(Mesh, reads_colours_of_three_and_four_channels) {
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

TEST(Mesh, refuses_attributes_of_another_length_or_type) {
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

TEST(Mesh, reads_interleaved_attributes) {
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

TEST(Mesh, puts_sparse_values_in_place_packed_whatever_the_base_stride) {
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
  File wide = f;
  Bytes last;
  append<std::uint32_t>(last, {0, 0xffffffff});
  wide.root["accessors"][0]["sparse"]["indices"] = {{"bufferView", wide.view(last)}, {"componentType", 5125}};
  expect_refused(complaint(wide),
                 "accessors[0].sparse.indices: wanted increasing indices below 3, found 4294967295");
  for (const char* count : {"4", "3", "0", "-1", "2147483647", "9223372036854775807"}) {
    File g = f;
    g.root["accessors"][0]["sparse"]["count"] = json::parse(count);
    expect_refused(complaint(g), "accessors[0].sparse");
  }
}

TEST(Mesh, keeps_unit_normals_normalises_others_and_replaces_useless_ones) {
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

TEST(Mesh, keeps_good_tangents_and_drops_all_if_one_is_bad) {
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

TEST(Mesh, leaves_out_triangles_with_useless_positions_and_keeps_the_others) {
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
