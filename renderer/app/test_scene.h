// A small scene for this room's tests: a floor, a tilted glossy square, a square lamp above, one camera
// "main".
#pragma once

#include <unistd.h>

#include <cstring>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

namespace app {

// A folder of the test's own that goes away with it.
class Folder {
 public:
  Folder() {
    static int count = 0;
    path_ = std::filesystem::temp_directory_path() /
            ("assay-app-test-" + std::to_string(getpid()) + "-" + std::to_string(count++));
    std::filesystem::create_directories(path_);
  }
  ~Folder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;
  std::string file(const std::string& name) const { return (path_ / name).string(); }
  std::string write(const std::string& name, const std::string& text) const {
    std::ofstream(path_ / name, std::ios::binary) << text;
    return file(name);
  }

 private:
  std::filesystem::path path_;
};

struct SceneParts {
  bool camera = true, lamp = true;
};

// Writes NAME.gltf and its buffer NAME.bin.
inline std::string write_scene(const Folder& folder, const std::string& name = "scene",
                               SceneParts parts = {}) {
  // Three squares of two triangles: corner, side, side.
  const float squares[3][3][3] = {{{-2, 0, 2}, {4, 0, 0}, {0, 0, -4}},
                                  {{-.8f, .2f, .3f}, {1.6f, 0, 0}, {0, 1.4f, -.8f}},
                                  {{-.5f, 2.5f, -.5f}, {1, 0, 0}, {0, 0, 1}}};
  std::vector<float> numbers;
  for (const auto& square : squares)
    for (const auto& [s, t] : {std::pair{0, 0}, {1, 0}, {1, 1}, {0, 0}, {1, 1}, {0, 1}})
      for (int axis = 0; axis < 3; ++axis)
        numbers.push_back(square[0][axis] + static_cast<float>(s) * square[1][axis] +
                          static_cast<float>(t) * square[2][axis]);
  std::string bytes(numbers.size() * sizeof(float), '\0');
  std::memcpy(bytes.data(), numbers.data(), bytes.size());
  folder.write(name + ".bin", bytes);

  std::string meshes, nodes, accessors, views;
  const std::string bounds[3] = {R"("min":[-2,0,-2],"max":[2,0,2])",
                                 R"("min":[-0.8,0.2,-0.5],"max":[0.8,1.6,0.3])",
                                 R"("min":[-0.5,2.5,-0.5],"max":[0.5,2.5,0.5])"};
  const int count = parts.lamp ? 3 : 2;
  for (int i = 0; i < count; ++i) {
    const std::string k = std::to_string(i), comma = i == 0 ? "" : ",";
    meshes += comma + R"({"primitives":[{"attributes":{"POSITION":)" + k + R"(},"material":)" + k + "}]}";
    nodes += comma + R"({"mesh":)" + k + "}";
    accessors += comma + R"({"bufferView":)" + k + R"(,"componentType":5126,"count":6,"type":"VEC3",)" +
                 bounds[i] + "}";
    views += comma + R"({"buffer":0,"byteOffset":)" + std::to_string(i * 72) + R"(,"byteLength":72})";
  }
  if (parts.camera) nodes += R"(,{"camera":0,"translation":[0,1,5]})";
  std::string roots = "0";
  for (int i = 1; i < count + (parts.camera ? 1 : 0); ++i) roots += "," + std::to_string(i);
  return folder.write(
      name + ".gltf",
      R"({"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[)" + roots + R"(]}],"nodes":[)" + nodes +
          R"(],"meshes":[)" + meshes + R"(],"accessors":[)" + accessors + R"(],"bufferViews":[)" + views +
          R"(],"buffers":[{"uri":")" + name + R"(.bin","byteLength":)" + std::to_string(bytes.size()) +
          R"(}],"materials":[
            {"name":"floor","doubleSided":true,"pbrMetallicRoughness":{"baseColorFactor":[0.6,0.6,0.5,1],"metallicFactor":0}},
            {"name":"glossy","doubleSided":true,"pbrMetallicRoughness":{"baseColorFactor":[0.8,0.3,0.2,1],"metallicFactor":0.5,"roughnessFactor":0.3}},
            {"name":"lamp","doubleSided":true,"emissiveFactor":[1,1,1],"extensions":{"KHR_materials_emissive_strength":{"emissiveStrength":8}}}],
          "extensionsUsed":["KHR_materials_emissive_strength"])" +
          (parts.camera
               ? R"(,"cameras":[{"name":"main","type":"perspective","perspective":{"aspectRatio":1.5,"yfov":0.7,"znear":0.1}}])"
               : "") +
          "}");
}

}  // namespace app
