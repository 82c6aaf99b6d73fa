#include "report/summaries.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>

#include "base/error.h"
#include "report/report.h"
#include "report/results.h"
#include "suite/testing.h"

namespace report {
namespace {

using suite::testing::read_text;
using suite::testing::write_text;

bool contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

class Summaries : public ::testing::Test {
 protected:
  std::string path(const std::string& name) const { return folder_.path() + "/" + name; }

  // A build folder `name` beside regression/, as a run leaves it.
  std::string run(const std::string& name, const std::vector<Json>& results, const std::string& orphan = "") {
    Json run = {
        {"finished", "2026-01-02T03:04:05Z"}, {"seconds", 2.5}, {"exit_code", 1}, {"suite", "../regression"}};
    run["cases"] = Json::array(), run["orphans"] = Json::array();
    if (!orphan.empty()) run["orphans"].push_back(orphan);
    for (const Json& r : results) {
      run["cases"].push_back(r["case"]);
      write_text(path(name) + "/results/" + r["case"].get<std::string>() + ".json", r.dump());
      write_text(path(name) + "/renders/" + r["case"].get<std::string>() + ".exr", "a picture");
    }
    write_text(path(name) + "/run.json", run.dump());
    return path(name);
  }
  static Json result(const std::string& name, const std::string& verdict, const std::string& reason = "") {
    return {
        {"case", name},
        {"verdict", verdict},
        {"passed", reason.empty()},
        {"reason", reason},
        {"seconds", .5},
        {"accept", reason.empty() ? "" : "assay accept " + name + " --because \"…\""},
        {"golden",
         {{"images",
           {{"render", "renders/" + name + ".exr"}, {"golden", "../regression/goldens/" + name + ".exr"}}}}},
        {"witnesses",
         {{{"label", "blender"},
           {"verdict", "AGREES"},
           {"passed", true},
           {"images", {{"witness", "../reference/blender/renders/" + name + ".exr"}}}}}}};
  }
  static Json changed() { return result("box", "CHANGED", "bias < 2 % & \"more\",\nline | two"); }

  // What Python's parser makes of an XML text: "tests failures errors skipped", names, messages.
  std::string parsed(const std::string& xml) {
    write_text(path("junit.xml"), xml);
    write_text(path("read.py"),
               "import sys, xml.etree.ElementTree as t\nr = t.parse(sys.argv[1]).getroot()\n"
               "print(r.get('tests'), r.get('failures'), r.get('errors'), r.get('skipped'))\n"
               "for c in r:\n  f = c.find('failure')\n  print(c.get('name'), f.get('message') if f is not "
               "None else '')\n");
    EXPECT_EQ(
        std::system(
            ("/usr/bin/python3 " + path("read.py") + " " + path("junit.xml") + " > " + path("out")).c_str()),
        0);
    return read_text(path("out"));
  }
  suite::testing::TemporaryFolder folder_;
};

TEST_F(Summaries, junit_is_xml_that_a_parser_reads_with_every_case_and_witness) {
  Json error = result("cone", "ERROR", "the renderer died"), quiet = result("disc", "QUIETER");
  quiet["witnesses"][0] = {
      {"label", "povray"}, {"verdict", "SKIPPED"}, {"passed", true}, {"reason", "no povray"}};
  const std::string text =
      parsed(junit(run("build", {changed(), error, quiet}, "goldens/old.exr: wanted a case")));
  EXPECT_TRUE(text.starts_with("7 2 1 1\n")) << text;
  EXPECT_TRUE(contains(text, "box bias < 2 % & \"more\",\nline | two\n")) << text;
  EXPECT_TRUE(contains(text, "disc/povray \n")) << text;
  EXPECT_TRUE(contains(text, "no orphans goldens/old.exr")) << text;
}

TEST_F(Summaries, junit_of_a_witness_that_differs_as_expected_is_no_failure_and_one_that_differs_is) {
  Json box = result("box", "IDENTICAL");
  box["witnesses"][0] = {{"label", "blender"}, {"verdict", "DIFFERS"}, {"passed", true}};
  EXPECT_TRUE(parsed(junit(run("a", {box}))).starts_with("2 0 0 0\n"));
  box["witnesses"][0]["passed"] = box["passed"] = false;
  const std::string text = parsed(junit(run("b", {box})));
  EXPECT_TRUE(text.starts_with("2 1 0 0\n")) << "the golden's own test stays green: " << text;
}

TEST_F(Summaries, markdown_names_what_changed_and_how_to_accept_it) {
  const std::string text = markdown(run("build", {changed(), result("disc", "IDENTICAL")}));
  for (const char* part :
       {"## Assay: 1 to look at", "2 cases: 1 CHANGED, 1 IDENTICAL. Witnesses: 2 AGREES.",
        "| box | CHANGED | bias < 2 % & \"more\", line \\| two |\n", "assay accept box --because"})
    EXPECT_TRUE(contains(text, part)) << part << "\nin\n" << text;
  EXPECT_FALSE(contains(text, "| disc |"));
  EXPECT_TRUE(
      markdown(run("good", {result("disc", "IDENTICAL")})).starts_with("## Assay: nothing changed\n"));
}

TEST_F(Summaries, annotations_escape_what_github_would_misread) {
  const std::string text = annotations(run("build", {changed(), result("disc", "IDENTICAL")}));
  EXPECT_TRUE(
      contains(text, "regression/cases/box.json,title=CHANGED box::bias < 2 %25 & \"more\",%0Aline | two\n"))
      << text;
  EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), 1) << text;
}

TEST_F(Summaries, merge_gathers_shards_and_points_their_paths_to_the_suite) {
  run("one/build", {changed()}, "an orphan");
  run("two/build", {result("disc", "IDENTICAL")}, "an orphan");
  merge(path("checkout/out/build"), path("checkout/regression"), {path("one/build"), path("two/build")});
  const Json whole = Json::parse(read_text(path("checkout/out/build/run.json")));
  EXPECT_EQ(whole["cases"], Json({"box", "disc"}));
  EXPECT_EQ(whole["orphans"], Json({"an orphan"}));
  EXPECT_EQ(whole["exit_code"], 1);
  EXPECT_EQ(whole["seconds"], 5);
  const Json box = Json::parse(read_text(path("checkout/out/build/results/box.json")));
  EXPECT_EQ(box["golden"]["images"]["golden"], "../../regression/goldens/box.exr");
  EXPECT_EQ(box["golden"]["images"]["render"], "renders/box.exr");
  EXPECT_EQ(box["witnesses"][0]["images"]["witness"], "../../reference/blender/renders/box.exr");
  EXPECT_EQ(read_text(path("checkout/out/build/renders/disc.exr")), "a picture");
  EXPECT_TRUE(contains(page(path("checkout/out/build")), ">CHANGED</span>"));
}

TEST_F(Summaries, merge_refuses_a_case_judged_twice_and_a_shard_without_an_end_and_writes_nothing) {
  run("one", {changed()}), run("two", {changed()}), run("three", {result("disc", "IDENTICAL")});
  std::filesystem::remove(path("three/run.json"));
  EXPECT_THROW(merge(path("out"), path("regression"), {path("one"), path("two")}), base::Error);
  EXPECT_THROW(merge(path("out"), path("regression"), {path("one"), path("three")}), base::Error);
  EXPECT_THROW(merge(path("out"), path("regression"), {path("one"), path("nowhere")}), base::Error);
  EXPECT_THROW(merge(path("one"), path("regression"), {path("one")}), base::Error);
  EXPECT_FALSE(std::filesystem::exists(path("out")));
}

}  // namespace
}  // namespace report
