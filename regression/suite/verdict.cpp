#include "suite/verdict.h"

namespace suite {

const char* name(Verdict verdict) {
  switch (verdict) {
    case Verdict::identical:
      return "IDENTICAL";
    case Verdict::equivalent:
      return "EQUIVALENT";
    case Verdict::quieter:
      return "QUIETER";
    case Verdict::changed:
      return "CHANGED";
    case Verdict::noisier:
      return "NOISIER";
    case Verdict::undecided:
      return "UNDECIDED";
    case Verdict::broken:
      return "BROKEN";
    case Verdict::error:
      return "ERROR";
    case Verdict::agrees:
      return "AGREES";
    case Verdict::differs:
      return "DIFFERS";
    case Verdict::skipped:
      return "SKIPPED";
  }
  return "ERROR";
}

int exit_code(Verdict verdict) {
  switch (verdict) {
    case Verdict::identical:
    case Verdict::equivalent:
    case Verdict::quieter:
    case Verdict::agrees:
    case Verdict::skipped:
      return 0;
    case Verdict::changed:
    case Verdict::noisier:
    case Verdict::undecided:
    case Verdict::broken:
    case Verdict::differs:
      return 1;
    case Verdict::error:
      return 2;
  }
  return 2;
}

}  // namespace suite
