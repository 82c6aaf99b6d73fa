// A case's picture once more, taken apart by lobe: for what may become a golden, and for what CHANGED.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "app/run.h"
#include "suite/lobes.h"

namespace app {

// The means by lobe of each case's own-seed picture; without the cases whose shader has no lobes or whose
// renderer cannot be asked for layers.
std::map<std::string, std::vector<suite::LobeMean>> lobes_of(const RunOptions& options,
                                                             const std::vector<suite::Case>& cases);

}  // namespace app
