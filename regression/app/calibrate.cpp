#include "app/calibrate.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <sstream>

#include "app/run.h"
#include "base/error.h"
#include "golden/golden.h"
#include "image/io.h"
#include "metric/flip.h"
#include "metric/rmse.h"
#include "suite/case_edit.h"

namespace app {
namespace {

namespace fs = std::filesystem;

// The rest of a margin is left to the bias itself.
constexpr double share_of_margin = .7;
// Differences below these are rounding: a case without noise must not fail for them.
constexpr double least_flip = 1e-4, least_relative_rmse = 1e-5;

struct Floor {
  double flip = 0, rmse = 0, mean = 0;
};

// The largest difference between any two of some independent renders.
Floor noise_floor(const std::vector<image::Image>& images) {
  metric::FlipOptions options;
  options.exposures = metric::automatic_exposures(images.front());
  if (!options.exposures) options.exposures = metric::Exposures{0, 0, 1};
  Floor floor;
  for (const float v : images.front().data) floor.mean += v / static_cast<double>(images.front().data.size());
  for (std::size_t a = 0; a < images.size(); ++a)
    for (std::size_t b = a + 1; b < images.size(); ++b) {
      floor.flip = std::max(floor.flip, metric::hdr_flip(images[a], images[b], options).mean);
      floor.rmse = std::max(floor.rmse, metric::rmse(images[a], images[b]).rmse);
    }
  return floor;
}

suite::Case::Limits limits_of(const Floor& floor, double factor) {
  return {std::min(1., round_up(std::max(factor * floor.flip, least_flip))),
          round_up(std::max(factor * floor.rmse, std::max(least_relative_rmse * floor.mean, 1e-9)))};
}

image::Render picture(const CalibrateOptions& options, const suite::Case& c, const suite::Job& job,
                      const suite::Outcome& outcome) {
  if (!outcome.ok) base::fail(c.name, ": ", outcome.error);
  image::Render render = read_job(options.renderer, job, options.layout.build + "/renders");
  if (const std::string fault = suite::data_fault(c, render); !fault.empty()) base::fail(c.name, ": ", fault);
  return render;
}

std::string shortest(double x) {
  std::ostringstream text;
  text << x;
  return text.str();
}

void write_case(const suite::Case& c, const suite::Case::Limits& limits, int spp, double tile_margin) {
  std::ifstream stream(c.file, std::ios::binary);
  std::ostringstream old;
  old << stream.rdbuf();
  std::string text = suite::with_member(
      old.str(), "limits",
      "{\"flip\": " + shortest(limits.flip) + ", \"rmse\": " + shortest(limits.rmse) + "}");
  if (tile_margin != c.margin_tile)
    text = suite::with_member(
        text, "margins",
        "{\"image\": " + shortest(c.margin_image) + ", \"tile\": " + shortest(tile_margin) + "}");
  if (spp != c.spp) text = suite::with_member(text, "spp", std::to_string(spp));
  if (text != old.str()) image::write_file(c.file, text.data(), text.size());
}

void calibrate_case(const CalibrateOptions& options, suite::Case c) {
  const std::string scratch = options.layout.build + "/renders";
  const suite::Case before = c;
  suite::Job probe = job_of(options.layout, c);
  probe.out = fs::absolute(options.layout.render_file(c.name + ".calibrate0")).string();
  const suite::Outcome outcome = options.renderer.run({probe}, scratch).front();
  const image::Render first = picture(options, c, probe, outcome);
  const SampleNeed need = samples_needed(c, first);

  // As many samples as the margins need, or as the budget allows.
  const double seconds_per_sample = outcome.seconds / c.spp;
  int affordable = need.spp;
  while (affordable > c.replicates && affordable * seconds_per_sample > options.budget_s) affordable /= 2;
  affordable = std::max(affordable / c.replicates, 1) * c.replicates;
  if (options.set_spp) c.spp = affordable;

  std::vector<suite::Job> jobs;
  for (int s = 0; s < options.seeds; ++s) {
    suite::Job job = job_of(options.layout, c);
    job.seed = suite::fresh_seed(c.seed, 100 + s);
    job.layers.clear();
    job.out = fs::absolute(options.layout.render_file(c.name + ".calibrate" + std::to_string(s))).string();
    jobs.push_back(job);
  }
  const std::vector<suite::Outcome> outcomes = options.renderer.run(jobs, scratch);
  std::vector<image::Image> images;
  for (std::size_t j = 0; j < jobs.size(); ++j)
    images.push_back(picture(options, c, jobs[j], outcomes[j]).mean);
  const Floor floor = noise_floor(images);
  const suite::Case::Limits limits = limits_of(floor, options.factor);
  for (const suite::Job& job : jobs) fs::remove(job.out);

  std::printf(
      "%-32s floor FLIP %.4f RMSE %.4g  limits %g %g  spp %d (margins need %d%s)  half-widths of what they "
      "allow: image %.2f tiles %.2f witnesses %.2f; tile margin %g\n",
      c.name.c_str(), floor.flip, floor.rmse, limits.flip, limits.rmse, c.spp, need.spp,
      affordable < need.spp ? (", " + std::to_string(affordable) + " in the budget").c_str() : "", need.image,
      need.tile, need.witness, need.tile_margin);
  if (!options.dry_run)
    write_case(before, limits, c.spp, options.set_margins ? need.tile_margin : before.margin_tile);
  if (!options.dry_run && c.spp != before.spp && fs::exists(options.layout.golden_file(c.name)))
    std::printf("%-32s its golden is stale now: %d samples instead of %d\n", "", c.spp, before.spp);
  std::fflush(stdout);
}

}  // namespace

double round_up(double x) {
  if (!(x > 0)) return x;
  const double unit = std::pow(10, std::floor(std::log10(x)) - 1);
  return std::ceil(x / unit * (1 - 1e-12)) * unit;
}

suite::Case::Limits calibrated_limits(const std::vector<image::Image>& images, double factor) {
  return limits_of(noise_floor(images), factor);
}

SampleNeed samples_needed(const suite::Case& c, const image::Render& picture) {
  metric::WelchOptions options;
  options.image_margin = c.margin_image;
  options.tile_margin = c.margin_tile;
  const metric::Noisy render{picture.mean, *picture.variance, c.replicates};
  options.false_alarm = metric::sidak(metric::case_false_alarm(), 6);  // of one look of stage 2
  // A render against one like it: the half-widths that a comparison with the golden will have.
  const metric::Comparison comparison = metric::compare_welch(render, render, options);
  if (!comparison.ok()) base::fail(c.name, ": ", comparison.failure);
  const auto half_width = [](const metric::Difference& d) { return (d.interval.high - d.interval.low) / 2; };
  SampleNeed need;
  // The margin must be shown where there is no bias, and a bias as large as the margin be found.
  for (const metric::Difference& d : comparison.image)
    need.image = std::max(need.image, half_width(d) / (share_of_margin * c.margin_image));
  need.image = std::max(need.image, comparison.image[metric::luminance].detectable / c.margin_image);
  for (const suite::Witness& w : c.witnesses) {
    if (suite::needs_own_render(c, w) || w.quantity == "brdf") continue;
    // 3.5 standard errors of our mean alone; the witness's own are not ours to reduce.
    const suite::WitnessResult known = w.kind == suite::WitnessKind::analytic
                                           ? suite::judge_witness(c, w, picture, nullptr)
                                           : suite::WitnessResult{};
    for (int q = 0; q < metric::quantity_count; ++q) {
      const bool is_known = w.kind == suite::WitnessKind::analytic;
      if (is_known && known.image.empty()) continue;
      const metric::Difference& d = is_known ? known.image[q] : comparison.image[q];
      const double error = is_known ? d.standard_error : d.standard_error / std::sqrt(2.);
      if (d.scale > 0)
        need.witness = std::max(need.witness, 3.5 * error / d.scale / (share_of_margin * w.margin));
    }
  }
  for (const metric::Tile& tile : comparison.tiles)
    for (const metric::Difference& d : tile.difference)
      need.tile = std::max(need.tile, half_width(d) / (share_of_margin * c.margin_tile));
  // A sound picture's worst of a few hundred tiles is 3.7 standard errors off, and its interval 2.6 wide.
  const double wide = need.tile * share_of_margin * c.margin_tile * (3.7 + 2.6) / 2.6;
  need.tile_margin = std::min(1., std::max(suite::Case{}.margin_tile, std::ceil(100 * wide) / 100));
  // Half-widths fall with the square root of the samples, or faster.
  const double wanted = c.spp * std::pow(std::max({need.image, need.tile, need.witness}), 2);
  need.spp = c.replicates;
  while (need.spp < wanted && need.spp < (1 << 19)) need.spp *= 2;
  return need;
}

int calibrate(const CalibrateOptions& options) {
  if (const char* ci = std::getenv("CI"); ci && *ci && !options.dry_run)
    base::fail("calibrate: wanted a person, found CI=", ci,
               " in the environment: limits are not written there");
  int exit_code = 0;
  for (const std::string& name : options.names) {
    try {
      calibrate_case(options, suite::read_case(options.layout, name));
    } catch (const base::Error& error) {
      std::cerr << "assay: calibrate: " << error.what() << "\n";
      exit_code = 2;
    }
  }
  return exit_code;
}

}  // namespace app
