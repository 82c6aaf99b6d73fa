#include "app/console.h"

#include <unistd.h>

#include <cstdio>
#include <ctime>
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
  if (seconds < 10) return format("%.2f s", seconds);
  const long whole = static_cast<long>(seconds + .5);
  if (whole < 60) return format("%ld s", whole);
  if (whole < 3600) return format("%ld:%02ld min", whole / 60, whole % 60);
  return format("%ld:%02ld:%02ld h", whole / 3600, whole / 60 % 60, whole % 60);
}

std::string message(const std::exception& error) {
  if (dynamic_cast<const std::bad_alloc*>(&error) != nullptr) return "out of memory";
  std::string text = error.what();
  for (char& c : text)
    if (c == '\n' || c == '\r') c = ' ';
  return text;
}

Console::Console(bool quiet, const std::string& log_file)
    : quiet_(quiet), terminal_(isatty(STDERR_FILENO) != 0) {
  if (log_file.empty()) return;
  log_.open(log_file, std::ios::app);
  if (!log_) base::fail("--log: ", log_file, ": cannot be written");
}

void Console::log(const std::string& line) {
  if (!log_.is_open()) return;
  const std::time_t now = std::time(nullptr);
  std::tm local{};
  localtime_r(&now, &local);
  char time[32];
  std::strftime(time, sizeof time, "%Y-%m-%d %H:%M:%S  ", &local);
  log_ << time << line << std::endl;
}

void Console::print(const std::string& line) {
  if (line_open_) std::fputs("\r\033[K", stderr);
  line_open_ = false;
  std::fputs((line + "\n").c_str(), stderr);
}

void Console::say(const std::string& line) {
  log(line);
  if (!quiet_) print(line);
}

void Console::warn(const std::string& line) { say("assay-render: warning: " + line); }

void Console::error(const std::string& line) {
  log("assay-render: error: " + line);
  print("assay-render: error: " + line);
}

void Console::start_progress() { start_ = last_line_ = Clock::now(); }

void Console::progress(double fraction, int samples, int samples_total, std::uint64_t rays) {
  if (quiet_ && !log_.is_open()) return;
  const Clock::time_point now = Clock::now();
  const double elapsed = std::chrono::duration<double>(now - start_).count();
  const bool plain_due = now - last_line_ >= plain_interval;
  if (elapsed < .2 || fraction <= 0 || (!terminal_ && !plain_due)) return;

  const std::string line = format("%3.0f %%  %d of %d samples  %.1f Mrays/s  ", 100 * fraction, samples,
                                  samples_total, static_cast<double>(rays) / elapsed * 1e-6) +
                           duration(elapsed * (1 - fraction) / fraction) + " left";
  if (plain_due) {
    last_line_ = now;
    log(line);
  }
  if (quiet_) return;
  if (!terminal_) return print(line);
  std::fputs(("\r" + line + "\033[K").c_str(), stderr);
  std::fflush(stderr);
  line_open_ = true;
}

void Console::end_progress() {
  if (line_open_) std::fputs("\r\033[K", stderr);
  line_open_ = false;
}

}  // namespace app
