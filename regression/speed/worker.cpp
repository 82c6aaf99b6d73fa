#include "speed/worker.h"

#include <poll.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstring>

#include "base/error.h"

namespace speed {

// One socket is both its standard input and output: MSG_NOSIGNAL then spares the judge a SIGPIPE.
Worker::Worker(const std::vector<std::string>& command) : name_(command.front()) {
  int ends[2];
  if (socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends) != 0)
    base::fail("cannot make a socket: ", std::strerror(errno));
  std::vector<char*> arguments;
  for (const std::string& word : command) arguments.push_back(const_cast<char*>(word.c_str()));
  arguments.push_back(nullptr);
  pid_ = fork();
  if (pid_ == 0) {
    setpgid(0, 0);
    prctl(PR_SET_PDEATHSIG, SIGKILL);
    dup2(ends[1], 0), dup2(ends[1], 1);
    execvp(arguments[0], arguments.data());
    _exit(127);
  }
  close(ends[1]);
  socket_ = ends[0];
  if (pid_ < 0) base::fail("cannot fork: ", std::strerror(errno));
  setpgid(pid_, pid_);
}

Worker::~Worker() { end(); }

void Worker::end() {
  if (socket_ >= 0) close(socket_);
  socket_ = -1;
  if (pid_ <= 0) return;
  // Its input is closed: half a second to leave, then not asked again.
  for (int i = 0; i < 50 && waitpid(pid_, nullptr, WNOHANG) == 0; ++i) usleep(10000);
  kill(-pid_, SIGKILL);
  waitpid(pid_, nullptr, 0);
  pid_ = 0;
}

void Worker::give_up(const std::string& why) {
  end();
  base::fail(name_, ": ", why);
}

nlohmann::json Worker::ask(const nlohmann::json& job, double timeout_s) {
  if (pid_ <= 0) base::fail(name_, ": has ended");
  const std::string line = job.dump() + "\n";
  for (std::size_t sent = 0; sent < line.size();) {
    const ssize_t count = send(socket_, line.data() + sent, line.size() - sent, MSG_NOSIGNAL);
    if (count <= 0 && errno != EINTR) give_up("wanted a program that takes a job, found that it has ended");
    if (count > 0) sent += static_cast<std::size_t>(count);
  }
  const auto deadline = std::chrono::steady_clock::now() + std::chrono::duration<double>(timeout_s);
  for (;;) {
    for (std::size_t stop; (stop = pending_.find('\n')) != std::string::npos;) {
      const nlohmann::json answer = nlohmann::json::parse(pending_.substr(0, stop), nullptr, false);
      pending_.erase(0, stop + 1);
      if (answer.is_object() && answer.contains("ok")) return answer;
    }
    if (std::chrono::steady_clock::now() > deadline) give_up("no answer within its time");
    pollfd file{socket_, POLLIN, 0};
    if (poll(&file, 1, 100) <= 0) continue;
    char buffer[4096];
    const ssize_t count = recv(socket_, buffer, sizeof buffer, 0);
    if (count == 0 || (count < 0 && errno != EINTR)) give_up("wanted an answer, found that it has ended");
    if (count > 0) pending_.append(buffer, static_cast<std::size_t>(count));
  }
}

}  // namespace speed
