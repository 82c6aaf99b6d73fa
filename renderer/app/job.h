// One render from options to files, and the last scene kept for the next job of a batch.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "app/console.h"
#include "app/options.h"
#include "scene/scene.h"

namespace app {

// Holds the scene that was read last.
class Stage {
 public:
  // The scene of `options`, with the camera, environment and defaults they ask for; fills
  // options.render.camera and adds a note for each default.
  const scene::Scene& prepare(Options& options);

 private:
  scene::Scene scene_;
  std::string key_;  // what scene_ was read from; empty: nothing, or a job has changed it
};

struct Result {  // to_json() is what --json prints
  std::string out, error;
  bool ok = false, partial = false;  // partial: stopped by a signal
  double seconds = 0, load_seconds = 0, build_seconds = 0, render_seconds = 0;
  int samples = 0;   // per pixel, done everywhere; --adaptive: their mean
  double noise = 0;  // image::Film::noise()
  std::uint64_t rays = 0;
  std::int64_t rejected = 0;  // samples that were not finite
};
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(Result, out, error, ok, partial, seconds, load_seconds, build_seconds,
                                   render_seconds, samples, noise, rays, rejected)

// Refuses what would not fit into this machine's memory. Throws base::Error.
void check_memory(const Options& options);

// Renders and writes. Throws base::Error. `options` are complete.
Result run(Options& options, Stage& stage, Console& console);

// The list of jobs in a file; refuses one that cannot be meant. Throws base::Error.
nlohmann::json read_jobs(const std::string& file);

// From now on the first SIGINT or SIGTERM only asks run() to stop; the second ends the process.
void watch_signals();
int stop_signal();  // 0, or the signal that came

}  // namespace app
