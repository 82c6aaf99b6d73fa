// The subcommands of `assay`: each fills its options from the command line and returns an exit code.
#pragma once

#include <string>
#include <vector>

namespace app {

// 0 fine, 1 a picture changed or is bad, 2 could not run. Never throws.
int assay_main(const std::vector<std::string>& arguments);

}  // namespace app
