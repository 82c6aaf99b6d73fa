#include "suite/judge.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <sstream>

#include "image/hash.h"
#include "metric/rmse.h"

namespace suite {
namespace {

constexpr int last_look = 2;

// The shares of a case's budget: half to the own seed, the other half to two looks and the noise.
double own_seed_level(const JudgeOptions& options) { return metric::sidak(options.false_alarm, 2); }
double fresh_level(const JudgeOptions& options) { return metric::sidak(own_seed_level(options), 3); }

metric::WelchOptions welch_options(const Case& c, double level) {
  metric::WelchOptions o;
  o.false_alarm = level;
  o.image_margin = c.margin_image;
  o.tile_margin = c.margin_tile;
  return o;
}

std::string place(const metric::Tile& tile) {
  return "(" + std::to_string(tile.x) + ", " + std::to_string(tile.y) + ")";
}

const metric::Difference& worst(const metric::Difference* differences) {
  return *std::max_element(differences, differences + metric::quantity_count,
                           [](const auto& a, const auto& b) { return std::abs(a.t) < std::abs(b.t); });
}

std::string with_interval(const metric::Difference& d) {
  return percent(d.relative()) + " [" + percent(d.interval.low) + ", " + percent(d.interval.high) + "]";
}

// "image -1.3 % [..], 14 of 64 tiles, worst at (24, 8): -9.1 % [..]"
std::string describe_bias(const metric::Comparison& comparison) {
  std::ostringstream text;
  const auto& image = worst(comparison.image);
  text << "bias of the image " << with_interval(image) << (image.significant ? "" : " (not significant)");
  long found = 0;
  const metric::Tile* most = nullptr;
  for (const metric::Tile& tile : comparison.tiles) {
    found += tile.significant();
    if (tile.significant() && (!most || std::abs(tile.t()) > std::abs(most->t()))) most = &tile;
  }
  text << "; " << found << " of " << comparison.tiles.size() << " tiles";
  if (most) text << ", worst at " << place(*most) << ": " << with_interval(worst(most->difference));
  return text.str();
}

// What keeps a comparison from being equivalent.
std::string describe_doubt(const Case& c, const metric::Comparison& comparison) {
  std::ostringstream text;
  const auto& image = worst(comparison.image);
  const bool image_fits = std::all_of(std::begin(comparison.image), std::end(comparison.image),
                                      [](const auto& d) { return d.within_margin; });
  text << "bias of the image " << with_interval(image) << (image_fits ? " inside" : " not inside")
       << " its margin " << percent(c.margin_image);
  const auto outside = std::count_if(comparison.tiles.begin(), comparison.tiles.end(),
                                     [](const auto& tile) { return !tile.within_margin(); });
  text << "; " << outside << " of " << comparison.tiles.size() << " tiles not inside "
       << percent(c.margin_tile);
  return text.str();
}

// Whether the variance layer can be what it says it is: the mean may be right, or even the golden's, while
// the noise on which every later verdict rests is not. Empty if nothing is wrong.
std::string noise_fault(const image::Render& golden, const image::Render& render, bool identical) {
  const image::Image &was = *golden.variance, &is = *render.variance;
  const auto noisy = std::count_if(was.data.begin(), was.data.end(), [](float v) { return v > 0; });
  const auto replicates = image::replicates(render);
  const bool alike = replicates.size() >= 2 &&
                     std::all_of(replicates.begin(), replicates.end(),
                                 [&](const image::Image* r) { return r->data == replicates.front()->data; });
  if (alike && noisy > static_cast<std::ptrdiff_t>(was.data.size() / 100))
    return "its " + std::to_string(replicates.size()) +
           " replicates are the same picture, while the golden has noise: they were drawn with one seed, or "
           "nothing "
           "is left that could be noisy";
  const double before = std::accumulate(was.data.begin(), was.data.end(), 0.),
               now = std::accumulate(is.data.begin(), is.data.end(), 0.);
  // Both are stored as half floats: 1 % is twenty times their rounding.
  if (identical && !(std::abs(now - before) <= .01 * before)) {
    std::ostringstream text;
    text << "the pixels are the golden's and the variance layer is " << now / before << " times the golden's";
    return text.str();
  }
  return "";
}

// "3 wrong pixels, worst at (4, 7): 0.02 instead of 0.8, 31 sigma"
std::string describe_wrong(const std::vector<metric::WrongPixel>& wrong) {
  const metric::WrongPixel& worst = wrong.front();
  std::ostringstream text;
  text << wrong.size() << (wrong.size() == 1 ? " wrong pixel at (" : " wrong pixels, worst at (") << worst.x
       << ", " << worst.y << "): " << worst.test << " instead of " << worst.reference << ", ";
  if (std::isfinite(worst.sigmas))
    text << std::lround(worst.sigmas) << " sigma";
  else
    text << "where nothing varies";
  return text.str();
}

// One side of a comparison, with what its header says.
metric::Noisy noisy(const Case& c, const image::Render& render) {
  return {render.mean, *render.variance,
          image::header_int(render.header, "assay:replicates").value_or(c.replicates),
          static_cast<double>(image::header_int(render.header, "assay:spp").value_or(0))};
}

void set(GoldenResult& result, Verdict verdict, const std::string& reason) {
  result.verdict = verdict;
  result.reason = reason;
  result.wants_fresh = false;
}

}  // namespace

std::string percent(double fraction) {
  char text[64];
  std::snprintf(text, sizeof text, "%.3g %%", fraction * 100);
  return text;
}

const metric::Comparison* GoldenResult::deciding() const {
  return welch ? &*welch : paired ? &*paired : nullptr;
}

std::uint32_t fresh_seed(std::uint32_t seed, int look) {
  // Below 2^31, because an EXR header holds signed integers.
  return (seed + 1000003u * static_cast<std::uint32_t>(look)) & 0x7fffffffu;
}

std::string data_fault(const Case& c, const image::Render& render) {
  const auto size = [](int w, int h) { return std::to_string(w) + " x " + std::to_string(h); };
  if (render.mean.width != c.width || render.mean.height != c.height)
    return "wrong size: wanted " + size(c.width, c.height) + ", found " +
           size(render.mean.width, render.mean.height);
  if (const auto count = image::count_non_finite(render.mean))
    return std::to_string(count) + " pixels are not finite";
  if (!render.variance) return "no channels variance.R variance.G variance.B";
  if (const auto count = image::count_non_finite(*render.variance))
    return "the variance of " + std::to_string(count) + " pixels is not finite";
  if (std::any_of(render.variance->data.begin(), render.variance->data.end(), [](float v) { return v < 0; }))
    return "a variance is negative";
  if (const int rejected = image::header_int(render.header, "assay:rejected").value_or(0))
    return std::to_string(rejected) + " samples were not finite and left out by the renderer";
  if (image::header_int(render.header, "assay:partial").value_or(0) != 0) return "the render is only partial";
  return "";
}

std::string golden_fault(const Case& c, const Hashes& hashes, const Golden& golden) {
  if (const std::string fault = data_fault(c, golden.render); !fault.empty())
    return "golden damaged: " + fault;
  if (golden.pixel_hash != image::pixel_hash(golden.render.mean))
    return "golden damaged: its pixels are not those of its pixel hash";
  if (golden.case_hash != hashes.a_case)
    return "golden stale: it was made for another scene, size, shader, depth, options, samples or seed than "
           "the case "
           "has today";
  return "";
}

std::vector<image::Image> replicate_tiles(const image::Render& render) {
  std::vector<image::Image> tiles;
  for (const image::Image* replicate : image::replicates(render))
    tiles.push_back(metric::tile_means(*replicate));
  return tiles;
}

GoldenResult judge_own_seed(const Case& c, const Golden& golden, const image::Render& render,
                            const JudgeOptions& options) {
  GoldenResult result;
  const bool identical = image::pixel_hash(render.mean) == golden.pixel_hash;

  metric::FlipOptions flip_options;
  flip_options.exposures = golden.exposures;
  metric::Flip flip = metric::hdr_flip(golden.render.mean, render.mean, flip_options);
  const metric::Rmse rmse = metric::rmse(golden.render.mean, render.mean);
  result.flip_map = std::move(flip.map);
  const auto measure = [&](const char* name, double value, std::optional<double> limit) {
    result.measures.push_back({name, value, limit, !limit || value <= *limit});
  };
  measure("flip", flip.mean, c.limits ? std::optional(c.limits->flip) : std::nullopt);
  measure("rmse", rmse.rmse, c.limits ? std::optional(c.limits->rmse) : std::nullopt);
  measure("relative mse", rmse.relative_mse, {});
  measure("largest difference", rmse.max_difference, {});

  // A renderer that still gives the golden's bits has the golden's noise: the test of a picture with itself
  // tells what bias this case could have shown.
  const metric::Noisy reference = noisy(c, golden.render), test = noisy(c, render);
  result.detectable = metric::compare_welch(reference, reference, welch_options(c, fresh_level(options)))
                          .image[metric::luminance]
                          .detectable;

  if (!flip.ok()) return set(result, Verdict::broken, "FLIP: " + flip.failure), result;
  if (!c.limits) return set(result, Verdict::broken, "not calibrated: run assay calibrate " + c.name), result;
  for (const Measure& m : result.measures)
    if (!m.ok) {
      std::ostringstream text;
      text << (m.name == "flip" ? "FLIP " : "RMSE ") << m.value << " is above its limit " << *m.limit;
      result.reason += (result.reason.empty() ? "" : "; ") + text.str();
    }
  const std::string over = result.reason;
  if (const std::string fault = noise_fault(golden.render, render, identical); !fault.empty())
    return set(result, Verdict::broken, fault), result;
  if (identical) {
    // Cannot happen with sound metrics, and is checked all the same.
    set(result, over.empty() ? Verdict::identical : Verdict::changed, over);
    return result;
  }

  const auto found = [&](const std::string& what) {
    set(result, Verdict::changed, over + (over.empty() ? "" : "; ") + what);
    return result;
  };
  const std::vector<image::Image> tiles = replicate_tiles(render);
  if (tiles.size() >= 2 && tiles.size() == golden.replicate_tiles.size()) {
    result.paired = metric::compare_paired({golden.render.mean, golden.replicate_tiles}, {render.mean, tiles},
                                           welch_options(c, own_seed_level(options)));
    if (!result.paired->ok()) return set(result, Verdict::broken, result.paired->failure), result;
    if (result.paired->biased()) return found(describe_bias(*result.paired));
  }
  result.wrong_pixels = metric::wrong_pixels(reference, test, image::replicates(render),
                                             std::max(1., reference.samples / reference.replicates));
  if (!result.wrong_pixels.empty()) return found(describe_wrong(result.wrong_pixels));
  if (!over.empty()) return set(result, Verdict::changed, over), result;
  set(result, Verdict::undecided, "the bits differ and the fresh seed was not judged");
  result.wants_fresh = true;
  return result;
}

void judge_fresh_seed(GoldenResult& result, const Case& c, const Golden& golden, const image::Render& fresh,
                      const JudgeOptions& options) {
  ++result.looks;
  const double level = fresh_level(options);
  const metric::Noisy reference = noisy(c, golden.render), test = noisy(c, fresh);
  result.welch = metric::compare_welch(reference, test, welch_options(c, level));
  const metric::Comparison& welch = *result.welch;
  if (!welch.ok()) return set(result, Verdict::broken, welch.failure);
  result.detectable = welch.image[metric::luminance].detectable;
  // Only the first look has the golden's number of samples, so only it can speak of noise.
  if (result.looks == 1) result.noise = metric::noise_ratio(reference, test, welch_options(c, level));
  const bool noise_moved = result.noise && result.noise->p < level;
  char ratio[96] = "";
  if (noise_moved)
    std::snprintf(ratio, sizeof ratio, "variance times %.3g [%.3g, %.3g]", result.noise->ratio,
                  result.noise->interval.low, result.noise->interval.high);

  if (welch.biased()) return set(result, Verdict::changed, "fresh seed: " + describe_bias(welch));
  if (noise_moved && result.noise->ratio > 1) return set(result, Verdict::noisier, ratio);
  if (welch.equivalent() || (result.paired && result.paired->equivalent())) {
    const metric::Difference& shown = worst(welch.equivalent() ? welch.image : result.paired->image);
    const std::string bias =
        "bias of the image " + with_interval(shown) + ", margin " + percent(c.margin_image);
    return set(result, noise_moved ? Verdict::quieter : Verdict::equivalent,
               noise_moved ? bias + "; " + ratio : bias);
  }
  set(result, Verdict::undecided, describe_doubt(c, welch));
  result.wants_fresh = result.looks < last_look;
}

}  // namespace suite
