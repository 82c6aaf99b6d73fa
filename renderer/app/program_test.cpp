// The program as others see it: exit codes, the one line of an error, JSON, batch files, signals.
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>

#include <chrono>
#include <nlohmann/json.hpp>
#include <sstream>
#include <thread>

#include "app/batch.h"
#include "app/test_scene.h"
#include "base/error.h"
#include "image/exr.h"

namespace app {
namespace {

using nlohmann::json;

const char* const program = ASSAY_BINARY_DIR "/bin/assay-render";

std::string read(const std::string& file) {
  std::ostringstream text;
  text << std::ifstream(file).rdbuf();
  return text.str();
}

struct ProgramTest : testing::Test {
  Folder folder;
  std::string scene = write_scene(folder);
  std::string small = " --width 40 --height 24 --spp 16 ";
  std::string out, err;  // of the last start

  // Returns the exit code; 1000 + signal if it died.
  int start(const std::string& arguments) {
    const std::string command = std::string(program) + " " + arguments + " >" + folder.file("stdout") +
                                " 2>" + folder.file("stderr") + " </dev/null";
    const int status = std::system(command.c_str());
    out = read(folder.file("stdout"));
    err = read(folder.file("stderr"));
    return WIFEXITED(status) ? WEXITSTATUS(status) : 1000 + WTERMSIG(status);
  }
  bool one_error_line() const {
    return err.rfind("assay-render: error: ", 0) == 0 && err.find('\n') == err.size() - 1;
  }
};

TEST_F(ProgramTest, renders_and_is_silent_if_quiet) {
  EXPECT_EQ(start(scene + small + "-o " + folder.file("a.exr") + " --quiet"), 0);
  EXPECT_EQ(out + err, "");
  EXPECT_EQ(image::read_exr(folder.file("a.exr")).mean.width, 40);
}

TEST_F(ProgramTest, exits_with_2_and_one_line_for_what_a_user_did_wrong) {
  folder.write("text.glb", "no scene at all");
  folder.write("empty.gltf", R"({"asset":{"version":"2.0"}})");
  const std::string a = " -o " + folder.file("a.exr") + " ";
  // One of each kind; what options alone can be wrong about is in options_test.cpp.
  for (const std::string& arguments :
       {folder.file("absent.glb") + a, folder.file("text.glb") + a, folder.file("empty.gltf") + a,
        scene + a + "--sppp 4", scene + " -o " + folder.file("no/folder/a.exr"),
        scene + a + "--environment " + folder.file("absent.hdr"), scene + a + "--camera 7",
        scene + a + "--log " + folder.file("no/folder/log"), "--batch " + folder.file("absent")}) {
    EXPECT_EQ(start(arguments), 2) << arguments;
    EXPECT_TRUE(one_error_line()) << arguments << ":\n" << err;
    EXPECT_FALSE(std::filesystem::exists(folder.file("a.exr"))) << arguments;
  }
}

TEST_F(ProgramTest, prints_its_version_and_help_on_standard_output) {
  EXPECT_EQ(start("--version"), 0);
  EXPECT_EQ(out.rfind("assay-render 0.", 0), 0u) << out;
  EXPECT_NE(out.find("(commit "), std::string::npos) << out;
  EXPECT_EQ(start("--help"), 0);
  EXPECT_NE(out.find("Exit codes"), std::string::npos);
  EXPECT_EQ(start(""), 2);
}

TEST_F(ProgramTest, describes_a_scene_without_rendering) {
  EXPECT_EQ(start(scene + " --info --json"), 0);
  const json info = json::parse(out);
  EXPECT_EQ(info.at("triangles"), 6);
  EXPECT_EQ(info.at("instances"), 3);
  EXPECT_EQ(info.at("materials").size(), 3u);
  EXPECT_EQ(info.at("materials").at(2).at("emission"), json::parse("[8,8,8]"));
  EXPECT_EQ(info.at("cameras").at(0).at("name"), "main");
  EXPECT_EQ(info.at("options").at("spp"), 256);
  EXPECT_EQ(start(scene + " --info"), 0);
  for (const char* part : {"'glossy'", "'main'", "3 instances", "size 810 x 540"})
    EXPECT_NE(out.find(part), std::string::npos) << part << "\n" << out;
}

TEST_F(ProgramTest, gives_results_as_json) {
  EXPECT_EQ(start(scene + small + "-o " + folder.file("a.exr") + " --json --quiet"), 0);
  const json ok = json::parse(out);
  EXPECT_EQ(ok.at("ok"), true);
  EXPECT_EQ(ok.at("samples"), 16);
  EXPECT_GT(ok.at("rays"), 40 * 24 * 16);
  EXPECT_EQ(ok.at("rejected"), 0);
  EXPECT_EQ(start(folder.file("absent.glb") + " -o " + folder.file("b.exr") + " --json"), 2);
  const json bad = json::parse(out);
  EXPECT_EQ(bad.at("ok"), false);
  EXPECT_NE(bad.at("error").get<std::string>().find("absent.glb"), std::string::npos);
}

TEST_F(ProgramTest, runs_the_other_jobs_of_a_batch_when_one_fails_and_gives_the_same_pictures) {
  const auto job = [&](const std::string& name, const std::string& more) {
    return R"({"scene":")" + scene + R"(","out":")" + folder.file(name) + R"(","width":40,"height":24)" +
           more + "}";
  };
  const std::string jobs = folder.write(
      "jobs.json", R"({"jobs":[)" + job("1.exr", R"(,"spp":16)") + "," + job("2.exr", R"(,"sppp":16)") + "," +
                       job("3.exr", R"(,"spp":16,"environment-color":[1,1,1])") + "," +
                       job("4.exr", R"(,"spp":16)") + "]}");
  EXPECT_EQ(start("--batch " + jobs + " --json --quiet"), 2);
  EXPECT_EQ(err, "assay-render: error: " + jobs + ": job 2: there is no option 'sppp'; nearest: spp\n");
  std::istringstream lines(out);
  std::string line;
  std::vector<json> results;
  while (std::getline(lines, line)) results.push_back(json::parse(line));
  ASSERT_EQ(results.size(), 4u);
  for (size_t i = 0; i < 4; ++i) {
    EXPECT_EQ(results[i].at("ok"), i != 1);
    EXPECT_EQ(results[i].at("out"), folder.file(std::to_string(i + 1) + ".exr"));
  }
  EXPECT_FALSE(std::filesystem::exists(folder.file("2.exr")));

  EXPECT_EQ(start(scene + small + "-o " + folder.file("alone.exr") + " --quiet"), 0);
  const image::Exr alone = image::read_exr(folder.file("alone.exr"));
  EXPECT_EQ(alone.mean.pixels, image::read_exr(folder.file("1.exr")).mean.pixels);
  EXPECT_EQ(alone.mean.pixels, image::read_exr(folder.file("4.exr")).mean.pixels);
  EXPECT_NE(alone.mean.pixels, image::read_exr(folder.file("3.exr")).mean.pixels);
}

TEST_F(ProgramTest, refuses_files_that_are_no_list_of_jobs) {
  Options options;
  for (const char* text :
       {"", "[]", "{}", R"({"jobs":1})", R"({"jobs":[],"job":[]})", "{\"jobs\":[", "\xff\xfe"}) {
    options.batch = folder.write("jobs.json", text);
    try {
      run_batch(options);
      ADD_FAILURE() << text;
    } catch (const base::Error& error) {
      EXPECT_EQ(std::string(error.what()).rfind(options.batch + ": wanted ", 0), 0u) << error.what();
    }
  }
  folder.write("jobs.json", R"({"jobs":[]})");
  EXPECT_EQ(run_batch(options), 0);
  options.given["scene"] = options.scene = scene;
  EXPECT_THROW(run_batch(options), base::Error);
}

TEST_F(ProgramTest, logs_what_happened_even_if_quiet) {
  const std::string log = folder.file("log");
  EXPECT_EQ(start(scene + small + "-o " + folder.file("a.exr") + " --quiet --log " + log), 0);
  EXPECT_NE(read(log).find("assay-render " + scene), std::string::npos);
  EXPECT_NE(read(log).find("a.exr: 40 x 24, 16 samples"), std::string::npos);
}

// Starts an endless render, waits for its first saved picture, sends a signal, returns the exit code.
int interrupted(const std::string& scene, const std::string& out, int signal) {
  const pid_t child = fork();
  if (child == 0) {
    execl(program, program, scene.c_str(), "-o", out.c_str(), "--width", "40", "--height", "24", "--spp",
          "16777216", "--save-progress", "--quiet", nullptr);
    _exit(99);
  }
  const auto give_up = std::chrono::steady_clock::now() + std::chrono::seconds(120);
  while (!std::filesystem::exists(out) && std::chrono::steady_clock::now() < give_up)
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  EXPECT_EQ(std::get<int>(*image::read_exr(out).metadata.find("assay:partial")), 1) << "saved while it runs";
  kill(child, signal);
  int status = 0;
  waitpid(child, &status, 0);
  return WIFEXITED(status) ? WEXITSTATUS(status) : 1000 + WTERMSIG(status);
}

TEST_F(ProgramTest, writes_the_picture_so_far_marked_partial_when_stopped) {
  for (const int signal : {SIGINT, SIGTERM}) {
    const std::string file = folder.file(std::to_string(signal) + ".exr");
    EXPECT_EQ(interrupted(scene, file, signal), 128 + signal);
    const image::Exr exr = image::read_exr(file);
    EXPECT_EQ(std::get<int>(*exr.metadata.find("assay:partial")), 1);
    const int samples = std::get<int>(*exr.metadata.find("assay:spp"));
    EXPECT_GE(samples, 8);
    EXPECT_LT(samples, 16777216);
    for (int x = 8; x < 32; ++x) EXPECT_GT(math::max_component(exr.mean.at(x, 18)), 0) << x;
  }
  int files = 0;
  for ([[maybe_unused]] const auto& entry : std::filesystem::directory_iterator(folder.file(""))) ++files;
  EXPECT_EQ(files, 4) << "two scene files, two pictures, nothing left over";
}

}  // namespace
}  // namespace app
