// What is asked of eval() and sample() beyond chi-squared, of every material of the table.
#include "sampling/checks.h"

#include <gtest/gtest.h>

#include <cstdio>

#include "sampling/cells.h"

namespace sampling {
namespace {

// B14, B17: the values that sample() returns are eval()'s, bit for bit, so that a sample's weight is
// f_cos/pdf of one and the same function.
TEST(Sample, returns_what_eval_says_bit_for_bit) {
  for (const Material& m : materials())
    for (int d = 0; d < direction_count; ++d) {
      const Vec3 wo = direction(d);
      EXPECT_EQ(disagreement(honest(at(m, wo), wo), 3000, 5 + static_cast<std::uint64_t>(d)), "")
          << m.name << " at cos " << wo.z;
    }
}

// B12, the second half. 6 standard errors: one in 5e8 per material and direction with fresh seeds.
TEST(Sample, weights_average_to_the_integral_of_f) {
  for (const Material& m : materials())
    for (int d = 0; d < direction_count; ++d) {
      const Vec3 wo = direction(d);
      EXPECT_EQ(wrong_weights(honest(at(m, wo), wo), 40000, 9 + static_cast<std::uint64_t>(d)), "")
          << m.name << " at cos " << wo.z;
    }
}

// B21. All four models are symmetric where shading, smooth and geometric normals agree. Where they do not,
// none is: the light's side alone is tested against the triangle and dimmed by the bump terminator.
TEST(Eval, is_reciprocal) {
  for (const Material& m : materials()) {
    if (m.lobes != all) continue;
    const Make make = [&](const Vec3& wo) { return honest(at(m, wo), wo); };
    EXPECT_EQ(not_reciprocal(make, 30000, 3), "") << m.name;
  }
}

// lajolla's test. Where a lobe stands alone its density is the reciprocal of the sampler's stretch.
TEST(Density, is_the_reciprocal_of_the_samplers_jacobian) {
  double worst = 0;
  int points = 0, lobes = 0;
  for (const Material& m : materials())
    for (int d = 0; d < 6; ++d)
      for (int lobe = 0; lobe < bsdf::lobe_count; ++lobe) {
        const Vec3 wo = direction(d);
        Bsdf b = at(m, wo);
        if (!(b.probability[lobe] > 0)) continue;
        if ((lobe == 1 && b.specular.is_delta) || (lobe == 2 && b.clearcoat.is_delta)) continue;
        for (float& p : b.probability) p = 0;
        b.probability[lobe] = 1;
        const Stretch s = stretch(honest(b, wo));
        EXPECT_LE(s.worst, .01) << m.name << ", lobe " << lobe << " at cos " << wo.z;
        worst = std::max(worst, s.worst);
        points += s.points;
        ++lobes;
      }
  std::printf("%d lobes, %d points: largest |pdf times area - 1| %.4f\n", lobes, points, worst);
  EXPECT_GT(points, 100 * lobes);  // of 144 each
}

// The tests' own quadrature, which is allowed 1e-4.
TEST(Cells, integrate_the_cosine_to_one_whatever_lobe_they_are_made_for) {
  for (const Material& m : materials())
    for (int d = 0; d < direction_count; ++d) {
      const Vec3 wo = direction(d);
      double sum = 0;
      for (const double part : Cells(at(m, wo), wo).integrate([](const Vec3& wi) { return wi.z / bsdf::pi; }))
        sum += part;
      EXPECT_NEAR(sum, 1, 5e-5) << m.name << " at cos " << wo.z;
    }
}

}  // namespace
}  // namespace sampling
