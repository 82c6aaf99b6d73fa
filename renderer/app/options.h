// What one run of assay-render is told to do. One table of options serves the command line, batch jobs and
// the help: same names, same validation.
#pragma once

#include <map>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "gltf/load.h"
#include "integrator/render.h"

namespace app {

struct Options {
  std::string scene, out;
  integrator::Settings
      render;          // width, height, spp and replicates if not given: 0 until choose_size() and complete()
  std::string camera;  // an index or a name; empty: the first

  std::string environment;  // a file that replaces the scene's environment
  std::optional<math::Vec3> environment_color;
  gltf::PunctualUnits punctual_units = gltf::PunctualUnits::automatic;

  bool layer_albedo = false, layer_normal = false, layer_depth = false, layer_position = false,
       layer_replicates = false;
  float exposure = 0;          // stops, 8-bit output only, as are the next two
  std::optional<float> gamma;  // absent: the sRGB curve
  bool filmic = false;
  bool save_progress = false;
  std::string log;

  std::string batch;  // from here on: the command line only
  bool info = false, json = false, quiet = false, help = false, version = false;

  std::map<std::string, std::string> given;  // every option set so far and its text
  // One line each, about what nobody asked for: choices only --info mentions, notes are always said.
  std::vector<std::string> choices, notes;

  Options() { render.width = render.height = render.spp = render.replicates = 0; }
  bool has(const std::string& name) const { return given.count(name) > 0; }
};

struct Row {
  std::string name;   // long, without dashes
  std::string brief;  // "-o" or empty
  std::string group;
  std::string value;  // what the help calls the value; empty for a flag
  std::string help;
  bool in_jobs;                                     // false: the command line only
  void (*set)(Options&, const std::string& value);  // throws base::Error "wanted W, found F"
};
const std::vector<Row>& table();

// Reads the command line; throws base::Error for what is not an option, naming the nearest.
Options parse_command_line(const std::vector<std::string>& arguments);

// Adds a batch job's keys to `options`, which start as the command line's.
void apply_job(Options& options, const nlohmann::json& job);

inline constexpr float default_aspect = 16.f / 9;

// Fills what was left open (samples, replicates) and refuses what does not go together.
void complete(Options& options);

// Fills in the size from the camera's aspect (0: it has none) and checks the crop against it.
void choose_size(Options& options, float camera_aspect);

// The options as a command line that does the same. Provenance leaves out the folders, which say where
// somebody works and not what was done.
std::string command(const Options& options, bool with_folders);

std::string help();
std::string shader_name(integrator::Shader shader);

}  // namespace app
