// The quick look, on prepared pictures.
#include "app/quick.h"

#include <gtest/gtest.h>

#include <filesystem>

#include "app/testing.h"

namespace app {
namespace {

namespace fs = std::filesystem;
using testing::recipe;
using testing::render;

class Quick : public testing::Runs {};

TEST_F(Quick, look_quickly_at_the_first_samples_and_in_full_where_they_differ) {
  suite_.add_case("b");
  suite_.prepare("b", render(recipe(5)));
  suite_.prepare("b", render(recipe(77)), 1, 8);
  bless({"a", "b"});
  const std::string result_file = suite_.layout.result_file("a");
  fs::remove(result_file);
  EXPECT_EQ(assay({"run", "--quick"}, true), 0) << out_ << err_;
  EXPECT_NE(out_.find("2 cases have their golden's first samples"), std::string::npos) << out_;
  EXPECT_FALSE(fs::exists(result_file));
  EXPECT_EQ(suite::read_json(suite_.layout.build + "/run.json")["quick"].dump(), R"(["a","b"])");

  suite_.prepare("b", render(recipe(78)), 1, 8);  // other first samples, the same picture: looked at in full
  EXPECT_EQ(assay({"run", "--quick"}, true), 0) << out_;
  EXPECT_EQ(out_.find("IDENTICAL  a"), std::string::npos);
  EXPECT_NE(out_.find("IDENTICAL  b"), std::string::npos);
  suite_.prepare("b", render(recipe(1, 1.02)));
  EXPECT_EQ(assay({"run", "--quick"}, true), 1) << out_;
  EXPECT_EQ(result("b")["verdict"], "CHANGED");

  // A quick look at stale, missing and uncalibrated goldens is none.
  fs::remove(suite_.layout.golden_file("a"));
  EXPECT_EQ(assay({"run", "--quick", "-k", "a"}, true), 1);
  EXPECT_EQ(result("a")["verdict"], "BROKEN");
  suite_.prepare("b", render(recipe(5)));
  suite_.prepare("b", render(recipe(77)), 1, 8);
  EXPECT_EQ(assay({"run", "--quick", "-k", "b"}, true), 0);
  suite_.add_case("b", "\"camera\": 1");
  EXPECT_EQ(assay({"run", "--quick", "-k", "b"}, true), 1);
}

TEST_F(Quick, renew_a_golden_that_cannot_be_looked_at_quickly) {
  fs::remove(suite_.path() + "/prepared/a.1.8.exr");
  bless({"a"});
  EXPECT_EQ(run_all(), 0);
  EXPECT_TRUE(fs::exists(suite_.layout.pending_file("a")));
  suite_.prepare("a", render(recipe(77)), 1, 8);
  bless({"a"});
  EXPECT_EQ(run_all(), 0);
  EXPECT_FALSE(fs::exists(suite_.layout.pending_file("a")));
}

TEST_F(Quick, is_the_first_samples_of_the_first_replicate) {
  suite::Case c = suite::read_case(suite_.layout, "a");
  EXPECT_EQ(quick_job(suite_.layout, c).spp, 8);
  c.spp = 1024;
  const suite::Job job = quick_job(suite_.layout, c);
  EXPECT_EQ(job.spp, 16);
  EXPECT_EQ(job.replicates, 1);
  EXPECT_EQ(job.seed, c.seed);
}

}  // namespace
}  // namespace app
