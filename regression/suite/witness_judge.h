// Is the picture right? One case's render against another witness: a stored Blender or POV-Ray picture, or a
// number known in closed form. Pure: images in, verdict out.
//
// Every check answers one of three things: shown to agree, shown to differ, or too noisy to tell. AGREES
// needs the first from all checks. An entry with "expect": "differs" passes when at least one check is
// *shown* to differ.
#pragma once

#include <string>
#include <vector>

#include "image/image.h"
#include "suite/case_file.h"
#include "suite/hashes.h"
#include "suite/judge.h"
#include "suite/verdict.h"

namespace suite {

struct WitnessResult {
  std::string label;  // Witness::label
  Verdict verdict = Verdict::broken;
  bool passed = false;  // with "expect": "differs" that is not verdict == agrees
  std::string reason;
  std::vector<Measure> measures;
  std::vector<metric::Difference>
      image;                 // R, G, B, luminance of the image's (or rectangle's) mean, if compared
  std::string said_by;       // the program that made the stored picture
  image::Image error_map;    // one channel: FLIP or the absolute difference; empty for analytic
  std::string error_map_is;  // "flip" or "absolute difference"
};

// The render a witness is compared with: the case's own, or another one if it asks for another shader or
// depth.
bool needs_own_render(const Case& c, const Witness& witness);

// Why a stored witness cannot speak: stale, wrong size, non-finite. Empty: it can. `scripts` is today's hash
// of the scripts that make it.
std::string witness_fault(const Case& c, const Witness& witness, const Hashes& hashes,
                          const std::string& scripts, const image::Render& stored);

// `stored` is null for analytic witnesses. Both pictures have passed data_fault() and witness_fault().
WitnessResult judge_witness(const Case& c, const Witness& witness, const image::Render& ours,
                            const image::Render* stored);

}  // namespace suite
