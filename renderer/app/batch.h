// Many renders in one process.
#pragma once

#include "app/options.h"

namespace app {

// Runs the jobs of options.batch in order, each starting from `options`; with options.json one JSON line per
// job. Returns the exit code. Throws base::Error if the file of jobs itself is no good.
int run_batch(const Options& options);

}  // namespace app
