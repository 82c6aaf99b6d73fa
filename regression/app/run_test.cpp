// Whole runs with a renderer that hands out prepared pictures, and the commands around them.
#include "app/run.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <limits>

#include "app/calibrate.h"
#include "app/commands.h"
#include "base/error.h"
#include "suite/schema.h"
#include "suite/testing.h"

namespace app {
namespace {

namespace fs = std::filesystem;
using suite::Verdict;
using suite::testing::Recipe;
using suite::testing::render;

Recipe recipe(unsigned seed, double factor = 1, int spp = 64) {
  Recipe r;
  r.seed = seed, r.spp = spp;
  r.factor = [factor](int, int) { return factor; };
  return r;
}

class Runs : public ::testing::Test {
 protected:
  void SetUp() override {
    if (const char* ci = std::getenv("CI")) ci_ = ci;
    ::unsetenv("CI");
    suite_.add_case("a");
    suite_.prepare("a", render(recipe(1)));
  }
  void TearDown() override {
    if (!ci_.empty()) ::setenv("CI", ci_.c_str(), 1);
  }
  // `assay` with these arguments on the fake suite, output swallowed.
  int assay(std::vector<std::string> arguments, bool with_renderer = false) {
    arguments.insert(arguments.begin(), "assay");
    if (arguments.size() > 1 && arguments[1] != "compare" && arguments[1][0] != '-')
      arguments.insert(arguments.end(), {"--suite", suite_.layout.root, "--build", suite_.layout.build});
    if (with_renderer) arguments.insert(arguments.end(), {"--renderer", suite_.command});
    ::testing::internal::CaptureStdout();
    ::testing::internal::CaptureStderr();
    const int code = assay_main(arguments);
    out_ = ::testing::internal::GetCapturedStdout();
    err_ = ::testing::internal::GetCapturedStderr();
    return code;
  }
  int run_all() { return assay({"run"}, true); }
  void bless(const std::vector<std::string>& names) {
    run_all();
    std::vector<std::string> arguments{"accept"};
    arguments.insert(arguments.end(), names.begin(), names.end());
    arguments.insert(arguments.end(), {"--because", "test"});
    ASSERT_EQ(assay(arguments), 0) << err_;
  }
  nlohmann::json result(const std::string& name) { return suite::read_json(suite_.layout.result_file(name)); }
  suite::testing::FakeSuite suite_;
  std::string ci_, out_, err_;
};

TEST_F(Runs, fail_on_a_missing_golden_write_none_and_leave_a_pending_picture) {
  EXPECT_EQ(run_all(), 1);
  EXPECT_EQ(result("a")["verdict"], "BROKEN");
  EXPECT_EQ(result("a")["reason"], "golden missing: " + suite_.layout.golden_file("a"));
  EXPECT_FALSE(fs::exists(suite_.layout.golden_file("a")));
  EXPECT_TRUE(fs::exists(suite_.layout.pending_file("a")));
  EXPECT_EQ(run_all(), 1);  // and do not pass the second time
}

TEST_F(Runs, pass_after_acceptance_and_leave_the_goldens_alone) {
  bless({"a"});
  const std::string before = suite::testing::read_text(suite_.layout.golden_file("a"));
  EXPECT_EQ(run_all(), 0) << out_ << err_;
  EXPECT_EQ(result("a")["verdict"], "IDENTICAL");
  EXPECT_EQ(result("a")["golden"]["measures"][0]["limit"], .2);
  EXPECT_FALSE(fs::exists(suite_.layout.pending_file("a")));
  EXPECT_EQ(suite::testing::read_text(suite_.layout.golden_file("a")), before);
  for (const auto& entry : fs::directory_iterator(suite_.layout.root + "/goldens"))
    EXPECT_TRUE(entry.path().filename() == "a.exr" || entry.path().filename() == "LOG.md") << entry.path();
}

TEST_F(Runs, find_a_changed_picture_and_print_the_command_that_accepts_it) {
  bless({"a"});
  suite_.prepare("a", render(recipe(1, 1.02)));
  EXPECT_EQ(run_all(), 1);
  const nlohmann::json r = result("a");
  EXPECT_EQ(r["verdict"], "CHANGED");
  EXPECT_NE(r["accept"].get<std::string>().find("assay accept a "), std::string::npos);
  EXPECT_NEAR(r["golden"]["paired"]["image"]["luminance"]["relative"].get<double>(), .02, .004);
  EXPECT_TRUE(fs::exists(suite_.layout.build + "/" + r["golden"]["images"]["flip"].get<std::string>()));
  EXPECT_TRUE(fs::exists(suite_.layout.build + "/" + r["golden"]["images"]["golden"].get<std::string>()));
  EXPECT_NE(out_.find("CHANGED"), std::string::npos);
}

TEST_F(Runs, take_a_fresh_seed_and_four_times_the_samples_when_needed) {
  bless({"a"});
  Recipe loud = recipe(1);
  loud.noise = 1;
  suite_.prepare("a", render(loud));
  loud.seed = suite::fresh_seed(1, 1);
  suite_.prepare("a", render(loud), suite::fresh_seed(1, 1));
  loud.seed = suite::fresh_seed(1, 2), loud.spp = 256;
  suite_.prepare("a", render(loud), suite::fresh_seed(1, 2), 256);
  // FLIP and RMSE must not decide here.
  std::string text = suite::testing::read_text(suite_.layout.case_file("a"));
  text.replace(text.find("0.2, \"rmse\": 0.2"), 16, "1, \"rmse\": 100");
  suite::testing::write_text(suite_.layout.case_file("a"), text);
  EXPECT_EQ(run_all(), 1) << out_;
  EXPECT_EQ(result("a")["golden"]["looks"], 2) << out_;
  EXPECT_EQ(result("a")["verdict"], "UNDECIDED") << out_;
}

TEST_F(Runs, call_a_case_whose_hash_moved_stale) {
  bless({"a"});
  suite_.add_case("a", R"("options": {"clamp": 3})");
  EXPECT_EQ(run_all(), 1);
  EXPECT_EQ(result("a")["verdict"], "BROKEN");
  EXPECT_EQ(result("a")["reason"].get<std::string>().substr(0, 12), "golden stale");
}

TEST_F(Runs, call_non_finite_pictures_broken_even_if_the_golden_were_as_bad) {
  bless({"a"});
  image::Render bad = render(recipe(1));
  bad.mean.at(0, 0, 0) = std::numeric_limits<float>::quiet_NaN();
  suite_.prepare("a", bad);
  EXPECT_EQ(run_all(), 1);
  EXPECT_EQ(result("a")["verdict"], "BROKEN");
  EXPECT_EQ(result("a")["accept"], "");
  EXPECT_FALSE(fs::exists(suite_.layout.pending_file("a")));
  EXPECT_EQ(assay({"accept", "a", "--because", "x"}), 2);
}

TEST_F(Runs, have_the_same_limits_where_ci_is_set) {
  bless({"a"});
  suite_.prepare("a", render(recipe(1, 1.002)));
  EXPECT_EQ(run_all(), 1);
  const std::string reason = result("a")["reason"];
  ::setenv("CI", "true", 1);
  EXPECT_EQ(run_all(), 1);
  ::unsetenv("CI");
  EXPECT_EQ(result("a")["reason"], reason);
}

TEST_F(Runs, fail_on_orphans) {
  bless({"a"});
  fs::copy_file(suite_.layout.golden_file("a"), suite_.layout.golden_file("gone"));
  EXPECT_EQ(run_all(), 1);
  EXPECT_NE(out_.find("orphan: "), std::string::npos);
  EXPECT_EQ(suite::read_json(suite_.layout.build + "/run.json")["orphans"].size(), 1u);
}

TEST_F(Runs, end_in_2_when_the_renderer_crashes_and_judge_the_others) {
  bless({"a"});
  suite_.add_case("b");  // nothing prepared: cp fails
  EXPECT_EQ(run_all(), 2);
  EXPECT_EQ(result("b")["verdict"], "ERROR");
  EXPECT_NE(result("b")["reason"].get<std::string>().find("cp: "), std::string::npos);
  EXPECT_EQ(result("a")["verdict"], "IDENTICAL");
}

TEST_F(Runs, end_in_2_when_the_renderer_hangs) {
  suite_.add_case("a", "\"timeout_s\": 0.3");
  suite::testing::write_script(suite_.path() + "/fake.sh", "#!/bin/sh\nsleep 60\n");
  EXPECT_EQ(run_all(), 2);
  EXPECT_NE(result("a")["reason"].get<std::string>().find("timed out after 0.3 s"), std::string::npos);
}

TEST_F(Runs, end_in_2_for_a_bad_case_file_and_judge_the_others) {
  bless({"a"});
  suite_.add_case("b", "\"sead\": 1");
  EXPECT_EQ(run_all(), 2);
  EXPECT_EQ(result("b")["verdict"], "ERROR");
  EXPECT_NE(result("b")["reason"].get<std::string>().find("did you mean \"seed\"?"), std::string::npos);
  EXPECT_EQ(result("a")["verdict"], "IDENTICAL");
}

TEST_F(Runs, do_not_forget_results_of_yesterday) {
  bless({"a"});
  run_all();
  suite::testing::write_script(suite_.path() + "/fake.sh", "#!/bin/sh\nexit 0\n");  // success, but no picture
  EXPECT_EQ(run_all(), 2);
  EXPECT_NE(result("a")["reason"].get<std::string>().find("wrote no "), std::string::npos);
}

TEST_F(Runs, judge_witnesses_and_miss_them) {
  suite_.add_case(
      "a",
      R"("witnesses": [{"kind": "blender", "margin": 0.01}, {"kind": "analytic", "mean": [0.725, 0.825, 0.925], "margin": 0.01, "source": "s"}])");
  const std::string file = suite_.layout.reference + "/blender/renders/a.exr";
  bless({"a"});
  EXPECT_EQ(run_all(), 1);
  EXPECT_EQ(result("a")["verdict"], "IDENTICAL");
  EXPECT_EQ(result("a")["witnesses"][0]["verdict"], "BROKEN");
  EXPECT_EQ(result("a")["witnesses"][1]["verdict"], "AGREES") << result("a")["witnesses"][1].dump(1);

  image::Render stored = render(recipe(50));
  const suite::Case c = suite::read_case(suite_.layout, "a");
  stored.header["assay:picture_hash"] = suite::hashes_of(suite_.layout, c).picture;
  stored.header["assay:script_hash"] = suite::script_hash(suite_.layout.reference + "/blender");
  stored.header["assay:witness"] = std::string("Blender 3.4.1");
  image::write_exr(file, stored);
  EXPECT_EQ(run_all(), 0) << out_;
  EXPECT_EQ(result("a")["witnesses"][0]["verdict"], "AGREES");
  EXPECT_EQ(result("a")["witnesses"][0]["said_by"], "Blender 3.4.1");

  suite::testing::write_text(suite_.layout.reference + "/blender/witness.py", "# changed");
  EXPECT_EQ(run_all(), 1);
  EXPECT_EQ(result("a")["witnesses"][0]["verdict"], "BROKEN");
  EXPECT_NE(result("a")["witnesses"][0]["reason"].get<std::string>().find("stale"), std::string::npos);
}

TEST_F(Runs, skip_a_witness_that_the_renderer_cannot_be_asked_for_unless_witnesses_are_required) {
  bless({"a"});
  suite_.add_case(
      "a", R"("witnesses": [{"kind": "analytic", "mean": [1, 1, 1], "source": "s", "shader": "direct"}])");
  suite_.command = suite_.path() + "/fake.sh {out} {seed} {spp} {scene}";
  EXPECT_EQ(run_all(), 0) << out_;
  EXPECT_EQ(result("a")["witnesses"][0]["verdict"], "SKIPPED");
  EXPECT_NE(out_.find("1 SKIPPED"), std::string::npos);
  EXPECT_EQ(assay({"run", "--require-witnesses"}, true), 1);
}

TEST_F(Runs, give_a_renderer_without_variance_a_seed_per_replicate) {
  for (unsigned r = 0; r < 8; ++r) {
    image::Render one = render(recipe(100 + r, 1, 8));
    one.variance.reset();
    one.layers.clear();
    one.header.clear();
    suite_.prepare("a", one, 1 + 7919 * r, 8);
    if (r == 0) suite_.prepare("a", one, 1, 64);
  }
  bless({"a"});
  EXPECT_EQ(run_all(), 0) << out_;
  const image::Render made = image::read_render(suite_.layout.render_file("a"));
  ASSERT_TRUE(made.variance.has_value());
  double variance = 0, expected = 0;
  for (size_t i = 0; i < made.mean.data.size(); ++i) {
    variance += made.variance->data[i];
    const double truth = .5 + .02 * static_cast<double>(i / 3 % 16) + .01 * static_cast<double>(i / 48) +
                         .1 * static_cast<double>(i % 3);
    expected += std::pow(truth * .02, 2) * 8 /
                64;  // eight replicates of the recipe, averaged over 8 seeds, at 8 samples
  }
  EXPECT_NEAR(variance / expected, 1, .1);
}

TEST_F(Runs, end_with_a_report_that_the_command_report_writes_again) {
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

TEST_F(Runs, select_cases_and_refuse_patterns_that_select_none) {
  suite_.add_case("b");
  bless({"a"});
  EXPECT_EQ(assay({"run", "-k", "a"}, true), 0) << out_;
  EXPECT_EQ(assay({"run", "-k", "zzz"}, true), 2);
  EXPECT_EQ(assay({"run", "--list"}), 0);
  EXPECT_EQ(out_, "a\n    A test.\nb\n    A test.\n");
}

TEST_F(Runs, measure_noise_and_write_limits_into_the_case) {
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
  ::setenv("CI", "1", 1);
  EXPECT_EQ(assay({"calibrate", "a"}, true), 2);
  ::unsetenv("CI");
}

TEST_F(Runs, choose_samples_that_the_margins_need) {
  suite::Case c = suite::read_case(suite_.layout, "a");
  c.margin_tile = 1, c.margin_image = .002;
  const SampleNeed need = samples_needed(c, render(recipe(1)));
  // sqrt(2) * .02 / sqrt(8 * 256) = .0625 %, times 2.6 for 99 %, times 1.13 for the brightest channel,
  // against .7 * .2 %.
  EXPECT_NEAR(need.image, 1.31, .08);
  EXPECT_EQ(need.spp, 128);
  EXPECT_DOUBLE_EQ(round_up(.01234), .013);
  EXPECT_DOUBLE_EQ(round_up(120), 120);
}

TEST_F(Runs, audit_what_is_stored_without_rendering) {
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

TEST_F(Runs, review_lists_what_is_pending_and_reject_empties_it) {
  run_all();
  EXPECT_EQ(assay({"review"}), 0);
  EXPECT_NE(out_.find("golden missing"), std::string::npos);
  EXPECT_NE(out_.find("accept a "), std::string::npos);
  EXPECT_EQ(assay({"reject", "a"}), 0);
  EXPECT_EQ(assay({"review"}), 0);
  EXPECT_EQ(out_, "nothing is pending\n");
  EXPECT_EQ(assay({"reject", "a"}), 2);
}

TEST_F(Runs, compare_pictures_with_exit_codes_that_mean_something) {
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
  EXPECT_EQ(assay({"compare", b, b, "--max-flip", "1"}), 1);
  Recipe small = recipe(1);
  small.width = 8;
  image::write_exr(b, render(small));
  EXPECT_EQ(assay({"compare", a, b}), 2);
  EXPECT_EQ(assay({"compare", a, suite_.path() + "/absent.exr"}), 2);
  EXPECT_EQ(assay({"compare", a, b, "--hdr", "--ldr"}), 2);
}

TEST_F(Runs, name_what_was_meant_by_a_wrong_word) {
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
}

}  // namespace
}  // namespace app
