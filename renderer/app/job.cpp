#include "app/job.h"

#include <unistd.h>

#include <cmath>
#include <csignal>
#include <filesystem>

#include "app/defaults.h"
#include "app/energy.h"
#include "app/output.h"
#include "base/error.h"
#include "integrator/adaptive.h"

namespace app {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

constexpr double save_interval_seconds = 5, pass_seconds = 2, brief_seconds = 1;
constexpr int fewest_for_pairs = 32;  // samples of a replicate: with fewer, adaptive sampling loses by them
constexpr double film_bytes = 32;     // of one pixel in one replicate, image/film.h
constexpr double noise_map_bytes = 100;  // of one pixel, integrator/adaptive.h: both maps and what makes them

volatile std::sig_atomic_t signal_received = 0;

double since(Clock::time_point start) { return std::chrono::duration<double>(Clock::now() - start).count(); }

// How many samples per pixel to add to `done`, of `total`. Doubling lets whoever stops early keep a whole,
// only noisier, picture, and a few seconds are enough for one pass, so that a stop is quick. What nobody
// could stop is done in one, for every pass has its cost. The result does not depend on it.
double next_pass(double done, double total, double seconds, double seconds_left) {
  const double per_second = done / std::max(seconds, 1e-6), left = total - done;
  if (left <= per_second * std::min(brief_seconds, seconds_left)) return left;
  return std::min({done, per_second * std::min(pass_seconds, seconds_left), left});
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
  const bool adaptive = options["adaptive"];
  const int of_the_pilot =
      (adaptive && r.replicates < integrator::enough_replicates ? 2 : 0) + (adaptive ? 2 : 0);
  const double gigabytes =
      width * height *
      (film_bytes * r.replicates * (films_of(options) + of_the_pilot) + (adaptive ? noise_map_bytes : 0)) /
      1e9;
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

  // Passes of samples until all are there, the time is up or a signal says stop.
  const Clock::time_point render_start = Clock::now();
  Clock::time_point last_save{};  // long ago: the first pass is shown at once
  const double limit = options.has("time") ? options["time"].get<double>() : 1e30;
  result.partial = stop_signal() != 0;
  double done = 0;  // samples per pixel
  const auto pass = [&](const integrator::Renderer::Counts& from, const integrator::Renderer::Counts& until,
                        double count, double total, const integrator::Sharing& sharing,
                        integrator::Spread* spread) {
    result.partial = !renderer.render(
        film, from, until, sharing, spread,
        [&](const integrator::Status& status) {
          const double now = done + status.fraction * count, elapsed = since(render_start);
          console.progress(elapsed, std::max(now / total, elapsed / limit), static_cast<int>(now),
                           static_cast<int>(total), renderer.rays());
          return stop_signal() == 0;
        },
        parts);
    if (result.partial) return;
    done += count;
    result.samples = static_cast<int>(std::lround(done));
    // A pass whose last pixel was under way was rendered to its end.
    result.partial = stop_signal() != 0 && done < total * (1 - 1e-9);
    if (options["save-progress"] && done < total && since(last_save) >= save_interval_seconds) {
      try {
        write_picture(options, scene, renderer, film, parts, result.samples, true);
      } catch (const base::Error& error) {  // a disk may have room again at the end
        console.warn(error.what());
      }
      last_save = Clock::now();
    }
  };

  // The same number everywhere: all, or the pilot.
  const bool adaptive = options["adaptive"];
  const int replicates = settings.replicates;
  const int each_has = settings.spp / replicates;  // every replicate
  // Half of many samples tell, shared two by two, also how many paths a camera ray is worth.
  const bool pairs = adaptive && each_has >= fewest_for_pairs;
  const int everywhere = !adaptive ? each_has : pairs ? each_has / 4 * 2 : each_has / 4;
  const double until = adaptive ? limit / 4 : limit;
  if (adaptive && std::max(film.width(), film.height()) <= integrator::block_side)
    base::fail("--adaptive: wanted a picture of more than 2 pixels in width or height, found ", film.width(),
               " x ", film.height());
  const bool few = adaptive && replicates < integrator::enough_replicates;
  const int least = few ? 3 : 1;
  int each = 0;
  std::optional<integrator::Spread> spread;  // of the pilot's samples, two by two
  if (adaptive) {
    const image::Film data(film.width(), film.height(), replicates, image::Film::Holds::data);
    spread = integrator::Spread{data, data};
  }
  std::optional<integrator::ReuseMap> reuse;  // from the pilot's first mark on; before, all do
  // The pilot has marks at a quarter and a half of it. With few replicates: the film as it was there, where
  // passes end whatever the machine's speed, so that the counts do not depend on it. Under --time, which does
  // not promise that, as it was before the last pass.
  std::vector<integrator::NoiseMap::Early> early;
  const bool timed = options.has("time");
  const int step = pairs ? 2 : 1;
  const int mark = std::max(2, everywhere / 4 / step * step);
  const std::array<int, 2> marks = {mark, std::max(mark + step, everywhere / 2 / step * step)};
  const auto next_mark = [&](int samples) {
    for (const int m : marks)
      if (m > samples) return std::min(m, everywhere);
    return everywhere;
  };
  while (each < everywhere && !result.partial && (each < least || since(render_start) < until)) {
    const double elapsed = since(render_start);
    int count = each == 0
                    ? std::min(adaptive ? 2 : 1, everywhere)
                    : std::max(1, static_cast<int>(next_pass(each, everywhere, elapsed, until - elapsed)));
    if (few) {
      if (timed)
        early.clear();
      else
        count = std::min(count, next_mark(each) - each);
      if (each > 0 && (timed || each == marks[0] || each == marks[1])) early.push_back({film, each});
    }
    if (adaptive && each < mark) count = std::min(count, std::min(mark, everywhere) - each);
    count = (count + step - 1) / step * step;  // no pass parts a pair
    const int first = each;
    each += count;
    pass([first](int, int, int) { return first; }, [each](int, int, int) { return each; }, count * replicates,
         everywhere * replicates,
         adaptive
             ? integrator::
                   Sharing{0, 0,
                           [&](int x, int y) {
                             return integrator::Technique{step, reuse ? reuse->at(x, y) : everywhere >= mark};
                           }}
             : integrator::Sharing{},
         adaptive ? &*spread : nullptr);
    if (adaptive && !reuse && each >= mark) reuse.emplace(*spread, renderer.rays());
  }

  // The rest where the pixels of the other colour find noise.
  if (adaptive && !result.partial) {
    const double paths = static_cast<double>(each) * replicates * film.width() * film.height();
    const double path_rays = static_cast<double>(renderer.rays()) / paths - .5;
    const auto map = [&](int color) {
      return integrator::NoiseMap(film, color, each, early, pairs ? &*spread : nullptr, path_rays);
    };
    integrator::NoiseMap black = map(0), white = map(1);
    early.clear();
    // Mean samples of a replicate in the end, as each color decides.
    std::array<double, 2> last;
    last.fill(static_cast<double>(settings.spp) / replicates);
    if (options.has("noise")) {
      const double most = static_cast<double>(1 << 24) / replicates;
      last = {black.mean_for_noise(options["noise"], most), white.mean_for_noise(options["noise"], most)};
    }
    const integrator::Plan plan(std::move(black), std::move(white));
    const double total = (last[0] + last[1]) / 2 * replicates;
    integrator::Plan::Levels level{0, 0};
    while (done < total * (1 - 1e-9) && !result.partial && since(render_start) < limit) {
      const double elapsed = since(render_start);
      const double count =
          std::min(std::max(next_pass(done, total, elapsed, limit - elapsed), 1.), total - done);
      const double share = (done + count - each * replicates) / (total - each * replicates);
      const integrator::Plan::Levels before = level;
      std::array<double, 2> now;
      for (const size_t color : {0, 1}) now[color] = each + share * (last[color] - each);
      level = plan.levels_of_mean(now);
      pass([&](int x, int y, int) { return plan.count(x, y, before); },
           [&](int x, int y, int) { return plan.count(x, y, level); }, count, total,
           {each, each / step,
            [&](int x, int y) {
              return integrator::Technique{plan.together(x, y), reuse && reuse->at(x, y)};
            }},
           nullptr);
    }
  }
  if (adaptive) {  // without noise anywhere it stays with the pilot
    double samples = 0;
    for (int y = 0; y < film.height(); ++y)
      for (int x = 0; x < film.width(); ++x) samples += static_cast<double>(film.samples(x, y));
    result.samples = static_cast<int>(std::lround(samples / (film.width() * film.height())));
  }
  result.render_seconds = since(render_start);
  result.rays = renderer.rays();
  result.rejected = film.rejected();
  result.noise = film.noise();
  if (options.has("time"))
    options.render.spp = std::max(1, result.samples);  // what was done stands for what was asked
  if (result.partial && result.rays == 0)
    base::fail(result.out, ": stopped before the first sample; nothing was written");
  write_picture(options, scene, renderer, film, parts, result.samples, result.partial);

  if (options.has("noise"))
    console.say(result.out + ": noise " + std::to_string(result.noise) + ", wanted " + options.text("noise") +
                (result.noise <= options["noise"].get<double>() ? ": reached" : ": not reached"));
  if (options.has("time")) console.say(result.out + ": stopped by the clock, so not reproducible");

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
