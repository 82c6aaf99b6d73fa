// Did the picture change? One case's render against its golden. Pure: images in, verdict out; who renders,
// when and how is app/run.h.
//
//   stage 1, the golden's own seed   same bits: IDENTICAL. Else a paired test on per-replicate tile means.
//   stage 2, a fresh fixed seed      Welch's test on image and tiles; once more with four times the samples.
//
// CHANGED as soon as one stage finds a bias above rounding, or pixels that are wrong in most replicates;
// EQUIVALENT if none did and one of them shows that any bias is inside the margins; else UNDECIDED. FLIP and
// RMSE of the own-seed render are computed and held to the case's limits whatever the hash says. The
// false-alarm budget of a case is split: half to stage 1; the other half in equal parts to the two looks of
// stage 2 and to the test of the noise. docs/judge.md has what a study of the whole of it measured.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "image/image.h"
#include "metric/flip.h"
#include "metric/statistics.h"
#include "metric/statistics_pixels.h"
#include "suite/case_file.h"
#include "suite/hashes.h"
#include "suite/lobes.h"
#include "suite/verdict.h"

namespace suite {

// What a case may do; only a study of the judge itself relaxes it.
struct JudgeOptions {
  double false_alarm = metric::case_false_alarm();  // of one case in one run
};

// One number that was held to a limit.
struct Measure {
  std::string name;
  double value = 0;
  std::optional<double> limit;  // the value must be at most this; absent: only reported
  bool ok = true;
};

// A stored picture with what judging needs, see docs/formats.md.
struct Golden {
  image::Render render;
  std::string case_hash, pixel_hash, quick_hash;  // quick: of the first samples alone; may be empty
  metric::Exposures exposures;
  std::vector<LobeMean> lobes;                // none: its shader has none
  bool knows_lobes = true;                    // false: made before goldens kept them
  std::vector<image::Image> replicate_tiles;  // tile means of each replicate; empty: no paired test
};

struct GoldenResult {
  Verdict verdict = Verdict::broken;
  std::string reason;        // one line; empty for IDENTICAL
  bool wants_fresh = false;  // undecided so far: render the fresh seed (or four times the samples) and go on
  int looks = 0;             // of stage 2, taken so far
  std::vector<Measure> measures;
  std::optional<metric::Comparison> paired, welch;  // the latest of each
  std::optional<metric::NoiseRatio> noise;
  std::vector<metric::WrongPixel> wrong_pixels;  // of the own-seed render, the worst first
  double detectable =
      0;  // smallest bias of the image's mean that other noise finds 99 times in 100, relative
  image::Image flip_map;  // one channel
  const metric::Comparison* deciding() const;
};

// The seeds of stage 2 follow from the case's own, so every run of every machine takes the same ones.
std::uint32_t fresh_seed(std::uint32_t seed, int look);

// Why a render cannot be judged: non-finite, wrong size, no variance, rejected samples, partial. Empty: it
// can.
std::string data_fault(const Case& c, const image::Render& render);
// Why a golden cannot be a yardstick: damaged, stale. Empty: it can.
std::string golden_fault(const Case& c, const Hashes& hashes, const Golden& golden);

GoldenResult judge_own_seed(const Case& c, const Golden& golden, const image::Render& render,
                            const JudgeOptions& options = {});
void judge_fresh_seed(GoldenResult& result, const Case& c, const Golden& golden, const image::Render& fresh,
                      const JudgeOptions& options = {});

// The tile means of a render's replicates, for the paired test.
std::vector<image::Image> replicate_tiles(const image::Render& render);

std::string percent(double fraction);  // "1.32 %", three digits

}  // namespace suite
