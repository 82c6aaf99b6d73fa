// What this program was built from.
#pragma once

namespace app {

extern const char* const version;  // "0.1.0 (commit 0123456789ab)"

}  // namespace app
