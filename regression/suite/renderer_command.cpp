#include "suite/renderer_command.h"

#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <set>

#include "base/error.h"
#include "image/io.h"
#include "suite/process.h"

namespace suite {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

const std::vector<std::string> known_placeholders = {
    "scene", "out", "width", "height", "spp", "seed", "depth", "shader", "camera", "replicates", "threads"};

// The names in braces of a template, whether known or not.
std::set<std::string> placeholders(const std::vector<std::string>& words) {
  std::set<std::string> names;
  for (const std::string& word : words)
    for (size_t open = word.find('{'); open != std::string::npos; open = word.find('{', open + 1))
      if (const size_t close = word.find('}', open); close != std::string::npos)
        names.insert(word.substr(open + 1, close - open - 1));
  return names;
}

void prepare(const Job& job) {
  fs::create_directories(fs::path(job.out).parent_path());
  fs::remove(job.out);
}

// A job is done when the renderer says so *and* there is a file.
Outcome finished(const Job& job, double seconds) {
  if (fs::is_regular_file(job.out)) return {true, "", seconds};
  return {false, "the renderer reported success but wrote no " + job.out, seconds};
}

std::string one_line(std::string text) {
  for (char& c : text)
    if (static_cast<unsigned char>(c) < 0x20) c = ' ';
  return text;
}

}  // namespace

RendererCommand RendererCommand::ours(const std::string& build) {
  const fs::path beside = fs::read_symlink("/proc/self/exe").parent_path() / "assay-render";
  const fs::path in_build = fs::path(build) / "bin" / "assay-render";
  RendererCommand command;
  for (const fs::path& candidate : {beside, in_build})
    if (command.program_.empty() && access(candidate.c_str(), X_OK) == 0)
      command.program_ = candidate.string();
  if (command.program_.empty())
    base::fail_in("renderer", "", beside.string() + " or " + in_build.string() + " (or --renderer 'CMD …')",
                  "neither");
  return command;
}

RendererCommand RendererCommand::from_template(const std::string& text) {
  RendererCommand command;
  command.template_ = split_command(text);
  const std::set<std::string> used = placeholders(command.template_);
  for (const std::string& name : used)
    if (std::find(known_placeholders.begin(), known_placeholders.end(), name) == known_placeholders.end())
      base::fail_in("--renderer", "{" + name + "}",
                    "one of {scene} {out} {width} {height} {spp} {seed} {shader} {depth} {camera} "
                    "{replicates} {threads}",
                    "{" + name + "}");
  for (const char* needed : {"scene", "out"})
    if (!used.count(needed))
      base::fail_in("--renderer", "", std::string("{") + needed + "} in the command", text);
  return command;
}

bool RendererCommand::understands(const std::string& placeholder) const {
  return !is_template() || placeholders(template_).count(placeholder) != 0;
}

std::string RendererCommand::text() const {
  if (!is_template()) return program_ + " --batch JOBS --json --quiet";
  std::string all;
  for (const std::string& word : template_) all += (all.empty() ? "" : " ") + word;
  return all;
}

std::vector<std::string> RendererCommand::arguments(const Job& job) const {
  const std::map<std::string, std::string> values = {{"scene", job.scene},
                                                     {"out", job.out},
                                                     {"shader", job.shader},
                                                     {"width", std::to_string(job.width)},
                                                     {"height", std::to_string(job.height)},
                                                     {"spp", std::to_string(job.spp)},
                                                     {"seed", std::to_string(job.seed)},
                                                     {"depth", std::to_string(job.depth)},
                                                     {"camera", std::to_string(job.camera)},
                                                     {"replicates", std::to_string(job.replicates)},
                                                     {"threads", std::to_string(threads_)}};
  std::vector<std::string> words;
  for (const std::string& word : template_) {
    std::string filled;
    for (size_t i = 0; i < word.size();) {
      const size_t close = word[i] == '{' ? word.find('}', i) : std::string::npos;
      if (close == std::string::npos) {
        filled += word[i++];
      } else {
        filled += values.at(word.substr(i + 1, close - i - 1));
        i = close + 1;
      }
    }
    words.push_back(filled);
  }
  return words;
}

std::vector<Outcome> RendererCommand::run(const std::vector<Job>& jobs, const std::string& scratch,
                                          const OnOutcome& on_outcome) const {
  if (jobs.empty()) return {};
  for (const Job& job : jobs) prepare(job);
  if (!is_template()) return run_batch(jobs, scratch, on_outcome);
  std::vector<Outcome> outcomes;
  for (size_t i = 0; i < jobs.size(); ++i) {
    const ProcessEnd end = run_process(arguments(jobs[i]), jobs[i].timeout_s);
    outcomes.push_back(end.ok() ? finished(jobs[i], end.seconds)
                                : Outcome{false, "renderer " + one_line(end.reason()), end.seconds});
    if (on_outcome) on_outcome(i, outcomes.back());
  }
  return outcomes;
}

std::vector<Outcome> RendererCommand::run_batch(const std::vector<Job>& jobs, const std::string& scratch,
                                                const OnOutcome& on_outcome) const {
  std::vector<Outcome> outcomes(jobs.size());
  std::vector<bool> done(jobs.size(), false);
  std::map<std::string, size_t> by_file;
  for (size_t i = 0; i < jobs.size(); ++i) by_file[jobs[i].out] = i;
  const auto settle = [&](size_t i, const Outcome& outcome) {
    outcomes[i] = outcome, done[i] = true;
    if (on_outcome) on_outcome(i, outcome);
  };

  // A process that dies takes one job with it; the others get another one. Three in a row that finish
  // nothing: the renderer itself is at fault, and no further process is started.
  int barren = 0;
  for (;;) {
    std::vector<size_t> open;
    for (size_t i = 0; i < jobs.size(); ++i)
      if (!done[i]) open.push_back(i);
    if (open.empty()) return outcomes;

    json list = json::array();
    for (size_t i : open) {
      const Job& job = jobs[i];
      json entry = job.options;
      entry.update({{"scene", job.scene},
                    {"out", job.out},
                    {"width", job.width},
                    {"height", job.height},
                    {"spp", job.spp},
                    {"replicates", job.replicates},
                    {"seed", job.seed},
                    {"depth", job.depth},
                    {"camera", job.camera},
                    {"shader", job.shader}});
      if (!job.layers.empty()) entry["layers"] = job.layers;
      if (threads_ > 0) entry["threads"] = threads_;
      list.push_back(entry);
    }
    const std::string text = json{{"jobs", list}}.dump(1);
    const std::string list_file = scratch + "/jobs.json";
    image::write_file(list_file, text.data(), text.size());

    size_t finished_here = 0;
    const ProcessEnd end = run_process(
        {program_, "--batch", list_file, "--json", "--quiet"}, jobs[open.front()].timeout_s,
        [&](const std::string& line) {
          const json report = json::parse(line, nullptr, false);
          if (!report.is_object() || !report.contains("out") || !report["out"].is_string()) return 0.;
          const auto found = by_file.find(report["out"].get<std::string>());
          if (found == by_file.end() || done[found->second]) return 0.;
          const size_t i = found->second;
          const double seconds = report.contains("seconds") && report["seconds"].is_number()
                                     ? report["seconds"].get<double>()
                                     : 0.;
          const bool ok = report.contains("ok") && report["ok"] == true;
          const std::string error = report.contains("error") && report["error"].is_string()
                                        ? report["error"].get<std::string>()
                                        : "no reason given";
          settle(i,
                 ok ? finished(jobs[i], seconds) : Outcome{false, "renderer: " + one_line(error), seconds});
          ++finished_here;
          const auto next = std::find(done.begin(), done.end(), false);
          return next == done.end() ? 10. : jobs[static_cast<size_t>(next - done.begin())].timeout_s;
        });

    const auto next = std::find(done.begin(), done.end(), false);
    if (next == done.end()) return outcomes;
    const size_t culprit = static_cast<size_t>(next - done.begin());
    const std::string reason =
        end.ok() ? "renderer ended without a word about this job" : "renderer " + one_line(end.reason());
    barren = finished_here ? 0 : barren + 1;
    settle(culprit, {false, reason, end.timed_out ? jobs[culprit].timeout_s : 0});
    if (barren == 3 || !end.start_error.empty())
      for (size_t i = 0; i < jobs.size(); ++i)
        if (!done[i]) settle(i, {false, reason + " (not tried again: it finished no job)", 0});
  }
}

}  // namespace suite
