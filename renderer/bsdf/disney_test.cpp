// Directional albedos of Burley 2012 (rows B06 and B18 of docs/bsdf-tests.md) and the mirrors of principled.
// That sample(), pdf and eval() describe one and the same function is tested in reference/sampling.

#include "bsdf/disney.h"

#include <gtest/gtest.h>

#include "bsdf/testing.h"
#include "math/sampler.h"

namespace bsdf {
namespace {

using testing::alone;
using testing::black;
using testing::direction;
using testing::Random;

// By 2^20 samples, stratified in the two numbers of the direction. The error is that of independent samples,
// which is larger.
double albedo_by_sampling(const Bsdf& b, const Vec3& wo, double& error) {
  constexpr int side = 1024, n = side * side;
  Random random(7);
  double sum = 0, squares = 0;
  for (int i = 0; i < n; ++i) {
    const float u_lobe = random.uniform(), a = random.uniform(), c = random.uniform();
    const auto s = sample(b, wo, u_lobe, (static_cast<float>(i % side) + a) / side * (1 - 0x1p-24f),
                          (static_cast<float>(i / side) + c) / side * (1 - 0x1p-24f));
    const double w = s ? static_cast<double>(s->f_cos.x) / static_cast<double>(s->pdf) : 0;
    sum += w;
    squares += w * w;
  }
  const double mean = sum / n;
  error = std::sqrt(std::max(0., squares / n - mean * mean) / n);
  return mean;
}

// Directional albedos of the published shader, base colour 1, by double quadrature on two grids that agree to
// 5e-4.
struct AlbedoRow {
  const char* name;
  Parameters parameters;
  std::optional<Lobe> lobe;  // alone: the shader keeps a Schlick edge at specular 0
  double albedo[7];
};
constexpr double albedo_cosines[7] = {1, .5, .2, .1, .05, .02, .01};

std::vector<AlbedoRow> albedo_rows() {
  const auto white = [](float roughness, float metallic) {
    Parameters p;
    p.base_color = Vec3(1);
    p.roughness = roughness;
    p.metallic = metallic;
    return p;
  };
  const auto coat = [](float gloss) {
    Parameters p = black();
    p.clearcoat = 1;
    p.clearcoat_roughness = std::sqrt(.1f + (.001f - .1f) * gloss);
    return p;
  };
  Parameters sheen = black();
  sheen.sheen = 1;
  sheen.sheen_tint = 0;
  Parameters all = white(1, 0);
  all.specular = all.sheen = all.clearcoat = 1;
  all.clearcoat_roughness = coat(0).clearcoat_roughness;
  const Lobe d = Lobe::diffuse, s = Lobe::specular, c = Lobe::clearcoat;
  return {
      {"diffuse_of_roughness_0", white(0, 0), d, {.9762, .9609, .8163, .6880, .5985, .5350, .5120}},
      {"diffuse_of_roughness_50", white(.5f, 0), d, {1.0060, 1.0083, 1.0248, 1.0235, 1.0174, 1.0111, 1.0084}},
      {"diffuse_of_roughness_100", white(1, 0), d, {1.0357, 1.0569, 1.2453, 1.3801, 1.4636, 1.5188, 1.5380}},
      {"sheen", sheen, d, {.0003, .0156, .0481, .0660, .0766, .0836, .0860}},
      {"clearcoat_of_gloss_0", coat(0), c, {.0081, .0131, .0305, .0392, .0439, .0468, .0477}},
      {"clearcoat_of_gloss_1", coat(1), c, {.0094, .0150, .0440, .0421, .0309, .0232, .0215}},
      {"metal_of_roughness_10", white(.1f, 1), s, {1.0000, .9999, .9987, .9942, .9761, .9111, .8816}},
      {"metal_of_roughness_50", white(.5f, 1), s, {.9158, .8551, .8315, .8543, .8746, .8887, .8936}},
      {"metal_of_roughness_100", white(1, 1), s, {.3069, .4091, .5114, .5579, .5845, .6017, .6076}},
      {"specular_of_roughness_50", white(.5f, 0), s, {.0367, .0555, .1235, .1563, .1718, .1798, .1821}},
      {"everything_of_roughness_100", all, {}, {1.069, 1.121, 1.373, 1.543, 1.646, 1.714, 1.738}},
  };
}

class DirectionalAlbedo : public ::testing::TestWithParam<AlbedoRow> {};
INSTANTIATE_TEST_SUITE_P(Of, DirectionalAlbedo, ::testing::ValuesIn(albedo_rows()),
                         [](const auto& info) { return info.param.name; });

// B06: within half a percent and 4 standard errors; the table has four digits, half a unit of the last is
// absolute. By quadrature elsewhere (reference/sampling), here by the sampler and the published table alone.
TEST_P(DirectionalAlbedo, is_that_of_the_published_shader) {
  const AlbedoRow& row = GetParam();
  for (int i = 0; i < 7; ++i) {
    const Vec3 wo = direction(albedo_cosines[i], .3);
    Bsdf b = prepare(Model::disney, {}, row.parameters, {}, wo);
    if (row.lobe) b = alone(b, *row.lobe);
    double error = 0;
    const double mean = albedo_by_sampling(b, wo, error);
    EXPECT_NEAR(mean, row.albedo[i], .005 * row.albedo[i] + 4 * error + (row.lobe ? 5e-5 : 5e-4))
        << row.name << " at cos " << albedo_cosines[i];
  }
}

// B18: a cosine clamped from below would show here.
TEST(DirectionalAlbedo, of_diffuse_goes_on_down_to_the_horizon) {
  Parameters p;
  p.base_color = Vec3(1);
  for (const auto& [cosine, albedo] : {std::pair(.01, 1.0084), std::pair(.001, 1.0058)}) {
    const Vec3 wo = direction(cosine, .3);
    double error = 0;
    EXPECT_NEAR(albedo_by_sampling(alone(prepare(Model::disney, {}, p, {}, wo), Lobe::diffuse), wo, error),
                albedo, .01 * albedo);
  }
}

TEST(Principled, turns_into_a_mirror_exactly_below_blenders_threshold) {
  const Vec3 wo = direction(.5, 0);
  Parameters p = black();
  p.base_color = Vec3(1);
  p.metallic = 1;
  p.roughness = .01778f;
  const auto mirror = sample(prepare(Model::principled, {}, p, {}, wo), wo, .5f, .3f, .3f);
  ASSERT_TRUE(mirror && mirror->is_delta);
  EXPECT_EQ(mirror->f_cos.x, mirror->pdf);
  p.roughness = .01779f;
  EXPECT_FALSE(prepare(Model::principled, {}, p, {}, wo).specular.is_delta);
}

TEST(Principled, a_mirror_among_other_lobes_reflects_as_much_as_the_glossy_lobe_just_above_the_threshold) {
  const Vec3 wo = direction(.7, .2);
  Parameters p = black();
  p.base_color = Vec3(.6f);
  p.metallic = .5f;
  p.specular = .5f;
  p.roughness = 0;
  double error = 0, glossy_error = 0;
  const double mirror = albedo_by_sampling(prepare(Model::principled, {}, p, {}, wo), wo, error);
  p.roughness = .018f;
  const double glossy = albedo_by_sampling(prepare(Model::principled, {}, p, {}, wo), wo, glossy_error);
  EXPECT_NEAR(mirror, glossy, 5 * (error + glossy_error) + .002);
}

// The number that chooses the lobe, stretched over what it leaves, is the direction's: both ways of drawing
// then give one direction.
TEST(Sample, TwoNumbersDrawWhatThreeDo) {
  Parameters p;
  p.base_color = {.6f, .4f, .2f};
  p.clearcoat = 1;
  const Vec3 wo = direction(.6f, .3f);
  const Bsdf b = prepare(Model::disney, {}, p, {}, wo);
  float below = 0;
  std::array<int, lobe_count> drawn{};
  for (int lobe = 0; lobe < lobe_count; ++lobe) {
    ASSERT_GT(b.probability[lobe], .05f);
    for (int i = 0; i < 64; ++i) {
      const float t = (static_cast<float>(i) + .5f) / 64, v = static_cast<float>(i * 37 % 64) / 64;
      const auto three = sample(b, wo, below + .5f * b.probability[lobe], t, v);
      const auto two = sample(b, wo, below + t * b.probability[lobe], v);
      ASSERT_EQ(two.has_value(), three.has_value());
      if (!two) continue;
      ++drawn[static_cast<size_t>(two->lobe)];
      EXPECT_EQ(two->lobe, three->lobe);
      EXPECT_LT(math::length(two->wi - three->wi), 1e-4f) << lobe << " " << t;
      EXPECT_NEAR(two->pdf, three->pdf, 1e-3f * three->pdf);
    }
    below += b.probability[lobe];
  }
  for (const int n : drawn) EXPECT_GT(n, 20);
  // The ends of the range stay in it.
  for (const float u : {0.f, math::largest_u, below - 1e-7f}) {
    const auto s = sample(b, wo, u, .5f);
    EXPECT_TRUE(!s || std::fabs(math::length(s->wi) - 1) < 1e-5f) << u;
  }
  EXPECT_FALSE(sample(b, -wo, .5f, .5f).has_value());
}

}  // namespace
}  // namespace bsdf
