// Written at every build, see commit.cmake beside this file.
#pragma once

namespace app {

extern const char* const version;  // "0.1.0"
extern const char* const commit;  // short git hash, "-dirty" if tracked files differed; "unknown" outside git

}  // namespace app
