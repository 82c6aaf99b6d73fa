// Each test is a defect that some well-known regression suite has or had, and that this one must not have.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <limits>
#include <regex>
#include <set>

#include "app/testing.h"
#include "golden/golden.h"

namespace app {
namespace {

namespace fs = std::filesystem;
using suite::testing::read_text;
using testing::recipe;
using testing::Recipe;
using testing::render;

class NoneOf : public testing::Runs {
 protected:
  std::set<std::string> goldens() const {
    std::set<std::string> files;
    if (fs::is_directory(suite_.layout.root + "/goldens"))
      for (const auto& entry : fs::recursive_directory_iterator(suite_.layout.root + "/goldens"))
        files.insert(entry.path().filename().string());
    return files;
  }
  std::string verdict() { return result("a")["verdict"]; }
};

TEST_F(NoneOf, the_silent_golden_that_is_written_and_passed_when_it_is_missing) {
  for (int time = 0; time < 2; ++time) {
    EXPECT_EQ(run_all(), 1);
    EXPECT_EQ(verdict(), "BROKEN");
    EXPECT_TRUE(goldens().empty());
  }
}

TEST_F(NoneOf, the_case_that_is_skipped_because_its_golden_is_missing) {
  bless({"a"});
  suite_.add_case("b");
  suite_.prepare("b", render(recipe(1)));
  EXPECT_EQ(run_all(), 1);
  EXPECT_EQ(result("b")["verdict"], "BROKEN");
  EXPECT_NE(out_.find("2 cases: 1 IDENTICAL, 1 BROKEN"), std::string::npos) << out_;
}

TEST_F(NoneOf, the_exit_code_that_is_always_0) {
  bless({"a"});
  EXPECT_EQ(run_all(), 0);
  suite_.prepare("a", render(recipe(1, 1.05)));
  EXPECT_EQ(run_all(), 1);
  suite::testing::write_script(suite_.path() + "/fake.sh", "#!/bin/sh\nexit 3\n");
  EXPECT_EQ(run_all(), 2);
}

// What the pages say can be typed, can be typed.
TEST_F(NoneOf, the_documented_option_that_nobody_parses) {
  const std::regex command(
      "assay (run|compare|accept|reject|review|report|audit|calibrate|study (?:null|power))([^`\n#]*)"),
      option("--[a-z][a-z-]*");
  int seen = 0;
  for (const char* page :
       {"/README.md", "/CONTRIBUTING.md", "/docs/judge.md", "/docs/formats.md", "/docs/report.md"}) {
    const std::string text = read_text(ASSAY_SOURCE_DIR + std::string(page));
    for (std::sregex_iterator c(text.begin(), text.end(), command), end; c != end; ++c) {
      std::vector<std::string> words;
      std::istringstream stream((*c)[1].str());
      for (std::string word; stream >> word;) words.push_back(word);
      words.push_back("--help");
      ASSERT_EQ(assay(words), 0) << (*c)[0];
      const std::string help = out_, rest = (*c)[2].str();
      for (std::sregex_iterator o(rest.begin(), rest.end(), option), last; o != last; ++o, ++seen)
        EXPECT_NE(help.find(o->str()), std::string::npos) << page << ": " << (*c)[0];
    }
  }
  EXPECT_GT(seen, 5);
}

TEST_F(NoneOf, the_threshold_that_is_wider_on_ci) {
  bless({"a"});
  suite_.prepare("a", render(recipe(1, 1.002)));
  EXPECT_EQ(run_all(), 1);
  const nlohmann::json here = result("a");
  ::setenv("CI", "true", 1);
  ::setenv("GITHUB_ACTIONS", "true", 1);
  EXPECT_EQ(run_all(), 1);
  ::unsetenv("GITHUB_ACTIONS");
  ::unsetenv("CI");
  for (const char* what : {"verdict", "reason", "limits", "margins", "golden"})
    EXPECT_EQ(result("a")[what], here[what]) << what;
}

TEST_F(NoneOf, the_second_golden_that_may_match_instead) {
  bless({"a"});
  suite_.prepare("a", render(recipe(1, 1.05)));
  fs::copy_file(suite_.layout.golden_file("a"), suite_.layout.golden_file("a_1"));
  EXPECT_EQ(run_all(), 1);
  EXPECT_EQ(verdict(), "CHANGED");
  EXPECT_NE(out_.find("orphan: "), std::string::npos) << out_;
}

// A renderer that gets it right every third time.
TEST_F(NoneOf, the_retry_until_it_is_green) {
  bless({"a"});
  suite_.prepare("b", render(recipe(1, 1.05)));
  suite::testing::write_script(suite_.path() + "/fake.sh",
                               "#!/bin/sh\nif [ -z \"$1\" ]; then exit 2; fi\nn=$(cat " + suite_.path() +
                                   "/count 2>/dev/null || echo 0)\necho $((n + 1)) > " + suite_.path() +
                                   "/count\ncase=b; if [ $n -ge 2 ]; then case=a; fi\ncp " + suite_.path() +
                                   "/prepared/$case.1.64.exr \"$1\"\n");
  EXPECT_EQ(run_all(), 1);
  EXPECT_EQ(verdict(), "CHANGED");
}

TEST_F(NoneOf, the_tag_that_skips_the_comparison) {
  suite_.add_case("a", R"("tags": ["accept", "skip", "flaky", "expected-failure"])");
  bless({"a"});
  suite_.prepare("a", render(recipe(1, 1.05)));
  EXPECT_EQ(run_all(), 1);
  EXPECT_EQ(verdict(), "CHANGED");
}

// Three times what may be called rounding, in a picture without noise, must be seen; a third of it must not.
TEST_F(NoneOf, the_slack_that_cancels_the_stated_level) {
  Recipe still = recipe(1);
  still.noise = 0;
  suite_.prepare("a", render(still));
  bless({"a"});
  still.factor = [](int, int) { return 1 + 3e-5; };
  suite_.prepare("a", render(still));
  EXPECT_EQ(run_all(), 1);
  EXPECT_EQ(verdict(), "CHANGED");
  still.factor = [](int, int) { return 1 + 3e-6; };
  suite_.prepare("a", render(still));
  still.seed = suite::fresh_seed(1, 1);
  suite_.prepare("a", render(still), still.seed);
  EXPECT_EQ(run_all(), 0) << out_;
  EXPECT_EQ(verdict(), "EQUIVALENT");
}

TEST_F(NoneOf, the_nan_that_is_equal_to_everything) {
  bless({"a"});
  image::Render bad = render(recipe(1));
  bad.mean.at(7, 7, 2) = std::numeric_limits<float>::quiet_NaN();
  suite_.prepare("a", bad);
  EXPECT_EQ(run_all(), 1);
  EXPECT_EQ(verdict(), "BROKEN");
  EXPECT_EQ(assay({"accept", "a", "--because", "it is only one"}), 2);
}

TEST_F(NoneOf, the_mask_from_the_candidate_that_hides_what_is_gone) {
  Recipe box = recipe(1);
  box.truth = [](int x, int y, int) { return x >= 10 && y >= 10 ? .4 : .05; };
  suite_.prepare("a", render(box));
  bless({"a"});
  box.truth = [](int, int, int) { return .05; };
  suite_.prepare("a", render(box));
  EXPECT_EQ(run_all(), 1);
  EXPECT_EQ(verdict(), "CHANGED");
}

TEST_F(NoneOf, the_failure_image_that_is_left_beside_the_goldens) {
  bless({"a"});
  const std::set<std::string> before = goldens();
  suite_.prepare("a", render(recipe(1, 1.05)));
  EXPECT_EQ(run_all(), 1);
  EXPECT_EQ(assay({"review"}), 0);
  EXPECT_EQ(assay({"reject", "a"}), 0);
  EXPECT_EQ(goldens(), before);
}

// Nothing that a browser would load by itself: no address, no style sheet, no script of another file.
TEST_F(NoneOf, the_report_that_needs_a_network) {
  bless({"a"});
  suite_.prepare("a", render(recipe(1, 1.05)));
  EXPECT_EQ(run_all(), 1);
  const std::string html = read_text(suite_.layout.build + "/report/index.html");
  ASSERT_NE(html.find("CHANGED"), std::string::npos);
  const std::regex fetches(
      R"re((?:src|href)\s*=\s*["']?(?:https?:)?//|@import|url\(\s*["']?(?:https?:)?//|<link[^>]+href|<script[^>]+src)re");
  std::smatch found;
  EXPECT_FALSE(std::regex_search(html, found, fetches)) << found.str();
}

}  // namespace
}  // namespace app
