#include "app/job.h"

#include <unistd.h>

#include <csignal>
#include <filesystem>

#include "app/defaults.h"
#include "app/energy.h"
#include "app/output.h"
#include "base/error.h"

namespace app {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

constexpr double save_interval_seconds = 5, pass_seconds = 2;
constexpr double film_bytes = 32;  // of one pixel in one replicate, image/film.h

volatile std::sig_atomic_t signal_received = 0;

double since(Clock::time_point start) { return std::chrono::duration<double>(Clock::now() - start).count(); }

// How many samples to add next. Doubling lets whoever stops early keep a whole, only noisier, picture, and a
// few seconds are enough for one pass, so that a stop is quick; the result does not depend on it.
int next_pass(const integrator::Settings& settings, int done, double seconds) {
  if (done == 0) return settings.replicates;
  const double affordable = std::min(pass_seconds * done / std::max(seconds, 1e-6), 1e9);
  const int whole = static_cast<int>(affordable) / settings.replicates * settings.replicates;
  return std::min({done, std::max(whole, settings.replicates), settings.spp - done});
}

// The picture's film and those of --layers lobes.
int films_of(const Options& options) {
  const std::vector<std::string> layers = options["layers"];
  return 1 + (std::count(layers.begin(), layers.end(), "lobes") > 0
                  ? static_cast<int>(integrator::part_names().size())
                  : 0);
}

}  // namespace

// Linux grants memory that is not there and later kills who uses it, so the film's is counted before.
void check_memory(const Options& options) {
  const integrator::Settings& r = options.render;
  const double width = r.crop_width > 0 ? r.crop_width : r.width;
  const double height = r.crop_width > 0 ? r.crop_height : r.height;
  const double gigabytes = film_bytes * width * height * r.replicates * films_of(options) / 1e9;
  const double there =
      static_cast<double>(sysconf(_SC_PHYS_PAGES)) * static_cast<double>(sysconf(_SC_PAGESIZE)) / 1e9;
  if (gigabytes > there)
    base::fail("out of memory: ", width, " x ", height, " pixels in ", r.replicates, " replicates take ",
               gigabytes, " GB, this machine has ", there, " GB (see --crop, --replicates)");
}

void watch_signals() {
  struct sigaction action = {};
  action.sa_handler = [](int signal) { signal_received = signal; };
  action.sa_flags = static_cast<int>(SA_RESETHAND) | SA_RESTART;
  sigaction(SIGINT, &action, nullptr);
  sigaction(SIGTERM, &action, nullptr);
}
int stop_signal() { return signal_received; }

const scene::Scene& Stage::prepare(Options& options) {
  std::error_code ignored;
  const fs::path path = fs::absolute(options.text("scene"), ignored);
  const auto changed = fs::last_write_time(path, ignored).time_since_epoch().count();
  const std::string key = path.string() + '\n' + std::to_string(changed) + options.text("punctual-units");
  if (key != std::exchange(key_, "")) {
    scene_ = {};  // before the next is read: two large scenes need not fit at once
    scene_ = gltf::load(options.text("scene"), options.load);
  }

  const bool has_camera = !scene_.cameras.empty(), has_light = app::has_light(scene_);
  if (options.has("camera")) options.render.camera = find_camera(scene_, options.text("camera"));
  choose_size(options, has_camera ? scene_.cameras[static_cast<size_t>(options.render.camera)].aspect : 0);
  if (!has_camera) {
    const float aspect = static_cast<float>(options.render.width) / static_cast<float>(options.render.height);
    scene_.cameras.push_back(framing_camera(scene_, aspect));
    options.notes.push_back("camera: the file has none, everything is framed");
  }

  if (options.has("environment")) {
    scene_.environment = read_environment(options);
  } else if (options.has("environment-color")) {
    scene_.environment = constant_environment(options["environment-color"]);
  } else if (!has_light && shows_light(options.render.shader)) {
    scene_.environment = neutral_environment();
    options.notes.push_back("light: the file has none, a soft neutral sky lights it");
  } else if (has_camera) {
    key_ = key;  // as the file has it
  }
  return scene_;
}

Result run(Options& options, Stage& stage, Console& console) {
  const Clock::time_point start = Clock::now();
  Result result;
  result.out = options.text("out");
  check_writable(options);
  const scene::Scene& scene = stage.prepare(options);
  result.load_seconds = since(start);
  for (const std::string& warning : scene.warnings) console.warn(warning);
  for (const std::string& note : options.notes) console.say(note);
  const integrator::Settings& settings = options.render;
  if (const std::string warning = energy_warning(scene, settings); !warning.empty()) console.warn(warning);

  check_memory(options);
  const integrator::Renderer renderer(scene, settings);
  result.build_seconds = renderer.build_seconds();
  image::Film film = renderer.film();
  std::vector<image::Film> parts;
  for (int i = 0; i < films_of(options) - 1; ++i) parts.push_back(renderer.film());

  // Passes of samples until all are there or a signal says stop.
  const Clock::time_point render_start = Clock::now();
  Clock::time_point last_save{};  // long ago: the first pass is shown at once
  result.partial = stop_signal() != 0;
  while (result.samples < settings.spp && !result.partial) {
    const int first = result.samples, count = next_pass(settings, first, since(render_start));
    result.partial = !renderer.render(
        film, first, count,
        [&](const integrator::Status& status) {
          const double done = first + status.fraction * count;
          console.progress(since(render_start), done / settings.spp, static_cast<int>(done), settings.spp,
                           renderer.rays());
          return stop_signal() == 0;
        },
        parts);
    if (!result.partial) result.samples = first + count;
    if (options["save-progress"] && !result.partial && result.samples < settings.spp &&
        since(last_save) >= save_interval_seconds) {
      try {
        write_picture(options, scene, renderer, film, parts, result.samples, true);
      } catch (const base::Error& error) {  // a disk may have room again at the end
        console.warn(error.what());
      }
      last_save = Clock::now();
    }
  }
  result.render_seconds = since(render_start);
  result.rays = renderer.rays();
  result.rejected = film.rejected();
  if (result.partial && result.rays == 0)
    base::fail(result.out, ": stopped before the first sample; nothing was written");
  write_picture(options, scene, renderer, film, parts, result.samples, result.partial);

  result.seconds = since(start);
  result.ok = !result.partial;
  if (result.rejected > 0)
    console.warn(result.out + ": " + std::to_string(result.rejected) +
                 " samples were not finite and were left out");
  console.say(result.out + ": " + std::to_string(film.width()) + " x " + std::to_string(film.height()) +
              ", " + std::to_string(result.samples) + " samples, " + duration(result.seconds) + ", " +
              speed(result.rays, result.render_seconds) +
              (result.partial ? ", stopped early: only the picture so far" : ""));
  return result;
}

}  // namespace app
