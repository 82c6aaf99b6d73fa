// Case files: regression/cases/NAME.json, read strictly (docs/formats.md, cases/schema.json), and where
// everything of a suite lies on disk.
#pragma once

#include <array>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

namespace suite {

enum class WitnessKind { blender, povray, analytic };

struct Witness {
  WitnessKind kind = WitnessKind::blender;
  double margin = .005;                    // relative to the witness's mean
  int spp = 1024, seeds = 8;               // blender: how its script renders
  bool flip = true;                        // blender: also judged by FLIP
  std::string quantity;                    // povray: direct, mirror, position, normal, brdf
  double tolerance = 0;                    // povray: see cases/schema.json
  double coverage = .002;                  // povray: share of pixels that may be hit by only one of the two
  std::array<double, 3> mean{};            // analytic
  std::optional<std::array<int, 4>> rect;  // analytic: x, y, width, height
  std::string source;                      // analytic
  std::string shader;                      // of our render for this comparison
  int depth = 0;                           // of our render for this comparison
  bool expect_differs = false;
  std::string because;

  // "blender", "povray.direct", "analytic"; with "-2" and so on appended for repetitions in one case.
  std::string label;
};

struct Case {
  std::string file;  // the path it was read from
  std::string name, why, scene, shader;
  int width = 0, height = 0, spp = 0, replicates = 0, depth = 0, camera = 0;
  std::uint32_t seed = 0;
  nlohmann::json options;  // long renderer options without dashes
  std::vector<Witness> witnesses;
  double margin_image = .005, margin_tile = .05;
  struct Limits {
    double flip, rmse;
  };
  std::optional<Limits> limits;  // absent: never calibrated
  double timeout_s = 60;
  std::vector<std::string> tags;
};

// Where a suite keeps what. Every path is absolute or relative to the current directory as given.
struct Layout {
  std::string root;       // holds cases/, scenes/, goldens/
  std::string reference;  // holds blender/ and povray/
  std::string build;      // everything written by a run

  // `root` empty: the nearest folder regression/ that holds cases/, from the current directory upwards;
  // throws base::Error if there is none. `build` empty: build/ beside the suite.
  static Layout find(std::string root, std::string build);

  std::string case_file(const std::string& name) const { return root + "/cases/" + name + ".json"; }
  std::string scene_file(const Case& c) const { return root + "/scenes/" + c.scene; }
  std::string golden_file(const std::string& name) const { return root + "/goldens/" + name + ".exr"; }
  std::string witness_folder(WitnessKind kind) const;
  std::string witness_file(const Case& c, const Witness& witness) const;
  std::string pending_file(const std::string& name) const { return build + "/pending/" + name + ".exr"; }
  std::string result_file(const std::string& name) const { return build + "/results/" + name + ".json"; }
  std::string render_file(const std::string& name) const { return build + "/renders/" + name + ".exr"; }
};

// Reads one case. Throws base::Error with one line for anything that is not as cases/schema.json says, a name
// that is not the file's, or a scene that is not there.
Case read_case(const Layout& layout, const std::string& name);

// The names of all cases, sorted. A suite without any is an error.
std::vector<std::string> case_names(const Layout& layout);

// True if `pattern` (with * or ?: a glob over the whole name; else a substring) selects `name`.
bool matches(const std::string& pattern, const std::string& name);

}  // namespace suite
