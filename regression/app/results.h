// What a run leaves for people and for the report: build/results/NAME.json per case, build/run.json, and
// lines on the terminal. The schema is in docs/formats.md, "Results".
#pragma once

#include <string>

#include "app/run.h"

namespace app {

void write_result(const RunOptions& options, const CaseOutcome& outcome);
// A map of one channel as an EXR with three equal ones.
void write_map(const std::string& file, const image::Image& map);

void write_run(const RunOptions& options, const RunResult& result);

// "IDENTICAL  cornell  0.41 s  FLIP 0/0.05  RMSE 0/0.02  sees 0.4 %  blender AGREES", then, indented, a line
// per reason.
std::string line_of(const CaseOutcome& outcome);

// Counts of verdicts, orphans, exit code: a few lines.
std::string summary_of(const RunOptions& options, const RunResult& result);

}  // namespace app
