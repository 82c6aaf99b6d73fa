// Who takes part, and how one of them renders one picture. A contestant is data: a command line started once
// per picture, or a worker that stays alive, with settings.
#pragma once

#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "image/image.h"
#include "speed/worker.h"
#include "suite/renderer_command.h"

namespace speed {

struct Contestant {
  std::string name;
  std::string family;         // whose converged picture it is held against
  bool is_reference = false;  // it renders that picture: fixed samples, no approximation
  int first = 4, last = 256;  // samples per pixel, doubling
  int compared_at = 64;       // others are asked how long they take to its error here
  std::optional<suite::RendererCommand> command;
  std::vector<std::string> worker;                     // if no command
  nlohmann::json settings = nlohmann::json::object();  // the worker's, added to each job
};

struct Order {
  std::string scene;  // file
  int size = 128;     // square pictures
  int spp = 16, seed = 1, depth = 8, threads = 0;
};

struct Shot {
  image::Image picture;
  double render_seconds = 0;  // neither start-up nor loading nor BVH
  double build_seconds = 0, load_seconds = 0;
  double process_seconds = 0;    // of a command: from start to end
  double rays = 0, peak_mb = 0;  // 0: not told
};

// Assay, Assay adaptive if this build of it has --adaptive, Cycles with fixed samples and adaptive, if
// Blender is there. `suite` is the folder regression/, `build` the one with bin/assay-render.
std::vector<Contestant> default_contestants(const std::string& suite, const std::string& build);

// NAME='CMD {scene} {out} …'; base::Error if it is not of that form.
Contestant custom_contestant(const std::string& text);

class Runner {
 public:
  explicit Runner(std::string scratch) : scratch_(std::move(scratch)) {}
  // base::Error if it fails, takes longer than `timeout_s` or writes no picture.
  Shot render(const Contestant& contestant, const Order& order, double timeout_s = 600);
  void dismiss() { workers_.clear(); }  // frees the workers' memory

 private:
  std::string scratch_;
  std::map<std::vector<std::string>, std::unique_ptr<Worker>> workers_;
};

}  // namespace speed
