// Synthetic pictures whose truth is known: what was changed must be what is said.
#include "suite/judge.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "image/hash.h"
#include "suite/testing.h"

namespace suite {
namespace {

using testing::Recipe;
using testing::render;

class Judging : public ::testing::Test {
 protected:
  void SetUp() override {
    suite_.add_case("a");
    case_ = read_case(suite_.layout, "a");
    case_.margin_image = .005;
    hashes_ = hashes_of(suite_.layout, case_);
  }
  Golden golden(const image::Render& render) const {
    Golden g;
    g.render = render;
    g.case_hash = hashes_.a_case;
    g.pixel_hash = image::pixel_hash(render.mean);
    g.exposures = metric::automatic_exposures(render.mean).value_or(metric::Exposures{0, 0, 1});
    g.replicate_tiles = replicate_tiles(render);
    return g;
  }
  // As app/run does it: own seed, then fresh seeds for as long as they are wanted.
  GoldenResult judge(const Golden& g, Recipe recipe) const {
    recipe.seed = 1;
    GoldenResult result = judge_own_seed(case_, g, render(recipe));
    for (int look = 1; result.wants_fresh && look < 5; ++look) {
      recipe.seed = fresh_seed(1, look);
      recipe.spp = look == 1 ? 64 : 256;
      judge_fresh_seed(result, case_, g, render(recipe));
    }
    return result;
  }
  testing::FakeSuite suite_;
  Case case_;
  Hashes hashes_;
};

TEST_F(Judging, says_identical_for_the_same_bits_and_computes_the_metrics_all_the_same) {
  const GoldenResult result = judge(golden(render({})), {});
  EXPECT_EQ(result.verdict, Verdict::identical) << result.reason;
  ASSERT_EQ(result.measures.size(), 4u);
  EXPECT_EQ(result.measures[0].value, 0);
  EXPECT_EQ(result.measures[0].limit, .2);
  EXPECT_EQ(result.measures[1].value, 0);
  EXPECT_GT(result.detectable, 0);
  EXPECT_LT(result.detectable, .01);
}

TEST_F(Judging, says_broken_for_replicates_drawn_with_one_seed) {
  // Their spread is zero and says nothing of the noise. This once passed as QUIETER.
  const Golden g = golden(render({}));
  Recipe recipe;
  recipe.seed = 1;
  image::Render alike = render(recipe);
  for (int r = 1; r < recipe.replicates; ++r)
    alike.layers["replicate" + std::to_string(r)] = alike.layers["replicate0"];
  alike.mean = alike.layers["replicate0"];
  std::fill(alike.variance->data.begin(), alike.variance->data.end(), 0.f);
  const GoldenResult result = judge_own_seed(case_, g, alike);
  EXPECT_EQ(result.verdict, Verdict::broken);
  EXPECT_NE(result.reason.find("drawn with one seed"), std::string::npos) << result.reason;
  EXPECT_FALSE(result.wants_fresh);
}

TEST_F(Judging, lets_a_picture_without_noise_have_equal_replicates) {
  Recipe recipe;
  recipe.noise = 0;
  EXPECT_EQ(judge(golden(render(recipe)), recipe).verdict, Verdict::identical);
}

TEST_F(Judging, says_broken_for_another_variance_behind_the_same_pixels) {
  const Golden g = golden(render({}));
  Recipe recipe;
  recipe.seed = 1;
  image::Render candidate = render(recipe);
  for (float& v : candidate.variance->data) v *= 1.02f;
  const GoldenResult result = judge_own_seed(case_, g, candidate);
  EXPECT_EQ(result.verdict, Verdict::broken);
  EXPECT_NE(result.reason.find("variance layer is 1.02 times"), std::string::npos) << result.reason;
}

TEST_F(Judging, says_equivalent_for_rounding) {
  Recipe recipe;
  recipe.factor = [](int x, int) { return 1 + 1e-7 * x; };
  const GoldenResult result = judge(golden(render({})), recipe);
  EXPECT_EQ(result.verdict, Verdict::equivalent) << result.reason;
  EXPECT_EQ(result.looks, 1);
}

TEST_F(Judging, says_equivalent_for_other_noise_around_the_same_truth) {
  Recipe golden_recipe;
  golden_recipe.seed = 99;
  const GoldenResult result = judge(golden(render(golden_recipe)), {});
  EXPECT_EQ(result.verdict, Verdict::equivalent) << result.reason;
}

TEST_F(Judging, sees_a_lobe_scaled_by_1003_through_paired_replicates) {
  Recipe recipe;
  recipe.noise = .1;  // the picture's own mean is uncertain by 0.3 %
  const Golden g = golden(render(recipe));
  recipe.factor = [](int, int) { return 1.003; };
  const GoldenResult result = judge(g, recipe);
  EXPECT_EQ(result.verdict, Verdict::changed) << result.reason;
  ASSERT_TRUE(result.paired.has_value());
  EXPECT_TRUE(result.paired->biased());
  EXPECT_EQ(result.looks, 0);
}

TEST_F(Judging, sees_a_bias_with_a_fresh_seed_if_the_replicates_are_not_kept) {
  Golden g = golden(render({}));
  g.replicate_tiles.clear();
  Recipe recipe;
  recipe.factor = [](int, int) { return 1.01; };
  const GoldenResult result = judge(g, recipe);
  EXPECT_EQ(result.verdict, Verdict::changed) << result.reason;
  EXPECT_EQ(result.looks, 1);
}

TEST_F(Judging, names_the_tile_that_changed) {
  Recipe recipe;
  recipe.factor = [](int x, int y) { return x >= 8 && y < 8 ? 1.05 : 1; };
  const GoldenResult result = judge(golden(render({})), recipe);
  EXPECT_EQ(result.verdict, Verdict::changed);
  EXPECT_NE(result.reason.find("1 of 4 tiles, worst at (8, 0)"), std::string::npos) << result.reason;
}

TEST_F(Judging, sees_a_dead_pixel_that_no_tile_would_show_and_no_firefly) {
  Recipe recipe;
  const Golden g = golden(render(recipe));
  image::Render dead = render(recipe), firefly = dead;
  for (int c = 0; c < 3; ++c) {
    dead.mean.at(9, 4, c) = 0;
    for (int r = 0; r < 8; ++r) dead.layers["replicate" + std::to_string(r)].at(9, 4, c) = 0;
    dead.variance->at(9, 4, c) = 0;
    firefly.mean.at(9, 4, c) += .2f / 8;
    firefly.layers["replicate3"].at(9, 4, c) += .2f;
    firefly.variance->at(9, 4, c) += .2f * .2f / 64;
  }
  const GoldenResult result = judge_own_seed(case_, g, dead);
  EXPECT_EQ(result.verdict, Verdict::changed);
  EXPECT_FALSE(result.paired->biased());
  EXPECT_EQ(result.reason.substr(0, 30), "1 wrong pixel at (9, 4): 0 ins") << result.reason;
  ASSERT_EQ(result.wrong_pixels.size(), 1u);
  GoldenResult sound = judge_own_seed(case_, g, firefly);
  EXPECT_EQ(sound.verdict, Verdict::undecided) << sound.reason;
  recipe.seed = fresh_seed(1, 1);
  judge_fresh_seed(sound, case_, g, render(recipe));
  EXPECT_EQ(sound.verdict, Verdict::equivalent) << sound.reason;
}

// A mask made from the picture under test would leave out what it does not show.
TEST_F(Judging, sees_an_object_that_is_gone) {
  Recipe recipe;
  recipe.truth = [](int x, int y, int) { return x >= 4 && x < 9 && y >= 4 && y < 9 ? .3 : .01; };
  const Golden with = golden(render(recipe));
  Recipe empty = recipe;
  empty.truth = [](int, int, int) { return .01; };
  case_.limits = Case::Limits{1, 100};
  EXPECT_EQ(judge(with, empty).verdict, Verdict::changed);
  EXPECT_EQ(judge(golden(render(empty)), recipe).verdict, Verdict::changed);
}

TEST_F(Judging, spends_a_cases_budget_once) {
  Recipe other;
  other.seed = 99;
  GoldenResult result = judge_own_seed(case_, golden(render(other)), render({}));
  ASSERT_TRUE(result.paired.has_value() && result.wants_fresh);
  other.seed = 7;
  judge_fresh_seed(result, case_, golden(render({})), render(other));
  ASSERT_TRUE(result.welch.has_value());
  // Levels of single tests, 5 regions of 4 quantities: stage 1 half, two looks and the noise the other half.
  const auto whole = [](double level) { return -std::expm1(20 * std::log1p(-level)); };
  const double own = whole(result.paired->level), look = whole(result.welch->level);
  EXPECT_NEAR(own, 5e-9, 1e-14);
  EXPECT_NEAR(own + 3 * look, metric::case_false_alarm(), 1e-14);
  EXPECT_NEAR(100 * metric::case_false_alarm(), metric::suite_false_alarm, 1e-12);
}

TEST_F(Judging, does_not_take_a_failure_to_see_for_equivalence) {
  Recipe recipe;
  recipe.noise = 2;  // a one-sample picture, as it were
  Recipe golden_recipe = recipe;
  golden_recipe.seed = 99;
  case_.limits = Case::Limits{1, 100};
  const GoldenResult result = judge(golden(render(golden_recipe)), recipe);
  EXPECT_EQ(result.verdict, Verdict::undecided) << result.reason;
  EXPECT_EQ(result.looks, 2);  // escalated once, never again
  EXPECT_FALSE(result.wants_fresh);
}

TEST_F(Judging, does_not_try_again_until_it_is_green) {
  Golden g = golden(render({}));
  g.replicate_tiles.clear();
  Recipe biased;
  biased.factor = [](int, int) { return 1.02; };
  GoldenResult result = judge_own_seed(case_, g, render(biased));
  ASSERT_TRUE(result.wants_fresh);
  biased.seed = 7;
  judge_fresh_seed(result, case_, g, render(biased));
  EXPECT_EQ(result.verdict, Verdict::changed);
  EXPECT_FALSE(result.wants_fresh);
}

TEST_F(Judging, says_noisier_and_quieter) {
  Recipe golden_recipe;
  golden_recipe.seed = 99, golden_recipe.width = golden_recipe.height = 64;
  case_.width = case_.height = 64;
  Recipe other = golden_recipe;
  other.noise = .04;
  const Golden quiet = golden(render(golden_recipe)), loud = golden(render(other));
  const GoldenResult noisier = judge(quiet, other);
  EXPECT_EQ(noisier.verdict, Verdict::noisier) << noisier.reason;
  const GoldenResult quieter = judge(loud, golden_recipe);
  EXPECT_EQ(quieter.verdict, Verdict::quieter) << quieter.reason;
  EXPECT_EQ(exit_code(noisier.verdict), 1);
  EXPECT_EQ(exit_code(quieter.verdict), 0);
}

TEST_F(Judging, holds_flip_and_rmse_to_their_limits_even_if_statistics_would_agree) {
  Recipe recipe;
  recipe.seed = 99;
  const Golden g = golden(render(recipe));
  case_.limits = Case::Limits{1e-6, 1};
  const GoldenResult flip = judge(g, {});
  EXPECT_EQ(flip.verdict, Verdict::changed);
  EXPECT_EQ(flip.reason.substr(0, 5), "FLIP ");
  EXPECT_FALSE(flip.measures[0].ok);
  case_.limits = Case::Limits{1, 1e-6};
  const GoldenResult rmse = judge(g, {});
  EXPECT_EQ(rmse.verdict, Verdict::changed);
  EXPECT_EQ(rmse.reason.substr(0, 5), "RMSE ");
}

TEST_F(Judging, calls_a_case_without_limits_broken_even_if_the_bits_are_the_same) {
  case_.limits.reset();
  const GoldenResult result = judge(golden(render({})), {});
  EXPECT_EQ(result.verdict, Verdict::broken);
  EXPECT_EQ(result.reason, "not calibrated: run assay calibrate a");
}

TEST_F(Judging, finds_every_fault_of_the_data) {
  const image::Render good = render({});
  EXPECT_EQ(data_fault(case_, good), "");
  image::Render bad = good;
  bad.mean.at(3, 3, 1) = std::numeric_limits<float>::quiet_NaN();
  bad.mean.at(4, 3, 0) = std::numeric_limits<float>::infinity();
  EXPECT_EQ(data_fault(case_, bad), "2 pixels are not finite");
  bad = good;
  bad.variance->at(0, 0, 0) = std::numeric_limits<float>::quiet_NaN();
  EXPECT_EQ(data_fault(case_, bad), "the variance of 1 pixels is not finite");
  bad = good;
  bad.variance->at(0, 0, 0) = -1;
  EXPECT_EQ(data_fault(case_, bad), "a variance is negative");
  bad = good;
  bad.variance.reset();
  EXPECT_EQ(data_fault(case_, bad), "no channels variance.R variance.G variance.B");
  bad = good;
  bad.header["assay:rejected"] = 3;
  EXPECT_EQ(data_fault(case_, bad), "3 samples were not finite and left out by the renderer");
  bad = good;
  bad.header["assay:partial"] = 1;
  EXPECT_EQ(data_fault(case_, bad), "the render is only partial");
  Recipe small;
  small.height = 8;
  EXPECT_EQ(data_fault(case_, render(small)), "wrong size: wanted 16 x 16, found 16 x 8");
}

TEST_F(Judging, refuses_goldens_that_are_stale_or_damaged) {
  Golden g = golden(render({}));
  EXPECT_EQ(golden_fault(case_, hashes_, g), "");
  g.render.mean.at(0, 0, 0) += .1f;
  EXPECT_EQ(golden_fault(case_, hashes_, g), "golden damaged: its pixels are not those of its pixel hash");
  g = golden(render({}));
  g.case_hash[0] = g.case_hash[0] == '0' ? '1' : '0';
  EXPECT_EQ(golden_fault(case_, hashes_, g).substr(0, 12), "golden stale");
}

TEST_F(Judging, takes_fresh_seeds_that_are_never_the_cases_own_nor_too_large_for_a_header) {
  for (const std::uint32_t seed : {0u, 1u, 2147483647u})
    for (int look = 1; look < 200; ++look) {
      EXPECT_NE(fresh_seed(seed, look), seed);
      EXPECT_LT(fresh_seed(seed, look), 1u << 31);
    }
}

TEST(Verdicts, have_the_documented_exit_codes) {
  for (const Verdict v :
       {Verdict::identical, Verdict::equivalent, Verdict::quieter, Verdict::agrees, Verdict::skipped})
    EXPECT_EQ(exit_code(v), 0) << name(v);
  for (const Verdict v :
       {Verdict::changed, Verdict::noisier, Verdict::undecided, Verdict::broken, Verdict::differs})
    EXPECT_EQ(exit_code(v), 1) << name(v);
  EXPECT_EQ(exit_code(Verdict::error), 2);
}

}  // namespace
}  // namespace suite
