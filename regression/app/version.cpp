#include "app/version.h"

#include "assay_commit.h"

const char* const app::version = ASSAY_VERSION " (commit " ASSAY_COMMIT ")";
