// One case as HTML: what it is for, its verdicts, pictures, numbers with their limits, provenance, and how to
// accept.
#pragma once

#include <string>

#include "report/pixels.h"
#include "report/results.h"

namespace report {

// `floats` receives the case's pictures for the viewer. Paths in `result` are relative to `build`.
std::string card_html(const CaseResult& result, const std::string& build, Floats& floats);

// The words the page filters by: "golden:CHANGED", "witness:DIFFERS", "failing", "pending".
std::vector<std::string> filter_words(const CaseResult& result);

}  // namespace report
