// For tests only: a folder that goes away, noisy pictures whose truth is known, and a small suite with a
// renderer that hands out pictures prepared by the test.
#pragma once

#include <sys/stat.h>
#include <unistd.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>
#include <random>
#include <sstream>
#include <string>

#include "image/image.h"
#include "image/io.h"
#include "suite/case_file.h"

namespace suite::testing {

class TemporaryFolder {
 public:
  TemporaryFolder() {
    std::string name = (std::filesystem::temp_directory_path() / "assay-test-XXXXXX").string();
    path_ = ::mkdtemp(name.data());
  }
  ~TemporaryFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  const std::string& path() const { return path_; }

 private:
  std::string path_;
};

inline void write_text(const std::string& file, const std::string& text) {
  std::filesystem::create_directories(std::filesystem::path(file).parent_path());
  std::ofstream(file, std::ios::binary) << text;
}

inline std::string read_text(const std::string& file) {
  std::ostringstream text;
  text << std::ifstream(file, std::ios::binary).rdbuf();
  return text.str();
}

inline void write_script(const std::string& file, const std::string& text) {
  write_text(file, text);
  ::chmod(file.c_str(), 0755);
}

// What a renderer would give: per pixel and channel the truth times `factor`, plus normal noise of relative
// size `noise` per replicate. The same seed gives the same noise, scaled by `factor` as a changed lobe would.
struct Recipe {
  int width = 16, height = 16, replicates = 8, spp = 64;
  unsigned seed = 1;
  double noise = .02;  // of one replicate at 64 samples
  std::function<double(int x, int y, int c)> truth = [](int x, int y, int c) {
    return .5 + .02 * x + .01 * y + .1 * c;
  };
  std::function<double(int x, int y)> factor = [](int, int) { return 1.; };
};

inline image::Render render(const Recipe& recipe) {
  std::mt19937 bits(recipe.seed);
  const auto normal = [&] {  // Box-Muller: the standard's distribution differs between libraries
    const double u = (static_cast<double>(bits()) + .5) / 4294967296.,
                 v = (static_cast<double>(bits()) + .5) / 4294967296.;
    return std::sqrt(-2 * std::log(u)) * std::cos(6.283185307179586 * v);
  };
  const double sigma = recipe.noise * std::sqrt(64. / recipe.spp);
  image::Render out;
  out.mean = image::Image(recipe.width, recipe.height, 3);
  out.variance = out.mean;
  std::vector<image::Image> replicates(static_cast<size_t>(recipe.replicates), out.mean);
  for (int y = 0; y < recipe.height; ++y)
    for (int x = 0; x < recipe.width; ++x)
      for (int c = 0; c < 3; ++c) {
        const double value = recipe.truth(x, y, c) * recipe.factor(x, y);
        double sum = 0, squares = 0;
        for (image::Image& r : replicates) {
          r.at(x, y, c) = static_cast<float>(value * (1 + sigma * normal()));
          sum += r.at(x, y, c);
        }
        const double count = recipe.replicates;
        for (image::Image& r : replicates) squares += std::pow(r.at(x, y, c) - sum / count, 2);
        out.mean.at(x, y, c) = static_cast<float>(sum / count);
        out.variance->at(x, y, c) = static_cast<float>(squares / (count - 1) / count);
      }
  for (size_t r = 0; r < replicates.size(); ++r) out.layers["replicate" + std::to_string(r)] = replicates[r];
  out.header["assay:replicates"] = recipe.replicates;
  out.header["assay:spp"] = recipe.spp;
  out.header["assay:seed"] = static_cast<int>(recipe.seed);
  out.header["assay:version"] = std::string("fake");
  out.header["assay:commit"] = std::string("0123456789ab");
  return out;
}

// A suite in a temporary folder, one scene, and a renderer that copies prepared/CASE.SEED.SPP.exr. Cases
// share the scene, so a case is known by its output's name.
class FakeSuite {
 public:
  FakeSuite() {
    write_text(path() + "/regression/scenes/box.gltf", R"({"asset": {"version": "2.0"}})");
    std::filesystem::create_directories(path() + "/regression/cases");
    std::filesystem::create_directories(path() + "/prepared");
    layout = Layout::find(path() + "/regression", path() + "/build");
    write_script(path() + "/fake.sh",
                 "#!/bin/sh\nname=$(basename \"$1\" .exr)\nname=${name%%.*}\n"
                 "cp '" +
                     path() + "/prepared/'\"$name.$2.$3.exr\" \"$1\"\n");
    command = path() + "/fake.sh {out} {seed} {spp} {scene} {shader} {depth}";
  }
  const std::string& path() const { return folder_.path(); }

  // `more` is added to the case file: "\"tags\": []" and so on.
  void add_case(const std::string& name, const std::string& more = "") const {
    write_text(layout.case_file(name), R"({"name": ")" + name +
                                           R"(", "why": "A test.", "scene": "box.gltf", "shader": "path",
  "size": [16, 16], "spp": 64, "replicates": 8, "seed": 1, "depth": 4,
  "limits": {"flip": 0.2, "rmse": 0.2}, "margins": {"image": 0.01, "tile": 0.05})" +
                                           (more.empty() ? "" : ",\n  " + more) + "}\n");
  }
  // What the renderer will answer for that case, seed and number of samples.
  void prepare(const std::string& name, const image::Render& picture, unsigned seed = 1, int spp = 64) const {
    image::write_exr(
        path() + "/prepared/" + name + "." + std::to_string(seed) + "." + std::to_string(spp) + ".exr",
        picture);
  }

  Layout layout;
  std::string command;

 private:
  TemporaryFolder folder_;
};

}  // namespace suite::testing
