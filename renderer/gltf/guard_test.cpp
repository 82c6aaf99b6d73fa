// Hostile files: each is refused with one line that names the place, and nothing outside the scene's folder
// is read.
#include "gltf/guard.h"

#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

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
  expect_refused(after("/bufferViews/0/byteStride", "8"), "accessors[0]");
  expect_refused(after("/bufferViews/0/byteStride", "16"), "accessors[0]");
  expect_refused(after("/bufferViews/0/byteStride", "-4"), "bufferViews[0].byteStride");
  expect_refused(after("/bufferViews/0/byteLength", "35"), "accessors[0]");
  expect_refused(after("/bufferViews/1/byteLength", "1000"), "bufferViews[1]");
  expect_refused(after("/bufferViews/1/byteOffset", "18446744073709551610"), "bufferViews[1]");
  expect_refused(after("/bufferViews/1/byteOffset", "9007199254740000"), "bufferViews[1]");
  expect_refused(after("/buffers/0/byteLength", "0"), "buffers[0].byteLength");
  expect_refused(after("/buffers/0/byteLength", "1000000000"), "buffers[0].byteLength");
  expect_refused(after("/buffers/0/byteLength", "4294967340"), "buffers[0].byteLength");
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
  expect_refused(nodes(chain.dump()), "levels of nodes");
}

TEST(Guard, reads_only_regular_files_inside_the_folder_of_the_scene) {
  const Folder outer;
  std::filesystem::create_directories(outer / "in/sub");
  std::filesystem::create_directories(outer / "in/directory");
  File f = triangle();
  const std::string binary(f.binary.begin(), f.binary.end());
  for (const char* name : {"secret.bin", "in/A..B.bin", "in/sub/x.bin", "in/ x.bin", "in/plus+x.bin"})
    outer.write(name, binary);
  std::filesystem::create_symlink(outer / "secret.bin", outer / "in/link.bin");
  std::filesystem::create_symlink(outer / "in/sub/x.bin", outer / "in/inner_link.bin");
  std::filesystem::create_directory_symlink(outer / ".", outer / "in/up");
  ASSERT_EQ(::mkfifo((outer / "in/fifo.bin").c_str(), 0600), 0);
  const auto with = [&](const std::string& uri) -> std::string {
    f.root["buffers"][0]["uri"] = uri;
    const std::string file = outer.write("in/scene.gltf", f.root.dump());
    try {
      load(file);
    } catch (const base::Error& error) {
      return error.what();
    }
    return "";
  };
  for (const std::string good : {"A..B.bin", "sub/x.bin", "%20x.bin", " x.bin", "%41..B.bin", "./sub/x.bin",
                                 "plus+x.bin", "inner_link.bin"})
    EXPECT_EQ(with(good), "") << good;
  // A file that is only in the current directory is not the scene's.
  const std::filesystem::path before = std::filesystem::current_path();
  std::filesystem::current_path(outer / ".");
  const std::string from_here = with("secret.bin");
  std::filesystem::current_path(before);
  expect_refused(from_here, "buffers[0].uri");
  for (const std::string bad : {"../secret.bin",
                                "sub/../sub/x.bin",
                                "sub/../../secret.bin",
                                "%2e%2e/secret.bin",
                                "..%2fsecret.bin",
                                "..%2Fsecret.bin",
                                "link.bin",
                                "up/secret.bin",
                                "fifo.bin",
                                "directory",
                                ".",
                                "",
                                "/etc/hostname",
                                "file:///etc/hostname",
                                "http://localhost/x",
                                "C:\\x",
                                "C:/x",
                                "\\\\host\\x",
                                "//host/x",
                                "missing.bin",
                                "%zz",
                                "%2",
                                "x%00.bin",
                                "sub\\x.bin"})
    expect_refused(with(bad), "buffers[0].uri");
  f.root["buffers"][0]["uri"] = std::string("sub/x.bin\0", 10);
  expect_refused(with(std::string("sub/x.bin\0.png", 14)), "buffers[0].uri");
}

TEST(Guard, reads_data_uris_strictly) {
  File f = triangle();
  const auto with = [&](const std::string& uri) {
    f.root["buffers"][0]["uri"] = uri;
    return complaint(f.root.dump());
  };
  const std::string good = base64(f.binary);
  EXPECT_EQ(with("data:application/octet-stream;base64," + good), "");
  EXPECT_EQ(with("data:;base64," + good + base64({0, 0, 0})), "");  // longer than byteLength is fine
  for (const std::string& bad :
       {"data:application/octet-stream;base64" + good, "data:text/plain," + good,
        "data:;base64," + good.substr(0, good.size() / 2), "data:;base64,!" + good.substr(1),
        std::string("data:"), std::string("data:;base64,")})
    expect_refused(with(bad), "buffers[0]");
}

TEST(Guard, keeps_to_its_limits) {
  Options options;
  const auto refused = [&](const std::string& place) {
    expect_refused(complaint(triangle(), options), place), options = {};
  };
  options.limits.file_bytes = 100, refused("100 bytes");
  options.limits.json_values = 10, refused("10 values");
  options.limits.nodes = 0, refused("nodes");
  options.limits.accessors = 1, refused("accessors");
  options.limits.vertices = 2, refused("vertices");
  options.limits.triangles = 0, refused("triangles");
  options.limits.instances = 0, refused("instances");
  EXPECT_EQ(complaint(triangle(), options), "");
  // A million zeros cost nothing to ask for.
  File f = triangle();
  f.root["accessors"][0].erase("bufferView");
  f.root["accessors"][0]["count"] = 4'000'000'000'000;
  expect_refused(complaint(f), "at most");
}

// Replace each value of a file that uses everything by each of these: no crash, no exception but base::Error,
// one line, and whatever loads is consistent.
TEST(Guard, survives_every_single_mutation_of_a_file_that_uses_everything) {
  File f = triangle();
  f.data<float>("VEC3", 5126, 3, {0, 0, 1, 0, 0, 1, 0, 0, 1});
  f.data<std::uint8_t>("VEC2", 5121, 3, {0, 0, 255, 0, 0, 255}, true);
  f.root["accessors"][0]["sparse"] = json::parse(
      R"({"count": 1, "indices": {"bufferView": 1, "componentType": 5123, "byteOffset": 2}, "values": {"bufferView": 0, "byteOffset": 12}})");
  f.root["bufferViews"][0]["byteStride"] = 12;
  json& primitive = f.root["meshes"][0]["primitives"][0];
  primitive["attributes"]["NORMAL"] = 2;
  primitive["attributes"]["TEXCOORD_0"] = 3;
  primitive["material"] = 0;
  primitive["mode"] = 4;
  primitive["targets"] = json::parse(R"([{"POSITION": 0}])");
  f.root["asset"]["generator"] = "hand";
  f.root["extensionsUsed"] = json::parse(R"(["KHR_lights_punctual"])");
  f.root["extensionsRequired"] = f.root["extensionsUsed"];
  f.root["cameras"] =
      json::parse(R"([{"type": "perspective", "perspective": {"yfov": 1, "znear": 0.1, "aspectRatio": 1}},
    {"type": "orthographic", "orthographic": {"xmag": 1, "ymag": 1, "znear": 0, "zfar": 9}}])");
  f.root["extensions"] =
      json::parse(R"({"KHR_lights_punctual": {"lights": [{"type": "spot", "color": [1, 1, 1], "intensity": 5,
    "range": 9, "spot": {"innerConeAngle": 0.1, "outerConeAngle": 0.5}}]}})");
  f.root["samplers"] =
      json::parse(R"([{"wrapS": 10497, "wrapT": 33071, "magFilter": 9728, "minFilter": 9729}])");
  f.root["textures"] = json::parse(R"([{"sampler": 0}])");
  f.root["materials"] =
      json::parse(R"([{"name": "m", "doubleSided": true, "alphaMode": "MASK", "alphaCutoff": 0.4,
    "emissiveFactor": [1, 1, 1], "normalTexture": {"index": 0, "scale": 1},
    "pbrMetallicRoughness": {"baseColorFactor": [1, 0.5, 0.25, 1], "metallicFactor": 0, "roughnessFactor": 0.5,
      "baseColorTexture": {"index": 0, "texCoord": 0,
        "extensions": {"KHR_texture_transform": {"offset": [0, 1], "rotation": 1, "scale": [2, 2], "texCoord": 0}}}},
    "extras": {"disney_sheen": 0.5, "disney_clearcoat_gloss": 1},
    "extensions": {"KHR_materials_ior": {"ior": 1.4}, "KHR_materials_specular": {"specularFactor": 1, "specularColorFactor": [1, 1, 1]},
      "KHR_materials_clearcoat": {"clearcoatFactor": 1, "clearcoatRoughnessFactor": 0.1},
      "KHR_materials_sheen": {"sheenColorFactor": [1, 1, 1], "sheenRoughnessFactor": 0.1},
      "KHR_materials_anisotropy": {"anisotropyStrength": 1, "anisotropyRotation": 1},
      "KHR_materials_emissive_strength": {"emissiveStrength": 2}}}])");
  f.root["skins"] = json::parse(R"([{"joints": [0]}])");
  f.root["animations"] = json::parse(
      R"([{"channels": [{"sampler": 0, "target": {"node": 0, "path": "translation"}}], "samplers": [{"input": 0, "output": 0}]}])");
  f.root["nodes"] = json::parse(
      R"([{"mesh": 0, "children": [1, 2], "skin": 0, "translation": [1, 2, 3], "rotation": [0, 0, 0, 1],
    "scale": [1, 2, 3]}, {"camera": 0, "matrix": [1,0,0,0, 0,1,0,0, 0,0,1,0, 0,0,0,1],
    "extensions": {"KHR_lights_punctual": {"light": 0}}}, {"camera": 1}])");
  f.root["scenes"][0]["extras"] = json::parse(
      R"({"environment_color": [1, 1, 1], "environment_strength": 1, "environment_rotation": 90})");
  ASSERT_EQ(complaint(f), "");

  const Folder folder;
  const json flat = f.root.flatten();
  std::set<std::string> pointers;
  for (const auto& [pointer, value] : flat.items())
    for (std::string part = pointer; !part.empty(); part = part.substr(0, part.rfind('/')))
      pointers.insert(part);
  int tried = 0, loaded = 0;
  for (const std::string& pointer : pointers)
    for (const char* value : {"null", "true", "-1", "0", "1e300", "1e-300", "7", "4294967295", "\"\"",
                              "\"x\"", "[]", "{}", "[null]", "{\"a\":[]}", "delete"}) {
      File bad = f;
      const json::json_pointer at(pointer);
      if (std::string(value) != "delete")
        bad.root[at] = json::parse(value);
      else if (bad.root[at.parent_pointer()].is_object())
        bad.root[at.parent_pointer()].erase(at.back());
      ++tried;
      try {
        const scene::Scene scene = load(folder.write("scene.glb", bad.to_glb()));
        ++loaded;
        for (const scene::Instance& i : scene.instances) {
          const scene::Mesh& mesh = scene.meshes.at(static_cast<size_t>(i.mesh));
          scene.materials.at(static_cast<size_t>(mesh.material));
          for (const math::UVec3& t : mesh.triangles) mesh.positions.at(std::max({t.x, t.y, t.z}));
          EXPECT_TRUE(mesh.normals.empty() || mesh.normals.size() == mesh.positions.size());
          for (int c = 0; c < 4; ++c)
            for (int r = 0; r < 4; ++r)
              EXPECT_TRUE(std::isfinite(i.to_world[c][r])) << pointer << ' ' << value;
        }
        for (const scene::Material& m : scene.materials)
          for (const float x : {m.metallic, m.roughness, m.specular, m.sheen, m.clearcoat, m.anisotropic})
            EXPECT_TRUE(x >= 0 && x <= 1) << pointer << ' ' << value;
      } catch (const base::Error& error) {
        EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos) << error.what();
        EXPECT_LT(std::strlen(error.what()), 500u) << error.what();
      } catch (const std::exception& other) {
        ADD_FAILURE() << pointer << " = " << value << ": " << other.what();
      }
    }
  EXPECT_GT(tried, 2500);
  EXPECT_GT(loaded, 100);
  EXPECT_GT(tried - loaded, 1000);
}

// Flip bytes of a good .glb: fixed seed, no crash.
TEST(Guard, survives_random_damage) {
  const std::string good = triangle().to_glb();
  std::uint64_t state = 1;
  const auto next = [&] { return (state = state * 6364136223846793005ull + 1442695040888963407ull) >> 33; };
  const Folder folder;
  int loaded = 0;
  for (int round = 0; round < 3000; ++round) {
    std::string bad = good;
    for (std::uint64_t k = 0; k <= next() % 4; ++k) bad[next() % bad.size()] = static_cast<char>(next());
    try {
      load(folder.write("scene.glb", bad));
      ++loaded;
    } catch (const base::Error& error) {
      EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos);
    }
  }
  EXPECT_GT(loaded, 20);
  EXPECT_LT(loaded, 2900);
}
