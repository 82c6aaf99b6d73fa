// What the commands print, refuse and answer to wrong words.
#include "app/commands.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <limits>

#include "app/calibrate.h"
#include "app/testing.h"
#include "image/io.h"

namespace app {
namespace {

namespace fs = std::filesystem;
using testing::recipe;
using testing::Recipe;
using testing::render;

class CommandLine : public testing::Runs {};

TEST_F(CommandLine, measure_noise_and_write_limits_into_the_case) {
  for (int s = 0; s < 4; ++s)
    suite_.prepare("a", render(recipe(suite::fresh_seed(1, 100 + s))), suite::fresh_seed(1, 100 + s));
  const std::string before = suite::testing::read_text(suite_.layout.case_file("a"));
  EXPECT_EQ(assay({"calibrate", "a", "--dry-run"}, true), 0) << err_;
  EXPECT_EQ(suite::testing::read_text(suite_.layout.case_file("a")), before);
  EXPECT_EQ(assay({"calibrate", "a", "--factor", "2"}, true), 0) << err_;
  const suite::Case c = suite::read_case(suite_.layout, "a");
  // Two renders of 8 replicates differ by sqrt(2/8) of a replicate's noise: .02 of a mean of .82.
  EXPECT_NEAR(c.limits->rmse, 2 * .02 * .84 * std::sqrt(2. / 8), .003);
  EXPECT_GT(c.limits->flip, 0);
  EXPECT_LT(c.limits->flip, .1);
  EXPECT_EQ(assay({"calibrate", "a", "--factor", "4"}, true), 2);  // at most 3 times the floor
  EXPECT_EQ(assay({"calibrate", "--all", "a"}, true), 2);
  EXPECT_EQ(err_, "assay: calibrate: wanted names of cases or --all, found both (a)\n");
  ::setenv("CI", "1", 1);
  EXPECT_EQ(assay({"calibrate", "a"}, true), 2);
  ::unsetenv("CI");
}

TEST_F(CommandLine, choose_samples_that_the_margins_need) {
  suite::Case c = suite::read_case(suite_.layout, "a");
  c.margin_tile = 1, c.margin_image = .002;
  const SampleNeed need = samples_needed(c, render(recipe(1)));
  // The difference of two: sqrt(2) * .02 / sqrt(8 * 256) = .0625 % of a pixel, .98 of it in luminance. To
  // show .2 %, 2.6 of these for 99 % and the brightest channel, against .7 * .2 %: 1.31. To find .2 % takes
  // more: 6.5 of them for a fresh seed's level, 8e-11, and 2.33 to do so 99 times in 100.
  EXPECT_NEAR(need.image, (6.5 + 2.33) * .98 * .0625 / .2, .08);
  EXPECT_EQ(need.spp, 512);
  EXPECT_DOUBLE_EQ(round_up(.01234), .013);
  EXPECT_DOUBLE_EQ(round_up(120), 120);
}

TEST_F(CommandLine, audit_what_is_stored_without_rendering) {
  bless({"a"});
  EXPECT_EQ(assay({"audit"}), 0) << out_;
  suite_.add_case("b");
  EXPECT_EQ(assay({"audit"}), 1);
  EXPECT_NE(out_.find("b: golden missing"), std::string::npos);
  fs::remove(suite_.layout.case_file("b"));
  image::Render golden = image::read_render(suite_.layout.golden_file("a"));
  golden.header.erase("assay:because");
  image::write_exr(suite_.layout.golden_file("a"), golden);
  EXPECT_EQ(assay({"audit"}), 1);
  EXPECT_NE(out_.find("assay:because"), std::string::npos);
}

TEST_F(CommandLine, review_lists_what_is_pending_and_reject_empties_it) {
  run_all();
  EXPECT_EQ(assay({"review"}), 0);
  EXPECT_NE(out_.find("golden missing"), std::string::npos);
  EXPECT_NE(out_.find("accept a "), std::string::npos);
  EXPECT_EQ(assay({"reject", "a"}), 0);
  EXPECT_EQ(assay({"review"}), 0);
  EXPECT_EQ(out_, "nothing is pending\n");
  EXPECT_EQ(assay({"reject", "a"}), 2);
}

TEST_F(CommandLine, compare_pictures_with_exit_codes_that_mean_something) {
  const std::string a = suite_.path() + "/x.exr", b = suite_.path() + "/y.exr",
                    map = suite_.path() + "/map.exr";
  image::write_exr(a, render(recipe(1)));
  image::write_exr(b, render(recipe(2)));
  EXPECT_EQ(assay({"compare", a, a}), 0);
  EXPECT_EQ(assay({"compare", a, b}), 1);
  EXPECT_EQ(assay({"compare", a, b, "--max-flip", "0.5", "--max-rmse", "0.5", "--flip-map", map}), 0);
  // Not a number is no limit, and a map goes into a picture in a folder that exists.
  for (const char* option : {"--max-flip", "--max-rmse", "--ppd"})
    EXPECT_EQ(assay({"compare", a, b, option, "nan"}), 2) << option;
  EXPECT_EQ(assay({"compare", a, b, "--flip-map", map + ".txt"}), 2);
  EXPECT_EQ(assay({"compare", a, b, "--flip-map", "/dev/full"}), 2);
  EXPECT_EQ(assay({"compare", a, b, "--flip-map", map + ".folder/map.exr"}), 2);
  EXPECT_EQ(image::read_render(map).mean.width, 16);
  EXPECT_EQ(assay({"compare", a, b, "--max-rmse", "0.0001"}), 1);
  EXPECT_EQ(assay({"compare", a, b, "--json"}), 1);
  const nlohmann::json j = nlohmann::json::parse(out_);
  EXPECT_EQ(j["flip"]["kind"], "hdr");
  EXPECT_FALSE(j["bias"]["biased"].get<bool>());
  image::Render bad = render(recipe(1));
  bad.mean.at(0, 0, 0) = std::numeric_limits<float>::infinity();
  image::write_exr(b, bad);
  EXPECT_EQ(assay({"compare", b, b}), 1);
  EXPECT_EQ(out_,
            "identical bits, but no pictures to compare: 1 pixels of the reference and 1 of the test are not "
            "finite\n");
  EXPECT_EQ(assay({"compare", b, b, "--max-flip", "1"}), 1);
  EXPECT_EQ(assay({"compare", a, b}), 1);
  EXPECT_EQ(out_, "different: 0 pixels of the reference and 1 of the test are not finite\n");
  Recipe small = recipe(1);
  small.width = 8;
  image::write_exr(b, render(small));
  EXPECT_EQ(assay({"compare", a, b}), 2);
  EXPECT_EQ(assay({"compare", a, suite_.path() + "/absent.exr"}), 2);
  EXPECT_EQ(assay({"compare", a, b, "--hdr", "--ldr"}), 2);
}

TEST_F(CommandLine, name_what_was_meant_by_a_wrong_word) {
  EXPECT_EQ(assay({"acept"}), 2);
  EXPECT_NE(err_.find("did you mean accept?"), std::string::npos);
  EXPECT_EQ(assay({"run", "--patern", "x"}), 2);
  EXPECT_NE(err_.find("--patern"), std::string::npos);
  EXPECT_EQ(assay({"accept", "aa", "--because", "x"}), 2);
  EXPECT_NE(err_.find("did you mean a?"), std::string::npos);
  EXPECT_EQ(assay({"accept", "a"}), 2);  // no reason given
  EXPECT_EQ(assay({}), 2);
  EXPECT_EQ(assay({"--help"}), 0);
  EXPECT_NE(out_.find("assay run"), std::string::npos);
  EXPECT_EQ(assay({"--version"}), 0);
  EXPECT_EQ(out_.rfind("assay 0.", 0), 0u) << out_;
  EXPECT_NE(out_.find("(commit "), std::string::npos);
}

TEST_F(CommandLine, end_with_a_report_that_the_command_report_writes_again) {
  bless({"a"});
  EXPECT_EQ(run_all(), 0);
  const std::string file = suite_.layout.build + "/report/index.html", html = suite::testing::read_text(file);
  EXPECT_NE(out_.find("report: " + file), std::string::npos) << out_;
  EXPECT_NE(html.find("IDENTICAL"), std::string::npos);
  std::filesystem::remove(file);
  EXPECT_EQ(assay({"report"}), 0) << err_;
  EXPECT_EQ(suite::testing::read_text(file), html);
  std::filesystem::remove_all(suite_.layout.build);
  EXPECT_EQ(assay({"report"}), 2);
}

TEST_F(CommandLine, select_cases_and_refuse_patterns_that_select_none) {
  suite_.add_case("b");
  bless({"a"});
  EXPECT_EQ(assay({"run", "-k", "a"}, true), 0) << out_;
  EXPECT_EQ(assay({"run", "-k", "zzz"}, true), 2);
  EXPECT_EQ(assay({"run", "--list"}), 0);
  EXPECT_EQ(out_, "a\n    A test.\nb\n    A test.\n");
}

// Every error begins with the program's name, whoever found it.
TEST_F(CommandLine, complain_in_one_line_with_one_prefix) {
  for (const std::vector<std::string>& wrong : {std::vector<std::string>{"acept"},
                                                {"run", "--patern"},
                                                {"accept", "aa", "--because", "x"},
                                                {"compare", "x.exr", "y.exr"},
                                                {"run", "-k", "zzz"},
                                                {"run", "--renderer", "true"},
                                                {"calibrate"},
                                                {"reject", "a"},
                                                {"study", "null", "--level", "nan"}}) {
    EXPECT_EQ(assay(wrong), 2) << wrong[0];
    EXPECT_EQ(err_.rfind("assay: ", 0), 0u) << err_;
    EXPECT_EQ(err_.find("assay: ", 1), std::string::npos) << err_;
    EXPECT_EQ(std::count(err_.begin(), err_.end(), '\n'), 1) << err_;
  }
}

TEST_F(CommandLine, say_their_ranges) {
  ASSERT_EQ(assay({"calibrate", "--help"}), 0);
  for (const char* range : {"in [2 - 64]", "in [1 - 3]", "in [0.001 - 3600]"})
    EXPECT_NE(out_.find(range), std::string::npos) << range << out_;
}

TEST_F(CommandLine, take_an_empty_ci_for_none) {
  ::setenv("CI", "", 1);
  bless({"a"});
  EXPECT_TRUE(fs::exists(suite_.layout.golden_file("a")));
  EXPECT_EQ(run_all(), 0);
  ::setenv("CI", "true", 1);
  EXPECT_EQ(assay({"accept", "a", "--because", "x"}), 2);
  ::unsetenv("CI");
}

}  // namespace
}  // namespace app
