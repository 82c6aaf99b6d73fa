// What the judge can say, and the exit code that follows.
#pragma once

namespace suite {

enum class Verdict {
  // About a render and its golden.
  identical,   // the same bits
  equivalent,  // other bits, and the data show that any bias is inside the case's margins
  quieter,     // equivalent, and the variance fell by more than chance allows
  changed,     // a bias or wrong pixels were found, or FLIP or RMSE left their limits
  noisier,     // no bias found, and the variance rose by more than chance allows
  undecided,   // neither shown, even with four times the samples
  broken,      // the data are bad: non-finite, wrong size, golden missing, stale, not calibrated, ...
  error,       // no data: the renderer crashed, timed out, could not start
  // About a render and a witness.
  agrees,
  differs,
  skipped,  // the comparison cannot be made with this renderer; counted, an error with --require-witnesses
};

const char* name(Verdict verdict);  // "IDENTICAL", ...
int exit_code(Verdict verdict);     // 0 fine, 1 the picture changed or is bad, 2 no data

}  // namespace suite
