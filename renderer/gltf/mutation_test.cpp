// Whatever is done to a good file: a refusal in one line, or a consistent scene.
#include <cmath>
#include <set>

#include "gltf/sample_test.h"

using namespace gltf;
using namespace gltf::sample;

// Replace each value of a file that uses everything by each of these: no crash, no exception but base::Error,
// one line, and whatever loads is consistent.
TEST(Mutation, survives_every_single_mutation_of_a_file_that_uses_everything) {
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
TEST(Mutation, survives_random_damage) {
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
