// The GoogleTest program over the case files, run as ctest would run it, on a small suite with prepared
// pictures.
#include <gtest/gtest.h>

#include "golden/golden.h"
#include "suite/process.h"
#include "suite/testing.h"

namespace app {
namespace {

using suite::testing::Recipe;
using suite::testing::render;

class CasesProgram : public ::testing::Test {
 protected:
  void SetUp() override {
    for (const char* name : {"a", "b"}) {
      suite_.add_case(
          name,
          R"("witnesses": [{"kind": "analytic", "mean": [0.725, 0.825, 0.925], "margin": 0.01, "source": "s"}])");
      suite_.prepare(name, render({}));
      const suite::Case c = suite::read_case(suite_.layout, name);
      golden::write_pending(suite_.layout, c, suite::hashes_of(suite_.layout, c), render({}), {});
      std::filesystem::create_directories(suite_.layout.root + "/goldens");
      std::filesystem::rename(suite_.layout.pending_file(name), suite_.layout.golden_file(name));
    }
  }
  int run(const std::vector<std::string>& variables, const std::string& filter = "*") {
    std::vector<std::string> words{"/usr/bin/env", "ASSAY_SUITE=" + suite_.layout.root,
                                   "ASSAY_BUILD=" + suite_.layout.build, "ASSAY_RENDERER=" + suite_.command};
    words.insert(words.end(), variables.begin(), variables.end());
    words.insert(words.end(), {ASSAY_BINARY_DIR "/bin/assay_cases_test", "--gtest_filter=" + filter});
    out_.clear();
    return suite::run_process(words, 60, [this](const std::string& line) { return out_ += line + "\n", 0.; })
        .exit_code;
  }
  bool printed(const std::string& text) const { return out_.find(text) != std::string::npos; }
  suite::testing::FakeSuite suite_;
  std::string out_;
};

TEST_F(CasesProgram, has_a_test_per_case_and_per_witness) {
  EXPECT_EQ(run({}), 0) << out_;
  for (const char* name :
       {"Case.a", "Case.b", "Witness.a/analytic", "Witness.b/analytic", "Suite.has_no_orphans"})
    EXPECT_TRUE(printed(std::string("OK ] ") + name)) << out_;
}

TEST_F(CasesProgram, fails_the_test_of_the_case_that_changed_and_says_how_to_accept_it) {
  Recipe changed;
  changed.factor = [](int x, int y) { return x < 8 && y < 8 ? 1.05 : 1; };
  suite_.prepare("b", render(changed));
  EXPECT_EQ(run({}), 1);
  EXPECT_TRUE(printed("OK ] Case.a"));
  EXPECT_TRUE(printed("FAILED  ] Case.b"));
  EXPECT_TRUE(printed("CHANGED: bias of the image"));
  EXPECT_TRUE(printed("assay accept b --suite "));
}

TEST_F(CasesProgram, renders_only_what_is_selected) {
  std::filesystem::remove(suite_.path() + "/prepared/b.1.64.exr");  // to render b would be an error
  EXPECT_EQ(run({}, "Case.a:Witness.a/*"), 0) << out_;
  EXPECT_EQ(run({}, "Witness.b/*"), 1);
}

TEST_F(CasesProgram, is_sharded_by_googletests_variables) {
  int tests = 0;
  for (const char* shard : {"0", "1", "2"}) {
    EXPECT_EQ(run({"GTEST_TOTAL_SHARDS=3", std::string("GTEST_SHARD_INDEX=") + shard}), 0) << out_;
    for (size_t at = out_.find("OK ] "); at != std::string::npos; at = out_.find("OK ] ", at + 1)) ++tests;
  }
  EXPECT_EQ(tests, 5);
}

TEST_F(CasesProgram, has_a_failing_test_for_a_case_it_cannot_read_and_for_orphans) {
  suite_.add_case("b", "\"sead\": 1");
  std::filesystem::copy_file(suite_.layout.golden_file("a"), suite_.layout.golden_file("gone"));
  EXPECT_EQ(run({}), 1);
  EXPECT_TRUE(printed("FAILED  ] Case.b"));
  EXPECT_TRUE(printed("FAILED  ] Suite.has_no_orphans"));
  EXPECT_TRUE(printed("OK ] Case.a"));
}

TEST_F(CasesProgram, cannot_run_without_a_suite) { EXPECT_EQ(run({"ASSAY_SUITE=/nonexistent"}), 2); }

}  // namespace
}  // namespace app
