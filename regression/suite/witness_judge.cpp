#include "suite/witness_judge.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <sstream>

namespace suite {
namespace {

// Of docs/formats.md: the cross-renderer rule asks for 3.5 standard errors.
constexpr double standard_errors = 3.5;

enum class Answer { agrees, differs, unclear };

class Checks {
 public:
  explicit Checks(WitnessResult& result) : result_(result) {}

  void add(Answer answer, const std::string& text) {
    all_agree_ = all_agree_ && answer == Answer::agrees;
    shown_ = shown_ || answer == Answer::differs;
    if (answer != Answer::agrees) reason_ += (reason_.empty() ? "" : "; ") + text;
  }

  // A number without uncertainty against its limit.
  void at_most(const std::string& name, double value, double limit) {
    const bool ok = value <= limit;  // false for NaN
    result_.measures.push_back({name, value, limit, ok});
    std::ostringstream text;
    text << name << " " << value << " above its limit " << limit;
    add(ok ? Answer::agrees : Answer::differs, text.str());
  }

  void conclude(const Witness& witness) {
    result_.verdict = all_agree_ ? Verdict::agrees : Verdict::differs;
    result_.reason = reason_;
    result_.passed = witness.expect_differs ? shown_ : all_agree_;
    if (!witness.expect_differs) return;
    const std::string expected = "expected to differ (" + witness.because + ")";
    result_.reason =
        shown_ ? reason_ + "; as " + expected
               : expected + ", but no difference is shown" + (reason_.empty() ? "" : ": " + reason_);
  }

 private:
  WitnessResult& result_;
  bool all_agree_ = true, shown_ = false;
  std::string reason_;
};

// The means of both images, channel by channel, by the rule |difference| + 3.5 standard errors <= margin.
void check_mean(Checks& checks, WitnessResult& result, double margin, const metric::Noisy& reference,
                const metric::Noisy& ours) {
  const metric::Comparison comparison = metric::compare_welch(reference, ours);
  if (!comparison.ok()) return checks.add(Answer::unclear, comparison.failure);
  result.image.assign(std::begin(comparison.image), std::end(comparison.image));
  static const char* const names[] = {"red", "green", "blue", "luminance"};
  for (int q = 0; q < metric::quantity_count; ++q) {
    const metric::Difference& d = comparison.image[q];
    const double error = d.scale > 0 ? standard_errors * d.standard_error / d.scale : 0;
    const bool agrees = metric::agrees(d, margin);
    result.measures.push_back(
        {std::string("bias + 3.5 SE, ") + names[q], std::abs(d.relative()) + error, margin, agrees});
    std::string text = std::string(names[q]) + " bias " + percent(d.relative()) + " ± " + percent(error) +
                       ", margin " + percent(margin);
    // Nothing to be relative to: a black witness and light of ours.
    const bool differs = d.scale > 0 ? std::abs(d.relative()) - error > margin : d.difference != 0;
    if (!agrees && !differs) text += " (too noisy to tell)";
    checks.add(agrees ? Answer::agrees : differs ? Answer::differs : Answer::unclear, text);
  }
}

// One standard normal deviate per pixel, the same in every run.
std::vector<float> deviates(std::size_t count) {
  std::mt19937 bits(1);
  const auto uniform = [&] { return (static_cast<double>(bits()) + .5) / 4294967296.; };
  std::vector<float> values(count);
  for (float& v : values) {
    const double radius = std::sqrt(-2 * std::log(uniform()));
    v = static_cast<float>(radius * std::cos(6.283185307179586 * uniform()));
  }
  return values;
}

// A picture that differs from `witness` by noise alone, as much of it as ours and the witness's together: its
// FLIP is what two sound renderers may show. The noise is that of our own replicates (half their number
// against the other half, so it has the right colours and tails), scaled; where those are silent or absent,
// it is normal and grey.
image::Image with_noise(const image::Render& witness, const image::Render& ours) {
  const std::vector<const image::Image*> replicates = image::replicates(ours);
  const std::size_t half = replicates.size() / 2;
  const std::vector<float> normal = deviates(witness.mean.pixels());
  image::Image noisy = witness.mean;
  for (std::size_t p = 0; p < noisy.pixels(); ++p) {
    double wanted = 0, have = 0, noise[3] = {0, 0, 0};
    for (std::size_t c = 0; c < 3; ++c) {
      const std::size_t i = 3 * p + c;
      have += ours.variance->data[i];
      wanted += double{ours.variance->data[i]} + (witness.variance ? witness.variance->data[i] : 0);
      for (std::size_t r = 0; r < 2 * half; ++r)
        noise[c] += (r < half ? 1 : -1) * double{replicates[r]->data[i]} / (2. * static_cast<double>(half));
    }
    const bool silent = half == 0 || have <= 0;
    for (std::size_t c = 0; c < 3; ++c) {
      const std::size_t i = 3 * p + c;
      const double variance =
          double{ours.variance->data[i]} + (witness.variance ? witness.variance->data[i] : 0);
      noisy.data[i] +=
          static_cast<float>(silent ? normal[p] * std::sqrt(variance) : noise[c] * std::sqrt(wanted / have));
    }
  }
  return noisy;
}

// LDR-FLIP of both pictures tone mapped at the middle of the witness's own automatic exposures.
void check_flip(Checks& checks, WitnessResult& result, const image::Render& witness,
                const image::Render& ours) {
  const auto exposures = metric::automatic_exposures(witness.mean);
  if (!exposures) return;  // a black witness: its mean says everything
  const double exposure = (exposures->start + exposures->stop) / 2;
  const auto mapped = [&](const image::Image& i) {
    return metric::tone_map(i, metric::ToneMapper::aces, exposure);
  };
  const image::Image reference = mapped(witness.mean);
  metric::Flip flip = metric::ldr_flip(reference, mapped(ours.mean), metric::Values::linear);
  const metric::Flip floor =
      metric::ldr_flip(reference, mapped(with_noise(witness, ours)), metric::Values::linear);
  result.measures.push_back({"flip of noise alone", floor.mean, {}, true});
  const double limit = 1.25 * floor.mean + .005;
  const bool ok = metric::flip_agrees(flip.mean, floor.mean);
  result.measures.push_back({"flip", flip.mean, limit, ok});
  std::ostringstream text;
  text << "FLIP " << flip.mean << " above its limit " << limit;
  checks.add(ok ? Answer::agrees : Answer::differs, text.str());
  result.error_map = std::move(flip.map);
  result.error_map_is = "flip";
}

// The largest difference of the three channels, per pixel.
image::Image absolute_difference(const image::Image& a, const image::Image& b) {
  image::Image map(a.width, a.height, 1);
  for (std::size_t p = 0; p < map.pixels(); ++p)
    for (std::size_t c = 0; c < 3; ++c)
      map.data[p] = std::max(map.data[p], std::abs(a.data[3 * p + c] - b.data[3 * p + c]));
  return map;
}

// Root mean square of the per-pixel difference, with what noise contributes taken out, in image
// means.
void check_rms(Checks& checks, WitnessResult& result, const Witness& entry, const image::Render& witness,
               const image::Render& ours) {
  double squares = 0, mean = 0;
  for (std::size_t i = 0; i < ours.mean.data.size(); ++i) {
    const double d = double{ours.mean.data[i]} - witness.mean.data[i];
    squares += d * d - ours.variance->data[i] - (witness.variance ? witness.variance->data[i] : 0);
    mean += witness.mean.data[i];
  }
  const double count = static_cast<double>(ours.mean.data.size());
  const double rms = std::sqrt(std::max(0., squares / count));
  checks.at_most("RMS beyond noise, in image means", mean > 0 ? rms / (mean / count) : rms, entry.tolerance);
  result.error_map = absolute_difference(ours.mean, witness.mean);
  result.error_map_is = "absolute difference";
}

// Where a picture of a quantity shows something: its coverage channel A says so, or else any value but 0.
bool hit(const image::Image& values, const image::Image* coverage, std::size_t pixel) {
  if (coverage) return coverage->data[pixel * static_cast<std::size_t>(coverage->channels)] > .5f;
  const float* v = &values.data[3 * pixel];
  return v[0] != 0 || v[1] != 0 || v[2] != 0;
}

const image::Image* layer(const image::Render& render, const std::string& name, int channels) {
  const auto found = render.layers.find(name);
  return found == render.layers.end() || found->second.channels != channels ? nullptr : &found->second;
}

// Noise-free quantities, pixel by pixel: the largest difference where both hit something, and how many pixels
// only one of them hits.
void check_pixels(Checks& checks, WitnessResult& result, const Witness& entry, const image::Render& witness,
                  const image::Render& ours) {
  // Our layer is exact at the pixel's centre, where the shader of that name is an average over the pixel.
  const image::Image* exact = layer(ours, entry.quantity, 3);
  const image::Image& mine = exact ? *exact : ours.mean;
  const image::Image* depth = layer(ours, "depth", 1);  // 0 where nothing is hit
  const image::Image* coverage = layer(witness, "A", 1);

  double worst = 0, low[3], high[3], full_scale = 0;
  std::fill(low, low + 3, std::numeric_limits<double>::infinity());
  std::fill(high, high + 3, -std::numeric_limits<double>::infinity());
  std::size_t both = 0, one = 0;
  result.error_map = image::Image(mine.width, mine.height, 1);
  for (std::size_t p = 0; p < mine.pixels(); ++p) {
    const bool theirs_hits = hit(witness.mean, coverage, p);
    // A lobe may well be 0 on the sphere; off it, any light of ours is too much.
    const bool ours_hits = entry.quantity == "brdf" ? theirs_hits || hit(mine, nullptr, p)
                           : depth                  ? depth->data[p] != 0
                                                    : hit(mine, nullptr, p);
    if (ours_hits != theirs_hits) ++one;
    if (!ours_hits || !theirs_hits) continue;
    ++both;
    double square = 0;
    for (std::size_t c = 0; c < 3; ++c) {
      const double value = witness.mean.data[3 * p + c], d = mine.data[3 * p + c] - value;
      square = entry.quantity == "brdf" ? std::max(square, d * d) : square + d * d;
      low[c] = std::min(low[c], value), high[c] = std::max(high[c], value);
      full_scale = std::max(full_scale, std::abs(value));
    }
    result.error_map.data[p] = static_cast<float>(std::sqrt(square));
    worst = std::max(worst, std::sqrt(square));
    if (std::isnan(square)) worst = square;
  }
  result.error_map_is = "absolute difference";
  if (both == 0) return checks.add(Answer::differs, "no pixel is hit by both");

  double scale = 1;
  std::string unit = "largest difference of the unit normals";
  if (entry.quantity == "position") {
    const double seen = std::hypot(high[0] - low[0], high[1] - low[1], high[2] - low[2]);
    scale = image::header_float(witness.header, "assay:scene_size").value_or(static_cast<float>(seen));
    unit = "largest difference, in sizes of the scene";
  } else if (entry.quantity == "brdf") {
    scale = image::header_float(witness.header, "assay:full_scale").value_or(static_cast<float>(full_scale));
    unit = "largest difference, of full scale";
  }
  checks.at_most(unit, scale > 0 ? worst / scale : worst, entry.tolerance);
  checks.at_most("share of pixels hit by only one",
                 static_cast<double>(one) / static_cast<double>(mine.pixels()), entry.coverage);
}

// The part of an image inside a rectangle.
image::Image crop(const image::Image& whole, const std::array<int, 4>& rect) {
  image::Image part(rect[2], rect[3], whole.channels);
  for (int y = 0; y < part.height; ++y)
    for (int x = 0; x < part.width; ++x)
      for (int c = 0; c < part.channels; ++c) part.at(x, y, c) = whole.at(rect[0] + x, rect[1] + y, c);
  return part;
}

void check_analytic(Checks& checks, WitnessResult& result, const Case& c, const Witness& entry,
                    const image::Render& ours, int replicates) {
  const std::array<int, 4> rect = entry.rect.value_or(std::array<int, 4>{0, 0, c.width, c.height});
  const image::Image mean = crop(ours.mean, rect), variance = crop(*ours.variance, rect);
  image::Image known(mean.width, mean.height, 3), certain(mean.width, mean.height, 3);
  for (std::size_t i = 0; i < known.data.size(); ++i) known.data[i] = static_cast<float>(entry.mean[i % 3]);
  check_mean(checks, result, entry.margin, {known, certain, 2}, {mean, variance, replicates});
}

}  // namespace

bool needs_own_render(const Case& c, const Witness& witness) {
  return witness.shader != c.shader || witness.depth != c.depth || witness.quantity == "position" ||
         witness.quantity == "normal";
}

std::string witness_fault(const Case& c, const Witness& witness, const Hashes& hashes,
                          const std::string& scripts, const image::Render& stored) {
  const auto text = [&](const char* key) { return image::header_string(stored.header, key).value_or(""); };
  if (text("assay:picture_hash") != hashes.picture)
    return "stale: made for another scene, size, camera, shader, depth or options than the case has today "
           "(picture hash)";
  if (text("assay:script_hash") != scripts)
    return "stale: the scripts that made it have changed (script hash)";
  if (stored.mean.width != c.width || stored.mean.height != c.height)
    return "wrong size: wanted " + std::to_string(c.width) + " x " + std::to_string(c.height) + ", found " +
           std::to_string(stored.mean.width) + " x " + std::to_string(stored.mean.height);
  if (const auto count = image::count_non_finite(stored.mean))
    return std::to_string(count) + " pixels are not finite";
  if (witness.kind == WitnessKind::blender) {
    if (!stored.variance) return "no channels variance.R variance.G variance.B";
    if (image::count_non_finite(*stored.variance)) return "its variance is not finite";
    if (image::header_int(stored.header, "assay:replicates").value_or(0) < 2)
      return "fewer than 2 replicates";
  }
  return "";
}

WitnessResult judge_witness(const Case& c, const Witness& witness, const image::Render& ours,
                            const image::Render* stored) {
  WitnessResult result;
  result.label = witness.label;
  Checks checks(result);
  const int replicates = image::header_int(ours.header, "assay:replicates").value_or(c.replicates);
  if (stored) result.said_by = image::header_string(stored->header, "assay:witness").value_or("");

  if (witness.kind == WitnessKind::analytic) {
    result.said_by = witness.source;
    check_analytic(checks, result, c, witness, ours, replicates);
  } else if (witness.kind == WitnessKind::blender) {
    check_mean(
        checks, result, witness.margin,
        {stored->mean, *stored->variance, image::header_int(stored->header, "assay:replicates").value_or(2)},
        {ours.mean, *ours.variance, replicates});
    if (witness.flip) check_flip(checks, result, *stored, ours);
  } else if (witness.quantity == "direct" || witness.quantity == "mirror") {
    // POV-Ray's rays lie on a grid; its variance, if it gives one, says what the grid leaves undecided.
    const image::Image variance = stored->variance.value_or(image::Image(c.width, c.height, 3));
    check_mean(checks, result, witness.margin, {stored->mean, variance, 2},
               {ours.mean, *ours.variance, replicates});
    check_rms(checks, result, witness, *stored, ours);
  } else {
    check_pixels(checks, result, witness, *stored, ours);
  }
  checks.conclude(witness);
  return result;
}

}  // namespace suite
