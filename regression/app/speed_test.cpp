// `assay speed` from the command line: errors in one line, and a run of renderers whose answers are known.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "app/testing.h"
#include "image/io.h"
#include "speed/compare.h"
#include "speed/contestants.h"
#include "speed/measure.h"
#include "speed/series.h"

namespace app {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

void write_text(const std::string& file, const std::string& text) {
  image::write_file(file, text.data(), text.size());
}

class Speed : public testing::Runs {
 protected:
  void SetUp() override {
    Runs::SetUp();
    write_text(suite_.layout.root + "/speed/scenes.json",
               R"({"scenes": [{"name": "grey", "what": "grey"}], "series": [{"name": "size", "axis": "pixels",
                   "points": [{"scene": "grey", "x": 8, "size": 8}, {"scene": "grey", "x": 16, "size": 16}]}]})");
    write_text(suite_.layout.build + "/speed/scenes/grey.glb", "any");
  }
  static std::string stub(const std::string& name, const std::string& speed, const std::string& noise,
                          const std::string& bias) {
    return name +
           "=/usr/bin/python3 '" ASSAY_SOURCE_DIR
           "/regression/speed/stub.py' {scene} {out} {width} {height} {spp} {seed} " +
           speed + " " + noise + " " + bias;
  }
  int speed(std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), {"speed", "--only-given"});
    return assay(arguments);
  }
  json results() { return suite::read_json(suite_.layout.build + "/speed/results.json"); }
};

TEST_F(Speed, says_in_one_line_what_is_wrong_with_the_command) {
  const auto expect = [&](const std::vector<std::string>& arguments, const std::string& part) {
    EXPECT_EQ(speed(arguments), 2) << part;
    EXPECT_EQ(std::count(err_.begin(), err_.end(), '\n'), 1) << err_;
    EXPECT_NE(err_.find(part), std::string::npos) << err_;
  };
  expect({}, "wanted --renderer NAME='CMD …'");
  expect({"--renderer", "true {scene} {out}"}, "wanted NAME='CMD {scene} {out} …'");
  expect({"--renderer", "x=true {scene} {out} {width} {height} {spp}"}, "wanted {seed} in the command");
  expect({"--renderer", "x=true {scene} {out} {sped}"}, "wanted one of {scene} {out}");
  expect({"-k", "gray"}, "wanted a pattern that one of grey, growth_size, small has, found 'gray'");
  expect({"--size", "4"}, "--size");
  expect({"--size", "5"}, "--size: wanted a number from 8 to 4096, found 5");
  expect({"--seconds-per-scene", "nan"}, "wanted a number from");
  expect({"--page"}, "wanted measurements (assay speed), found none");
  fs::remove_all(suite_.layout.build + "/speed");
  expect({"--renderer", stub("x", "1", "1", "0")}, "wanted the scenes that scripts/make-speed-scenes makes");
}

TEST_F(Speed, tells_a_renderer_that_fails_and_keeps_the_others_parts) {
  EXPECT_EQ(speed({"-k", "grey", "--renderer",
                   "x=/usr/bin/python3 -c 'import sys; sys.exit(\"no light\")' {scene} {out} {width} "
                   "{height} {spp} {seed}"}),
            2);
  EXPECT_NE(err_.find("ended with exit code 1: no light"), std::string::npos) << err_;
}

// One is four times slower than the other at equal noise, and has a bias of .02; both by construction.
TEST_F(Speed, finds_the_ratio_of_times_the_exponent_and_the_bias_that_were_planted) {
  ASSERT_EQ(speed({"--size", "32", "--seconds-per-scene", "3", "--renderer",
                   stub("assay", ".0001", ".04", "0"), "--renderer", stub("other", ".0004", ".04", ".02")}),
            0)
      << err_;
  const json scene = results()["scenes"]["grey"];
  // Own converged pictures: the bias is not in the errors. 3,072 numbers a picture: a squared error is known
  // to 2.6 %, a ratio of two to 3.6 %, the middle of three rounds to less: 15 % is more than 5 sigma.
  const auto ratio = speed::equal_error(scene, "assay", "other", "mse");
  ASSERT_TRUE(ratio);
  EXPECT_NEAR(ratio->value, 4, .6);
  EXPECT_GT(ratio->error, .004);
  EXPECT_LT(ratio->error, .4);
  // FLIP falls with the root of the samples, and the other's picture is brighter.
  EXPECT_NEAR(speed::equal_error(scene, "assay", "other", "flip")->value, 4, 1.5);
  EXPECT_NEAR(speed::fit(scene["contestants"]["assay"])->p, 1, .03);
  // Efficiency: four times at equal noise.
  EXPECT_NEAR(speed::efficiency(scene["contestants"]["assay"], 64) /
                  speed::efficiency(scene["contestants"]["other"], 64),
              4, .6);
  // The means differ by the bias; each by itself has none.
  EXPECT_NEAR(
      scene["references"]["other"]["mean"].get<double>() - scene["references"]["assay"]["mean"].get<double>(),
      .02, .002);
  for (const char* name : {"assay", "other"}) {
    const json bias = scene["contestants"][name]["mean_bias"];
    EXPECT_LT(std::abs(bias[0].get<double>()), 5 * bias[1].get<double>());
    EXPECT_LT(bias[1].get<double>(), .003);
  }
  const json points = results()["series"]["size"]["points"];
  ASSERT_EQ(points.size(), 2);
  EXPECT_NEAR(points[1]["other"]["seconds"].get<double>() * 256 / .0004, 1, 1e-9);
  EXPECT_TRUE(fs::exists(suite_.layout.build + "/speed/index.html"));
}

// One of two has a bias of 4 % of the mean; variance .04 / 64 in 3,072 numbers leaves means of 20 pictures
// uncertain by .02 % each.
TEST_F(Speed, measures_the_bias_of_a_family_until_its_interval_is_what_was_asked_for) {
  std::vector<speed::Contestant> contestants = {speed::custom_contestant(stub("fixed", "0", ".04", "0")),
                                                speed::custom_contestant(stub("adaptive", "0", ".04", ".02")),
                                                speed::custom_contestant(stub("stranger", "0", ".04", "0"))};
  contestants[1].family = contestants[0].family, contestants[1].is_reference = false;
  speed::Plan plan;
  plan.size = 32, plan.seconds = 30;
  speed::Runner runner(suite_.layout.build + "/scratch");
  const json bias =
      speed::measure_bias(suite_.layout.build + "/speed/scenes/grey.glb", 1, plan, contestants, runner);
  ASSERT_EQ(bias.size(), 1);
  EXPECT_EQ(bias["adaptive"]["pictures"], 20);
  const double relative = bias["adaptive"]["relative"], error = bias["adaptive"]["error"];
  EXPECT_GT(error, 0);
  EXPECT_LT(error, .001);
  EXPECT_NEAR(relative, .04, 5 * error);
}

TEST_F(Speed, writes_its_section_of_a_page_and_makes_it_again_without_measuring) {
  const std::string page = suite_.layout.build + "/page.md";
  write_text(page, "before\n<!-- study speed -->\nold\n<!-- /study speed -->\nafter\n");
  ASSERT_EQ(speed({"-k", "grey", "--size", "8", "--seconds-per-scene", ".1", "--rounds", "2", "--write", page,
                   "--renderer", stub("assay", ".001", ".04", "0"), "--renderer",
                   stub("other", ".001", ".04", "0")}),
            0)
      << err_;
  const std::string first = suite::testing::read_text(page);
  EXPECT_EQ(first.find("old"), std::string::npos);
  EXPECT_EQ(first.rfind("before\n<!-- study speed -->\n`assay speed", 0), 0);
  EXPECT_NE(first.find("| grey | assay |"), std::string::npos);
  ASSERT_EQ(speed({"--page", "--write", page}), 0) << err_;
  EXPECT_NE(suite::testing::read_text(page).find("| grey | assay |"), std::string::npos);
}

// What `assay speed` asks of assay-render by itself, at the fewest samples it asks for.
TEST_F(Speed, asks_our_own_renderer_for_what_it_can_do) {
  int ours = 0;
  for (const speed::Contestant& c :
       speed::default_contestants(ASSAY_SOURCE_DIR "/regression", ASSAY_BINARY_DIR)) {
    if (c.family != "assay") continue;
    suite::Job job;
    job.scene = ASSAY_SOURCE_DIR "/regression/scenes/cornell.glb";
    job.out = suite_.layout.build + "/" + std::to_string(ours++) + ".exr";
    job.width = job.height = 8;
    job.spp = c.first, job.replicates = 1, job.depth = 2, job.seed = 1;
    const suite::Outcome outcome = c.command->run({job}, suite_.layout.build).front();
    EXPECT_TRUE(outcome.ok) << c.name << ": " << outcome.error;
  }
  EXPECT_EQ(ours, 2);  // fixed and adaptive
}

TEST(SpeedLevels, are_left_out_from_the_dearest_but_never_those_compared) {
  speed::Contestant cheap, dear, adaptive;
  cheap.first = dear.first = 4, cheap.last = dear.last = 256;
  adaptive.first = 128, adaptive.last = 256, adaptive.compared_at = 256;
  using Levels = std::vector<std::vector<int>>;
  EXPECT_EQ(speed::choose_levels({cheap}, {1}, 1, 1e9), (Levels{{4, 8, 16, 32, 64, 128, 256}}));
  EXPECT_EQ(speed::choose_levels({cheap, dear, adaptive}, {1, 4, 4}, 3, 1),
            (Levels{{4, 8, 16, 32, 64}, {4, 8, 16, 32, 64}, {128, 256}}));
  // 508 + 4 x 508 = 2540; without the dear one's highest 1516.
  EXPECT_EQ(speed::choose_levels({cheap, dear}, {1, 4}, 1, 1600),
            (Levels{{4, 8, 16, 32, 64, 128, 256}, {4, 8, 16, 32, 64, 128}}));
}

}  // namespace
}  // namespace app
