#include "app/console.h"

#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <ctime>
#include <iomanip>
#include <new>

#include "base/error.h"

namespace app {
namespace {

constexpr std::chrono::seconds plain_interval{5};

template <typename... Values>
std::string format(const char* pattern, Values... values) {
  char text[256];
  std::snprintf(text, sizeof text, pattern, values...);
  return text;
}

}  // namespace

std::string duration(double seconds) {
  const long whole = std::lround(seconds);
  if (seconds < 10) return format("%.2f s", seconds);
  if (whole < 60) return format("%ld s", whole);
  if (whole < 3600) return format("%ld:%02ld min", whole / 60, whole % 60);
  return format("%ld:%02ld:%02ld h", whole / 3600, whole / 60 % 60, whole % 60);
}

std::string speed(std::uint64_t rays, double seconds) {
  return format("%.1f Mrays/s", static_cast<double>(rays) * 1e-6 / std::max(seconds, 1e-9));
}

std::string message(const std::exception& error) {
  if (dynamic_cast<const std::bad_alloc*>(&error) != nullptr) return "out of memory";
  std::string text = error.what();
  std::replace_if(
      text.begin(), text.end(), [](char c) { return c == '\n' || c == '\r'; }, ' ');
  return text;
}

void print_result(const std::string& text) {
  if (std::fputs(text.c_str(), stdout) < 0 || std::fflush(stdout) != 0)
    base::fail("standard output: cannot write: ", std::strerror(errno));
}

Console::Console(bool quiet) : quiet_(quiet), terminal_(isatty(STDERR_FILENO) != 0) {}

void Console::open_log(const std::string& file) {
  log_ = {};
  if (!file.empty()) log_.open(log_file_ = file, std::ios::app);
  if (!file.empty() && !log_) base::fail("--log: ", file, ": cannot write: ", std::strerror(errno));
}

void Console::log(const std::string& line) {
  if (!log_.is_open()) return;
  const std::time_t now = std::time(nullptr);
  if (log_ << std::put_time(std::localtime(&now), "%F %T  ") << line << std::endl) return;
  log_.close();
  warn("--log: " + log_file_ + ": cannot write any more: " + std::strerror(errno));
}

// On a terminal the line stays open to be rewritten if `end` is "", and wipes what stood there.
void Console::print(const std::string& line, const char* end) {
  std::fprintf(stderr, "%s%s%s", terminal_ ? "\r\033[K" : "", line.c_str(), end);
  std::fflush(stderr);
}

void Console::say(const std::string& line) {
  log(line);
  if (!quiet_) print(line, "\n");
}

void Console::warn(const std::string& line) { say("assay-render: warning: " + line); }

void Console::error(const std::string& line) {
  log("assay-render: error: " + line);
  print("assay-render: error: " + line, "\n");
}

void Console::progress(double seconds, double fraction, int samples, int samples_total, std::uint64_t rays) {
  const bool plain_due = Clock::now() - last_line_ >= plain_interval;
  if (seconds < .2 || fraction <= 0 || (!terminal_ && !plain_due)) return;
  const std::string line = format("%3.0f %%  %d of %d samples  ", 100 * fraction, samples, samples_total) +
                           speed(rays, seconds) + "  " + duration(seconds * (1 - fraction) / fraction) +
                           " left";
  if (plain_due) {
    last_line_ = Clock::now();
    log(line);
  }
  if (!quiet_) print(line, terminal_ ? "" : "\n");
}

}  // namespace app
