// The accused, as the judge sees it: a command that turns a scene into an EXR. No code is shared with it.
//
// Our own renderer takes all jobs in one process (`assay-render --batch jobs.json --json --quiet`); any other
// is given as a template and started once per job. Whatever it does - crash, hang, write nothing - becomes
// one line in an Outcome.
#pragma once

#include <cstdint>
#include <functional>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace suite {

struct Job {
  std::string scene, out, shader;
  int width = 0, height = 0, spp = 0, replicates = 0, depth = 0, camera = 0;
  std::uint32_t seed = 0;
  nlohmann::json options = nlohmann::json::object();
  std::string layers;  // comma-separated; a template's renderer is not asked for any
  double timeout_s = 60;
};

struct Outcome {
  bool ok = false;
  std::string error;  // one line, if not ok
  double seconds = 0;
};

using OnOutcome = std::function<void(std::size_t job, const Outcome&)>;

class RendererCommand {
 public:
  // assay-render beside the running program, or in `build`/bin. Throws base::Error if there is none.
  static RendererCommand ours(const std::string& build);
  // A template with {scene} {out} and perhaps {width} {height} {spp} {seed} {shader} {depth} {camera}
  // {replicates} {threads}; options of a case are not passed on. Throws base::Error for an unknown or missing
  // placeholder.
  static RendererCommand from_template(const std::string& command);

  // 0: as many as the renderer likes.
  void set_threads(int threads) { threads_ = threads; }

  // The file is removed before each job, so an old picture is never taken for a new one. `scratch` is a
  // folder for the job list.
  std::vector<Outcome> run(const std::vector<Job>& jobs, const std::string& scratch,
                           const OnOutcome& on_outcome = {}) const;

  bool is_template() const { return !template_.empty(); }
  bool understands(const std::string& placeholder) const;  // always true for our own
  std::string text() const;                                // for the provenance
  // A template's words, filled in for this job.
  std::vector<std::string> arguments(const Job& job) const;

 private:
  std::vector<Outcome> run_batch(const std::vector<Job>& jobs, const std::string& scratch,
                                 const OnOutcome&) const;

  std::string program_;
  std::vector<std::string> template_;
  int threads_ = 0;
};

}  // namespace suite
