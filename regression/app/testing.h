// For tests only: `assay` with arguments, on a small suite with prepared pictures.
#pragma once

#include <gtest/gtest.h>

#include <cstdlib>
#include <string>
#include <vector>

#include "app/commands.h"
#include "app/run.h"
#include "suite/schema.h"
#include "suite/testing.h"

namespace app::testing {

using suite::testing::Recipe;
using suite::testing::render;

inline Recipe recipe(unsigned seed, double factor = 1, int spp = 64) {
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
    suite_.prepare("a", render(recipe(77)), 1, 8);  // the quick look: 8 of a replicate's 8 samples
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

}  // namespace app::testing
