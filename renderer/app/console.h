// What a person sees while a job runs: notes, warnings and one line of progress on standard error, all of it
// also in the log if there is one. Standard output is left to results (--info, --json).
#pragma once

#include <chrono>
#include <cstdint>
#include <exception>
#include <fstream>
#include <string>

namespace app {

class Console {
 public:
  explicit Console(bool quiet = false);

  // From now on, instead of any log before; "" for none. Throws base::Error.
  void open_log(const std::string& file);

  void log(const std::string& line);  // the log only
  void say(const std::string& line);
  void warn(const std::string& line);
  void error(const std::string& line);  // printed even if quiet

  // `fraction` of the work is done after `seconds`. On a terminal one line that is rewritten; elsewhere a
  // line every five seconds.
  void progress(double seconds, double fraction, int samples, int samples_total, std::uint64_t rays);

 private:
  using Clock = std::chrono::steady_clock;
  void print(const std::string& line, const char* end);

  bool quiet_, terminal_;
  std::string log_file_;
  std::ofstream log_;
  Clock::time_point last_line_ = Clock::now();
};

// What an error says, in one line.
std::string message(const std::exception& error);

// Writes to standard output at once; throws base::Error if that fails, as on a full disk.
void print_result(const std::string& text);

std::string duration(double seconds);  // "0.42 s", "37 s", "4:05 min", "2:10:00 h"
std::string speed(std::uint64_t rays, double seconds);

}  // namespace app
