// What one run of assay-render is told to do. One table of options (options.cpp) serves the command line,
// batch jobs, --help and the provenance: name, default, range and documentation stand in one row each.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "gltf/load.h"
#include "integrator/render.h"

namespace app {

struct Options {
  nlohmann::json given;  // values by the option's name
  std::string answer;    // to --help, --version: what to print instead of doing anything

  // From here on filled by complete(); the size by choose_size().
  integrator::Settings render;
  gltf::Options load;
  std::string environment_hash;  // SHA-256 of --environment, once it was read
  // One line each, about what nobody asked for: choices only --info mentions, notes are always said.
  std::vector<std::string> choices, notes;

  bool has(const std::string& name) const { return given.contains(name); }
  // The value given, the default, or null; as text "" for null.
  const nlohmann::json& operator[](const std::string& name) const;
  std::string text(const std::string& name) const;
  size_t index(const std::string& name) const;  // of the value among the names it may have

  static constexpr int most_side = 32768;  // pixels
};

// Reads the command line; throws base::Error for what is not an option, naming the nearest.
Options parse_command_line(std::vector<std::string> arguments);

// Adds a batch job's keys to `options`, which start as the command line's.
void apply_job(Options& options, const nlohmann::json& job);

// Fills what was left open (samples, replicates) and refuses what does not go together.
void complete(Options& options);
// The same without looking at the output.
void complete_settings(Options& options);

// Fills in the size from the camera's aspect (0: it has none) and checks the crop against it.
void choose_size(Options& options, float camera_aspect);

// Everything that decides the picture but the scene itself, of options that are complete.
nlohmann::json decisive(const Options& options);

// The options as a command line that does the same. Provenance leaves out the folders, which say where
// somebody works and not what was done.
std::string command(const Options& options, bool with_folders);

std::vector<std::string> option_names();
// What --help says of an option.
const std::string& help_of(const std::string& option);
// The names that an option chooses from, in the order of the program's enumerations.
const std::vector<std::string>& choices_of(const std::string& option);

}  // namespace app
