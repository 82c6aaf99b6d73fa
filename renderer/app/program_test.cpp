// The program as others see it: exit codes, the one line of an error, JSON, batch files, signals.
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>

#include <chrono>
#include <nlohmann/json.hpp>
#include <sstream>
#include <thread>

#include "app/job.h"
#include "app/output.h"
#include "app/test_scene.h"
#include "base/error.h"
#include "image/read_exr_test.h"

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
  std::string before;    // what the shell does first
  std::string out, err;  // of the last start

  // Returns the exit code; 1000 + signal if it died.
  int start(const std::string& arguments, const std::string& standard_output = "") {
    const std::string command = before + program + " " + arguments + " >" +
                                (standard_output.empty() ? folder.file("stdout") : standard_output) + " 2>" +
                                folder.file("stderr") + " </dev/null";
    const int status = std::system(command.c_str());
    out = read(folder.file("stdout"));
    err = read(folder.file("stderr"));
    return WIFEXITED(status) ? WEXITSTATUS(status) : 1000 + WTERMSIG(status);
  }
  std::ptrdiff_t count_files() const {
    return std::distance(std::filesystem::directory_iterator(folder.file("")), {});
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
  const std::string jobs = folder.file("jobs.json");
  const auto error = [&](const std::string& text) {
    folder.write("jobs.json", text);
    EXPECT_EQ(start("--batch " + jobs), 2) << text;
    EXPECT_TRUE(one_error_line()) << err;
    return err;
  };
  for (const char* text :
       {"", "[]", "{}", R"({"jobs":1})", R"({"jobs":[{}],"job":[]})", "{\"jobs\":[", "\xff\xfe"})
    EXPECT_EQ(error(text).rfind("assay-render: error: " + jobs + ": wanted ", 0), 0u) << err;
  EXPECT_EQ(
      error(R"({"jobs":[]})"),
      "assay-render: error: " + jobs + R"(: wanted {"jobs": [...]} with one job or more, found none)" + "\n");
  EXPECT_EQ(error(R"({"jobs":[{"scene":"a","out":"1.exr"},{"spp":4,"scene":"a","spp":8}]})"),
            "assay-render: error: " + jobs + ": job 2: wanted each key once, found \"spp\" twice\n");
  EXPECT_EQ(error(R"({"jobs":[],"jobs":[{}]})"),
            "assay-render: error: " + jobs + ": wanted each key once, found \"jobs\" twice\n");
  EXPECT_EQ(error(R"({"jobs":[{"out":"x/../1.exr"},{"out":"2.exr"},{"out":"./1.exr"}]})"),
            "assay-render: error: " + jobs +
                ": job 3: out: wanted a picture of its own, found that of job 1, './1.exr'\n");
  EXPECT_EQ(start("--batch " + folder.file("")), 2);
  EXPECT_EQ(err,
            "assay-render: error: --batch: " + folder.file("") + ": wanted a file of jobs, found a folder\n");
  EXPECT_EQ(start("--batch absent.json"), 2);
  EXPECT_EQ(err, "assay-render: error: --batch: absent.json: cannot read: No such file or directory\n");
  EXPECT_EQ(start("--batch " + jobs + " -o a.exr"), 2);
  EXPECT_EQ(err, "assay-render: error: --batch: wanted no --out beside it, found 'a.exr'\n");
}

TEST_F(ProgramTest, names_the_option_and_the_file_when_a_file_is_at_fault) {
  const std::string a = folder.file("a.exr"), absent = folder.file("no/a.exr"), here = folder.file("");
  const auto error = [&](const std::string& arguments) {
    EXPECT_EQ(start(arguments), 2) << arguments;
    return err.substr(0, err.size() - 1);
  };
  const std::string prefix = "assay-render: error: ";
  EXPECT_EQ(error(scene + " -o " + absent),
            prefix + "--out: " + absent + ": cannot write: there is no folder " + folder.file("no"));
  EXPECT_EQ(error(scene + " -o " + scene),
            prefix + "--out: wanted a name ending in .exr, .hdr, .png or .jpg, found '" + scene + "'");
  EXPECT_EQ(error(scene + " -o " + a + " --log " + absent),
            prefix + "--log: " + absent + ": cannot write: No such file or directory");
  EXPECT_EQ(error(scene + " -o " + a + " --environment " + absent)
                .rfind(prefix + "--environment: " + absent + ": ", 0),
            0u)
      << err;
  folder.write("a.exr", "no picture");
  EXPECT_EQ(error(scene + " -o " + a + " --environment " + a),
            prefix + "--out: " + a + ": cannot write: it is the file of --environment");
  std::filesystem::create_directory(folder.file("b.exr"));
  EXPECT_EQ(error(scene + " -o " + folder.file("b.exr")),
            prefix + "--out: " + folder.file("b.exr") + ": cannot write: it is a folder");
  EXPECT_EQ(error(folder.file("no.glb") + " -o " + a).rfind(prefix + folder.file("no.glb") + ": ", 0), 0u)
      << err;
}

// A child that is nobody special, so that permissions count even where tests are run by root.
TEST_F(ProgramTest, finds_missing_permissions_before_it_renders) {
  namespace fs = std::filesystem;
  fs::permissions(folder.file(""), fs::perms::owner_all | fs::perms::group_exec | fs::perms::others_exec);
  const auto refused = [&](const std::string& file) {
    const pid_t child = fork();
    if (child == 0) {
      if (geteuid() == 0 && seteuid(65534) != 0) _exit(3);
      Options options;
      options.given = {{"scene", scene}, {"out", file}};
      try {
        check_writable(options);
      } catch (const base::Error& error) {
        _exit(std::string(error.what()).find("Permission denied") != std::string::npos ? 2 : 4);
      }
      _exit(0);
    }
    int status = 0;
    waitpid(child, &status, 0);
    return WEXITSTATUS(status);
  };
  fs::create_directory(folder.file("open"));
  fs::permissions(folder.file("open"), fs::perms::all);
  EXPECT_EQ(refused(folder.file("open/a.exr")), 0);
  folder.write("open/a.exr", "somebody else's");
  fs::permissions(folder.file("open/a.exr"), fs::perms::owner_read);
  EXPECT_EQ(refused(folder.file("open/a.exr")), 2) << "a file that may only be read is not replaced";
  fs::permissions(folder.file("open"),
                  fs::perms::owner_read | fs::perms::others_exec | fs::perms::others_read);
  EXPECT_EQ(refused(folder.file("open/b.exr")), 2);
}

TEST_F(ProgramTest, logs_what_happened_even_if_quiet) {
  const std::string log = folder.file("log");
  EXPECT_EQ(start(scene + small + "-o " + folder.file("a.exr") + " --quiet --log " + log), 0);
  EXPECT_NE(read(log).find("assay-render " + scene), std::string::npos);
  EXPECT_NE(read(log).find("a.exr: 40 x 24, 16 samples"), std::string::npos);
}

// Starts an endless render, waits for its first saved picture, sends a signal, returns the exit code.
int interrupted(const std::string& scene, const std::string& out, int signal,
                const char* crop = "0,0,40,24") {
  const pid_t child = fork();
  if (child == 0) {
    execl(program, program, scene.c_str(), "-o", out.c_str(), "--width", "40", "--height", "24", "--spp",
          "16777216", "--crop", crop, "--save-progress", "--quiet", nullptr);
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
  ASSERT_EQ(start(scene + " --width 40 --height 24 --spp 8 --quiet -o " + folder.file("first.exr")), 0);
  const std::vector<math::Vec3> first = image::read_exr(folder.file("first.exr")).mean.pixels;
  for (const int signal : {SIGINT, SIGTERM}) {
    const std::string file = folder.file(std::to_string(signal) + ".exr");
    EXPECT_EQ(interrupted(scene, file, signal), 128 + signal);
    const image::Exr exr = image::read_exr(file);
    EXPECT_EQ(std::get<int>(*exr.metadata.find("assay:partial")), 1);
    const int samples = std::get<int>(*exr.metadata.find("assay:spp"));
    EXPECT_GE(samples, 8);
    EXPECT_LT(samples, 16777216);
    // Whoever shows light with the samples of the first pass shows it with more.
    int lit = 0;
    for (size_t i = 0; i < first.size(); ++i) {
      if (math::is_black(first[i])) continue;
      ++lit;
      EXPECT_GT(math::max_component(exr.mean.pixels[i]), 0) << i;
    }
    EXPECT_GT(lit, 300);
  }
  // One pixel is always the last one under way.
  EXPECT_EQ(interrupted(scene, folder.file("pixel.exr"), SIGINT, "20,12,1,1"), 128 + SIGINT);
  EXPECT_EQ(std::get<int>(*image::read_exr(folder.file("pixel.exr")).metadata.find("assay:partial")), 1);
  EXPECT_EQ(count_files(), 8)
      << "two scene files, four pictures, standard output and error: nothing left over";
}

// What a limit of the shell says about a file that grows is what a full disk says; a process that does not
// ignore the signal SIGXFSZ is killed in the middle of writing.
TEST_F(ProgramTest, keeps_the_good_picture_when_the_next_cannot_be_written) {
  const std::string out = folder.file("a.exr"),
                    job = scene + " --width 200 --height 200 --spp 8 --quiet -o " + out;
  ASSERT_EQ(start(job), 0);
  const std::string good = read(out);
  ASSERT_GT(good.size(), 20u * 1024);
  before = "ulimit -f 8; trap '' XFSZ; ";
  EXPECT_EQ(start(job + " --seed 2"), 2);
  EXPECT_EQ(err, "assay-render: error: --out: " + out + ": cannot write: File too large\n");
  EXPECT_EQ(read(out), good);
  EXPECT_EQ(count_files(), 5) << "scene, buffer, picture, standard output and error: no leftovers";
  before = "ulimit -f 8; ";
  EXPECT_NE(start(job + " --seed 2"), 0);
  EXPECT_EQ(read(out), good);
}

TEST_F(ProgramTest, fails_if_its_results_cannot_be_written_and_goes_on_without_a_log) {
  const std::string job = scene + small + "-o " + folder.file("a.exr");
  EXPECT_EQ(start(job + " --json --quiet", "/dev/full"), 2);
  EXPECT_EQ(err, "assay-render: error: standard output: cannot write: No space left on device\n");
  EXPECT_EQ(start(job + " --log /dev/full"), 0);
  EXPECT_NE(err.find("warning: --log: /dev/full: cannot write any more: No space left"), std::string::npos)
      << err;
}

TEST_F(ProgramTest, says_that_memory_does_not_suffice) {
  EXPECT_EQ(
      start(scene + " --width 32768 --height 32768 --spp 64 --replicates 64 -o " + folder.file("a.exr")), 2);
  EXPECT_EQ(
      err.rfind("assay-render: error: out of memory: 32768 x 32768 pixels in 64 replicates take 2199.02 GB, ",
                0),
      0u)
      << err;
  EXPECT_TRUE(one_error_line()) << err;
#ifndef ASSAY_SANITIZED  // its shadow does not fit under a limit
  before = "ulimit -v 700000; ";
  EXPECT_EQ(start(scene + " --width 4000 --height 4000 --spp 8 --threads 1 -o " + folder.file("a.exr")), 2);
  EXPECT_EQ(err, "assay-render: error: out of memory\n");
#endif
  EXPECT_FALSE(std::filesystem::exists(folder.file("a.exr")));
}

TEST_F(ProgramTest, leaves_a_whole_picture_when_killed) {
  const std::string out = folder.file("a.exr");
  EXPECT_EQ(interrupted(scene, out, SIGKILL), 1000 + SIGKILL);
  EXPECT_EQ(image::read_exr(out).mean.width, 40);
}

TEST_F(ProgramTest, does_not_disturb_another_run_in_the_same_folder) {
  const std::string log = " --quiet --log " + folder.file("log");
  const auto job = [&](const std::string& name, int seed) {
    return std::string(program) + " " + scene + small + log + " --seed " + std::to_string(seed) + " -o " +
           folder.file(name);
  };
  ASSERT_EQ(std::system((job("1.exr", 1) + " && " + job("2.exr", 2)).c_str()), 0);
  const auto pixels = [&](const std::string& name) { return image::read_exr(folder.file(name)).mean.pixels; };
  const auto one = pixels("1.exr"), two = pixels("2.exr");
  const std::string pair = job("1.exr", 1) + " & " + job("2.exr", 2) + " & " + job("same.exr", 1) + " & " +
                           job("same.exr", 2) + " & ";
  ASSERT_EQ(std::system(("cd " + folder.file("") + "; " + pair + "wait").c_str()), 0);
  EXPECT_TRUE(pixels("1.exr") == one && pixels("2.exr") == two && one != two);
  EXPECT_TRUE(pixels("same.exr") == one || pixels("same.exr") == two);
  EXPECT_EQ(count_files(), 6) << "scene, buffer, three pictures and the log";
  const std::string text = read(folder.file("log"));
  EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), 12) << "a command and a result for each run\n"
                                                            << text;
}

}  // namespace
}  // namespace app
