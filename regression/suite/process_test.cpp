#include "suite/process.h"

#include <gtest/gtest.h>

#include <chrono>
#include <csignal>
#include <thread>

#include "base/error.h"
#include "suite/testing.h"

namespace suite {
namespace {

ProcessEnd shell(const std::string& script, double timeout_s = 20, const OnLine& on_line = {}) {
  return run_process({"/bin/sh", "-c", script}, timeout_s, on_line);
}

TEST(Process, reports_how_a_program_ended) {
  EXPECT_TRUE(shell("exit 0").ok());
  EXPECT_EQ(shell("exit 7").exit_code, 7);
  EXPECT_EQ(shell("echo first >&2; echo the reason >&2; exit 7").reason(),
            "ended with exit code 7: the reason");
  EXPECT_EQ(shell("kill -SEGV $$").signal, SIGSEGV);
  EXPECT_EQ(shell("echo bad pointer >&2; kill -SEGV $$").reason(),
            "crashed with signal 11 (Segmentation fault): bad pointer");
}

TEST(Process, says_why_a_program_could_not_be_started) {
  const ProcessEnd end = run_process({"/nonexistent/renderer"}, 20);
  EXPECT_FALSE(end.ok());
  EXPECT_EQ(end.reason(), "cannot start /nonexistent/renderer: No such file or directory");
}

TEST(Process, kills_the_whole_group_when_time_is_up) {
  const testing::TemporaryFolder folder;
  const auto start = std::chrono::steady_clock::now();
  // A grandchild that would speak later, and a child that waits for it.
  const ProcessEnd end = shell("(sleep 2; touch " + folder.path() + "/alive) & wait", .3);
  EXPECT_TRUE(end.timed_out);
  EXPECT_EQ(end.reason(), "timed out after 0.3 s");
  EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::milliseconds(1800));
  std::this_thread::sleep_for(std::chrono::milliseconds(2200));
  EXPECT_FALSE(std::filesystem::exists(folder.path() + "/alive"));
}

TEST(Process, does_not_wait_for_descendants_that_keep_its_pipes) {
  const auto start = std::chrono::steady_clock::now();
  EXPECT_TRUE(shell("sleep 5 & exit 0").ok());
  EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(3));
}

TEST(Process, does_not_listen_for_ever_to_a_descendant_that_goes_on_writing) {
  const auto start = std::chrono::steady_clock::now();
  EXPECT_TRUE(shell("yes & exit 0").ok());
  EXPECT_TRUE(shell("setsid yes & sleep .2; exit 0", 2).ok());  // one that has left the group
  EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(8));
}

TEST(Process, leaves_nothing_running_when_a_callback_throws) {
  const testing::TemporaryFolder folder;
  EXPECT_THROW(shell("echo a; sleep 1; touch " + folder.path() + "/alive", 20,
                     [](const std::string&) -> double { throw base::Error("disk full"); }),
               base::Error);
  std::this_thread::sleep_for(std::chrono::milliseconds(1300));
  EXPECT_FALSE(std::filesystem::exists(folder.path() + "/alive"));
}

TEST(Process, hands_out_lines_and_lets_them_move_the_deadline) {
  std::vector<std::string> lines;
  const ProcessEnd end =
      shell("echo a; sleep .6; echo b; sleep .6; printf c", 1, [&](const std::string& line) {
        lines.push_back(line);
        return 1.;
      });
  EXPECT_TRUE(end.ok()) << end.reason();
  EXPECT_EQ(lines, (std::vector<std::string>{"a", "b", "c"}));
  EXPECT_TRUE(shell("echo a; sleep .6; echo b; sleep .6; printf c", 1).timed_out);
}

TEST(Process, survives_much_output_on_both_streams) {
  size_t bytes = 0;
  const ProcessEnd end = shell(
      "i=0; while [ $i -lt 3000 ]; do echo 0123456789012345678901234567890123456789; echo "
      "01234567890123456789012345678901234567890123456789 >&2; i=$((i+1)); done",
      20, [&](const std::string& line) { return bytes += line.size(), 0.; });
  EXPECT_TRUE(end.ok());
  EXPECT_EQ(bytes, 3000u * 40u);
  EXPECT_LE(end.error_output.size(), 65536u);
}

TEST(Process, gives_the_program_an_empty_standard_input) { EXPECT_TRUE(shell("! read line").ok()); }

TEST(SplitCommand, follows_a_shells_quotes_and_expands_nothing) {
  using Words = std::vector<std::string>;
  EXPECT_EQ(split_command("a  b\tc"), (Words{"a", "b", "c"}));
  EXPECT_EQ(split_command(R"(a 'b c' "d \"e" f\ g '' $HOME `x`)"),
            (Words{"a", "b c", "d \"e", "f g", "", "$HOME", "`x`"}));
  EXPECT_THROW(split_command("a 'b"), base::Error);
  EXPECT_THROW(split_command("  "), base::Error);
}

}  // namespace
}  // namespace suite
