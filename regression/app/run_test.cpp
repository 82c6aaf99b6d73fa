// Whole runs with a renderer that hands out prepared pictures, and the commands around them.
#include "app/run.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <limits>

#include "app/testing.h"
#include "base/error.h"

namespace app {
namespace {

namespace fs = std::filesystem;
using suite::Verdict;
using testing::recipe;
using testing::Recipe;
using testing::render;

class Runs : public testing::Runs {};

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
  EXPECT_EQ(err_.rfind("assay: b: renderer ", 0), 0u) << err_;  // on standard error, too
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

}  // namespace
}  // namespace app
