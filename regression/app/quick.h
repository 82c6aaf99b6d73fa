// The quick look: the first samples of a case's first replicate, whose hash its golden carries. Equal hashes
// say that the picture is very likely the golden's to the bit, in a thirtieth of the time; anything else says
// nothing but that the case must be judged in full.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "app/run.h"

namespace app {

// The first 16 samples of the first replicate, or all that it has.
inline constexpr int quick_samples = 16;
suite::Job quick_job(const suite::Layout& layout, const suite::Case& c);

// The pixel hash of each case's quick picture; without those that could not be rendered.
std::map<std::string, std::string> quick_hashes(const RunOptions& options,
                                                const std::vector<suite::Case>& cases);

// The cases of options.names whose quick picture is that of their golden, which is sound and not stale.
std::vector<std::string> quickly_identical(const RunOptions& options);

}  // namespace app
