// The null study: golden, own-seed render and fresh seeds are renders of one scene with unrelated seeds, as
// if a change had drawn other random numbers and left every expectation as it was. Any alarm is false.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <iostream>
#include <sstream>

#include "app/calibrate.h"
#include "app/run.h"
#include "app/study.h"
#include "app/study_pictures.h"
#include "base/error.h"

namespace app {
namespace {

namespace fs = std::filesystem;
using suite::Verdict;

// What a number of trials came to.
struct Tally {
  int trials = 0;
  int paired = 0, pixels = 0, welch = 0, noisier = 0;  // false alarms, by what gave them
  int quieter = 0;                                     // no alarm, but a claim from the same budget
  int low_paired = 0, low_welch = 0, low_green = 0;  // p-values below 1 %: of comparisons, of one single test
  int looks = 0;                                     // comparisons with a fresh seed
  int flip = 0, rmse = 0;                            // limits left, calibrated as assay calibrate does
  int alarms() const { return paired + pixels + welch + noisier + quieter; }
  void add(const Tally& o) {
    trials += o.trials, paired += o.paired, pixels += o.pixels, welch += o.welch, noisier += o.noisier;
    quieter += o.quieter, low_paired += o.low_paired, low_welch += o.low_welch, low_green += o.low_green;
    looks += o.looks, flip += o.flip, rmse += o.rmse;
  }
};

class NullStudy {
 public:
  NullStudy(const StudyOptions& options, const suite::Case& c) : options_(options), case_(c) {
    // The same picture, about as wide as it was high, small.
    const double aspect = static_cast<double>(c.width) / c.height;
    case_.height = std::max(8, static_cast<int>(std::lround(std::sqrt(options.pixels / aspect))));
    case_.width = std::max(8, static_cast<int>(std::lround(case_.height * aspect)));
    case_.replicates = 8;
    case_.spp = std::max(8, options.spp / 8 * 8);
    // Some cases tame their heavy tails; here those are what is wanted.
    case_.options.erase("clamp");
    // The limits of FLIP and RMSE have no stated rate: they are counted apart and must not decide.
    case_.limits = suite::Case::Limits{1, 1e30};
  }

  Tally run(int trials) {
    const double level = options_.level;
    const suite::JudgeOptions judge{level};
    const std::vector<image::Render> calibration = renders(1u << 20, 4, "");
    std::vector<image::Image> means;
    for (const image::Render& r : calibration) means.push_back(r.mean);
    const suite::Case::Limits limits = calibrated_limits(means, 2);
    Tally tally;
    constexpr int together = 250;  // pictures in memory and on disk at a time
    for (int first = 0; first < trials; first += together) {
      const int count = std::min(together, trials - first);
      const auto seed = static_cast<unsigned>(3 * first + 1);
      const std::vector<image::Render> all = renders(seed, 3 * count, "replicates");
      std::vector<suite::GoldenResult> results;
      std::vector<suite::Golden> goldens;
      std::vector<unsigned> undecided;
      for (int i = 0; i < count; ++i) {
        goldens.push_back(as_golden(case_, all[3 * i]));
        results.push_back(suite::judge_own_seed(case_, goldens.back(), all[3 * i + 1], judge));
        ++tally.trials;
        tally.flip += results[i].measures[0].value > limits.flip;
        tally.rmse += results[i].measures[1].value > limits.rmse;
        tally.low_paired += results[i].paired && results[i].paired->smallest_p < .01;
        if (!results[i].wants_fresh) continue;
        suite::judge_fresh_seed(results[i], case_, goldens[i], all[3 * i + 2], judge);
        ++tally.looks;
        tally.low_welch += results[i].welch->smallest_p < .01;
        tally.low_green += results[i].welch->image[metric::green].p < .01;
        if (results[i].wants_fresh) undecided.push_back(static_cast<unsigned>(i));
      }
      // Four times the samples, for those that want them.
      suite::Case more = case_;
      more.spp *= 4;
      std::vector<suite::Job> jobs;
      for (const unsigned i : undecided) jobs.push_back(job(more, (1u << 21) + seed + i, ""));
      const std::vector<image::Render> last = made(jobs);
      for (std::size_t k = 0; k < undecided.size(); ++k)
        suite::judge_fresh_seed(results[undecided[k]], case_, goldens[undecided[k]], last[k], judge);
      for (const suite::GoldenResult& r : results) count_alarms(r, tally);
    }
    return tally;
  }

 private:
  static void count_alarms(const suite::GoldenResult& r, Tally& tally) {
    if (r.verdict == Verdict::broken) base::fail("study null: ", r.reason);
    if (r.paired && r.paired->biased())
      ++tally.paired;
    else if (!r.wrong_pixels.empty())
      ++tally.pixels;
    else if (r.welch && r.welch->biased())
      ++tally.welch;
    else if (r.verdict == Verdict::noisier)
      ++tally.noisier;
    else if (r.verdict == Verdict::quieter)
      ++tally.quieter;
  }

  suite::Job job(const suite::Case& c, unsigned seed, const std::string& layers) const {
    suite::Job j = job_of(options_.layout, c);
    j.seed = seed;
    j.layers = layers;
    j.out = fs::absolute(options_.layout.build + "/study/null/" + c.name + "/" + c.name + "." +
                         std::to_string(seed) + ".exr")
                .string();
    return j;
  }
  std::vector<image::Render> renders(unsigned first_seed, int count, const std::string& layers) const {
    std::vector<suite::Job> jobs;
    for (int i = 0; i < count; ++i) jobs.push_back(job(case_, first_seed + static_cast<unsigned>(i), layers));
    return made(jobs);
  }
  std::vector<image::Render> made(const std::vector<suite::Job>& jobs) const {
    return made_pictures(options_.renderer, jobs, options_.layout.build + "/study/null/" + case_.name);
  }

  const StudyOptions& options_;
  suite::Case case_;
};

std::string share(int found, int of) {
  char text[48];
  std::snprintf(text, sizeof text, found ? "%.2f %%" : "%.0f", of ? 100. * found / of : 0.);
  return text;
}

void row(std::ostream& out, const std::string& name, const Tally& t) {
  out << "| " << name << " | " << t.trials << " | " << t.alarms() << " | " << t.paired << " | " << t.welch
      << " | " << t.noisier + t.quieter << " | " << t.pixels << " | " << share(t.low_green, t.looks) << " | "
      << share(t.low_paired, t.trials) << " | " << share(t.low_welch, t.looks) << " | " << t.flip << " | "
      << t.rmse << " |\n";
}

}  // namespace

int study_null(const StudyOptions& options) {
  const int each =
      (options.trials + static_cast<int>(options.names.size()) - 1) / static_cast<int>(options.names.size());
  std::vector<Tally> tallies(options.names.size());
  for_each_case(options.names.size(), [&](std::size_t i) {
    NullStudy study(options, suite::read_case(options.layout, options.names[i]));
    tallies[i] = study.run(each);
    std::fprintf(stderr, "%s: %d alarms in %d\n", options.names[i].c_str(), tallies[i].alarms(),
                 tallies[i].trials);
  });
  Tally all;
  std::ostringstream table;
  for (std::size_t i = 0; i < tallies.size(); ++i) {
    row(table, "`" + options.names[i] + "`", tallies[i]);
    all.add(tallies[i]);
  }
  const metric::Interval interval = metric::rate_interval(all.alarms(), all.trials);
  const bool refuted = interval.low > options.level;
  char rate[256];
  std::snprintf(
      rate, sizeof rate,
      "%d false alarms in %d trials: %.3g %%, 95 %% interval [%.3g %%, %.3g %%]. The judge promises at most "
      "%.3g %%: %s.\n\n",
      all.alarms(), all.trials, 100. * all.alarms() / all.trials, 100 * interval.low, 100 * interval.high,
      100 * options.level, refuted ? "**refuted**" : "kept");
  const metric::Interval single = metric::rate_interval(all.low_green, all.looks);
  char exact[256];
  std::snprintf(
      exact, sizeof exact,
      "A single test, of the image's green at the fresh seed: p is below 1 %% in %d of %d, %.3g %%, 95 %% "
      "interval [%.3g %%, %.3g %%].\n\n",
      all.low_green, all.looks, all.looks ? 100. * all.low_green / all.looks : 0., 100 * single.low,
      100 * single.high);
  std::ostringstream text;
  text << "`" << options.command << "`\n\n"
       << options.names.size() << " cases in about " << options.pixels << " pixels and " << options.spp
       << " samples, " << each << " trials each.\n\n"
       << rate << exact
       << "| case | trials | alarms | paired | fresh seed | noise | pixels | image p < 1 % | paired p < 1 % "
          "| fresh p "
          "< 1 % | FLIP | RMSE |\n|---|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|\n";
  row(text, "all", all);
  text << table.str() << "\n";
  std::cout << text.str() << std::flush;
  if (!options.write_file.empty()) write_section(options.write_file, "null", text.str());
  return refuted ? 1 : 0;
}

}  // namespace app
