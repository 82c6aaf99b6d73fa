// Is the judge right about its own error rates? Two studies with real renders through the judge's own code:
//
//   null    pictures that differ by noise alone; how often is the judge wrong? Small pictures, thousands of
//           seeds, and a budget of false alarms so much larger that some must come.
//   power   pictures with a known bias, at the cases' own sizes and samples; how often is the judge right?
//
// Both are deterministic: every seed follows from its number. What they print is a section of docs/judge.md,
// which
// `--write` puts there, between the markers of its own name.
#pragma once

#include <string>
#include <vector>

#include "metric/statistics.h"
#include "suite/case_file.h"
#include "suite/renderer_command.h"

namespace app {

struct StudyOptions {
  suite::Layout layout;
  suite::RendererCommand renderer;
  std::vector<std::string> names;
  std::string command;     // for the page
  std::string write_file;  // a page with the study's markers; empty: print only

  int trials = 10200;   // null: case-seeds in all
  double level = 1e-3;  // null: false alarms a case may give
  int pixels = 256;     // null: of a picture, about
  int spp = 16;         // null: samples of a pixel, in eight replicates
  int seeds = 8;        // power: renders of each case
};

// Print the section; 1 if the study refutes what the judge promises, else 0.
int study_null(const StudyOptions& options);
int study_power(const StudyOptions& options);

// Replaces what stands between `<!-- study NAME -->` and `<!-- /study NAME -->`.
void write_section(const std::string& file, const std::string& name, const std::string& text);

}  // namespace app
