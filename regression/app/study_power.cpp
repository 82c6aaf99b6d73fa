// The power study: renders at a case's own size and samples, given a known bias, against a golden without it.
//
//   image   radiance times 1 + b
//   lobe    what base colour weighs (the diffuse lobe, a metal's specular) times 1 - b
//   tile    one 8 x 8 tile at least half as bright as the image, times 1 + b
//
// each with the golden's own random numbers, as a changed formula has, and with others, as if the sampling
// had changed, too. The fresh seed is another one in both. The second look, with four times the samples, is
// left out: it could only find more. So are the limits of FLIP and RMSE.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <iostream>
#include <map>
#include <sstream>

#include "app/run.h"
#include "app/study.h"
#include "app/study_pictures.h"
#include "base/error.h"

namespace app {
namespace {

namespace fs = std::filesystem;
using suite::Verdict;

enum class Kind { image, lobe, tile };
struct Rung {
  Kind kind;
  double bias;
};
constexpr Rung ladder[] = {{Kind::image, 0},   {Kind::image, .0025}, {Kind::image, .005}, {Kind::image, .01},
                           {Kind::image, .02}, {Kind::lobe, .0025},  {Kind::lobe, .005},  {Kind::lobe, .01},
                           {Kind::lobe, .02},  {Kind::tile, .02},    {Kind::tile, .05},   {Kind::tile, .1},
                           {Kind::tile, .2}};
constexpr std::size_t rungs = std::size(ladder);

std::string name_of(const Rung& r) {
  static const char* const kinds[] = {"image", "lobe", "tile"};
  return r.bias == 0 ? "none" : kinds[static_cast<int>(r.kind)] + (" " + suite::percent(r.bias));
}

struct Count {
  int trials = 0, found = 0, passed = 0;
  void add(const Count& o) { trials += o.trials, found += o.found, passed += o.passed; }
};
// By rung, and by whether the random numbers are the golden's or others.
using Counts = std::map<std::pair<std::size_t, bool>, Count>;

class PowerStudy {
 public:
  PowerStudy(const StudyOptions& options, const suite::Case& c) : options_(options), case_(c) {
    case_.limits = suite::Case::Limits{1, 1e30};
  }

  Counts run() {
    const std::string scene = options_.layout.scene_file(case_), folder = scratch();
    pictures_ = renders(scene);
    dark_ = renders(without_base_colour(scene, folder + "/scenes"));
    Counts counts;
    for (int k = 0; k < options_.seeds; ++k) {
      const suite::Golden golden = as_golden(case_, pictures_[k]);
      for (std::size_t r = 0; r < rungs; ++r)
        for (const bool own : {true, false}) trial(golden, k, ladder[r], own, counts[{r, own}]);
      detectable_ += suite::judge_own_seed(case_, golden, pictures_[k]).detectable / options_.seeds;
    }
    return counts;
  }
  double detectable() const { return detectable_; }

 private:
  std::vector<image::Render> renders(const std::string& scene) const {
    std::vector<suite::Job> jobs;
    for (int k = 0; k < options_.seeds; ++k) {
      suite::Job j = job_of(options_.layout, case_);
      j.scene = fs::absolute(scene).string();
      j.seed = static_cast<unsigned>(1000 + k);
      j.timeout_s *= 10;  // a case's own is for one renderer on an idle machine
      j.out = fs::absolute(scratch() + "/" + case_.name + "." + std::to_string(k) + ".exr").string();
      jobs.push_back(j);
    }
    return made_pictures(options_.renderer, jobs, scratch());
  }

  std::string scratch() const { return options_.layout.build + "/study/power/" + case_.name; }

  // The tile of trial k: the bright ones in turn.
  metric::Tile tile_of(int k) const {
    const metric::Noisy noisy{pictures_[k].mean, *pictures_[k].variance, case_.replicates};
    const metric::Comparison all = metric::compare_welch(noisy, noisy);
    std::vector<metric::Tile> bright;
    for (const metric::Tile& t : all.tiles)
      if (t.difference[metric::luminance].reference >= all.image[metric::luminance].reference / 2)
        bright.push_back(t);
    return bright[static_cast<std::size_t>(k) * 7 % bright.size()];
  }

  image::Render biased(int k, const Rung& rung, const metric::Tile& tile) const {
    const image::Render& sound = pictures_[static_cast<std::size_t>(k % options_.seeds)];
    if (rung.bias == 0) return sound;
    if (rung.kind == Kind::lobe)
      return mixed(sound, dark_[static_cast<std::size_t>(k % options_.seeds)], rung.bias);
    return scaled(sound, [&](int x, int y) {
      const bool inside = x >= tile.x && x < tile.x + tile.width && y >= tile.y && y < tile.y + tile.height;
      return rung.kind == Kind::image || inside ? 1 + rung.bias : 1;
    });
  }

  void trial(const suite::Golden& golden, int k, const Rung& rung, bool own, Count& count) const {
    const metric::Tile tile = tile_of(k);
    const image::Render render = biased(own ? k : k + 1, rung, tile);
    // Base colour may weigh nothing in this scene.
    if (own && rung.kind == Kind::lobe && !changes_anything(golden, render)) return;
    if (!own && rung.kind == Kind::lobe && !changes_anything(golden, biased(k, rung, tile))) return;
    suite::GoldenResult result = suite::judge_own_seed(case_, golden, render);
    if (result.wants_fresh) suite::judge_fresh_seed(result, case_, golden, biased(k + 2, rung, tile));
    if (result.verdict == Verdict::broken) base::fail("study power: ", case_.name, ": ", result.reason);
    ++count.trials;
    count.found += result.verdict == Verdict::changed;
    count.passed += suite::exit_code(result.verdict) == 0;
  }

  static bool changes_anything(const suite::Golden& golden, const image::Render& render) {
    double difference = 0, sum = 0;
    for (std::size_t i = 0; i < render.mean.data.size(); ++i) {
      difference += std::abs(double{render.mean.data[i]} - golden.render.mean.data[i]);
      sum += std::abs(double{golden.render.mean.data[i]});
    }
    return difference > 1e-5 * sum;
  }

  const StudyOptions& options_;
  suite::Case case_;
  std::vector<image::Render> pictures_, dark_;
  double detectable_ = 0;
};

std::string share(int found, int of) {
  if (of == 0) return "-";
  char text[32];
  std::snprintf(text, sizeof text, "%.3g %%", 100. * found / of);
  return text;
}

std::string with_interval(const Count& c) {
  if (c.trials == 0) return "-";
  return share(c.found, c.trials) + " (≥ " + suite::percent(metric::rate_interval(c.found, c.trials).low) +
         ")";
}

}  // namespace

int study_power(const StudyOptions& options) {
  if (options.seeds < 3) base::fail("study power: --seeds: wanted 3 or more, found ", options.seeds);
  Counts all;
  std::ostringstream table;
  std::vector<std::string> missing;
  constexpr std::size_t none = 0, half_percent = 2, lobe = 7, tile = 11;
  std::vector<Counts> counted(options.names.size());
  std::vector<double> detectable(options.names.size());
  for_each_case(options.names.size(), [&](std::size_t i) {
    PowerStudy study(options, suite::read_case(options.layout, options.names[i]));
    counted[i] = study.run();
    detectable[i] = study.detectable();
    const Count &own = counted[i][{half_percent, true}], &other = counted[i][{half_percent, false}];
    std::fprintf(stderr, "%s: image 0.5 %% found %s with its own random numbers, %s with others\n",
                 options.names[i].c_str(), share(own.found, own.trials).c_str(),
                 share(other.found, other.trials).c_str());
  });
  for (std::size_t i = 0; i < counted.size(); ++i) {
    Counts& counts = counted[i];
    const auto found = [&](std::size_t r, bool own) {
      return share(counts[{r, own}].found, counts[{r, own}].trials);
    };
    const Count& sound = counts[{none, false}];
    table << "| `" << options.names[i] << "` | " << suite::percent(detectable[i]) << " | "
          << share(sound.passed, sound.trials) << " | " << found(half_percent, true) << " | "
          << found(half_percent, false) << " | " << found(lobe, true) << " | " << found(tile, true) << " | "
          << found(tile, false) << " |\n";
    if (counts[{half_percent, false}].found < counts[{half_percent, false}].trials)
      missing.push_back(options.names[i]);
    for (const auto& [key, count] : counts) all[key].add(count);
  }
  const Count& promise = all[{half_percent, true}];
  const bool refuted = promise.found < .99 * promise.trials;
  std::ostringstream text;
  text << "`" << options.command << "`\n\n"
       << options.names.size() << " cases, " << options.seeds
       << " trials of each. Found: CHANGED, with the lower end of the 95 % interval. Passed: EQUIVALENT or "
          "QUIETER; what "
          "is neither is UNDECIDED (so far) or NOISIER.\n\n"
       << "| bias | trials | found, own random numbers | passed | found, other random numbers | passed |\n"
          "|---|--:|--:|--:|--:|--:|\n";
  for (std::size_t r = 0; r < rungs; ++r) {
    const Count &own = all[{r, true}], &other = all[{r, false}];
    text << "| " << name_of(ladder[r]) << " | " << other.trials << " | " << with_interval(own) << " | "
         << share(own.passed, own.trials) << " | " << with_interval(other) << " | "
         << share(other.passed, other.trials) << " |\n";
  }
  text << "\nAt least 99 % of biases of 0.5 % of the image: " << (refuted ? "**missed**" : "kept")
       << " with the golden's own random numbers; with others ";
  if (missing.empty()) {
    text << "every case finds all.\n\n";
  } else {
    text << "these cases missed some:";
    for (const std::string& name : missing) text << " `" << name << "`";
    text << ".\n\n";
  }
  text << "| case | sees | no bias, other numbers: passed | image 0.5 %, own | image 0.5 %, others | lobe 1 "
          "%, own | tile "
          "10 %, own | tile 10 %, others |\n|---|--:|--:|--:|--:|--:|--:|--:|\n"
       << table.str() << "\n";
  std::cout << text.str() << std::flush;
  if (!options.write_file.empty()) write_section(options.write_file, "power", text.str());
  return refuted ? 1 : 0;
}

}  // namespace app
