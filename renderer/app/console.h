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
  // Throws base::Error if the log cannot be written.
  Console(bool quiet, const std::string& log_file);

  void log(const std::string& line);  // the log only
  void say(const std::string& line);
  void warn(const std::string& line);
  // Errors are printed even if quiet.
  void error(const std::string& line);

  // On a terminal one line that is rewritten; elsewhere a line every five seconds.
  void start_progress();
  void progress(double fraction, int samples, int samples_total, std::uint64_t rays);
  void end_progress();

 private:
  using Clock = std::chrono::steady_clock;
  void print(const std::string& line);

  bool quiet_, terminal_;
  bool line_open_ = false;  // a progress line stands on the terminal and must be wiped first
  std::ofstream log_;
  Clock::time_point start_, last_line_;
};

// What an error says, in one line.
std::string message(const std::exception& error);

// "0.42 s", "37 s", "4:05 min", "2:10:00 h".
std::string duration(double seconds);

}  // namespace app
