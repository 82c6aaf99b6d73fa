#include "suite/process.h"

#include <fcntl.h>
#include <poll.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstring>
#include <sstream>

#include "base/error.h"

namespace suite {
namespace {

using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

struct Pipe {
  int ends[2] = {-1, -1};
  Pipe() {
    if (pipe2(ends, O_CLOEXEC) != 0) base::fail("cannot make a pipe: ", std::strerror(errno));
  }
  ~Pipe() { close_read(), close_write(); }
  Pipe(const Pipe&) = delete;
  Pipe& operator=(const Pipe&) = delete;
  void close_read() { shut(ends[0]); }
  void close_write() { shut(ends[1]); }

 private:
  static void shut(int& end) {
    if (end >= 0) close(end);
    end = -1;
  }
};

// The group of the program under way, for the signal handler.
std::atomic<pid_t> running_group{0};
static_assert(std::atomic<pid_t>::is_always_lock_free);

// An interrupted judge takes the whole group with it, grandchildren too, and then ends as the signal says.
void end_with_group(int number) {
  if (const pid_t group = running_group; group > 0) kill(-group, SIGKILL);
  signal(number, SIG_DFL);
  raise(number);
}

// A started program. Never left running: not even if a callback throws or the judge is interrupted.
class Child {
 public:
  explicit Child(pid_t pid) : pid_(pid) {
    running_group = pid;
    for (const int number : {SIGINT, SIGTERM, SIGHUP}) signal(number, end_with_group);
  }
  ~Child() { end(); }
  Child(const Child&) = delete;
  Child& operator=(const Child&) = delete;

  // Looked at, not reaped: as a zombie it keeps its number, so that end() can hit no stranger.
  bool has_exited() const {
    siginfo_t information{};
    return waitid(P_PID, static_cast<id_t>(pid_), &information, WEXITED | WNOHANG | WNOWAIT) == 0 &&
           information.si_pid == pid_;
  }
  void kill_group() const { kill(-pid_, SIGKILL); }
  // Kills what is left of its group and returns how it ended, as waitpid says it.
  int end() {
    if (pid_ > 0) {
      kill_group();
      running_group = 0;
      wait4(pid_, &status_, 0, &usage_);
    }
    pid_ = 0;
    return status_;
  }
  double peak_mb() const { return static_cast<double>(usage_.ru_maxrss) / 1024; }  // after end()

 private:
  pid_t pid_;
  int status_ = 0;
  rusage usage_{};
};

// In the child, between fork and exec: only calls that are safe there.
[[noreturn]] void become(char* const* arguments, const Pipe& out, const Pipe& err, const Pipe& failure) {
  setpgid(0, 0);
  prctl(PR_SET_PDEATHSIG, SIGKILL);  // an interrupted judge leaves no renderer behind
  const int null = open("/dev/null", O_RDONLY);
  dup2(null, 0);
  dup2(out.ends[1], 1);
  dup2(err.ends[1], 2);
  execvp(arguments[0], arguments);
  const int error = errno;
  [[maybe_unused]] const ssize_t written = write(failure.ends[1], &error, sizeof error);
  _exit(127);
}

// Reads what is there. False at the end of the stream.
bool read_some(int fd, std::string& text) {
  char buffer[4096];
  const ssize_t count = read(fd, buffer, sizeof buffer);
  if (count > 0) text.append(buffer, static_cast<size_t>(count));
  return count > 0 || (count < 0 && (errno == EAGAIN || errno == EINTR));
}

std::string last_line(const std::string& text) {
  std::string last, line;
  for (std::istringstream lines(text); std::getline(lines, line);)
    if (line.find_first_not_of(" \t\r") != std::string::npos) last = line;
  return last;
}

}  // namespace

std::string ProcessEnd::reason() const {
  std::ostringstream text;
  if (!start_error.empty())
    text << start_error;
  else if (timed_out)
    text << "timed out after " << static_cast<int>(seconds * 10 + .5) / 10. << " s";
  else if (signal != 0)
    text << "crashed with signal " << signal << " (" << strsignal(signal) << ")";
  else
    text << "ended with exit code " << exit_code;
  const std::string last = last_line(error_output);
  if (start_error.empty() && !last.empty()) text << ": " << last;
  return text.str();
}

ProcessEnd run_process(const std::vector<std::string>& arguments, double timeout_s, const OnLine& on_line) {
  Pipe out, err, failure;
  std::vector<char*> pointers;
  for (const std::string& argument : arguments) pointers.push_back(const_cast<char*>(argument.c_str()));
  pointers.push_back(nullptr);

  ProcessEnd end;
  const auto start = Clock::now();
  const pid_t pid = fork();
  if (pid < 0) base::fail("cannot fork: ", std::strerror(errno));
  if (pid == 0) become(pointers.data(), out, err, failure);
  setpgid(pid, pid);  // in both, so that neither order of events loses
  Child child(pid);
  out.close_write(), err.close_write(), failure.close_write();

  int error = 0;
  if (read(failure.ends[0], &error, sizeof error) == sizeof error) {
    end.start_error = "cannot start " + arguments[0] + ": " + std::strerror(error);
    return end;
  }

  fcntl(out.ends[0], F_SETFL, O_NONBLOCK);
  fcntl(err.ends[0], F_SETFL, O_NONBLOCK);
  auto deadline = start + std::chrono::duration<double>(timeout_s);
  std::string pending;
  const auto hand_out_lines = [&](bool all) {
    for (size_t stop; (stop = pending.find('\n')) != std::string::npos || (all && !pending.empty());) {
      const std::string line = pending.substr(0, stop);
      pending.erase(0, stop == std::string::npos ? stop : stop + 1);
      const double seconds = on_line ? on_line(line) : 0;
      if (seconds > 0) deadline = Clock::now() + std::chrono::duration<double>(seconds);
    }
  };

  for (bool exited = false;;) {
    pollfd files[2] = {{out.ends[0], POLLIN, 0}, {err.ends[0], POLLIN, 0}};
    const bool something = poll(files, 2, exited ? 0 : 20) > 0;
    if (files[0].revents && !read_some(out.ends[0], pending)) out.close_read();
    if (files[1].revents && !read_some(err.ends[0], end.error_output)) err.close_read();
    if (end.error_output.size() > 65536) end.error_output.erase(0, end.error_output.size() - 32768);
    hand_out_lines(false);
    // Descendants may keep the pipes open, or go on writing, for ever: the end of the child is the end, once
    // what it has written is read.
    if (exited && (!something || Clock::now() > deadline)) break;
    if (!exited && child.has_exited()) {
      exited = true;
      child.kill_group();
    }
    if (!exited && Clock::now() > deadline) {
      end.timed_out = true;
      break;
    }
    if (out.ends[0] < 0 && err.ends[0] < 0 && !exited) usleep(2000);  // poll has nothing left to wait for
  }
  const int status = child.end();
  hand_out_lines(true);
  end.seconds = seconds_since(start);
  end.peak_mb = child.peak_mb();
  if (!end.timed_out && WIFEXITED(status)) end.exit_code = WEXITSTATUS(status);
  if (!end.timed_out && WIFSIGNALED(status)) end.signal = WTERMSIG(status);
  return end;
}

std::vector<std::string> split_command(const std::string& command) {
  std::vector<std::string> arguments;
  std::string word;
  bool in_word = false;
  char quote = 0;
  for (size_t i = 0; i < command.size(); ++i) {
    const char c = command[i];
    if (quote) {
      if (c == quote)
        quote = 0;
      else if (c == '\\' && quote == '"' && i + 1 < command.size())
        word += command[++i];
      else
        word += c;
    } else if (c == '\'' || c == '"') {
      quote = c, in_word = true;
    } else if (c == '\\' && i + 1 < command.size()) {
      word += command[++i], in_word = true;
    } else if (c == ' ' || c == '\t' || c == '\n') {
      if (in_word) arguments.push_back(word);
      word.clear(), in_word = false;
    } else {
      word += c, in_word = true;
    }
  }
  if (quote) base::fail_in("--renderer", "", "every quote closed", command);
  if (in_word) arguments.push_back(word);
  if (arguments.empty()) base::fail_in("--renderer", "", "a command", "nothing");
  return arguments;
}

}  // namespace suite
