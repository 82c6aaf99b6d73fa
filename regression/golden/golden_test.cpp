#include "golden/golden.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <limits>

#include "base/error.h"
#include "image/hash.h"
#include "suite/testing.h"

namespace golden {
namespace {

namespace fs = std::filesystem;
using suite::testing::Recipe;
using suite::testing::render;

class Goldens : public ::testing::Test {
 protected:
  void SetUp() override {
    if (const char* ci = std::getenv("CI")) ci_ = ci;
    ::unsetenv("CI");
    suite_.add_case("a");
    suite_.add_case("b");
  }
  void TearDown() override {
    if (!ci_.empty()) ::setenv("CI", ci_.c_str(), 1);
  }
  suite::Case read(const std::string& name) { return suite::read_case(suite_.layout, name); }
  void pend(const std::string& name, const image::Render& picture,
            const std::optional<suite::Golden>& previous = {}) {
    const suite::Case c = read(name);
    write_pending(suite_.layout, c, suite::hashes_of(suite_.layout, c), picture, previous);
  }
  std::string error_of(const std::function<void()>& step) {
    try {
      step();
    } catch (const base::Error& error) {
      return error.what();
    }
    return "no error";
  }
  bool exists(const std::string& name) { return fs::exists(suite_.layout.golden_file(name)); }
  suite::testing::FakeSuite suite_;
  std::string ci_;
};

TEST_F(Goldens, keep_picture_variance_tiles_and_provenance) {
  const image::Render picture = render({});
  pend("a", picture);
  accept(suite_.layout, {read("a")}, "First golden");
  const suite::Golden golden = golden::read(suite_.layout.golden_file("a"));
  EXPECT_EQ(image::pixel_hash(golden.render.mean), image::pixel_hash(picture.mean));
  EXPECT_EQ(golden.pixel_hash, image::pixel_hash(picture.mean));
  EXPECT_EQ(golden.case_hash, suite::hashes_of(suite_.layout, read("a")).a_case);
  EXPECT_EQ(image::header_string(golden.render.header, "assay:because"), "First golden");
  EXPECT_EQ(image::header_string(golden.render.header, "assay:accepted")->size(), 10u);
  for (size_t i = 0; i < picture.variance->data.size(); ++i)
    EXPECT_NEAR(golden.render.variance->data[i], picture.variance->data[i], 1e-3 * picture.variance->data[i]);
  const std::vector<image::Image> tiles = suite::replicate_tiles(picture);
  ASSERT_EQ(golden.replicate_tiles.size(), 8u);
  for (size_t r = 0; r < tiles.size(); ++r) EXPECT_EQ(golden.replicate_tiles[r].data, tiles[r].data) << r;
  EXPECT_EQ(suite::golden_fault(read("a"), suite::hashes_of(suite_.layout, read("a")), golden), "");
  EXPECT_FALSE(golden.render.layers.count("replicate0"));
}

TEST_F(Goldens, are_logged_with_their_reason_and_leave_nothing_pending) {
  pend("a", render({}));
  pend("b", render({}));
  EXPECT_EQ(pending_names(suite_.layout), (std::vector<std::string>{"a", "b"}));
  accept(suite_.layout, {read("a")}, "The box moved");
  accept(suite_.layout, {read("b")}, "Another reason");
  const std::string log = suite::testing::read_text(suite_.layout.root + "/goldens/LOG.md");
  EXPECT_LT(log.find("The box moved"), log.find("- `a`: pixels "));
  EXPECT_LT(log.find("- `a`: pixels "), log.find("Another reason"));
  EXPECT_NE(log.find("- `b`: pixels "), std::string::npos);
  EXPECT_TRUE(pending_names(suite_.layout).empty());
}

TEST_F(Goldens, are_never_written_where_ci_is_set) {
  pend("a", render({}));
  ::setenv("CI", "true", 1);
  EXPECT_NE(error_of([&] { accept(suite_.layout, {read("a")}, "r"); }).find("CI=true"), std::string::npos);
  ::unsetenv("CI");
  EXPECT_FALSE(exists("a"));
  EXPECT_FALSE(fs::exists(suite_.layout.root + "/goldens/LOG.md"));
}

TEST_F(Goldens, need_a_reason) {
  pend("a", render({}));
  EXPECT_NE(error_of([&] { accept(suite_.layout, {read("a")}, " \n"); }).find("--because"),
            std::string::npos);
  EXPECT_FALSE(exists("a"));
}

TEST_F(Goldens, are_not_made_from_what_is_not_there_or_out_of_date) {
  EXPECT_NE(error_of([&] { accept(suite_.layout, {read("a")}, "r"); }).find("no pending picture"),
            std::string::npos);
  pend("a", render({}));
  suite_.add_case("a", "\"camera\": 1");
  EXPECT_NE(error_of([&] { accept(suite_.layout, {read("a")}, "r"); }).find("the pending picture is stale"),
            std::string::npos);
  EXPECT_FALSE(exists("a"));
}

TEST_F(Goldens, are_not_made_from_broken_pictures) {
  image::Render bad = render({});
  bad.mean.at(2, 2, 0) = std::numeric_limits<float>::quiet_NaN();
  pend("a", bad);
  EXPECT_NE(error_of([&] { accept(suite_.layout, {read("a")}, "r"); }).find("1 pixels are not finite"),
            std::string::npos);
  bad = render({});
  bad.header["assay:rejected"] = 1;
  pend("a", bad);
  EXPECT_NE(error_of([&] { accept(suite_.layout, {read("a")}, "r"); }).find("were not finite"),
            std::string::npos);
  EXPECT_FALSE(exists("a"));
}

TEST_F(Goldens, are_accepted_all_or_none) {
  pend("a", render({}));
  EXPECT_NE(error_of([&] {
              accept(suite_.layout, {read("a"), read("b")}, "r");
            }).find("accept: b: "),
            std::string::npos);
  EXPECT_FALSE(exists("a"));
  EXPECT_EQ(pending_names(suite_.layout), std::vector<std::string>{"a"});
}

TEST_F(Goldens, stay_as_they_are_when_the_new_picture_is_rejected) {
  pend("a", render({}));
  accept(suite_.layout, {read("a")}, "r");
  const std::string before = suite::testing::read_text(suite_.layout.golden_file("a"));
  Recipe other;
  other.seed = 2;
  pend("a", render(other));
  reject(suite_.layout, {"a"});
  EXPECT_EQ(suite::testing::read_text(suite_.layout.golden_file("a")), before);
  EXPECT_TRUE(pending_names(suite_.layout).empty());
  EXPECT_THROW(reject(suite_.layout, {"a"}), base::Error);
}

TEST_F(Goldens, are_what_they_were_after_undo_and_the_picture_is_pending_again) {
  const auto bytes = [&](const std::string& name) {
    return suite::testing::read_text(suite_.layout.golden_file(name));
  };
  const std::string log_file = suite_.layout.root + "/goldens/LOG.md";
  pend("a", render({}));
  accept(suite_.layout, {read("a")}, "First");
  const std::string golden = bytes("a"), log = suite::testing::read_text(log_file);
  Recipe brighter;
  brighter.factor = [](int, int) { return 2.; };
  pend("a", render(brighter));
  pend("b", render({}));
  accept(suite_.layout, {read("a"), read("b")}, "Second");
  EXPECT_NE(bytes("a"), golden);
  ::setenv("CI", "true", 1);
  EXPECT_NE(error_of([&] { undo(suite_.layout); }).find("CI=true"), std::string::npos);
  ::unsetenv("CI");
  EXPECT_EQ(undo(suite_.layout), (std::vector<std::string>{"a", "b"}));
  EXPECT_EQ(bytes("a"), golden);
  EXPECT_FALSE(exists("b"));
  EXPECT_EQ(suite::testing::read_text(log_file), log);
  EXPECT_EQ(pending_names(suite_.layout), (std::vector<std::string>{"a", "b"}));
  EXPECT_EQ(refusal(suite_.layout, read("a")), "");
  EXPECT_NE(error_of([&] { undo(suite_.layout); }).find("found none"), std::string::npos)
      << "only the last one";
}

TEST_F(Goldens, are_left_alone_by_undo_once_they_changed_again) {
  pend("a", render({}));
  accept(suite_.layout, {read("a")}, "First");
  image::Render newer = image::read_render(suite_.layout.golden_file("a"));
  newer.header["assay:pixel_hash"] = std::string(64, '0');
  image::write_exr(suite_.layout.golden_file("a"), newer);
  EXPECT_NE(error_of([&] { undo(suite_.layout); }).find("the golden that was accepted last"),
            std::string::npos);
  EXPECT_TRUE(exists("a"));
}

TEST_F(Goldens, keep_their_exposures_when_the_same_picture_is_accepted_again) {
  Recipe dim, bright;
  bright.factor = [](int, int) { return 16.; };
  pend("a", render(dim));
  accept(suite_.layout, {read("a")}, "r");
  const suite::Golden first = golden::read(suite_.layout.golden_file("a"));
  pend("a", render(bright), first);
  EXPECT_EQ(golden::read(suite_.layout.pending_file("a")).exposures.start, first.exposures.start);
  suite_.add_case("a", "\"camera\": 1");  // another picture chooses anew
  pend("a", render(bright), first);
  EXPECT_NEAR(golden::read(suite_.layout.pending_file("a")).exposures.start, first.exposures.start - 4, .2);
}

TEST_F(Goldens, that_are_no_goldens_are_refused_by_name) {
  image::write_exr(suite_.layout.golden_file("a"), render({}));
  EXPECT_NE(
      error_of([&] { golden::read(suite_.layout.golden_file("a")); }).find("assay:case_hash: wanted a text"),
      std::string::npos);
  suite::testing::write_text(suite_.layout.golden_file("a"), "not a picture");
  EXPECT_NE(error_of([&] { golden::read(suite_.layout.golden_file("a")); }), "no error");
}

TEST_F(Goldens, without_a_case_are_orphans_and_so_are_witness_pictures) {
  EXPECT_TRUE(orphans(suite_.layout).empty());
  image::write_exr(suite_.layout.golden_file("gone"), render({}));
  image::write_exr(suite_.layout.reference + "/blender/renders/a.exr", render({}));
  image::write_exr(suite_.layout.reference + "/povray/renders/a.normal.exr", render({}));
  EXPECT_EQ(orphans(suite_.layout).size(), 3u);
  suite_.add_case("a", R"("witnesses": [{"kind": "blender"}, {"kind": "povray", "quantity": "normal"}])");
  const std::vector<std::string> left = orphans(suite_.layout);
  ASSERT_EQ(left.size(), 1u);
  EXPECT_EQ(left[0], suite_.layout.golden_file("gone") + ": wanted a case gone, found none");
}

}  // namespace
}  // namespace golden
