// What can be said about stored pictures without rendering: goldens and witness renders are there, sound and
// current.
#pragma once

#include <string>
#include <vector>

#include "suite/case_file.h"

namespace app {

// One line per fault; none if all is well.
std::vector<std::string> audit(const suite::Layout& layout, const std::vector<std::string>& names);

}  // namespace app
