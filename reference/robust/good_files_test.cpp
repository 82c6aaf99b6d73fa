// What must still load, however much is refused: docs/robustness.md, X21.
#include <map>

#include "gltf/sample_test.h"
#include "robust/robust.h"

namespace robust {
namespace {

// X21. Every scene of the suite, against what its own JSON says of it: triangles and bounds.
TEST(GoodFiles, hold_the_triangles_and_bounds_their_accessors_declare) {
  int files = 0, triangles = 0;
  for (const auto& entry : std::filesystem::directory_iterator(ASSAY_SOURCE_DIR "/regression/scenes")) {
    if (entry.path().extension() != ".glb") continue;
    SCOPED_TRACE(entry.path().string());
    std::ostringstream text;
    text << std::ifstream(entry.path(), std::ios::binary).rdbuf();
    const std::string bytes = text.str();
    std::uint32_t length = 0;
    std::memcpy(&length, &bytes[12], 4);
    const auto root = gltf::sample::json::parse(bytes.substr(20, length));
    const scene::Scene s = gltf::load(entry.path().string());
    // By name, which the loader keeps: mesh name, or mesh name and primitive.
    std::map<std::string, std::pair<size_t, const scene::Mesh*>> found;
    for (const scene::Mesh& m : s.meshes) found[m.name] = {found[m.name].first + 1, &m};
    for (const auto& mesh : root["meshes"])
      for (size_t p = 0; p < mesh["primitives"].size(); ++p) {
        const auto& primitive = mesh["primitives"][p];
        const std::string name = mesh.value("name", "");
        const auto it = found.find(p == 0 ? name : name + "[" + std::to_string(p) + "]");
        if (it == found.end() || it->second.first != 1 || primitive.value("mode", 4) != 4) continue;
        const scene::Mesh& m = *it->second.second;
        const auto& position = root["accessors"][primitive["attributes"]["POSITION"].get<size_t>()];
        const size_t indices =
            (primitive.contains("indices") ? root["accessors"][primitive["indices"].get<size_t>()]
                                           : position)["count"];
        EXPECT_EQ(m.triangles.size(), indices / 3) << m.name;
        triangles += static_cast<int>(m.triangles.size());
        for (int axis = 0; axis < 3 && position.contains("min"); ++axis) {
          float low = std::numeric_limits<float>::infinity(), high = -std::numeric_limits<float>::infinity();
          for (const Vec3& v : m.positions) low = std::min(low, v[axis]), high = std::max(high, v[axis]);
          EXPECT_EQ(low, position["min"][static_cast<size_t>(axis)].get<float>()) << m.name;
          EXPECT_EQ(high, position["max"][static_cast<size_t>(axis)].get<float>()) << m.name;
        }
      }
    ++files;
  }
  EXPECT_GT(files, 30);
  EXPECT_GT(triangles, 10'000);
  measured(files, " files, ", triangles, " triangles");
}

}  // namespace
}  // namespace robust
