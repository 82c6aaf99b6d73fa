#include "app/job.h"

#include <algorithm>
#include <chrono>
#include <csignal>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "app/defaults.h"
#include "app/describe.h"
#include "app/energy.h"
#include "app/output.h"
#include "base/error.h"

namespace app {
namespace {

using Clock = std::chrono::steady_clock;
using integrator::Shader;

constexpr double save_interval_seconds = 5, pass_seconds = 2;

volatile std::sig_atomic_t signal_received = 0;

double since(Clock::time_point start) { return std::chrono::duration<double>(Clock::now() - start).count(); }

// Shaders that need no light to show something.
bool needs_light(Shader shader) {
  return shader != Shader::eyelight && shader != Shader::normal && shader != Shader::albedo &&
         shader != Shader::texcoord && shader != Shader::position;
}

// How many samples to add next. Doubling lets whoever stops early keep a whole, only noisier, picture, and a
// few seconds are enough for one pass, so that a stop is quick; the result does not depend on it.
int next_pass(const integrator::Settings& settings, int done, double seconds) {
  if (done == 0) return settings.replicates;
  const double affordable = std::min(pass_seconds * done / std::max(seconds, 1e-6), 1e9);
  const int whole = static_cast<int>(affordable) / settings.replicates * settings.replicates;
  return std::min({done, std::max(whole, settings.replicates), settings.spp - done});
}

}  // namespace

void watch_signals() {
  struct sigaction action = {};
  action.sa_handler = [](int signal) { signal_received = signal; };
  action.sa_flags = static_cast<int>(SA_RESETHAND) | SA_RESTART;
  sigaction(SIGINT, &action, nullptr);
  sigaction(SIGTERM, &action, nullptr);
}
int stop_signal() { return signal_received; }

void Stage::load(const Options& options) {
  std::error_code ignored;
  const std::filesystem::path path = std::filesystem::absolute(options.scene, ignored);
  const auto changed = std::filesystem::last_write_time(path, ignored).time_since_epoch().count();
  const std::string key = path.string() + '\n' + std::to_string(changed) + '\n' +
                          std::to_string(static_cast<int>(options.punctual_units));
  if (key == key_) {
    scene_.cameras.resize(file_cameras_);
    if (file_environment_) scene_.environment = std::move(*file_environment_);
  } else {
    key_.clear();
    scene_ = {};  // before the next is read: two large scenes need not fit at once
    gltf::Options how;
    how.punctual_units = options.punctual_units;
    scene_ = gltf::load(options.scene, how);
    key_ = key;
    file_cameras_ = scene_.cameras.size();
  }
  file_environment_.reset();
}

void Stage::replace_environment(scene::Environment environment) {
  file_environment_ = std::move(scene_.environment);
  scene_.environment = std::move(environment);
}

scene::Scene& Stage::prepare(Options& options) {
  load(options);
  if (!options.camera.empty()) options.render.camera = find_camera(scene_, options.camera);
  const size_t camera = static_cast<size_t>(options.render.camera);
  choose_size(options, scene_.cameras.empty() ? 0 : scene_.cameras[camera].aspect);
  if (scene_.cameras.empty()) {
    const float aspect = static_cast<float>(options.render.width) / static_cast<float>(options.render.height);
    const std::optional<scene::Camera> framed = framing_camera(scene_, aspect);
    if (!framed) base::fail(options.scene, ": wanted something to render, found no triangles and no camera");
    scene_.cameras.push_back(*framed);
    options.notes.push_back("camera: the file has none, everything is framed");
  }

  if (!options.environment.empty()) {
    replace_environment(read_environment(options.environment));
  } else if (options.environment_color) {
    replace_environment(constant_environment(*options.environment_color));
  } else if (!has_light(scene_) && needs_light(options.render.shader)) {
    replace_environment(neutral_environment());
    options.notes.push_back("light: the file has none, a soft neutral sky lights it");
  }
  return scene_;
}

nlohmann::json to_json(const Result& r) {
  return {{"out", r.out},
          {"ok", r.error.empty() && !r.partial},
          {"seconds", r.seconds},
          {"samples", r.samples},
          {"rays", r.rays},
          {"rejected", r.rejected},
          {"error", r.error},
          {"partial", r.partial},
          {"load_seconds", r.load_seconds},
          {"build_seconds", r.build_seconds},
          {"render_seconds", r.render_seconds}};
}

void print_json(const nlohmann::json& object) {
  std::puts(object.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace).c_str());
  std::fflush(stdout);
}

Result run(Options& options, Stage& stage, Console& console) {
  const Clock::time_point start = Clock::now();
  Result result;
  result.out = options.out;
  check_writable(options.out);
  std::error_code error;
  if (std::filesystem::equivalent(options.out, options.scene, error))
    base::fail(options.out, ": cannot write: it is the scene itself");

  const scene::Scene& scene = stage.prepare(options);
  result.load_seconds = since(start);
  for (const std::string& warning : scene.warnings) console.warn(warning);
  for (const std::string& note : options.notes) console.say(note);
  const integrator::Settings& settings = options.render;
  if (settings.shader == Shader::path_disney && settings.d_constant)
    if (const auto warning = energy_warning(scene, settings.d_gamma, *settings.d_constant))
      console.warn(*warning);

  const integrator::Renderer renderer(scene, settings);
  result.build_seconds = renderer.build_seconds();
  image::Film film = renderer.film();
  const auto save = [&](bool partial) {
    result.rejected = film.rejected();
    write_picture(options, scene, renderer, film, result.samples, partial);
  };

  // Passes of samples until all are there or a signal says stop.
  const Clock::time_point render_start = Clock::now();
  Clock::time_point last_save{};  // long ago: the first pass is shown at once
  console.start_progress();
  bool stopped = stop_signal() != 0;
  while (result.samples < settings.spp && !stopped) {
    const int first = result.samples;
    const int count = next_pass(settings, first, since(render_start));
    const bool finished = renderer.render(film, first, count, [&](const integrator::Status& status) {
      const double done = (first + status.fraction * count) / settings.spp;
      console.progress(done, first + static_cast<int>(status.fraction * count), settings.spp,
                       renderer.rays());
      return stop_signal() == 0;
    });
    stopped = !finished;
    if (finished) result.samples = first + count;
    if (options.save_progress && !stopped && result.samples < settings.spp &&
        since(last_save) >= save_interval_seconds) {
      save(true);
      last_save = Clock::now();
    }
  }
  console.end_progress();
  result.render_seconds = since(render_start);
  result.rays = renderer.rays();
  result.partial = stopped;
  if (stopped && result.rays == 0)
    base::fail(options.out, ": stopped before the first sample; nothing was written");
  save(stopped);

  result.seconds = since(start);
  if (result.rejected > 0)
    console.warn(options.out + ": " + std::to_string(result.rejected) +
                 " samples were not finite and were left out");
  char rate[64];
  std::snprintf(rate, sizeof rate, "%.1f Mrays/s",
                static_cast<double>(result.rays) * 1e-6 / std::max(result.render_seconds, 1e-9));
  console.say(options.out + ": " + std::to_string(film.width()) + " x " + std::to_string(film.height()) +
              ", " + std::to_string(result.samples) + " samples, " + duration(result.seconds) + ", " + rate +
              (stopped ? ", stopped early: only the picture so far" : ""));
  return result;
}

}  // namespace app
