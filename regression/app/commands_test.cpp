// The commands around a run: new cases, undo, summaries, shards; and what a run leaves untouched.
#include "app/commands.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <map>

#include "golden/golden.h"
#include "suite/testing.h"

namespace app {
namespace {

namespace fs = std::filesystem;
using suite::testing::read_text;
using suite::testing::Recipe;
using suite::testing::render;

class Commands : public ::testing::Test {
 protected:
  void SetUp() override {
    if (const char* ci = std::getenv("CI")) ci_ = ci;
    ::unsetenv("CI");
    for (const char* name : {"a", "b"}) {
      suite_.add_case(name);
      suite_.prepare(name, render({}));
    }
  }
  void TearDown() override {
    if (!ci_.empty()) ::setenv("CI", ci_.c_str(), 1);
  }
  int assay(std::vector<std::string> words, const std::string& build = "") {
    words.insert(words.begin(), "assay");
    words.insert(words.end(),
                 {"--suite", suite_.layout.root, "--build", build.empty() ? suite_.layout.build : build});
    if (words[1] == "run") words.insert(words.end(), {"--renderer", suite_.command});
    ::testing::internal::CaptureStdout();
    ::testing::internal::CaptureStderr();
    const int code = assay_main(words);
    out_ = ::testing::internal::GetCapturedStdout();
    err_ = ::testing::internal::GetCapturedStderr();
    return code;
  }
  // Every file of the suite with its contents and time.
  std::map<std::string, std::string> snapshot() const {
    std::map<std::string, std::string> files;
    for (const auto& entry : fs::recursive_directory_iterator(suite_.layout.root))
      files[entry.path().string()] =
          entry.is_regular_file() ? read_text(entry.path().string()) +
                                        std::to_string(entry.last_write_time().time_since_epoch().count())
                                  : "folder";
    return files;
  }
  suite::testing::FakeSuite suite_;
  std::string out_, err_, ci_;
};

TEST_F(Commands, a_run_writes_nothing_beside_its_build_folder) {
  const auto before = snapshot();
  EXPECT_EQ(assay({"run"}, suite_.path() + "/elsewhere"), 1) << "the goldens are missing";
  EXPECT_EQ(snapshot(), before);
  EXPECT_TRUE(fs::exists(suite_.path() + "/elsewhere/pending/a.exr"));
  EXPECT_FALSE(fs::exists(suite_.layout.build));
}

TEST_F(Commands, undo_takes_an_accept_back) {
  EXPECT_EQ(assay({"run"}), 1);
  EXPECT_EQ(assay({"accept", "a", "b", "--because", "First"}), 0) << err_;
  EXPECT_EQ(assay({"run"}), 0) << out_;
  EXPECT_EQ(assay({"undo"}), 0) << err_;
  EXPECT_NE(out_.find("a: the golden is what it was"), std::string::npos);
  EXPECT_FALSE(fs::exists(suite_.layout.golden_file("a")));
  EXPECT_EQ(assay({"undo"}), 2);
  EXPECT_EQ(assay({"accept", "a", "b", "--because", "After all"}), 0) << err_;
}

TEST_F(Commands, shards_are_merged_into_one_report_with_summaries) {
  const std::string one = suite_.path() + "/one", two = suite_.path() + "/two";
  EXPECT_EQ(assay({"run", "-k", "a"}, one), 1);
  EXPECT_EQ(assay({"run", "-k", "b"}, two), 1);
  const std::string junit = suite_.path() + "/junit.xml";
  EXPECT_EQ(assay({"report", "--merge", one, two, "--junit", junit, "--markdown", "-"}), 0) << err_;
  EXPECT_NE(out_.find("2 cases: 2 BROKEN"), std::string::npos) << out_;
  EXPECT_NE(read_text(junit).find("tests=\"2\" failures=\"2\""), std::string::npos) << read_text(junit);
  EXPECT_TRUE(fs::exists(suite_.layout.build + "/report/index.html"));
  EXPECT_EQ(assay({"accept", "a", "b", "--because", "From the shards"}), 0) << err_;
  EXPECT_EQ(assay({"report", "--merge", one, one}), 2);
  EXPECT_NE(err_.find("each case in one shard"), std::string::npos) << err_;
}

TEST_F(Commands, a_new_case_is_checked_before_it_stays) {
  const std::string file = suite_.layout.case_file("fresh");
  EXPECT_EQ(assay({"new-case", "fresh", "--scene", "box.gltf", "--why", "Notices \"this\"."}), 0) << err_;
  EXPECT_EQ(suite::read_case(suite_.layout, "fresh").why, "Notices \"this\".");
  EXPECT_NE(out_.find("assay calibrate fresh"), std::string::npos);
  const std::string text = read_text(file);
  EXPECT_EQ(assay({"new-case", "fresh", "--scene", "box.gltf", "--why", "Again."}), 2);
  EXPECT_EQ(read_text(file), text);
  EXPECT_EQ(assay({"new-case", "Bad/../name", "--scene", "box.gltf", "--why", "x"}), 2);
  EXPECT_EQ(assay({"new-case", "other", "--scene", suite_.path() + "/fake.sh", "--why", "x"}), 2);
  EXPECT_NE(err_.find("a file in "), std::string::npos) << err_;
  EXPECT_EQ(assay({"new-case", "other", "--scene", "box.gltf", "--why", ""}), 2);
  EXPECT_EQ(assay({"new-case", "other", "--scene", "box.gltf", "--why", "x", "--shader", "phong"}), 2);
  EXPECT_EQ(assay({"new-case", "other", "--scene", "box.gltf", "--why", "x", "--spp", "9"}), 2);
  EXPECT_FALSE(fs::exists(suite_.layout.case_file("other")));
}

}  // namespace
}  // namespace app
