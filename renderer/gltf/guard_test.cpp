// Hostile files: each is refused with one line that names the place, and nothing outside the scene's folder
// is read.
#include "gltf/guard.h"

#include <ctime>

#include "gltf/sample_test.h"

using namespace gltf;
using namespace gltf::sample;

namespace {

// The message after changing one place of the good triangle file to `value` (given as JSON text).
std::string after(const std::string& pointer, const std::string& value, const Options& options = {}) {
  File f = triangle();
  f.root[json::json_pointer(pointer)] = json::parse(value);
  return complaint(f, options);
}

std::string nested(const std::string& key, int depth) {
  std::string text = triangle().root.dump();
  text.back() = ',';
  text += '"' + key + "\":";
  for (int i = 0; i < depth; ++i) text += i % 2 ? "[" : "{\"a\":";
  text += "1";
  for (int i = depth - 1; i >= 0; --i) text += i % 2 ? ']' : '}';
  return text + '}';
}

}  // namespace

TEST(Guard, loads_the_file_that_the_hostile_ones_are_made_from) {
  EXPECT_EQ(complaint(triangle()), "");
  EXPECT_EQ(load_file(triangle()).meshes.at(0).triangles.size(), 1u);
}

TEST(Guard, refuses_every_truncation_of_a_good_glb) {
  const std::string good = triangle().to_glb();
  ASSERT_GT(good.size(), 200u);
  for (size_t length = 0; length < good.size(); ++length)
    EXPECT_NE(complaint(std::string_view(good).substr(0, length)), "") << length << " bytes";
  EXPECT_NE(complaint(good + "x"), "");
}

TEST(Guard, refuses_a_glb_whose_header_or_chunks_lie) {
  const std::string good = triangle().to_glb();
  const auto with = [&](size_t at, std::uint64_t value) {
    std::string bad = good, raw;
    put32(raw, value);
    return complaint(bad.replace(at, 4, raw));
  };
  const std::uint64_t json_length = (triangle().root.dump().size() + 3) / 4 * 4, second = 20 + json_length;
  expect_refused(with(0, 0x21212121), "JSON");
  expect_refused(with(4, 1), "GLB header: wanted version 2, found 1");
  expect_refused(with(8, 12), "GLB header");
  expect_refused(with(8, good.size() + 4), "GLB header");
  expect_refused(with(12, 0xfffffffc), "GLB chunk 0");
  expect_refused(with(12, json_length - 1), "GLB chunk 0");
  expect_refused(with(12, 0), "GLB chunk 1");
  expect_refused(with(16, 0x004E4942), "GLB chunk 0");
  expect_refused(with(second, 0xfffffffc), "GLB chunk 1");
  expect_refused(with(second, 3), "GLB chunk 1");
  expect_refused(with(second + 4, 0x4E4F534A), "GLB chunk 1");
  expect_refused(with(second + 4, 0x12345678), "buffers[0]: wanted a uri or a BIN chunk");
  std::string twice = good + good.substr(second), length;
  put32(length, twice.size());
  expect_refused(complaint(twice.replace(8, 4, length)), "GLB chunk 2");
  // Unknown chunks after the known ones are to be skipped.
  std::string more = good + std::string("\4\0\0\0WHATabcd", 12);
  length.clear();
  put32(length, more.size());
  EXPECT_EQ(complaint(more.replace(8, 4, length)), "");
}

TEST(Guard, refuses_deep_json_before_any_parser_recurses) {
  for (const char* key : {"extras", "extensions", "unknown"})
    for (const int depth : {64, 500, 5000, 100'000, 1'000'000})
      expect_refused(complaint(nested(key, depth)), "nested levels");
  EXPECT_EQ(complaint("{\"asset\":{\"version\":\"2.0\"},\"a\":\"" + std::string(1000, '[') + "\\\"[\"}"), "");
}

TEST(Guard, settles_what_encodings_mean) {
  const std::string empty = R"({"asset":{"version":"2.0"}})";
  EXPECT_EQ(complaint(empty), "");
  EXPECT_EQ(complaint("\xEF\xBB\xBF" + empty), "");                            // a BOM is skipped
  EXPECT_EQ(complaint(R"({"asset":{"version":"1.0","version":"2.0"}})"), "");  // the last key wins
  expect_refused(complaint(R"({"asset":{"version":"2.0","version":"1.0"}})"), "asset.version");
  expect_refused(complaint("{\"asset\":{\"version\":\"2.0\",\"copyright\":\"\xff\"}}"), "JSON");  // not UTF-8
  expect_refused(complaint(R"({"asset":{"version":"2.0"},"x":NaN})"), "JSON");
  expect_refused(complaint(R"({"asset":{"version":"2.0"},"x":1e999})"), "JSON");
  expect_refused(complaint(""), "JSON");
  expect_refused(complaint("[]"), "JSON: wanted an object");
}

TEST(Guard, refuses_other_versions_and_names_unknown_required_extensions) {
  expect_refused(after("/asset/version", "\"1.0\""), "asset.version: wanted 2.0, found 1.0");
  expect_refused(after("/asset/minVersion", "\"2.1\""), "asset.minVersion");
  for (const std::string name :
       {"XX_unknown", "KHR_draco_mesh_compression", "KHR_texture_basisu", "KHR_mesh_quantization"}) {
    const std::string message = after("/extensionsRequired", "[\"" + name + "\"]");
    expect_refused(message, "found " + name);
    expect_refused(message, "KHR_materials_sheen");  // the list of what is supported
    File f = triangle();
    f.root["extensionsUsed"].push_back(name);
    EXPECT_TRUE(warned(load_file(f), name));
  }
  for (const std::string& name : supported_extensions())
    EXPECT_EQ(after("/extensionsRequired", "[\"" + name + "\"]"), "");
}

TEST(Guard, refuses_accessors_outside_their_bufferView) {
  for (const char* count :
       {"4", "1000000", "9223372036854775808", "6148914691236517206"})  // the last: 12 c = 2^64 + 8
    expect_refused(after("/accessors/0/count", count), "accessors[0]");
  for (const char* offset : {"1", "36", "37", "18446744073709551600", "-4"})
    expect_refused(after("/accessors/0/byteOffset", offset), "accessors[0]");
  expect_refused(after("/accessors/0/type", "\"VEC4\""), "accessors[0]");
  expect_refused(after("/accessors/0/componentType", "5127"), "accessors[0].componentType");
  expect_refused(after("/accessors/0/componentType", "5130"), "accessors[0].componentType");
  for (const char* stride : {"4", "8"})
    expect_refused(after("/bufferViews/0/byteStride", stride), "accessors[0]: wanted a byteStride");
  expect_refused(after("/bufferViews/0/byteStride", "16"), "accessors[0]");
  expect_refused(after("/bufferViews/0/byteStride", "-4"), "bufferViews[0].byteStride");
  expect_refused(after("/bufferViews/0/byteLength", "35"), "accessors[0]");
  expect_refused(after("/bufferViews/1/byteLength", "1000"), "bufferViews[1]");
  for (const char* offset : {"18446744073709551610", "18446744073709551614"})  // + 6 = 2^64, 2^64 + 4
    expect_refused(after("/bufferViews/1/byteOffset", offset), "bufferViews[1]");
  expect_refused(after("/bufferViews/1/byteOffset", "9007199254740000"), "bufferViews[1]");
  expect_refused(after("/buffers/0/byteLength", "0"), "buffers[0].byteLength");
  expect_refused(after("/buffers/0/byteLength", "1000000000"), "buffers[0].byteLength");
  expect_refused(after("/buffers/0/byteLength", "4294967340"), "buffers[0].byteLength");
}

TEST(Guard, refuses_sparse_ranges_outside_their_bufferView) {
  File f = triangle();
  f.root["accessors"][0]["sparse"] =
      json::parse(R"({"count": 1, "indices": {"bufferView": 1, "componentType": 5123},
    "values": {"bufferView": 0}})");
  EXPECT_EQ(complaint(f), "");
  for (const char* part : {"indices", "values"})
    for (const char* offset :
         {"36", "9007199254740992", "18446744073709551614", "18446744073709551604", "-4"}) {
      File bad = f;
      bad.root["accessors"][0]["sparse"][part]["byteOffset"] = json::parse(offset);
      expect_refused(complaint(bad), std::string("accessors[0].sparse.") + part);
    }
}

TEST(Guard, lets_the_last_element_end_short_of_a_whole_stride) {
  File f;
  f.data<float>("VEC3", 5126, 3, {0, 0, 0, 9, 1, 0, 0, 9, 0, 1, 0});  // 16 bytes apart, 44 bytes in all
  f.root["bufferViews"][0]["byteStride"] = 16;
  f.root["meshes"] = json::parse(R"([{"primitives": [{"attributes": {"POSITION": 0}}]}])");
  f.root["nodes"] = json::parse(R"([{"mesh": 0}])");
  f.root["scenes"] = json::parse(R"([{"nodes": [0]}])");
  EXPECT_EQ(load_file(f).meshes.at(0).positions.at(2), math::Vec3(0, 1, 0));
  f.root["bufferViews"][0]["byteLength"] = 43;
  expect_refused(complaint(f), "accessors[0]");
}

TEST(Guard, treats_a_count_of_zero_as_nothing_to_read) {
  File f = triangle();
  f.root["accessors"][1]["count"] = 0;
  const scene::Scene scene = load_file(f);
  EXPECT_TRUE(scene.instances.empty());
  EXPECT_TRUE(warned(scene, "no triangles"));
}

TEST(Guard, refuses_images_outside_their_buffer_before_they_are_decoded) {
  File f = triangle();
  f.view({0x89, 'P', 'N', 'G', '\r', '\n', 0x1a, '\n', 0, 0, 0, 13, 'I', 'H', 'D', 'R'});
  f.root["images"] = json::parse(R"([{"bufferView": 2, "mimeType": "image/png"}])");
  f.root["textures"] = json::parse(R"([{"source": 0}])");
  const auto with = [&](const char* key, std::uint64_t value) {
    File bad = f;
    bad.root["bufferViews"][2][key] = value;
    return complaint(bad);
  };
  EXPECT_EQ(complaint(f), "");  // the image is not used by a material, so nobody decodes it
  expect_refused(with("byteLength", 70000), "bufferViews[2]");
  expect_refused(with("byteOffset", 1ull << 33), "bufferViews[2]");
  expect_refused(with("byteOffset", f.binary.size()), "bufferViews[2]");
  expect_refused(with("byteLength", 0), "bufferViews[2]");
}

TEST(Guard, refuses_every_dangling_reference_and_names_it) {
  File f = triangle();
  f.view({1, 2, 3, 4});
  f.root["scene"] = 0;
  f.root["cameras"] = json::parse(R"([{"type": "perspective", "perspective": {"yfov": 1, "znear": 0.1}}])");
  f.root["images"] = json::parse(R"([{"bufferView": 2, "mimeType": "image/png"}])");
  f.root["samplers"] = json::parse("[{}]");
  f.root["textures"] = json::parse(R"([{"source": 0, "sampler": 0}])");
  f.root["materials"] = json::parse(R"([{"normalTexture": {"index": 0}, "emissiveTexture": {"index": 0},
    "occlusionTexture": {"index": 0},
    "pbrMetallicRoughness": {"baseColorTexture": {"index": 0}, "metallicRoughnessTexture": {"index": 0}}}])");
  f.root["extensions"] = json::parse(R"({"KHR_lights_punctual": {"lights": [{"type": "point"}]}})");
  f.root["nodes"] = json::parse(R"([{"mesh": 0, "children": [1]}, {"camera": 0,
    "extensions": {"KHR_lights_punctual": {"light": 0}}}])");
  f.root["meshes"][0]["primitives"][0]["material"] = 0;
  f.root["meshes"][0]["primitives"][0]["targets"] = json::parse(R"([{"POSITION": 0}])");
  f.root["accessors"][0]["sparse"] =
      json::parse(R"({"count": 1, "indices": {"bufferView": 1, "componentType": 5123},
    "values": {"bufferView": 0}})");
  const char* places[] = {"/scene",
                          "/scenes/0/nodes/0",
                          "/nodes/0/children/0",
                          "/nodes/0/mesh",
                          "/nodes/1/camera",

                          "/nodes/1/extensions/KHR_lights_punctual/light",

                          "/meshes/0/primitives/0/attributes/POSITION",
                          "/meshes/0/primitives/0/indices",
                          "/meshes/0/primitives/0/material",
                          "/meshes/0/primitives/0/targets/0/POSITION",
                          "/materials/0/normalTexture/index",
                          "/materials/0/emissiveTexture/index",
                          "/materials/0/occlusionTexture/index",
                          "/materials/0/pbrMetallicRoughness/baseColorTexture/index",
                          "/materials/0/pbrMetallicRoughness/metallicRoughnessTexture/index",
                          "/textures/0/source",
                          "/textures/0/sampler",
                          "/images/0/bufferView",
                          "/accessors/0/bufferView",
                          "/accessors/1/bufferView",
                          "/accessors/0/sparse/indices/bufferView",
                          "/accessors/0/sparse/values/bufferView",
                          "/bufferViews/0/buffer"};
  for (const std::string place : places) {
    // "/a/0/b" as messages spell it: "a[0].b".
    std::string dotted;
    std::istringstream steps(place.substr(1));
    for (std::string step; std::getline(steps, step, '/');)
      dotted += std::isdigit(step[0]) ? '[' + step + ']' : (dotted.empty() ? "" : ".") + step;
    const auto with = [&](const std::string& value) {
      File bad = f;
      EXPECT_TRUE(bad.root.contains(json::json_pointer(place))) << place;
      bad.root[json::json_pointer(place)] = json::parse(value);
      return complaint(bad);
    };
    for (const char* value : {"-1", "99", "2147483647", "9223372036854775808", "1.5", "\"0\"", "null"})
      expect_refused(with(value), "scene.glb: " + dotted);
    // The first index past the end, whatever the array's length.
    const std::string message = with("99"), below = "an index below ";
    ASSERT_NE(message.find(below), std::string::npos) << message;
    expect_refused(with(std::to_string(std::stoi(message.substr(message.find(below) + below.size())))),
                   dotted);
  }
}

TEST(Guard, refuses_codes_that_glTF_does_not_have) {
  for (const char* key : {"wrapS", "wrapT", "magFilter", "minFilter"})
    for (const char* code : {"0", "-1", "\"10497\"", "10497.0", "[]"})
      expect_refused(after("/samplers", "[{\"" + std::string(key) + "\": " + code + "}]"),
                     "samplers[0]." + std::string(key));
  expect_refused(after("/meshes/0/primitives/0/mode", "7"), "meshes[0].primitives[0].mode");
  expect_refused(after("/accessors/0/type", "\"VEC5\""), "accessors[0].type");
  expect_refused(after("/accessors/0/type", "\"VEC3 VEC4\""), "accessors[0].type");
}

TEST(Guard, refuses_cycles_shared_nodes_and_deep_chains) {
  const auto nodes = [](const std::string& text) { return after("/nodes", text); };
  expect_refused(nodes(R"([{"children": [0]}])"), "nodes");
  expect_refused(nodes(R"([{"mesh": 0}, {"children": [2]}, {"children": [1]}])"),
                 "nodes: wanted trees, found a cycle");
  expect_refused(nodes(R"([{"children": [1, 2]}, {"children": [3]}, {"children": [3]}, {"mesh": 0}])"),
                 "nodes[3]");
  expect_refused(nodes(R"([{"children": [1, 1]}, {"mesh": 0}])"), "nodes[1]");
  expect_refused(nodes(R"([{"mesh": 0}, {"children": [0]}])"), "scenes[0].nodes");
  expect_refused(after("/scenes/0/nodes", "[0, 0]"), "scenes[0].nodes");
  json chain = json::array();
  for (int i = 1; i < 200'000; ++i) {
    json node;
    node["children"].push_back(i);
    chain.push_back(node);
  }
  chain.push_back(json::object());
  const std::clock_t before = std::clock();
  expect_refused(nodes(chain.dump()), "levels of nodes");
  EXPECT_LT(std::clock() - before, 10 * CLOCKS_PER_SEC);
}

TEST(Guard, takes_as_many_levels_of_nodes_as_it_says_and_no_more) {
  Options options;
  for (const int levels : {options.limits.node_depth, options.limits.node_depth + 1}) {
    json chain = json::array({json::object()});
    chain[0]["mesh"] = 0;
    for (int i = 1; i < levels; ++i) {  // children first
      chain.push_back(json::object());
      chain.back()["children"].push_back(i - 1);
      chain.back()["translation"] = {1, 0, 0};
    }
    File f = triangle();
    f.root["nodes"] = chain;
    f.root["scenes"][0]["nodes"][0] = levels - 1;
    if (levels > options.limits.node_depth)
      expect_refused(complaint(f), "at most 1024 levels of nodes");
    else
      EXPECT_EQ(load_file(f).instances.at(0).to_world[3].x, static_cast<float>(levels - 1));
  }
}

// The least memory with which a mesh of 64 triangles can be placed so many times.
std::uint64_t memory_for(int instances) {
  File f = triangle();
  Bytes indices;
  for (int i = 0; i < 64; ++i) append<std::uint16_t>(indices, {0, 1, 2});
  json& accessor = f.root["accessors"][1];
  accessor["bufferView"] = f.view(indices), accessor["count"] = 3 * 64;
  for (int i = 1; i < instances; ++i) {
    f.root["nodes"].push_back(f.root["nodes"][0]);
    f.root["scenes"][0]["nodes"].push_back(i);
  }
  std::uint64_t low = 0, high = 1'000'000'000;
  while (high - low > 1) {
    Options options;
    options.limits.memory = (low + high) / 2;
    (complaint(f, options).empty() ? high : low) = options.limits.memory;
  }
  return high;
}

// Up to 4,096 triangles are copied for each instance, 120 bytes each; more are built once and shared.
TEST(Guard, counts_the_copies_of_small_meshes) {
  const auto more = [](int instances) {
    return static_cast<double>(memory_for(instances)) - static_cast<double>(memory_for(instances - 1));
  };
  EXPECT_NEAR(more(64) - more(63), 0, 100);
  EXPECT_NEAR(more(64) - more(65), 64 * 64 * 120, 100);
}

TEST(Guard, keeps_to_its_limits) {
  Options options;
  const auto refused = [&](const std::string& place) {
    expect_refused(complaint(triangle(), options), place), options = {};
  };
  options.limits.memory = 100, refused("no more memory than 100 bytes");
  options.limits.nodes = 0, refused("nodes");
  options.limits.accessors = 1, refused("accessors");
  EXPECT_EQ(complaint(triangle(), options), "");
  // A million zeros cost nothing to ask for.
  File f = triangle();
  f.root["accessors"][0].erase("bufferView");
  f.root["accessors"][0]["count"] = 4'000'000'000'000;
  expect_refused(complaint(f), "accessors[0]: wanted no more memory");
}

TEST(Guard, caps_what_small_files_ask_for) {
  // A hundred thousand instances of a mesh of as many triangles, in a file of a few megabytes.
  File f = triangle();
  f.root["accessors"][0].erase("bufferView");
  f.root["accessors"][0]["count"] = 300'000;
  f.root["meshes"][0]["primitives"][0].erase("indices");
  f.root["nodes"] = json::array();
  f.root["scenes"][0]["nodes"] = json::array();
  for (int i = 0; i < 100'000; ++i) {
    f.root["nodes"].push_back({{"mesh", 0}});
    f.root["scenes"][0]["nodes"].push_back(i);
  }
  EXPECT_EQ(load_file(f).instances.size(), 100'000u);
  // Each lamp is one more to choose from.
  f.root["materials"] = json::parse(R"([{"emissiveFactor": [1, 1, 1]}])");
  f.root["meshes"][0]["primitives"][0]["material"] = 0;
  expect_refused(complaint(f), "wanted no more memory");
  // As many accessors over one bufferView cost no more than their text.
  f = triangle();
  for (int i = 0; i < 100'000; ++i) f.root["accessors"].push_back(f.root["accessors"][0]);
  EXPECT_EQ(complaint(f), "");
  // More than the guard fills defaults into.
  f.root["materials"] = json::array();
  for (int i = 0; i < 20'000; ++i) f.root["materials"].push_back(json::object());
  expect_refused(complaint(f), "materials: wanted at most 16384");
}
