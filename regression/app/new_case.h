// A new case from a scene and a sentence: the file, checked, and what to do next.
#pragma once

#include <string>

#include "suite/case_file.h"

namespace app {

struct NewCase {
  std::string name, scene, why, shader = "disney";  // scene: a path to a file in the suite's scenes/
  int width = 64, height = 64, spp = 256, depth = 4;
};

// Writes cases/NAME.json. Throws base::Error if it exists, or would not be a case; nothing is then left
// behind.
void new_case(const suite::Layout& layout, const NewCase& options);

}  // namespace app
