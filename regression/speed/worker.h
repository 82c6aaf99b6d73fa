// A program that stays alive: one line of JSON to its standard input is a job, one line from its standard
// output the answer. Linux. It ends when its input is closed, and is killed, with what it started, if it does
// not.
#pragma once

#include <sys/types.h>

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace speed {

class Worker {
 public:
  explicit Worker(const std::vector<std::string>& command);  // base::Error if it cannot be started
  ~Worker();
  Worker(const Worker&) = delete;
  Worker& operator=(const Worker&) = delete;

  // Throws base::Error if the program ends or is silent for longer; it is then of no further use.
  nlohmann::json ask(const nlohmann::json& job, double timeout_s);

 private:
  [[noreturn]] void give_up(const std::string& why);
  void end();

  std::string name_;
  pid_t pid_ = 0;
  int socket_ = -1;
  std::string pending_;
};

}  // namespace speed
