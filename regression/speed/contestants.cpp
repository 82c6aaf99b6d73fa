#include "speed/contestants.h"

#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <set>
#include <utility>

#include "base/error.h"
#include "image/io.h"
#include "suite/process.h"

namespace speed {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

std::string quoted(const std::string& word) { return "'" + word + "'"; }

std::string our_renderer(const std::string& build) {
  for (const fs::path& path : {fs::read_symlink("/proc/self/exe").parent_path() / "assay-render",
                               fs::path(build) / "bin" / "assay-render"})
    if (access(path.c_str(), X_OK) == 0) return path.string();
  base::fail_in("renderer", "", "assay-render beside this program or in " + build + "/bin", "neither");
}

bool knows_option(const std::string& program, const std::string& option) {
  bool found = false;
  suite::run_process({program, "--help"}, 60, [&](const std::string& line) {
    found |= line.find(option) != std::string::npos;
    return 0.;
  });
  return found;
}

bool blender_is_there() {
  const char* named = std::getenv("ASSAY_BLENDER");
  return suite::run_process({named ? named : "blender", "--version"}, 60).ok();
}

double number(const json& object, const char* key, double otherwise = 0) {
  const auto found = object.find(key);
  return found != object.end() && found->is_number() ? found->get<double>() : otherwise;
}

}  // namespace

std::vector<Contestant> default_contestants(const std::string& suite, const std::string& build) {
  const std::string program = our_renderer(build);
  const std::string command =
      quoted(program) +
      " {scene} -o {out} --width {width} --height {height} --spp {spp} --seed {seed} "
      "--depth {depth} --threads {threads} --shader principled --max-memory 16 --json --quiet";
  std::vector<Contestant> all;
  Contestant assay{"assay", "assay", true, 4, 256, 64, suite::RendererCommand::from_template(command + " --replicates 1"),
                   {},      {}};
  all.push_back(assay);
  if (knows_option(program, "--adaptive ")) {
    assay.name = "assay adaptive", assay.is_reference = false;
    assay.command = suite::RendererCommand::from_template(command + " --replicates 1 --adaptive");
    assay.first = 16;  // the least that it takes
    all.push_back(assay);
  }
  if (!blender_is_there()) return all;
  Contestant cycles{"cycles", "cycles", true, 4, 128, 64, {}, {}, {{"adaptive", false}}};
  cycles.worker = {"/usr/bin/python3", suite + "/speed/cycles/worker.py"};
  all.push_back(cycles);
  // With its default threshold, .01, Cycles first looks after 64 samples: before that the two are one.
  cycles.name = "cycles adaptive", cycles.is_reference = false, cycles.settings["adaptive"] = true;
  cycles.first = 128, cycles.last = 256, cycles.compared_at = 256;
  all.push_back(cycles);
  return all;
}

Contestant custom_contestant(const std::string& text) {
  const std::size_t equals = text.find('=');
  if (equals == 0 || equals == std::string::npos || equals + 1 == text.size())
    base::fail_in("--renderer", "", "NAME='CMD {scene} {out} …'", "'" + text + "'");
  Contestant contestant;
  contestant.name = contestant.family = text.substr(0, equals);
  contestant.is_reference = true;
  contestant.command = suite::RendererCommand::from_template(text.substr(equals + 1));
  for (const char* needed : {"width", "height", "spp", "seed"})
    if (!contestant.command->understands(needed))
      base::fail_in("--renderer", contestant.name, std::string("{") + needed + "} in the command",
                    text.substr(equals + 1));
  return contestant;
}

Shot Runner::render(const Contestant& contestant, const Order& order, double timeout_s) {
  fs::create_directories(scratch_);
  const std::string out = scratch_ + "/" + contestant.family + ".exr";
  fs::remove(out);
  const int threads = order.threads > 0 ? order.threads : static_cast<int>(sysconf(_SC_NPROCESSORS_ONLN));
  json answer = json::object();
  Shot shot;
  if (contestant.command) {
    suite::Job job;
    job.scene = order.scene, job.out = out, job.shader = "principled";
    job.width = job.height = order.size;
    job.spp = order.spp, job.seed = static_cast<std::uint32_t>(order.seed), job.depth = order.depth;
    job.replicates = 1;
    suite::RendererCommand command = *contestant.command;
    command.set_threads(threads);
    const suite::ProcessEnd end =
        suite::run_process(command.arguments(job), timeout_s, [&](const std::string& line) {
          const json parsed = json::parse(line, nullptr, false);
          if (parsed.is_object()) answer = parsed;
          return 0.;
        });
    if (!end.ok()) base::fail(contestant.name, ": ", order.scene, ": ", end.reason());
    shot.process_seconds = end.seconds, shot.peak_mb = end.peak_mb;
  } else {
    std::unique_ptr<Worker>& worker = workers_[contestant.worker];
    if (!worker) worker = std::make_unique<Worker>(contestant.worker);
    json job = contestant.settings;
    job.update({{"scene", order.scene},
                {"out", out},
                {"width", order.size},
                {"height", order.size},
                {"spp", order.spp},
                {"seed", order.seed},
                {"depth", order.depth},
                {"threads", threads}});
    answer = worker->ask(job, timeout_s);
    if (answer.value("ok", false) != true)
      base::fail(contestant.name, ": ", order.scene, ": ",
                 answer.value("error", std::string("no reason given")));
    shot.peak_mb = number(answer, "rss_mb");
  }
  shot.render_seconds = number(answer, "render_seconds", shot.process_seconds);
  shot.build_seconds = number(answer, "build_seconds");
  shot.load_seconds = number(answer, "load_seconds");
  shot.rays = number(answer, "rays");
  if (!fs::is_regular_file(out)) base::fail(contestant.name, ": ", order.scene, ": wrote no picture");
  shot.picture = image::read_render(out).mean;
  return shot;
}

}  // namespace speed
