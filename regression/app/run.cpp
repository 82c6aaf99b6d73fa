#include "app/run.h"

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <map>

#include "app/lobes.h"
#include "app/quick.h"
#include "app/results.h"
#include "base/error.h"
#include "image/io.h"

namespace app {
namespace {

namespace fs = std::filesystem;
using suite::Verdict;

// What a job of a batch is for.
struct Purpose {
  std::size_t a_case;
  int witness;  // index, or -1: the case's own picture
};

class Run {
 public:
  explicit Run(const RunOptions& options) : options_(options), layout_(options.layout) {}

  RunResult all() {
    prepare();
    first_batch();
    for (int look = 1; look <= 2; ++look) fresh_batch(look);
    explain_pending();
    for (std::size_t i = 0; i < result_.cases.size(); ++i) settle(i);
    sign_pending();
    result_.orphans = golden::orphans(layout_);
    result_.exit_code = result_.orphans.empty() ? 0 : 1;
    for (const CaseOutcome& c : result_.cases)
      result_.exit_code = std::max(result_.exit_code, c.exit_code(options_.require_witnesses));
    return std::move(result_);
  }

 private:
  // Reads all case files and what is stored; whatever is wrong with one of them is the verdict of that case
  // alone.
  void prepare() {
    result_.cases.resize(options_.names.size());
    goldens_.resize(options_.names.size());
    stored_.resize(options_.names.size());
    jobs_left_.assign(options_.names.size(), 0);
    settled_.assign(options_.names.size(), false);
    for (std::size_t i = 0; i < options_.names.size(); ++i) {
      CaseOutcome& outcome = result_.cases[i];
      outcome.name = options_.names[i];
      fs::remove(layout_.result_file(outcome.name));
      fs::remove(layout_.pending_file(outcome.name));
      try {
        suite::Case c = suite::read_case(layout_, outcome.name);
        outcome.hashes = suite::hashes_of(layout_, c);
        for (const suite::Witness& w : c.witnesses) outcome.witnesses.push_back({w, {}, {}, {}, {}});
        outcome.a_case = std::move(c);
      } catch (const base::Error& error) {
        say(outcome, Verdict::error, error.what());
        continue;
      }
      read_golden(i);
      for (std::size_t w = 0; w < outcome.witnesses.size(); ++w) read_witness(i, w);
    }
  }

  static void say(CaseOutcome& outcome, Verdict verdict, const std::string& reason) {
    outcome.golden.verdict = verdict;
    outcome.golden.reason = reason;
    outcome.golden.wants_fresh = false;
  }

  void read_golden(std::size_t i) {
    CaseOutcome& outcome = result_.cases[i];
    const std::string file = layout_.golden_file(outcome.name);
    if (!fs::exists(file)) return say(outcome, Verdict::broken, "golden missing: " + file);
    outcome.golden_file = file;
    try {
      suite::Golden golden = golden::read(file);
      outcome.golden_header = golden.render.header;
      const std::string fault = suite::golden_fault(*outcome.a_case, outcome.hashes, golden);
      if (!fault.empty()) say(outcome, Verdict::broken, fault);
      golden_sound_[i] = fault.empty();
      goldens_[i] = std::move(golden);
    } catch (const base::Error& error) {
      say(outcome, Verdict::broken, std::string("golden damaged: ") + error.what());
    }
  }

  void read_witness(std::size_t i, std::size_t w) {
    CaseOutcome& outcome = result_.cases[i];
    WitnessOutcome& witness = outcome.witnesses[w];
    const suite::Case& c = *outcome.a_case;
    stored_[i].resize(outcome.witnesses.size());
    witness.result.label = witness.entry.label;
    const auto broken = [&](const std::string& reason) {
      witness.result.verdict = Verdict::broken;
      witness.result.reason = reason;
      witness_ready_[{i, w}] = false;
    };
    witness_ready_[{i, w}] = true;
    if (witness.entry.kind != suite::WitnessKind::analytic) {
      const std::string file = layout_.witness_file(c, witness.entry);
      if (!fs::exists(file)) return broken("stored picture missing: " + file);
      witness.stored_file = file;
      try {
        stored_[i][w] = image::read_render(file);
        const std::string fault = suite::witness_fault(c, witness.entry, outcome.hashes,
                                                       script_hash(witness.entry.kind), *stored_[i][w]);
        if (!fault.empty()) return broken(file + ": " + fault);
      } catch (const base::Error& error) {
        return broken(error.what());
      }
    }
    // A renderer that cannot be asked cannot be compared.
    const bool other_shader = witness.entry.shader != c.shader;
    const bool other_depth = witness.entry.depth != c.depth;
    for (const auto& [other, word] : {std::pair(other_shader, "shader"), std::pair(other_depth, "depth")})
      if (other && !options_.renderer.understands(word)) {
        broken(std::string("the renderer command has no {") + word + "}");
        witness.result.verdict = Verdict::skipped;
        return;
      }
  }

  const std::string& script_hash(suite::WitnessKind kind) {
    auto [entry, is_new] = script_hashes_.try_emplace(kind);
    if (is_new) entry->second = suite::script_hash(layout_.witness_folder(kind));
    return entry->second;
  }

  // Every case's own picture, and those its witnesses need besides.
  void first_batch() {
    std::vector<suite::Job> jobs;
    std::vector<Purpose> purposes;
    for (std::size_t i = 0; i < result_.cases.size(); ++i) {
      const CaseOutcome& outcome = result_.cases[i];
      if (!outcome.a_case) continue;
      jobs.push_back(job_of(layout_, *outcome.a_case));
      purposes.push_back({i, -1});
      for (std::size_t w = 0; w < outcome.witnesses.size(); ++w) {
        const suite::Witness& entry = outcome.witnesses[w].entry;
        if (!witness_ready_[{i, w}] || !suite::needs_own_render(*outcome.a_case, entry)) continue;
        jobs.push_back(witness_job(*outcome.a_case, entry));
        purposes.push_back({i, static_cast<int>(w)});
      }
    }
    for (const Purpose& p : purposes) ++jobs_left_[p.a_case];
    std::size_t done = 0;
    options_.renderer.run(jobs, scratch(), [&](std::size_t j, const suite::Outcome& rendered) {
      const Purpose& purpose = purposes[j];
      CaseOutcome& outcome = result_.cases[purpose.a_case];
      progress("rendered " + std::to_string(++done) + " of " + std::to_string(jobs.size()) + ": " +
               outcome.name);
      outcome.seconds += rendered.seconds;
      if (purpose.witness < 0)
        own_picture(purpose.a_case, jobs[j], rendered);
      else
        witness_picture(purpose.a_case, static_cast<std::size_t>(purpose.witness), jobs[j], rendered);
      if (--jobs_left_[purpose.a_case] == 0 && !unfinished(outcome)) settle(purpose.a_case);
    });
  }

  suite::Job witness_job(const suite::Case& c, const suite::Witness& entry) const {
    suite::Job job = job_of(layout_, c);
    job.out = fs::absolute(layout_.render_file(c.name + "." + entry.label)).string();
    job.shader = entry.shader;
    job.depth = entry.depth;
    if (entry.quantity == "position" || entry.quantity == "normal") {
      // Layers are first hits through the pixels' centres, so samples and light do not matter. A template's
      // renderer knows no layers and is asked for the shader of that name.
      job.layers = entry.quantity + ",depth";
      job.spp = job.replicates;
      if (!options_.renderer.is_template()) job.shader = c.shader, job.depth = 0;
    }
    return job;
  }

  // The picture of a job, or why there is none, or why it is no good.
  std::optional<image::Render> take(const suite::Case& c, const suite::Job& job,
                                    const suite::Outcome& rendered, Verdict& verdict, std::string& reason) {
    verdict = Verdict::error;
    reason = rendered.error;
    if (!rendered.ok) return std::nullopt;
    try {
      image::Render render = read_job(options_.renderer, job, scratch());
      verdict = Verdict::broken;
      reason = suite::data_fault(c, render);
      if (!reason.empty()) return std::nullopt;
      return render;
    } catch (const base::Error& error) {
      reason = error.what();
      return std::nullopt;
    }
  }

  void own_picture(std::size_t i, const suite::Job& job, const suite::Outcome& rendered) {
    CaseOutcome& outcome = result_.cases[i];
    const suite::Case& c = *outcome.a_case;
    Verdict verdict;
    std::string reason;
    const std::optional<image::Render> render = take(c, job, rendered, verdict, reason);
    if (rendered.ok) outcome.render_file = job.out;
    if (!render) {
      say(outcome, verdict, reason);
      for (std::size_t w = 0; w < outcome.witnesses.size(); ++w)
        if (witness_ready_[{i, w}] && !suite::needs_own_render(c, outcome.witnesses[w].entry))
          witness_failed(outcome.witnesses[w], verdict, reason);
      return;
    }
    outcome.render_header = render->header;
    if (golden_sound_[i]) {
      outcome.golden = suite::judge_own_seed(c, *goldens_[i], *render);
      if (!outcome.golden.flip_map.empty())
        outcome.map_file = write_map(outcome.name + ".flip", outcome.golden.flip_map);
    }
    // An identical picture is worth a new golden only if the old one lacks what was added since.
    const bool wanted = outcome.golden.verdict != Verdict::identical || goldens_[i]->quick_hash.empty() ||
                        !goldens_[i]->knows_lobes;
    if (wanted && !options_.judge_only) {
      golden::write_pending(layout_, c, outcome.hashes, *render, goldens_[i]);
      outcome.pending_file = layout_.pending_file(c.name);
    }
    for (std::size_t w = 0; w < outcome.witnesses.size(); ++w)
      if (witness_ready_[{i, w}] && !suite::needs_own_render(c, outcome.witnesses[w].entry))
        witness_speaks(i, w, job.out, *render);
  }

  void witness_picture(std::size_t i, std::size_t w, const suite::Job& job, const suite::Outcome& rendered) {
    CaseOutcome& outcome = result_.cases[i];
    Verdict verdict;
    std::string reason;
    const std::optional<image::Render> render = take(*outcome.a_case, job, rendered, verdict, reason);
    if (!render) return witness_failed(outcome.witnesses[w], verdict, reason);
    witness_speaks(i, w, job.out, *render);
  }

  static void witness_failed(WitnessOutcome& witness, Verdict verdict, const std::string& reason) {
    witness.result.verdict = verdict;
    witness.result.reason = reason;
    witness.result.passed = false;
  }

  void witness_speaks(std::size_t i, std::size_t w, const std::string& render_file,
                      const image::Render& render) {
    CaseOutcome& outcome = result_.cases[i];
    WitnessOutcome& witness = outcome.witnesses[w];
    const auto& stored = stored_[i][w];
    witness.result =
        suite::judge_witness(*outcome.a_case, witness.entry, render, stored ? &*stored : nullptr);
    witness.render_file = render_file;
    if (!witness.result.error_map.empty())
      witness.map_file = write_map(outcome.name + "." + witness.entry.label, witness.result.error_map);
  }

  // Stage 2 for whoever needs it: a fresh seed, the second time with four times the samples.
  void fresh_batch(int look) {
    std::vector<suite::Job> jobs;
    std::vector<std::size_t> owners;
    for (std::size_t i = 0; i < result_.cases.size(); ++i) {
      const CaseOutcome& outcome = result_.cases[i];
      if (!outcome.golden.wants_fresh) continue;
      suite::Job job = job_of(layout_, *outcome.a_case);
      job.seed = suite::fresh_seed(job.seed, look);
      job.layers.clear();
      job.out = fs::absolute(layout_.render_file(outcome.name + (look == 1 ? ".fresh" : ".fresh4"))).string();
      if (look > 1) job.spp *= 4, job.timeout_s *= 4;
      jobs.push_back(job);
      owners.push_back(i);
    }
    if (jobs.empty()) return;
    options_.renderer.run(jobs, scratch(), [&](std::size_t j, const suite::Outcome& rendered) {
      const std::size_t i = owners[j];
      CaseOutcome& outcome = result_.cases[i];
      progress("fresh seed " + std::to_string(j + 1) + " of " + std::to_string(jobs.size()) + ": " +
               outcome.name);
      outcome.seconds += rendered.seconds;
      Verdict verdict;
      std::string reason;
      const std::optional<image::Render> fresh = take(*outcome.a_case, jobs[j], rendered, verdict, reason);
      if (fresh) {
        outcome.fresh_file = jobs[j].out;
        suite::judge_fresh_seed(outcome.golden, *outcome.a_case, *goldens_[i], *fresh);
      } else {
        say(outcome, verdict, "fresh seed: " + reason);
      }
      if (!unfinished(outcome)) settle(i);
    });
  }

  // Cases that may still get another verdict, or a better reason.
  static bool unfinished(const CaseOutcome& outcome) {
    return outcome.golden.wants_fresh || outcome.golden.verdict == Verdict::changed;
  }

  // What may become a golden carries the means of its lobes; what CHANGED tells which of them moved.
  void explain_pending() {
    lobes_ = lobes_of(options_, pending_cases());
    for (std::size_t i = 0; i < result_.cases.size(); ++i) {
      const auto now = lobes_.find(result_.cases[i].name);
      suite::GoldenResult& golden = result_.cases[i].golden;
      if (golden.verdict != Verdict::changed || now == lobes_.end()) continue;
      const std::string moved = suite::moved_lobes(goldens_[i]->lobes, now->second);
      if (!moved.empty()) golden.reason += "; " + moved;
    }
  }

  std::vector<suite::Case> pending_cases() const {
    std::vector<suite::Case> cases;
    for (const CaseOutcome& c : result_.cases)
      if (!c.pending_file.empty()) cases.push_back(*c.a_case);
    return cases;
  }

  // What may become a golden carries the hash of its first samples.
  void sign_pending() {
    const std::vector<suite::Case> cases = pending_cases();
    if (cases.empty()) return;
    const auto hashes = quick_hashes(options_, cases);
    for (const suite::Case& c : cases)
      if (const auto hash = hashes.find(c.name); hash != hashes.end())
        golden::sign(layout_, c, hash->second, lobes_[c.name]);
  }

  // The verdict stands: write it down and tell.
  void settle(std::size_t i) {
    if (settled_[i]) return;
    settled_[i] = true;
    CaseOutcome& outcome = result_.cases[i];
    if (!outcome.pending_file.empty())
      outcome.accept_command =
          options_.program + " accept " + outcome.name + options_.accept_options + " --because \"…\"";
    write_result(options_, outcome);
    if (options_.on_case) options_.on_case(outcome);
  }

  std::string write_map(const std::string& name, const image::Image& map) const {
    std::string file = layout_.build + "/results/" + name + ".exr";
    app::write_map(file, map);
    return file;
  }
  std::string scratch() const { return layout_.build + "/renders"; }
  void progress(const std::string& line) const {
    if (options_.on_progress) options_.on_progress(line);
  }

  const RunOptions& options_;
  const suite::Layout& layout_;
  RunResult result_;
  std::vector<std::optional<suite::Golden>> goldens_;
  std::map<std::size_t, bool> golden_sound_;
  std::map<std::string, std::vector<suite::LobeMean>> lobes_;
  std::vector<std::vector<std::optional<image::Render>>> stored_;
  std::map<std::pair<std::size_t, std::size_t>, bool> witness_ready_;
  std::map<suite::WitnessKind, std::string> script_hashes_;
  std::vector<int> jobs_left_;
  std::vector<bool> settled_;
};

}  // namespace

bool CaseOutcome::passed(bool require_witnesses) const { return exit_code(require_witnesses) == 0; }

int CaseOutcome::exit_code(bool require_witnesses) const {
  int code = suite::exit_code(golden.verdict);
  for (const WitnessOutcome& w : witnesses) {
    if (w.result.passed || (w.result.verdict == Verdict::skipped && !require_witnesses)) continue;
    code = std::max({code, 1, suite::exit_code(w.result.verdict)});
  }
  return code;
}

RunResult run(const RunOptions& options) {
  const auto start = std::chrono::steady_clock::now();
  RunOptions rest = options;
  std::vector<std::string> same;
  if (options.quick) {
    same = quickly_identical(options);
    std::erase_if(rest.names, [&](const std::string& name) {
      return std::find(same.begin(), same.end(), name) != same.end();
    });
  }
  RunResult result = Run(rest).all();
  result.quick = std::move(same);
  result.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  write_run(options, result);
  return result;
}

}  // namespace app
