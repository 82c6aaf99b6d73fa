#include "app/study.h"

#include <fstream>
#include <sstream>

#include "base/error.h"
#include "image/io.h"

namespace app {

void write_section(const std::string& file, const std::string& name, const std::string& text) {
  std::ifstream stream(file, std::ios::binary);
  std::ostringstream bytes;
  bytes << stream.rdbuf();
  const std::string page = bytes.str(), begin = "<!-- study " + name + " -->\n",
                    end = "<!-- /study " + name + " -->";
  const std::size_t from = page.find(begin), to = page.find(end);
  if (from == std::string::npos || to == std::string::npos || to < from)
    base::fail_in(file, "", "the lines " + begin.substr(0, begin.size() - 1) + " and " + end, "neither");
  const std::string whole = page.substr(0, from + begin.size()) + text + page.substr(to);
  image::write_file(file, whole.data(), whole.size());
}

}  // namespace app
