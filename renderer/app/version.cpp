#include "app/version.h"

#include "assay_commit.h"

const char *const app::version = ASSAY_VERSION, *const app::commit = ASSAY_COMMIT;
