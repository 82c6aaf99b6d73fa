// Runs a program without a shell, in a process group of its own, so that whatever it started dies with it;
// never waits longer than told. Linux.
#pragma once

#include <functional>
#include <string>
#include <vector>

namespace suite {

struct ProcessEnd {
  std::string start_error;  // not empty: it could not be started, and why
  bool timed_out = false;
  int exit_code = -1;        // if it ended by itself
  int signal = 0;            // if a signal ended it
  std::string error_output;  // the last part of what it wrote to stderr
  double seconds = 0;
  double peak_mb = 0;  // largest resident size it had

  bool ok() const { return start_error.empty() && !timed_out && signal == 0 && exit_code == 0; }
  // One line: "timed out after 60 s", "crashed with signal 11 (Segmentation fault): last line of stderr", ...
  std::string reason() const;
};

// Called for each line of stdout; returns the seconds the program may take from now on, 0 to leave the
// deadline alone.
using OnLine = std::function<double(const std::string& line)>;

ProcessEnd run_process(const std::vector<std::string>& arguments, double timeout_s,
                       const OnLine& on_line = {});

// Splits a command into arguments as a shell would: blanks separate, '…' and "…" keep together, a backslash
// takes the next character as it is. Nothing is expanded. Throws base::Error for an open quote or an empty
// command.
std::vector<std::string> split_command(const std::string& command);

}  // namespace suite
