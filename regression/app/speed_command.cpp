// `assay speed`: measures speed against error, and writes build/speed/index.html and a section of
// docs/speed.md. What was measured is kept in build/speed/results.json after every round, so an interrupted
// run loses little.
#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <memory>
#include <sstream>

#include "app/command_parts.h"
#include "app/study.h"
#include "base/error.h"
#include "image/io.h"
#include "speed/measure.h"
#include "speed/page.h"
#include "speed/series.h"
#include "suite/process.h"

namespace app {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

struct SpeedArguments {
  Common common;
  std::string pattern, write_file, command;
  std::vector<std::string> renderers;
  speed::Plan plan;
  bool page_only = false, without_defaults = false;
  double bias = 0;  // percent; 0: not asked for
};

json read_json(const std::string& file) {
  std::ifstream stream(file);
  if (!stream) base::fail_in(file, "", "a file that can be read", "none");
  const json value = json::parse(stream, nullptr, false);
  if (!value.is_object()) base::fail_in(file, "", "a JSON object", "something else");
  return value;
}

std::string read_text(const std::string& file) {
  std::ifstream stream(file, std::ios::binary);
  std::ostringstream text;
  text << stream.rdbuf();
  return text.str();
}

void write_json(const std::string& file, const json& value) {
  const std::string text = value.dump(1) + "\n";
  image::write_file(file, text.data(), text.size());
}

// One `assay speed`, from the manifest to the page.
class Session {
 public:
  explicit Session(SpeedArguments a)
      : a_(std::move(a)),
        layout_(a_.common.layout()),
        folder_(layout_.build + "/speed"),
        manifest_(read_json(layout_.root + "/speed/scenes.json")),
        runner_(folder_ + "/scratch") {
    const std::string kept = folder_ + "/results.json";
    if ((a_.page_only || a_.bias > 0 || !a_.pattern.empty()) && fs::exists(kept)) all_ = read_json(kept);
    for (const char* part : {"scenes", "series", "what"})
      if (!all_.contains(part)) all_[part] = json::object();
    if (!all_.contains("command")) all_["command"] = a_.command;
  }

  int run() {
    if (!a_.page_only) measure();
    page();
    std::cout << folder_ << "/index.html\n";
    return failed_ ? 2 : 0;
  }

 private:
  bool selected(const std::string& name) const {
    return a_.pattern.empty() || suite::matches(a_.pattern, name);
  }

  void measure() {
    std::vector<std::string> names;
    for (const json& scene : manifest_["scenes"]) names.push_back(scene["name"]);
    for (const json& series : manifest_["series"])
      names.push_back("growth_" + series["name"].get<std::string>());
    names.push_back("small");
    if (std::none_of(names.begin(), names.end(), [&](const std::string& name) { return selected(name); })) {
      std::string list;
      for (const std::string& name : names) list += (list.empty() ? "" : ", ") + name;
      base::fail_in("-k", "", "a pattern that one of " + list + " has", "'" + a_.pattern + "'");
    }
    if (!a_.without_defaults) contestants_ = speed::default_contestants(layout_.root, layout_.build);
    for (const std::string& text : a_.renderers) {
      contestants_.push_back(speed::custom_contestant(text));
      for (std::size_t i = 0; i + 1 < contestants_.size(); ++i)
        if (contestants_[i].name == contestants_.back().name)
          base::fail_in("--renderer", "", "a name of its own", contestants_.back().name);
    }
    if (contestants_.empty()) base::fail("--only-given: wanted --renderer NAME='CMD …' with it, found none");
    const std::string ours = a_.without_defaults ? "" : speed::command_line(contestants_[0], {}, "")[0];
    if (a_.bias == 0) all_["machine"] = speed::machine(ours);

    for (const json& scene : manifest_["scenes"]) {
      const std::string name = scene["name"], file = scene_file(name);
      if (!selected(name) || !is_made(name, file)) continue;
      attempt(name, [&] {
        if (a_.bias > 0) {
          all_["bias"][name] = speed::measure_bias(file, a_.bias / 100, a_.plan, contestants_, runner_);
          return;
        }
        json result =
            speed::measure_scene(name, file, a_.plan, contestants_, runner_, [&](const json& so_far) {
              all_["scenes"][name] = so_far, all_["what"][name] = scene["what"];
              write_json(folder_ + "/results.json", all_);
              std::cout << name << ": round " << so_far["rounds"] << std::endl;
            });
        if (!ours.empty()) result["profile"] = profile(file);
        all_["scenes"][name] = result;
      });
    }
    for (const json& series : manifest_["series"]) {
      const std::string name = series["name"];
      if (a_.bias > 0 || !selected("growth_" + name)) continue;
      attempt("growth_" + name, [&] {
        for (const json& point : series["points"])
          if (!is_made(point["scene"], scene_file(point["scene"]))) return;
        all_["series"][name] =
            speed::measure_series(series, folder_ + "/scenes", a_.plan, contestants_, runner_);
      });
    }
    if (a_.bias == 0 && !a_.without_defaults && selected("small") &&
        is_made("cornell", scene_file("cornell")))
      attempt("small", [&] {
        all_["small"] = speed::measure_small(scene_file("cornell"), ours, contestants_, folder_ + "/scratch");
      });
    fs::remove_all(folder_ + "/scratch");
  }

  // One part: its failure is told and does not stop the others; the page is written after each.
  template <typename Work>
  void attempt(const std::string& name, const Work& work) {
    std::cout << name << std::endl;
    try {
      work();
    } catch (const base::Error& error) {
      complain(error.what());
      failed_ = true;
    }
    runner_.dismiss();
    write_json(folder_ + "/results.json", all_);
    page();
  }

  std::string scene_file(const std::string& name) const { return folder_ + "/scenes/" + name + ".glb"; }

  // Scenes that need what is not installed are left out by scripts/make-speed-scenes, which says so.
  bool is_made(const std::string& name, const std::string& file) {
    if (fs::exists(file)) return true;
    if (!fs::exists(folder_ + "/scenes"))
      base::fail_in(folder_ + "/scenes", "", "the scenes that scripts/make-speed-scenes makes", "none");
    std::cout << name << ": skipped, no " << file << " (scripts/make-speed-scenes)" << std::endl;
    return false;
  }

  json profile(const std::string& file) const {
    speed::Order order;
    order.scene = file, order.size = 2 * a_.plan.size, order.threads = a_.plan.threads;
    const std::string scratch = folder_ + "/scratch";
    return speed::profile(speed::command_line(contestants_[0], order, scratch + "/profile.exr"), scratch);
  }

  void page() const {
    if (all_["scenes"].empty() && all_["series"].empty() && !all_.contains("small"))
      base::fail_in(folder_ + "/results.json", "", "measurements (assay speed)", "none");
    const suite::ProcessEnd plotted = suite::run_process(
        {"/usr/bin/python3", "-B", layout_.root + "/speed/plot.py", folder_ + "/results.json", folder_}, 120);
    if (!plotted.ok()) complain("speed: no plots (apt-get install python3-matplotlib): " + plotted.reason());
    std::vector<std::string> plots;
    for (const char* name : {"error.svg", "growth.svg"})
      if (plotted.ok() && fs::exists(folder_ + "/" + name)) plots.push_back(read_text(folder_ + "/" + name));
    const std::string page = speed::html(all_, plots);
    image::write_file(folder_ + "/index.html", page.data(), page.size());
    if (a_.write_file.empty()) return;
    const std::string images = (fs::path(a_.write_file).parent_path() / "images/speed").string();
    for (const char* name : {"error.svg", "growth.svg"})
      if (fs::exists(folder_ + "/" + name)) {
        fs::create_directories(images);
        fs::copy_file(folder_ + "/" + name, images + "/" + name, fs::copy_options::overwrite_existing);
      }
    write_section(a_.write_file, "speed", speed::markdown(all_, "images/speed"));
  }

  SpeedArguments a_;
  suite::Layout layout_;
  std::string folder_;
  json manifest_, all_ = json::object();
  speed::Runner runner_;
  std::vector<speed::Contestant> contestants_;
  bool failed_ = false;
};

}  // namespace

void add_speed(CLI::App& app, const std::vector<std::string>& arguments, int& code) {
  // Filled in by the parser, after this function has returned.
  const auto a = std::make_shared<SpeedArguments>();
  CLI::App* command = app.add_subcommand("speed", "Speed against error, with Blender Cycles: docs/speed.md");
  add_common(command, a->common);
  command
      ->add_option("-k", a->pattern,
                   "Only scenes, growth_… and small whose name holds PATTERN; the others keep their results")
      ->type_name("PATTERN");
  command->add_option("--seconds-per-scene", a->plan.seconds, "About; more gives more samples and rounds")
      ->check(between(.1, 1e5))
      ->capture_default_str();
  command
      ->add_option(
          "--bias", a->bias,
          "Instead of speed: how far the mean of adaptive pictures is from that of fixed ones, until its "
          "interval at 99.9 % is PERCENT of it or --seconds-per-scene are over; the rest keeps its results")
      ->type_name("PERCENT")
      ->check(between(1e-3, 100));
  command->add_option("--size", a->plan.size, "Pixels across and down")
      ->check(between(8, 4096))
      ->capture_default_str();
  command->add_option("--rounds", a->plan.rounds_min, "At least, with other seeds each")
      ->check(between(2, 64))
      ->capture_default_str();
  command->add_option("-j,--threads", a->plan.threads, "Of each renderer; default: all")
      ->check(between(1, 1024));
  command
      ->add_option("--renderer", a->renderers,
                   "One more contestant: NAME='CMD {scene} {out} {width} {height} {spp} {seed} …'. A line of "
                   "JSON from it with "
                   "render_seconds is its time, else that of the whole process")
      ->type_name("NAME='CMD …'");
  command->add_flag("--only-given", a->without_defaults,
                    "Only the renderers given, neither Assay nor Cycles");
  command->add_option("--write", a->write_file, "Put tables and plots into this page, between its markers")
      ->type_name("FILE.md");
  command->add_flag("--page", a->page_only, "Measure nothing, write the pages again");
  command->footer(
      "Scenes: scripts/make-speed-scenes. Writes speed/index.html and speed/results.json in the build "
      "folder.");
  command->callback([a, &arguments, &code] {
    a->plan.rounds_max = std::max(a->plan.rounds_min, a->plan.rounds_max);
    a->command = "assay";
    for (std::size_t i = 1; i < arguments.size(); ++i) {
      const std::string& word = arguments[i];
      if (word == "--suite" || word == "--build" || word == "--write")
        ++i;
      else if (word != "--page")
        a->command += " " + word;
    }
    code = Session(*a).run();
  });
}

}  // namespace app
