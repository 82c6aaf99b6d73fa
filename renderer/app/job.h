// One render from options to files, and the last scene kept for the next job of a batch.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>

#include "app/console.h"
#include "app/options.h"
#include "scene/scene.h"

namespace app {

// Holds the scene that was loaded last, and undoes what a job added to it.
class Stage {
 public:
  // The scene of `options`, with the camera, environment and defaults they ask for; fills
  // options.render.camera and adds a note for each default.
  scene::Scene& prepare(Options& options);

 private:
  scene::Scene scene_;
  std::string key_;  // what scene_ was loaded from; empty: nothing
  size_t file_cameras_ = 0;
  std::optional<std::optional<scene::Environment>>
      file_environment_;  // set while a job's stands in its place
  void load(const Options& options);
  void replace_environment(scene::Environment environment);
};

struct Result {
  std::string out, error;  // error: empty if the picture was written
  bool partial = false;    // stopped by a signal
  double seconds = 0, load_seconds = 0, build_seconds = 0, render_seconds = 0;
  int samples = 0;  // per pixel, done everywhere
  std::uint64_t rays = 0;
  std::int64_t rejected = 0;  // samples that were not finite
};
nlohmann::json to_json(const Result& result);

// One line on standard output, at once.
void print_json(const nlohmann::json& object);

// Renders and writes. Throws base::Error. `options` are complete.
Result run(Options& options, Stage& stage, Console& console);

// From now on the first SIGINT or SIGTERM only asks run() to stop; the second ends the process.
void watch_signals();
int stop_signal();  // 0, or the signal that came

}  // namespace app
