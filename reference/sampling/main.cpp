// Prints the table of planted faults against checks, as Markdown. With a file as argument: exits with 1
// unless the file has that table (docs/bsdf-tests.md).
#include <cstdio>
#include <fstream>
#include <sstream>

#include "sampling/faults.h"

namespace {

using namespace sampling;

// Adds a row; says how many checks reject.
int add(std::string& table, const std::string& what, const Verdicts& verdicts, const char* source) {
  int rejections = 0;
  table += "| " + what + " |";
  for (const std::string& why : verdicts) {
    table += why.empty() ? "  |" : " rejected |";
    rejections += !why.empty();
  }
  table += std::string(" ") + source + " |\n";
  return rejections;
}

}  // namespace

int main(int argc, char** argv) {
  std::string table = "| planted fault |", line = "|---|";
  for (int c = 0; c < check_count; ++c) {
    table += std::string(" ") + name(static_cast<Check>(c)) + " |";
    line += "---|";
  }
  table += " seen in |\n" + line + "---|\n";
  Verdicts without;
  for (const Fault& f : faults()) {
    const Verdicts v = verdicts_without(f);
    for (std::size_t c = 0; c < v.size(); ++c) without[c] += v[c];
  }
  int wrong = add(table, "none, in each of these materials", without, "");
  for (const Fault& f : faults()) wrong += add(table, f.name, verdicts(f), f.source) == 0;
  std::printf("%s", table.c_str());
  if (argc > 1) {
    std::ostringstream file;
    file << std::ifstream(argv[1]).rdbuf();
    if (file.str().find(table) == std::string::npos) {
      std::fprintf(stderr, "%s: wanted the table above, found another\n", argv[1]);
      return 1;
    }
  }
  return wrong ? 1 : 0;
}
