// The studies on prepared pictures: they must acquit a sound judge's numbers and convict wrong ones.
#include "app/study.h"

#include <gtest/gtest.h>

#include <cmath>

#include "app/study_pictures.h"
#include "app/testing.h"
#include "base/error.h"

namespace app {
namespace {

using testing::recipe;
using testing::render;

class Studies : public testing::Runs {
 protected:
  // What the null study will ask for: golden, render and fresh seed in turn, and four to calibrate by.
  void prepare_null(int trials, double fresh_factor) {
    for (int i = 0; i < 3 * trials; ++i)
      suite_.prepare("a", render(recipe(static_cast<unsigned>(i + 1), i % 3 == 2 ? fresh_factor : 1, 16)),
                     static_cast<unsigned>(i + 1), 16);
    for (unsigned s = 1u << 20; s < (1u << 20) + 4; ++s) suite_.prepare("a", render(recipe(s, 1, 16)), s, 16);
    for (unsigned s = 1u << 21; s < (1u << 21) + 4 * static_cast<unsigned>(trials); ++s)
      suite_.prepare("a", render(recipe(s, fresh_factor, 64)), s, 64);
  }
  std::string page() const { return suite_.path() + "/page.md"; }
};

TEST_F(Studies, of_the_null_acquit_pictures_that_differ_by_noise_alone) {
  prepare_null(20, 1);
  suite::testing::write_text(page(), "before\n<!-- study null -->\nold\n<!-- /study null -->\nafter\n");
  EXPECT_EQ(assay({"study", "null", "--trials", "20", "--write", page()}, true), 0) << out_ << err_;
  EXPECT_NE(out_.find("\n0 false alarms in 20 trials"), std::string::npos) << out_;
  EXPECT_NE(out_.find("| `a` | 20 | 0 |"), std::string::npos) << out_;
  EXPECT_EQ(out_.rfind("`assay study null --trials 20 --renderer ", 0), 0u) << "no folder of this machine";
  const std::string written = suite::testing::read_text(page());
  EXPECT_EQ(written, "before\n<!-- study null -->\n" + out_ + "<!-- /study null -->\nafter\n");
  EXPECT_EQ(assay({"study", "null", "--trials", "20"}, true), 0);
  EXPECT_NE(out_.find("\n0 false alarms in 20 trials"), std::string::npos) << "the same each time";
}

TEST_F(Studies, of_the_null_convict_a_judge_that_is_given_biased_fresh_seeds) {
  prepare_null(20, 1.05);
  EXPECT_EQ(assay({"study", "null", "--trials", "20"}, true), 1) << out_;
  EXPECT_NE(out_.find("**refuted**"), std::string::npos);
  EXPECT_NE(out_.find("| all | 20 | 20 | 0 | 20 |"), std::string::npos) << out_;
}

TEST_F(Studies, of_power_count_what_is_found_and_what_passes) {
  for (unsigned s = 1000; s < 1003; ++s) suite_.prepare("a", render(recipe(s)), s, 64);
  EXPECT_EQ(assay({"study", "power", "--seeds", "3"}, true), 0) << out_ << err_;
  const auto has = [&](const std::string& text) { return out_.find(text) != std::string::npos; };
  EXPECT_TRUE(has("| none | 3 | 0 % (\xE2\x89\xA5 0 %) | 100 % |")) << out_;
  EXPECT_TRUE(has("| image 0.5 % | 3 | 100 % (")) << out_;
  EXPECT_TRUE(has("| lobe 1 % | 0 | - | - | - | - |")) << "the prepared pictures know no base colour\n"
                                                       << out_;
  EXPECT_EQ(assay({"study", "power", "--seeds", "2"}, true), 2);
}

TEST_F(Studies, want_a_page_with_their_markers) {
  suite::testing::write_text(page(), "nothing here\n");
  EXPECT_THROW(write_section(page(), "null", "text\n"), base::Error);
  EXPECT_EQ(suite::testing::read_text(page()), "nothing here\n");
}

TEST_F(Studies, know_what_their_biased_pictures_must_be) {
  const image::Render a = render(recipe(1)), b = render(recipe(2));
  const image::Render half = scaled(a, [](int x, int) { return x < 8 ? .5 : 1; });
  const image::Render third = mixed(a, b, .25);
  for (const auto& [x, factor] : {std::pair(3, .5), {12, 1.}}) {
    EXPECT_NEAR(half.mean.at(x, 5, 1), factor * a.mean.at(x, 5, 1), 1e-6);
    EXPECT_NEAR(half.variance->at(x, 5, 1) / (factor * factor * a.variance->at(x, 5, 1)), 1, 1e-3);
    EXPECT_NEAR(third.mean.at(x, 5, 1), .75 * a.mean.at(x, 5, 1) + .25 * b.mean.at(x, 5, 1), 1e-6);
  }
  EXPECT_EQ(image::replicates(half)[3]->at(3, 5, 1), .5f * image::replicates(a)[3]->at(3, 5, 1));
}

TEST_F(Studies, blacken_base_colours_and_leave_the_rest) {
  const std::string folder = suite_.path() + "/dark", scene = suite_.path() + "/regression/scenes/red.gltf";
  suite::testing::write_text(suite_.path() + "/regression/scenes/sky.hdr", "sky");
  suite::testing::write_text(scene, R"({"asset": {"version": "2.0"}, "materials": [{"pbrMetallicRoughness":
    {"baseColorFactor": [1, 0.5, 0.2, 0.25], "roughnessFactor": 0.3}}, {"emissiveFactor": [1, 1, 1]}]})");
  const nlohmann::json dark = suite::read_json(without_base_colour(scene, folder));
  EXPECT_EQ(dark["materials"][0]["pbrMetallicRoughness"].dump(),
            R"({"baseColorFactor":[0.0,0.0,0.0,0.25],"roughnessFactor":0.3})");
  EXPECT_EQ(dark["materials"][1]["emissiveFactor"].dump(), "[1,1,1]");
  EXPECT_EQ(dark["materials"][1]["pbrMetallicRoughness"]["baseColorFactor"][3], 1.);
  EXPECT_EQ(suite::testing::read_text(folder + "/sky.hdr"), "sky");
  suite::testing::write_text(scene, "no JSON");
  EXPECT_THROW(without_base_colour(scene, folder), base::Error);
}

}  // namespace
}  // namespace app
