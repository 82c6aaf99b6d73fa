# Writes OUTPUT, a header with ASSAY_VERSION and ASSAY_COMMIT, and touches it only when they changed:
#   cmake -DSOURCE=<repository> -DVERSION=<x.y.z> -DOUTPUT=<header> -P commit.cmake
# Without git, or outside a clone, the commit is "unknown".
cmake_policy(VERSION 3.25)
set(commit unknown)
find_program(GIT git)
if(GIT AND EXISTS "${SOURCE}/.git")
  execute_process(COMMAND ${GIT} -C ${SOURCE} describe --always --dirty --exclude=* --abbrev=12
                  OUTPUT_VARIABLE described OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET RESULT_VARIABLE failed)
  if(NOT failed AND described)
    set(commit ${described})
  endif()
endif()
file(CONFIGURE OUTPUT "${OUTPUT}" @ONLY CONTENT
  "#define ASSAY_VERSION \"@VERSION@\"\n#define ASSAY_COMMIT \"@commit@\"\n")
