// Runs before anything else of a program that is built for AVX2 (ASSAY_ISA), and is itself built without:
// where the machine has none, one line instead of an illegal instruction. CMakeLists.txt asks the building
// machine by the same lines. Nothing is included that other files share with it, or the linker might take
// their AVX2 code for it.
#include <unistd.h>

namespace {

[[gnu::constructor(101)]] void check_cpu() {
  __builtin_cpu_init();  // libgcc's own call of it may come later
  if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("bmi2") && __builtin_cpu_supports("fma"))
    return;
  static const char text[] =
      "this program is built for processors with AVX2, and this one has none: build it with "
      "-DASSAY_ISA=x86-64\n";
  [[maybe_unused]] const ssize_t written = write(STDERR_FILENO, text, sizeof text - 1);
  _exit(2);
}

}  // namespace
