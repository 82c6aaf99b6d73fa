// `assay compare A B`: any two pictures, A the reference.
#pragma once

#include <optional>
#include <string>

namespace app {

struct CompareOptions {
  std::string reference, test;
  bool json = false;
  std::string flip_map;           // EXR to write; empty: none
  double pixels_per_degree = 0;   // 0: FLIP's default
  bool hdr = false, ldr = false;  // neither: LDR if one of the two is an 8-bit picture
  std::optional<double> max_flip, max_rmse;
};

// Prints the comparison. 0: the same pixels, or inside all limits given; 1: not, or a picture holds NaN or
// infinity.
int compare(const CompareOptions& options);

}  // namespace app
