// Hostile files against the whole program: the fuzzer's corpus, and what a small file can make the process
// take.
#include "app/survive_test.h"

#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/wait.h>

#include <nlohmann/json.hpp>
#include <set>
#include <sstream>

#include "app/test_scene.h"

namespace app {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

std::string read(const fs::path& file) {
  std::ostringstream text;
  text << std::ifstream(file, std::ios::binary).rdbuf();
  return text.str();
}

const fs::path corpus = ASSAY_SOURCE_DIR "/renderer/app/corpus";

// X22. Also what scripts/fuzz found, once mended.
TEST(Corpus, is_refused_in_one_line_or_rendered_file_by_file) {
  const Folder folder;
  int rendered = 0, refused = 0;
  std::set<std::string> reasons;
  for (const char* kind : {"gltf", "glb", "image"})
    for (const auto& entry : fs::directory_iterator(corpus / kind)) {
      SCOPED_TRACE(entry.path().string());
      const std::string error = survive(read(entry.path()), folder.file("a.gltf"));
      ++(error.empty() ? rendered : refused);
      reasons.insert(error);
    }
  EXPECT_GT(rendered, 30);
  EXPECT_GT(refused, 25);
  EXPECT_GT(reasons.size(), 20u) << "each for a reason of its own";
  RecordProperty("measured", std::to_string(rendered) + " files rendered, " + std::to_string(refused) +
                                 " refused in one line each, 0 crashes");
}

std::string glb(const json& root, std::string binary = "") {
  std::string text = root.dump();
  text.resize((text.size() + 3) / 4 * 4, ' ');
  binary.resize((binary.size() + 3) / 4 * 4);
  std::string out = "glTF";
  const auto put = [&](size_t value) {
    for (int shift = 0; shift < 32; shift += 8) out += static_cast<char>(value >> shift & 255);
  };
  put(2), put(12 + 8 + text.size() + (binary.empty() ? 0 : 8 + binary.size()));
  put(text.size()), out += "JSON" + text;
  if (!binary.empty()) put(binary.size()), (out += "BIN") += '\0', out += binary;
  return out;
}

// A mesh of `vertices` vertices that are nowhere in the file.
json scene_of(size_t vertices, size_t nodes, float emission) {
  json root = {{"asset", {{"version", "2.0"}}},
               {"scene", 0},
               {"scenes", {{{"nodes", json::array()}}}},
               {"nodes", json::array()},
               {"meshes", {{{"primitives", {{{"attributes", {{"POSITION", 0}}}, {"material", 0}}}}}}},
               {"accessors", {{{"componentType", 5126}, {"count", vertices}, {"type", "VEC3"}}}},
               {"materials", {{{"emissiveFactor", {emission, 0, 0}}}}}};
  for (size_t i = 0; i < nodes; ++i) {
    root["nodes"].push_back({{"mesh", 0}});
    root["scenes"][0]["nodes"].push_back(i);
  }
  return root;
}

// X13. The files sit just below what is refused, by the limit of memory or by a count: the worst there is.
TEST(HostileFile, takes_less_than_a_gigabyte) {
#ifdef ASSAY_SANITIZED
  GTEST_SKIP() << "a sanitizer takes memory of its own";
#endif
  const Folder folder;
  const auto many = [](size_t count, const json& value) {
    json out = json::array();
    for (size_t i = 0; i < count; ++i) out.push_back(value);
    return out;
  };
  std::vector<std::pair<std::string, std::string>> files;
  files.emplace_back("a million vertices and more from no bytes", glb(scene_of(3'600'000, 1, 0)));
  files.emplace_back("lamps placed by the hundred", glb(scene_of(30'000, 250, 1)));
  files.emplace_back("200,000 instances", glb(scene_of(3, 200'000, 0)));
  json root = scene_of(3, 1, 0);
  root["extras"] = many(1'000'000, {{"a", 0}});
  files.emplace_back("a million objects that nobody reads", glb(root));
  root = scene_of(3, 1, 0);
  root["nodes"] = many(300'000, {{"name", "a"}, {"translation", {1, 2, 3}}});
  root["nodes"][0] = {{"mesh", 0}};
  files.emplace_back("nodes", glb(root));
  root = scene_of(3, 1, 0);
  const std::string bomb = read(corpus / "image" / "bomb.png");
  std::string binary;
  for (int i = 0; i < 8; ++i) {
    root["bufferViews"].push_back(
        {{"buffer", 0}, {"byteOffset", binary.size()}, {"byteLength", bomb.size()}});
    root["images"].push_back({{"bufferView", i}, {"mimeType", "image/png"}});
    root["textures"].push_back({{"source", i}});
    root["materials"].push_back({{"normalTexture", {{"index", i}}}});
    binary += bomb;
  }
  root["buffers"] = {{{"byteLength", binary.size()}}};
  files.emplace_back("eight images of 2^25 pixels each", glb(root, binary));
  root["materials"] = json::array({root["materials"][1]});
  files.emplace_back("one of them", glb(root, binary));
  // An environment in run lengths, 1.2 MB for 15 million pixels.
  std::string map = "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 3800 +X 4000\n", row = "\2\2\x0f\xa0";
  for (int part = 0; part < 4; ++part)
    for (int left = 4000; left > 0; left -= 127)
      (row += static_cast<char>(128 + std::min(left, 127))) += static_cast<char>(128);
  for (int y = 0; y < 3800; ++y) map += row;
  folder.write("sky.hdr", map);
  root = scene_of(3, 1, 0);
  root["scenes"][0]["extras"]["environment"] = "sky.hdr";
  files.emplace_back("an environment of 15 million pixels", glb(root));

  double worst = 0;
  std::string worst_name;
  for (const auto& [name, bytes] : files) {
    const std::string file = folder.write("a.glb", bytes), out = folder.file("a.exr");
    const pid_t child = fork();
    if (child == 0) {
      const char* const program = ASSAY_BINARY_DIR "/bin/assay-render";
      std::freopen("/dev/null", "w", stderr);
      execl(program, program, file.c_str(), "-o", out.c_str(), "--width", "8", "--height", "8", "--spp", "1",
            "--quiet", nullptr);
      _exit(99);
    }
    int status = 0;
    rusage used{};
    wait4(child, &status, 0, &used);
    const double megabytes = static_cast<double>(used.ru_maxrss) / 1e3;
    ASSERT_TRUE(WIFEXITED(status)) << name << ": signal " << WTERMSIG(status);
    const int code = WEXITSTATUS(status);
    std::printf("%-45s %8.2f MB in the file, %4.0f MB taken, exit code %d\n", name.c_str(),
                static_cast<double>(bytes.size()) / 1e6, megabytes, code);
    EXPECT_TRUE(code == 0 || code == 2) << name;
    EXPECT_LT(megabytes, 1000) << name;
    if (megabytes > worst) worst = megabytes, worst_name = name;
  }
  std::ostringstream text;
  text << files.size() << " files, at most " << std::lround(worst) << " MB (" << worst_name << ")";
  RecordProperty("measured", text.str());
}

}  // namespace
}  // namespace app
