// One case as HTML: what it is for, its verdicts, pictures, numbers with their limits, provenance, and how to
// accept.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "report/parts.h"
#include "report/pixels.h"
#include "report/results.h"

namespace report {

// A witness of a case, for the table of all of them.
struct WitnessRow {
  std::string case_name;
  Json witness;
  std::optional<Parts> parts;
};

// `floats` receives the case's pictures, `rows` its witnesses. Paths in `result` are relative to `build`.
std::string card_html(const CaseResult& result, const std::string& build, Floats& floats,
                      std::vector<WitnessRow>& rows);

// The words the page filters by, as "group:word": "status:failing", "verdict:CHANGED", "witness:DIFFERS",
// "by:Blender", "tag:disney".
std::vector<std::string> filter_words(const CaseResult& result);

// Where a result counts as its case wants it: a witness that differs as it must.
bool as_expected(const Json& witness);

// "Blender", "POV-Ray normal", the label of a closed form.
std::string kind_name(const Json& witness);

// A command and a button that copies it.
std::string command_html(const std::string& before, const std::string& command);

// The interval of a relative bias against the margin as a small plot; `range` is its half width.
std::string interval_svg(const Json& difference, double margin, double range, const std::string& css_class);

// "RMS difference 1.2 % of the mean: noise 1.19 %, bias 0.03 %, …" and the shares as a bar.
std::string parts_html(const Parts& parts);
std::string parts_bar(const Parts& parts);

}  // namespace report
