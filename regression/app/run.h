// A run of the suite: everything from case names to results on disk. One process of the renderer takes all
// cases; fresh seeds and four times the samples are a second and a third batch, for the cases that need them.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "golden/golden.h"
#include "suite/case_file.h"
#include "suite/judge.h"
#include "suite/renderer_command.h"
#include "suite/witness_judge.h"

namespace app {

// What became of one witness entry of one case.
struct WitnessOutcome {
  suite::Witness entry;
  suite::WitnessResult result;
  std::string render_file, stored_file, map_file;  // empty: there is none
};

// What became of one case.
struct CaseOutcome {
  std::string name;
  std::optional<suite::Case> a_case;  // absent: its file is bad
  suite::Hashes hashes;
  suite::GoldenResult golden;  // verdict and reason even if nothing could be judged
  std::vector<WitnessOutcome> witnesses;
  double seconds = 0;                                                        // rendering, all batches
  std::string render_file, golden_file, fresh_file, map_file, pending_file;  // empty: there is none
  image::Header render_header, golden_header;
  std::string accept_command;  // empty: nothing that could be accepted

  bool passed(bool require_witnesses) const;
  int exit_code(bool require_witnesses) const;  // the worst of golden and witnesses
};

struct RunOptions {
  suite::Layout layout;
  suite::RendererCommand renderer;
  std::vector<std::string> names;
  bool require_witnesses = false;
  bool judge_only = false;                        // no pending pictures, no lobes of what CHANGED
  bool quick = false;                             // cases whose first samples are the golden's need no more
  std::string program = "assay", accept_options;  // as the accept command should be typed
  std::function<void(const CaseOutcome&)> on_case = {};      // as soon as its verdict stands
  std::function<void(const std::string&)> on_progress = {};  // "rendering 3 of 27: cornell"
};

struct RunResult {
  std::vector<CaseOutcome> cases;    // in the order of options.names
  std::vector<std::string> quick;    // the cases that options.quick found identical; not among `cases`
  std::vector<std::string> orphans;  // one line each; any fails the run
  double seconds = 0;
  int exit_code = 2;
};

// Judges and writes build/results/NAME.json for each case, the maps beside them, pending pictures, and
// build/run.json. With options.quick only for the cases whose first samples differ; what is on disk of the
// others stays as it was.
RunResult run(const RunOptions& options);

// The job that makes a case's own picture.
suite::Job job_of(const suite::Layout& layout, const suite::Case& c);

// Reads what a job made. A foreign renderer without variance is run once per replicate with a seed of its
// own, and the spread of those pictures is the variance. Throws base::Error.
image::Render read_job(const suite::RendererCommand& renderer, const suite::Job& job,
                       const std::string& scratch);

}  // namespace app
