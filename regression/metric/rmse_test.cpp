#include "metric/rmse.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "base/error.h"

namespace {

using image::Image;

TEST(Rmse, AgreesWithAnExampleWorkedByHand) {
  Image a(2, 1, 3), b(2, 1, 3);
  a.data = {0, 1, 2, 3, 4, 5};
  b.data = {1, 1, 4, 3, 0, 5};  // squares 1 0 4 0 16 0
  const metric::Rmse r = metric::rmse(a, b, 0.5);
  EXPECT_DOUBLE_EQ(r.rmse, std::sqrt(21 / 6.0));
  EXPECT_DOUBLE_EQ(r.relative_mse, (1 / 0.5 + 4 / 4.5 + 16 / 16.5) / 6);
  EXPECT_EQ(r.max_difference, 4);
  EXPECT_EQ(r.non_finite, 0u);
}

// In float the sum would stop growing at 2^24 of these.
TEST(Rmse, IsSummedInDoublePrecision) {
  const Image a(6000, 1000, 3, 0), b(6000, 1000, 3, 1);
  EXPECT_EQ(metric::rmse(a, b).rmse, 1);
}

TEST(Rmse, OfANaNOrInfinityMeetsNoLimit) {
  Image a(2, 1, 3, 1), b = a;
  for (const float bad : {std::nanf(""), std::numeric_limits<float>::infinity()}) {
    b.at(1, 0, 1) = bad;
    for (const metric::Rmse& r : {metric::rmse(a, b), metric::rmse(b, a), metric::rmse(b, b)}) {
      EXPECT_FALSE(r.rmse <= 1e30);
      EXPECT_FALSE(r.max_difference <= 1e30);
      EXPECT_GE(r.non_finite, 1u);
    }
  }
  EXPECT_THROW(metric::rmse(a, Image(1, 2, 3)), base::Error);
  EXPECT_THROW(metric::rmse(Image(), Image()), base::Error);
}

}  // namespace
