#include "suite/witness_judge.h"

#include <gtest/gtest.h>

#include <limits>

#include "suite/testing.h"

namespace suite {
namespace {

using testing::Recipe;
using testing::render;

Recipe recipe(unsigned seed, double factor = 1, double noise = .02) {
  Recipe r;
  r.seed = seed, r.noise = noise;
  r.factor = [factor](int, int) { return factor; };
  return r;
}

class Witnesses : public ::testing::Test {
 protected:
  void SetUp() override {
    suite_.add_case("a");
    case_ = read_case(suite_.layout, "a");
  }
  // A witness entry as the case file would say it.
  Witness entry(const std::string& json) {
    suite_.add_case("a", "\"witnesses\": [" + json + "]");
    case_ = read_case(suite_.layout, "a");
    return case_.witnesses.front();
  }
  testing::FakeSuite suite_;
  Case case_;
};

// A picture without noise, of three functions of the pixel.
image::Render exact(const std::function<double(int, int, int)>& value) {
  image::Render out;
  out.mean = image::Image(16, 16, 3);
  out.variance = image::Image(16, 16, 3);
  for (int y = 0; y < 16; ++y)
    for (int x = 0; x < 16; ++x)
      for (int c = 0; c < 3; ++c) out.mean.at(x, y, c) = static_cast<float>(value(x, y, c));
  return out;
}

TEST_F(Witnesses, agree_with_a_sound_render_of_other_noise) {
  const Witness w = entry(R"({"kind": "blender", "margin": 0.01})");
  const image::Render stored = render(recipe(5)), ours = render(recipe(6));
  const WitnessResult result = judge_witness(case_, w, ours, &stored);
  EXPECT_EQ(result.verdict, Verdict::agrees) << result.reason;
  EXPECT_TRUE(result.passed);
  EXPECT_EQ(result.image.size(), 4u);
  EXPECT_EQ(result.error_map_is, "flip");
}

TEST_F(Witnesses, differ_from_a_bias_beyond_the_margin) {
  const Witness w = entry(R"({"kind": "blender", "margin": 0.01})");
  const image::Render stored = render(recipe(5)), ours = render(recipe(6, 1.02));
  const WitnessResult result = judge_witness(case_, w, ours, &stored);
  EXPECT_EQ(result.verdict, Verdict::differs);
  EXPECT_FALSE(result.passed);
  EXPECT_NE(result.reason.find("luminance bias 2"), std::string::npos) << result.reason;
}

TEST_F(Witnesses, too_noisy_to_tell_are_no_agreement) {
  const Witness w = entry(R"({"kind": "blender", "margin": 0.01, "flip": false})");
  const image::Render stored = render(recipe(5, 1, 2)), ours = render(recipe(6, 1, 2));
  const WitnessResult result = judge_witness(case_, w, ours, &stored);
  EXPECT_EQ(result.verdict, Verdict::differs);
  EXPECT_NE(result.reason.find("too noisy to tell"), std::string::npos);
}

TEST_F(Witnesses, catch_by_flip_what_leaves_the_mean_alone) {
  const Witness w = entry(R"({"kind": "blender", "margin": 0.01})");
  Recipe moved = recipe(6);
  moved.factor = [](int x, int y) { return (x + y) / 4 % 2 ? 1.3 : .7; };  // a pattern whose mean is 1
  Recipe plain = recipe(5);
  plain.truth = moved.truth = [](int, int, int) { return .5; };
  const image::Render stored = render(plain), ours = render(moved);
  const WitnessResult result = judge_witness(case_, w, ours, &stored);
  EXPECT_EQ(result.verdict, Verdict::differs);
  EXPECT_EQ(result.reason.substr(0, 5), "FLIP ") << result.reason;
}

TEST_F(Witnesses, expected_to_differ_pass_only_when_the_difference_is_shown) {
  const Witness w =
      entry(R"({"kind": "blender", "margin": 0.01, "flip": false, "expect": "differs", "because": "a bug"})");
  const image::Render stored = render(recipe(5));
  const WitnessResult shown = judge_witness(case_, w, render(recipe(6, 1.05)), &stored);
  EXPECT_EQ(shown.verdict, Verdict::differs);
  EXPECT_TRUE(shown.passed) << shown.reason;
  const WitnessResult same = judge_witness(case_, w, render(recipe(6)), &stored);
  EXPECT_EQ(same.verdict, Verdict::agrees);
  EXPECT_FALSE(same.passed);
  EXPECT_NE(same.reason.find("expected to differ (a bug)"), std::string::npos);
  const WitnessResult noisy = judge_witness(case_, w, render(recipe(6, 1, 2)), &stored);
  EXPECT_EQ(noisy.verdict, Verdict::differs);
  EXPECT_FALSE(noisy.passed) << noisy.reason;  // not shown: noise is no finding
}

TEST_F(Witnesses, known_in_closed_form_hold_for_the_image_or_a_rectangle) {
  Recipe r = recipe(3);
  r.truth = [](int x, int, int c) { return x < 8 ? 1. + c : 5.; };
  const image::Render ours = render(r);
  EXPECT_EQ(
      judge_witness(
          case_,
          entry(
              R"({"kind": "analytic", "mean": [1, 2, 3], "source": "s", "rect": [0, 4, 8, 12], "margin": 0.01})"),
          ours, nullptr)
          .verdict,
      Verdict::agrees);
  EXPECT_EQ(
      judge_witness(
          case_,
          entry(
              R"({"kind": "analytic", "mean": [1, 2, 3], "source": "s", "rect": [0, 4, 9, 12], "margin": 0.01})"),
          ours, nullptr)
          .verdict,
      Verdict::differs);
  EXPECT_EQ(judge_witness(
                case_, entry(R"({"kind": "analytic", "mean": [3, 3.5, 4], "source": "s", "margin": 0.01})"),
                ours, nullptr)
                .verdict,
            Verdict::agrees);
  EXPECT_EQ(judge_witness(
                case_, entry(R"({"kind": "analytic", "mean": [3, 3.5, 4.1], "source": "s", "margin": 0.01})"),
                ours, nullptr)
                .verdict,
            Verdict::differs);
}

TEST_F(Witnesses, of_black_demand_black) {
  const Witness w = entry(R"({"kind": "analytic", "mean": [0, 0, 0], "source": "no light"})");
  EXPECT_EQ(judge_witness(case_, w, exact([](int, int, int) { return 0; }), nullptr).verdict,
            Verdict::agrees);
  EXPECT_EQ(judge_witness(case_, w, exact([](int x, int y, int) { return x + y == 3 ? 1e-3 : 0; }), nullptr)
                .verdict,
            Verdict::differs);
}

TEST_F(Witnesses, of_direct_light_are_held_to_mean_and_per_pixel) {
  const Witness w = entry(R"({"kind": "povray", "quantity": "direct", "margin": 0.005, "tolerance": 0.02})");
  Recipe plain = recipe(6);
  plain.truth = [](int, int, int) { return .5; };
  const image::Render stored = exact([](int, int, int) { return .5; });
  const WitnessResult good = judge_witness(case_, w, render(plain), &stored);
  EXPECT_EQ(good.verdict, Verdict::agrees) << good.reason;
  plain.factor = [](int, int) { return 1.01; };
  EXPECT_EQ(judge_witness(case_, w, render(plain), &stored).verdict, Verdict::differs);
  plain.factor = [](int x, int) { return x % 2 ? 1.05 : .95; };
  const WitnessResult pattern = judge_witness(case_, w, render(plain), &stored);
  EXPECT_EQ(pattern.verdict, Verdict::differs);
  EXPECT_EQ(pattern.reason.substr(0, 3), "RMS") << pattern.reason;
}

TEST_F(Witnesses, of_positions_are_exact_to_a_share_of_the_scene) {
  const Witness w = entry(R"({"kind": "povray", "quantity": "position", "tolerance": 0.0001})");
  const auto place = [](int x, int y, int c) { return y < 4 ? 0. : c == 0 ? x : c == 1 ? y : 3.; };
  image::Render stored = exact(place), ours = exact([](int, int, int) { return 77.; });
  ours.layers["position"] = exact(place).mean;  // the layer, not the shader's average, is compared
  ours.layers["depth"] = image::Image(16, 16, 1);
  for (int y = 4; y < 16; ++y)
    for (int x = 0; x < 16; ++x) ours.layers["depth"].at(x, y) = 1;
  EXPECT_EQ(judge_witness(case_, w, ours, &stored).verdict, Verdict::agrees);

  ours.layers["position"].at(5, 5, 0) += .005f;  // the seen box measures 18.6: 2.7e-4 of it
  const WitnessResult moved = judge_witness(case_, w, ours, &stored);
  EXPECT_EQ(moved.verdict, Verdict::differs);
  EXPECT_NE(moved.reason.find("in sizes of the scene 0.00026"), std::string::npos) << moved.reason;
  stored.header["assay:scene_size"] = 100.f;
  EXPECT_EQ(judge_witness(case_, w, ours, &stored).verdict, Verdict::agrees);
  ours.layers["position"].at(5, 5, 0) = std::numeric_limits<float>::quiet_NaN();
  EXPECT_EQ(judge_witness(case_, w, ours, &stored).verdict, Verdict::differs);
}

TEST_F(Witnesses, of_positions_count_pixels_that_only_one_hits) {
  const Witness w = entry(R"({"kind": "povray", "quantity": "position", "coverage": 0.02})");
  const auto place = [](int x, int y, int c) { return y < 4 ? 0. : c == 0 ? x : c == 1 ? y : 3.; };
  image::Render stored = exact(place), ours = exact(place);
  stored.layers["A"] = image::Image(16, 16, 1);
  for (int y = 4; y < 16; ++y)
    for (int x = 0; x < 16; ++x) stored.layers["A"].at(x, y) = 1;
  for (int x = 0; x < 5; ++x) stored.layers["A"].at(x, 4) = 0;  // 5 of 256: just under 2 %
  EXPECT_EQ(judge_witness(case_, w, ours, &stored).verdict, Verdict::agrees);
  stored.layers["A"].at(5, 4) = 0;
  const WitnessResult result = judge_witness(case_, w, ours, &stored);
  EXPECT_EQ(result.verdict, Verdict::differs);
  EXPECT_EQ(result.reason.substr(0, 32), "share of pixels hit by only one ") << result.reason;
  // A picture of nothing agrees with nothing.
  const image::Render nothing = exact([](int, int, int) { return 0; });
  EXPECT_EQ(judge_witness(case_, w, nothing, &stored).verdict, Verdict::differs);
}

TEST_F(Witnesses, of_a_lobe_are_exact_to_a_share_of_full_scale) {
  const Witness w = entry(R"({"kind": "povray", "quantity": "brdf", "tolerance": 0.00001})");
  const auto lobe = [](int x, int y, int) { return x > y ? 2. * x * y : 0.; };
  image::Render stored = exact(lobe), ours = exact(lobe);
  EXPECT_EQ(judge_witness(case_, w, ours, &stored).verdict, Verdict::agrees);
  ours.mean.at(15, 14, 2) += .0041f;  // full scale is 420
  EXPECT_EQ(judge_witness(case_, w, ours, &stored).verdict, Verdict::agrees);
  ours.mean.at(15, 14, 2) += .0002f;
  EXPECT_EQ(judge_witness(case_, w, ours, &stored).verdict, Verdict::differs);
}

TEST_F(Witnesses, that_are_stale_or_unsound_cannot_speak) {
  const Witness w = entry(R"({"kind": "blender"})");
  const Hashes hashes = hashes_of(suite_.layout, case_);
  image::Render stored = render(recipe(5));
  stored.header["assay:picture_hash"] = hashes.picture;
  stored.header["assay:script_hash"] = std::string("abc");
  EXPECT_EQ(witness_fault(case_, w, hashes, "abc", stored), "");
  EXPECT_EQ(witness_fault(case_, w, hashes, "abd", stored).substr(0, 26), "stale: the scripts that ma");
  Hashes other = hashes;
  other.picture[3] = 'x';
  EXPECT_EQ(witness_fault(case_, w, other, "abc", stored).substr(0, 15), "stale: made for");
  image::Render bad = stored;
  bad.mean.at(0, 0, 0) = std::numeric_limits<float>::quiet_NaN();
  EXPECT_EQ(witness_fault(case_, w, hashes, "abc", bad), "1 pixels are not finite");
  bad = stored;
  bad.variance.reset();
  EXPECT_NE(witness_fault(case_, w, hashes, "abc", bad), "");
  bad = stored;
  bad.header.erase("assay:replicates");
  EXPECT_EQ(witness_fault(case_, w, hashes, "abc", bad), "fewer than 2 replicates");
}

TEST_F(Witnesses, with_another_shader_or_depth_get_a_render_of_their_own) {
  EXPECT_FALSE(needs_own_render(case_, entry(R"({"kind": "blender"})")));
  EXPECT_TRUE(needs_own_render(case_, entry(R"({"kind": "blender", "shader": "principled"})")));
  EXPECT_TRUE(needs_own_render(
      case_, entry(R"({"kind": "povray", "quantity": "direct"})")));  // depth 1, the case has 4
  EXPECT_TRUE(
      needs_own_render(case_, entry(R"({"kind": "povray", "quantity": "normal", "shader": "path"})")));
  EXPECT_FALSE(needs_own_render(case_, entry(R"({"kind": "povray", "quantity": "mirror"})")));
}

}  // namespace
}  // namespace suite
