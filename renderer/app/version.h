#pragma once

#include <string>

namespace app {

std::string version();  // "0.1.0"
std::string
commit();  // short git hash of the build, "-dirty" if tracked files differed; "unknown" outside git

}  // namespace app
