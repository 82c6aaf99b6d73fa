// The tests tested: each planted fault is rejected by the checks that must reject it, and the same BRDF
// without the fault is not.
#include "sampling/faults.h"

#include <gtest/gtest.h>

#include <cctype>
#include <cstdio>

namespace sampling {
namespace {

class PlantedFault : public testing::TestWithParam<Fault> {};

TEST_P(PlantedFault, is_rejected) {
  const Verdicts with = verdicts(GetParam()), without = verdicts_without(GetParam());
  for (std::size_t c = 0; c < with.size(); ++c) {
    const char* const check = name(static_cast<Check>(c));
    if (!with[c].empty()) std::printf("%s: %s: %s\n", GetParam().name.c_str(), check, with[c].c_str());
    EXPECT_TRUE(without[c].empty()) << check << " rejects the BRDF without the fault: " << without[c];
  }
  EXPECT_FALSE(GetParam().must_reject.empty());
  for (const Check check : GetParam().must_reject)
    EXPECT_FALSE(with[static_cast<std::size_t>(check)].empty()) << name(check) << " does not see it";
}

std::string name_of(const testing::TestParamInfo<Fault>& info) {
  std::string name;
  for (const char c : info.param.name) name += std::isalnum(static_cast<unsigned char>(c)) ? c : '_';
  return name;
}
INSTANTIATE_TEST_SUITE_P(The, PlantedFault, testing::ValuesIn(faults()), name_of);

}  // namespace
}  // namespace sampling
