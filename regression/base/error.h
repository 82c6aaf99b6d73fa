// The judge's one way to report what a user or a file did wrong: an Error whose message is one line,
// "file: place: wanted W, found F". main() prints it and exits with code 2. Programming errors are asserts
// instead.
#pragma once

#include <sstream>
#include <stdexcept>
#include <string>

namespace base {

struct Error : std::runtime_error {
  using std::runtime_error::runtime_error;
};

// Throws Error with the parts written one after the other; control characters become blanks, so it stays one
// line whatever a file name or a library's message holds.
template <typename... Parts>
[[noreturn]] void fail(const Parts&... parts) {
  std::ostringstream line;
  (line << ... << parts);
  std::string text = line.str();
  while (!text.empty() && (text.back() == '\n' || text.back() == '\r')) text.pop_back();
  for (char& c : text)
    if (static_cast<unsigned char>(c) < 0x20) c = ' ';
  throw Error(text);
}

// Throws Error "file: place: wanted W, found F". `place` may be empty.
[[noreturn]] inline void fail_in(const std::string& file, const std::string& place, const std::string& wanted,
                                 const std::string& found) {
  fail(file, ": ", place, place.empty() ? "" : ": ", "wanted ", wanted, ", found ", found);
}

}  // namespace base
