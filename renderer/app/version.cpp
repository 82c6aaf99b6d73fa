// The commit is asked for at every build, see commit.cmake beside this file.
#include "app/version.h"

#include "assay_commit.h"

namespace app {

std::string version() { return ASSAY_VERSION; }
std::string commit() { return ASSAY_COMMIT; }

}  // namespace app
