// The suite as a GoogleTest program: one test per case, one per case and witness, registered from the case
// files when the program starts. The pictures of all selected tests (--gtest_filter, GTEST_TOTAL_SHARDS,
// GTEST_SHARD_INDEX) are rendered in one batch before the first of them.
//
// Environment: ASSAY_SUITE, ASSAY_BUILD (folders, as --suite and --build of assay), ASSAY_RENDERER (a
// template, as
// --renderer), ASSAY_THREADS, ASSAY_REQUIRE_WITNESSES=1.
#include <gtest/gtest.h>

#include <cstdlib>
#include <iostream>
#include <map>
#include <set>

#include "app/results.h"
#include "app/run.h"
#include "base/error.h"

namespace app {
namespace {

std::string environment(const char* name) {
  const char* value = std::getenv(name);
  return value ? value : "";
}

// The run that the tests look into.
struct Judged {
  suite::Layout layout;
  bool require_witnesses = false;
  std::map<std::string, CaseOutcome> cases;
  std::vector<std::string> orphans;
};
Judged judged;

// A test's name is NAME or NAME/WITNESS.
std::string case_of(const std::string& test) { return test.substr(0, test.find('/')); }

class RenderSelected : public testing::Environment {
 public:
  void SetUp() override {
    std::set<std::string> names;
    const testing::UnitTest& all = *testing::UnitTest::GetInstance();
    for (int s = 0; s < all.total_test_suite_count(); ++s) {
      const testing::TestSuite& tests = *all.GetTestSuite(s);
      if (std::string(tests.name()) == "Suite") continue;
      for (int t = 0; t < tests.total_test_count(); ++t)
        if (tests.GetTestInfo(t)->should_run()) names.insert(case_of(tests.GetTestInfo(t)->name()));
    }
    RunOptions options;
    options.layout = judged.layout;
    options.names.assign(names.begin(), names.end());
    options.require_witnesses = judged.require_witnesses;
    options.accept_options = " --suite " + judged.layout.root + " --build " + judged.layout.build;
    const std::string command = environment("ASSAY_RENDERER"), threads = environment("ASSAY_THREADS");
    try {
      options.renderer = command.empty() ? suite::RendererCommand::ours(judged.layout.build)
                                         : suite::RendererCommand::from_template(command);
      if (!threads.empty()) options.renderer.set_threads(std::atoi(threads.c_str()));
      options.on_case = [](const CaseOutcome& c) { std::cout << line_of(c) << std::endl; };
      RunResult result = run(options);
      std::cout << summary_of(options, result) << std::flush;
      for (CaseOutcome& c : result.cases) judged.cases[c.name] = std::move(c);
      judged.orphans = result.orphans;
    } catch (const base::Error& error) {
      FAIL() << error.what();
    }
  }
};

class CaseTest : public testing::Test {
 public:
  explicit CaseTest(std::string name) : name_(std::move(name)) {}
  void TestBody() override {
    const CaseOutcome& outcome = judged.cases.at(name_);
    if (suite::exit_code(outcome.golden.verdict) == 0) return;
    ADD_FAILURE() << suite::name(outcome.golden.verdict) << ": " << outcome.golden.reason
                  << (outcome.a_case ? "\nwhy this case: " + outcome.a_case->why : "")
                  << (outcome.accept_command.empty()
                          ? ""
                          : "\nif the new picture is right: " + outcome.accept_command);
  }

 private:
  std::string name_;
};

class WitnessTest : public testing::Test {
 public:
  WitnessTest(std::string name, std::string label) : name_(std::move(name)), label_(std::move(label)) {}
  void TestBody() override {
    for (const WitnessOutcome& w : judged.cases.at(name_).witnesses) {
      if (w.entry.label != label_) continue;
      if (w.result.verdict == suite::Verdict::skipped && !judged.require_witnesses)
        GTEST_SKIP() << w.result.reason;
      EXPECT_TRUE(w.result.passed) << suite::name(w.result.verdict) << ": " << w.result.reason;
      return;
    }
    FAIL() << "the case has no witness " << label_;
  }

 private:
  std::string name_, label_;
};

class OrphanTest : public testing::Test {
 public:
  void TestBody() override {
    for (const std::string& orphan : judged.orphans) ADD_FAILURE() << orphan;
  }
};

void register_tests() {
  for (const std::string& name : suite::case_names(judged.layout)) {
    const std::string file = judged.layout.case_file(name);
    testing::RegisterTest("Case", name.c_str(), nullptr, nullptr, file.c_str(), 1,
                          [name]() -> testing::Test* { return new CaseTest(name); });
    try {
      for (const suite::Witness& w : suite::read_case(judged.layout, name).witnesses)
        testing::RegisterTest(
            "Witness", (name + "/" + w.label).c_str(), nullptr, nullptr, file.c_str(), 1,
            [name, label = w.label]() -> testing::Test* { return new WitnessTest(name, label); });
    } catch (const base::Error&) {
      // The test of the case itself will say what is wrong with its file.
    }
  }
  testing::RegisterTest("Suite", "has_no_orphans", nullptr, nullptr, __FILE__, __LINE__,
                        []() -> testing::Test* { return new OrphanTest; });
}

}  // namespace
}  // namespace app

int main(int argc, char** argv) {
  testing::InitGoogleTest(&argc, argv);
  try {
    app::judged.layout =
        suite::Layout::find(app::environment("ASSAY_SUITE"), app::environment("ASSAY_BUILD"));
    // Shards may run side by side: each writes into a folder of its own.
    if (const std::string shard = app::environment("GTEST_SHARD_INDEX");
        app::environment("GTEST_TOTAL_SHARDS") > "1")
      app::judged.layout.build += "/shard" + shard;
    app::judged.require_witnesses = app::environment("ASSAY_REQUIRE_WITNESSES") == "1";
    app::register_tests();
  } catch (const base::Error& error) {
    std::cerr << error.what() << "\n";
    return 2;
  }
  testing::AddGlobalTestEnvironment(new app::RenderSelected);
  return RUN_ALL_TESTS();
}
