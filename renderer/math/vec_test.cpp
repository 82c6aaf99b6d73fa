// What the compiler must not do to our arithmetic.

#include "math/vec.h"

#include <gtest/gtest.h>

namespace math {
namespace {

struct Pair {
  double x, y;
};

// g++ 12.2 at -O2 returns its argument unrounded unless told not to use its SLP vectoriser.
[[gnu::noinline]] Pair through_float(const Pair& p) {
  const float x = static_cast<float>(p.x), y = static_cast<float>(p.y);
  return {x, y};
}

TEST(Compiler, rounds_when_a_double_passes_through_float) {
  const volatile double third = 1. / 3;
  const Pair p = through_float({third, third});
  EXPECT_EQ(p.x, static_cast<double>(1.f / 3));
  EXPECT_EQ(p.y, static_cast<double>(1.f / 3));
}

TEST(Compiler, keeps_non_finite_numbers_apart) {
  const volatile float nan = std::nanf("");
  EXPECT_TRUE(std::isnan(nan));  // -ffast-math folds this to false
  EXPECT_TRUE(std::signbit(-0.f * (nan == nan ? 2.f : 1.f)));
}

}  // namespace
}  // namespace math
