// The one way in which a user's or a file's mistake leaves the renderer: an Error whose message is a single line
// "file: place: wanted W, found F". main() prints it and exits with code 2. Programming errors are asserts instead.
#pragma once

#include <sstream>
#include <stdexcept>
#include <string>

namespace base {

struct Error : std::runtime_error {
  using std::runtime_error::runtime_error;
};

// Throws Error with the parts written one after the other, line breaks folded into blanks.
template <typename... Parts>
[[noreturn]] void fail(const Parts&... parts) {
  std::ostringstream line;
  (line << ... << parts);
  std::string text = line.str();
  for (char& c : text)
    if (c == '\n' || c == '\r') c = ' ';
  throw Error(text);
}

// Throws Error "file: place: wanted W, found F". `place` may be empty.
[[noreturn]] inline void fail_in(const std::string& file, const std::string& place, const std::string& wanted,
                                 const std::string& found) {
  fail(file, ": ", place, place.empty() ? "" : ": ", "wanted ", wanted, ", found ", found);
}

}  // namespace base
