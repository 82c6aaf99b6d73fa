// The renderer's sampling against its densities: every material of the table in eight directions.
//
// Rows B12 (clearcoat alone), B13 (visible normals), B19 (anisotropic extremes) of docs/bsdf-tests.md.
#include "sampling/chi_squared.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cctype>
#include <cstdio>

namespace sampling {
namespace {

class ChiSquaredOf : public testing::TestWithParam<Material> {};

TEST_P(ChiSquaredOf, sampled_directions_follow_the_density_and_fail_as_often_as_it_says) {
  const auto row = static_cast<std::uint64_t>(
      std::distance(materials().begin(), std::ranges::find(materials(), GetParam().name, &Material::name)));
  for (int d = 0; d < direction_count; ++d) {
    const Vec3 wo = direction(d);
    const std::uint64_t from = seed() + 1000 * row + static_cast<std::uint64_t>(d);
    const ChiSquared r = chi_squared(honest(at(GetParam(), wo), wo), draws(), from);
    std::printf(
        "%-50s cos %4.2f: succeed %.5f, integral %.5f (p %.3f); cells %.0f of %d (p %.3f), rings %.0f of "
        "%d (p %.3f)\n",
        GetParam().name.c_str(), static_cast<double>(wo.z), r.share, r.integral, r.p_total, r.cells.statistic,
        r.cells.degrees, r.cells.p, r.rings.statistic, r.rings.degrees, r.rings.p);
    EXPECT_GT(r.p_total, significance()) << "total, at cos " << wo.z << ", seed " << from;
    EXPECT_GT(r.cells.p, significance()) << "cells, at cos " << wo.z << ", seed " << from;
    EXPECT_GT(r.rings.p, significance()) << "rings, at cos " << wo.z << ", seed " << from;
    EXPECT_GT(r.cells.degrees, 50) << "the cells do not resolve the lobe";
  }
}

std::string name_of(const testing::TestParamInfo<Material>& info) {
  std::string name;
  for (const char c : info.param.name) name += std::isalnum(static_cast<unsigned char>(c)) ? c : '_';
  return name;
}
INSTANTIATE_TEST_SUITE_P(Materials, ChiSquaredOf, testing::ValuesIn(materials()), name_of);

}  // namespace
}  // namespace sampling
