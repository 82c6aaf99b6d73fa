// The command line and batch jobs: what they accept, and that each mistake is named in one line.
#include "app/options.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <sstream>

#include "app/text.h"
#include "base/error.h"

namespace app {
namespace {

using Words = std::vector<std::string>;

Options parsed(const Words& words) {
  Options options = parse_command_line(words);
  complete(options);
  return options;
}

Options job(const std::string& text, const Words& command_line = {}) {
  Options options = parse_command_line(command_line);
  apply_job(options, nlohmann::json::parse(text));
  complete(options);
  return options;
}

// The message of the error that `action` throws.
template <typename Action>
std::string error_of(const Action& action) {
  try {
    action();
  } catch (const base::Error& error) {
    EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos);
    return error.what();
  }
  return "no error";
}
std::string error_of(const Words& words) {
  return error_of([&] { parsed(words); });
}
std::string error_of_job(const std::string& text) {
  return error_of([&] { job(text); });
}

TEST(CommandLine, reads_every_kind_of_option) {
  const Options o = parsed({"a.glb",
                            "-o",
                            "b.exr",
                            "--shader",
                            "path_disney",
                            "--d-gamma",
                            "1",
                            "--d-constant=0.005",
                            "--spp",
                            "64",
                            "--crop",
                            "1,2,3,4",
                            "--width",
                            "40",
                            "--height",
                            "30",
                            "--hide-environment",
                            "--filter",
                            "blackman-harris",
                            "--layers",
                            "albedo,depth",
                            "--clamp",
                            "10"});
  EXPECT_EQ(o.text("scene"), "a.glb");
  EXPECT_EQ(o.text("out"), "b.exr");
  EXPECT_EQ(o.render.shader, integrator::Shader::path_disney);
  EXPECT_EQ(o.render.d_gamma, 1.f);
  EXPECT_EQ(o.render.d_constant, .005f);
  EXPECT_EQ(o.render.spp, 64);
  EXPECT_EQ(o.text("crop"), "1,2,3,4");
  EXPECT_TRUE(o.render.hide_environment);
  EXPECT_EQ(o.render.filter, integrator::Filter::blackman_harris);
  EXPECT_EQ(o.text("layers"), "albedo,depth");
  EXPECT_EQ(o.render.clamp, 10.f);
}

TEST(CommandLine, reads_every_shader_by_its_own_name) {
  int next = 0;
  for (const char* name : {"path", "path_disney", "principled", "disney", "eyelight", "direct", "path-nomis",
                           "normal", "albedo", "texcoord", "position"})
    EXPECT_EQ(parsed({"a.glb", "-o", "b.exr", "--shader", name}).render.shader,
              static_cast<integrator::Shader>(next++));
}

TEST(CommandLine, takes_negative_numbers_after_a_blank) {
  EXPECT_EQ(parsed({"a.glb", "-o", "b.png", "--exposure", "-1.5"})["exposure"], -1.5f);
  EXPECT_EQ(parsed({"a.glb", "-o", "b.png", "--exposure", "-.5"})["exposure"], -.5f);
}

TEST(CommandLine, names_the_nearest_option_when_one_is_misspelt) {
  EXPECT_EQ(error_of({"a.glb", "-o", "b.exr", "--sppp", "4"}), "there is no option '--sppp'; nearest: --spp");
  EXPECT_EQ(error_of({"--replicate=4", "a.glb"}),
            "there is no option '--replicate=4'; nearest: --replicates");
  EXPECT_NE(error_of({"a.glb", "--qqqqqqqq"}).find("--help"), std::string::npos);
}

TEST(CommandLine, names_the_nearest_choice_when_one_is_misspelt) {
  const std::string error = error_of({"a.glb", "-o", "b.exr", "--shader", "pathdisney"});
  EXPECT_EQ(error.rfind("--shader: wanted one of path, ", 0), 0u) << error;
  EXPECT_NE(error.find("near 'path_disney'"), std::string::npos) << error;
}

TEST(CommandLine, refuses_values_that_are_not_wholly_numbers_in_range) {
  EXPECT_EQ(error_of({"a.glb", "-o", "b.exr", "--spp", "12x"}),
            "--spp: wanted an integer in [1, 16777216], found '12x'");
  for (const char* bad : {"0", "-1", "1.5", "0x10", "99999999999", "", " 4", "nan"})
    EXPECT_EQ(error_of({"a.glb", "-o", "b.exr", "--spp", bad}).rfind("--spp: wanted an integer", 0), 0u)
        << bad;
  for (const char* bad : {"0", "-1", "10.01", "nan", "inf", "1,5", "0x1"})
    EXPECT_EQ(error_of({"a.glb", "-o", "b.exr", "--shader", "path_disney", "--d-gamma", bad})
                  .rfind("--d-gamma: wanted", 0),
              0u)
        << bad;
  EXPECT_EQ(error_of({"a.glb", "-o", "b.exr", "--d-constant", "automatic"})
                .rfind("--d-constant: wanted auto or a number in [0, 1000000]", 0),
            0u);
  EXPECT_EQ(error_of({"a.glb", "-o", "b.exr", "--crop", "1,2,3"}).rfind("--crop: wanted X,Y", 0), 0u);
  EXPECT_EQ(error_of({"a.glb", "-o", "b.exr", "--layers", "albedo,nromal"})
                .rfind("--layers: wanted a list of albedo, ", 0),
            0u);
}

TEST(CommandLine, refuses_a_second_scene_a_missing_scene_and_a_missing_output) {
  EXPECT_NE(error_of({"a.glb", "b.glb", "-o", "c.exr"}).find("second one, 'b.glb'"), std::string::npos);
  EXPECT_NE(error_of({"-o", "c.exr"}).find("no scene"), std::string::npos);
  EXPECT_NE(error_of({"a.glb"}).find("no output"), std::string::npos);
  EXPECT_EQ(error_of({"a.glb", "--info"}), "no error");
}

TEST(CommandLine, refuses_an_option_without_its_value_one_given_twice_and_a_flag_with_a_value) {
  EXPECT_EQ(error_of({"a.glb", "-o", "b.exr", "--spp"}),
            "--spp: wanted an integer in [1, 16777216], found nothing");
  EXPECT_EQ(error_of({"a.glb", "-o"}), "--out: wanted FILE, found nothing");
  EXPECT_EQ(error_of({"a.glb", "-o", ""}), "--out: wanted FILE, found nothing");
  EXPECT_EQ(error_of({"a.glb", "-o", "b.exr", "--spp", "4", "--spp", "8"}),
            "--spp: wanted once, found twice");
  EXPECT_EQ(error_of({"a.glb", "-o", "b.exr", "--quiet=3"}), "--quiet: wanted no value, found one");
  EXPECT_EQ(error_of({"a.glb", "-o", "b.exr", "-x"}), "there is no option '-x' (see assay-render --help)");
  EXPECT_EQ(error_of({"a.glb", "-spp", "4"}), "there is no option '-spp'; nearest: --spp");
}

TEST(CommandLine, says_the_range_of_d_gamma_in_one_way_from_both_ends) {
  for (const char* bad : {"0", "11"})
    EXPECT_EQ(error_of({"a.glb", "-o", "b.exr", "--shader", "path_disney", "--d-gamma", bad}),
              std::string("--d-gamma: wanted a number in (0, 10], found '") + bad + "'");
}

TEST(Complete, refuses_what_does_not_go_together) {
  const auto starts = [](const Words& words, const std::string& with) {
    const std::string error = error_of(words);
    EXPECT_EQ(error.rfind(with, 0), 0u) << error;
  };
  starts({"a.glb", "-o", "b.gif"}, "--out: wanted a name ending in");
  starts({"a.glb", "-o", "b"}, "--out: wanted a name ending in");
  starts({"a.glb", "-o", "b.png", "--layers", "albedo"}, "--layers: only .exr");
  starts({"a.glb", "-o", "b.exr", "--gamma", "2.2"}, "--gamma: only .png and .jpg");
  starts({"a.glb", "-o", "b.exr", "--filmic"}, "--filmic: only .png and .jpg");
  starts({"a.glb", "-o", "b.exr", "--d-gamma", "1"}, "--d-gamma: only --shader path_disney");
  starts({"a.glb", "-o", "b.exr", "--adaptive", "--spp", "15"},
         "--adaptive: wanted at least 16 --spp, a multiple");
  starts({"a.glb", "-o", "b.exr", "--adaptive", "--spp", "16", "--replicates", "8"},
         "--adaptive: wanted at least 16 --spp, a multiple of --replicates and at least 4 times as many");
  starts({"a.glb", "-o", "b.exr", "--noise", "0.1"}, "--noise: only --adaptive has it");
  starts({"a.glb", "-o", "b.exr", "--adaptive", "--noise", "0.1", "--spp", "16"},
         "--noise: wanted at least 8");
  starts({"a.glb", "-o", "b.exr", "--adaptive", "--noise", "0.1", "--time", "2"}, "--noise and --time");
  starts({"a.glb", "-o", "b.exr", "--spp", "20", "--replicates", "8"},
         "--replicates: wanted a divisor of --spp 20, found 8");
  starts({"a.glb", "-o", "b.exr", "--environment", "e.hdr", "--environment-color", "1,1,1"},
         "--environment and");
  EXPECT_EQ(error_of({"a.glb", "-o", "b.JPG", "--gamma", "2.2"}), "no error");
}

TEST(Complete, chooses_replicates_that_divide_the_samples) {
  const auto replicates = [](const char* spp) {
    return parsed({"a.glb", "-o", "b.exr", "--spp", spp}).render.replicates;
  };
  EXPECT_EQ(replicates("256"), 8);
  EXPECT_EQ(replicates("20"), 5);
  EXPECT_EQ(replicates("21"), 7);
  EXPECT_EQ(replicates("13"), 1);
  EXPECT_EQ(replicates("1"), 1);
  EXPECT_EQ(parsed({"a.glb", "-o", "b.exr"}).render.spp, 256);
  // Given replicates alone, the samples give way.
  EXPECT_EQ(parsed({"a.glb", "-o", "b.exr", "--replicates", "5"}).render.spp, 260);
}

TEST(ChooseSize, derives_what_is_missing_from_the_aspect) {
  const auto size = [](const Words& words, float aspect) {
    Words all = {"a.glb", "-o", "b.exr"};
    all.insert(all.end(), words.begin(), words.end());
    Options o = parsed(all);
    choose_size(o, aspect);
    return std::make_pair(o.render.width, o.render.height);
  };
  EXPECT_EQ(size({}, 0), std::make_pair(960, 540));
  EXPECT_EQ(size({}, 2.35f), std::make_pair(1269, 540));
  EXPECT_EQ(size({"--width", "1920"}, 0), std::make_pair(1920, 1080));
  EXPECT_EQ(size({"--height", "1080"}, 2), std::make_pair(2160, 1080));
  EXPECT_EQ(size({"--width", "1"}, 90), std::make_pair(1, 1));
  EXPECT_EQ(size({"--width", "7", "--height", "3"}, 2), std::make_pair(7, 3));
}

TEST(ChooseSize, refuses_a_crop_that_sticks_out) {
  const auto error = [](const char* crop) {
    return error_of([&] {
      Options o = parsed({"a.glb", "-o", "b.exr", "--width", "10", "--height", "8", "--crop", crop});
      choose_size(o, 0);
    });
  };
  EXPECT_EQ(error("5,0,6,1"), "--crop: wanted a part of the 10 x 8 picture, found 5,0,6,1");
  EXPECT_EQ(error("5,1,5,8"), "--crop: wanted a part of the 10 x 8 picture, found 5,1,5,8");
  EXPECT_EQ(error("5,1,5,7"), "no error");
}

TEST(Job, means_the_same_as_the_command_line) {
  const Options a =
      job(R"({"scene": "a.glb", "out": "b.exr", "spp": 64, "shader": "path_disney", "d-gamma": 1,
    "d-constant": 0.005, "crop": [1, 2, 3, 4], "camera": 0, "hide-environment": true, "save-progress": false,
    "environment-color": [0.5, 1, 2], "layers": ["albedo", "depth"]})");
  const Options b = parsed({"a.glb",
                            "-o",
                            "b.exr",
                            "--spp",
                            "64",
                            "--shader",
                            "path_disney",
                            "--d-gamma",
                            "1",
                            "--d-constant",
                            "0.005",
                            "--crop",
                            "1,2,3,4",
                            "--camera",
                            "0",
                            "--hide-environment",
                            "--environment-color",
                            "0.5,1,2",
                            "--layers",
                            "albedo,depth"});
  EXPECT_EQ(command(a, true), command(b, true));
  EXPECT_EQ(a.render.d_constant, .005f);
  EXPECT_FALSE(a["save-progress"]);
}

TEST(Job, starts_from_the_command_line_and_wins_over_it) {
  const Options o = job(R"({"scene": "a.glb", "out": "b.exr", "spp": 16})",
                        {"--batch", "j.json", "--spp", "64", "--threads", "3"});
  EXPECT_EQ(o.render.spp, 16);
  EXPECT_EQ(o.render.threads, 3);
}

TEST(Job, turns_off_a_flag_of_the_command_line) {
  const Words words = {"--batch", "j.json", "--save-progress", "--hide-environment"};
  const Options o = job(R"({"scene": "a.glb", "out": "b.exr", "save-progress": false})", words);
  EXPECT_FALSE(o["save-progress"]);
  EXPECT_TRUE(o.render.hide_environment);
}

TEST(Job, names_the_near_miss_of_an_unknown_key) {
  EXPECT_EQ(error_of_job(R"({"scene": "a.glb", "out": "b.exr", "dgamma": 1})"),
            "there is no option 'dgamma'; nearest: d-gamma");
  EXPECT_EQ(error_of_job(R"({"scene": "a.glb", "outt": "b.exr"})"),
            "there is no option 'outt'; nearest: out");
}

TEST(Job, refuses_values_of_the_wrong_type_and_options_of_the_command_line) {
  EXPECT_EQ(error_of_job(R"({"hide-environment": 1})"), "hide-environment: wanted true or false, found 1");
  EXPECT_EQ(error_of_job(R"({"spp": true})"), "spp: wanted an integer in [1, 16777216], found true");
  EXPECT_EQ(error_of_job(R"({"spp": null})"), "spp: wanted an integer in [1, 16777216], found null");
  EXPECT_EQ(error_of_job(R"({"spp": 1.5})"), "spp: wanted an integer in [1, 16777216], found '1.5'");
  EXPECT_EQ(error_of_job(R"({"crop": [1, [2], 3, 4]})"),
            "crop: wanted X,Y,W,H, each an integer in [0, 32768], found '1,[2],3,4'");
  EXPECT_EQ(error_of_job(R"({"info": true})"), "info: belongs on the command line, not in a job");
  EXPECT_EQ(error_of_job(R"([1])"), "wanted an object of options, found [1]");
}

TEST(Help, names_every_option_its_range_and_default_and_every_exit_code) {
  const std::string text = parse_command_line({"--help"}).answer;
  for (const std::string& name : option_names())
    EXPECT_NE(text.find(name == "scene" ? "scene FILE" : "--" + name), std::string::npos) << name;
  for (const char* part : {"--spp N=256", "--shader NAME=disney", "--seed N=1", "a number in (0, 10]",
                           "an integer in [1, 16777216]", "auto or a number in [0, 1000000]",
                           "one of box, triangle, blackman-harris", "[-64, 64]", "[0.1, 10]",
                           "X,Y,W,H, each an integer in [0,", "\n  0    ", "\n  2    ", "\n  130  "})
    EXPECT_NE(text.find(part), std::string::npos) << part;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) EXPECT_LE(line.size(), 110u) << line;
}

TEST(Command, quotes_what_a_shell_would_change_and_leaves_out_folders_if_told_to) {
  const Options o = parsed({"x/a b.glb", "-o", "/y/it's.exr", "--spp", "4", "--environment", "z/e.hdr"});
  EXPECT_EQ(command(o, true),
            "assay-render 'x/a b.glb' --spp 4 --environment z/e.hdr --out '/y/it'\\''s.exr'");
  EXPECT_EQ(command(o, false), "assay-render 'a b.glb' --spp 4 --environment e.hdr --out 'it'\\''s.exr'");
}

TEST(Nearest, finds_slips_and_beginnings_but_not_strangers) {
  const std::vector<std::string> words = {"spp", "seed", "environment", "environment-color"};
  EXPECT_EQ(nearest("environmnet", words), ", near 'environment'");
  EXPECT_EQ(nearest("env", words), ", near 'environment'");
  EXPECT_EQ(nearest("sed", words, "; nearest: --", ""), "; nearest: --seed");
  EXPECT_EQ(nearest("threads", words), "");
}

}  // namespace
}  // namespace app
