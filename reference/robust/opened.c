/* For scripts/mutate, with LD_PRELOAD: writes the path of every file that is opened to the file $ASSAY_OPENED. */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <fcntl.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/syscall.h>
#include <unistd.h>

static void note(const char* path) {
  const char* const file = getenv("ASSAY_OPENED");
  char line[4200];
  if (!file || !path) return;
  /* A relative path is meant from where the program stands now. */
  char* const whole = path[0] == '/' ? NULL : getcwd(NULL, 0);
  const int length = snprintf(line, sizeof line, "%s%s%s\n", whole ? whole : "", whole ? "/" : "", path);
  free(whole);
  const long log = syscall(SYS_openat, AT_FDCWD, file, O_WRONLY | O_APPEND | O_CLOEXEC, 0);
  if (log >= 0 && length > 0) {
    if (write((int)log, line, strlen(line)) < 0) abort();
    close((int)log);
  }
}

#define OPEN(NAME)                                            \
  int NAME(const char* path, int flags, ...) {                \
    va_list more;                                             \
    va_start(more, flags);                                    \
    const int mode = va_arg(more, int);                       \
    va_end(more);                                             \
    note(path);                                               \
    int (*real)(const char*, int, ...) = dlsym(RTLD_NEXT, #NAME); \
    return real(path, flags, mode);                           \
  }
OPEN(open)
OPEN(open64)

#define OPENAT(NAME)                                               \
  int NAME(int folder, const char* path, int flags, ...) {         \
    va_list more;                                                  \
    va_start(more, flags);                                         \
    const int mode = va_arg(more, int);                            \
    va_end(more);                                                  \
    note(path);                                                    \
    int (*real)(int, const char*, int, ...) = dlsym(RTLD_NEXT, #NAME); \
    return real(folder, path, flags, mode);                        \
  }
OPENAT(openat)
OPENAT(openat64)

#define FOPEN(NAME)                                             \
  FILE* NAME(const char* path, const char* mode) {              \
    note(path);                                                 \
    FILE* (*real)(const char*, const char*) = dlsym(RTLD_NEXT, #NAME); \
    return real(path, mode);                                    \
  }
FOPEN(fopen)
FOPEN(fopen64)
