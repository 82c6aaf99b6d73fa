// Faults that BRDF samplers have had, planted in wrappers around the renderer's, each with the checks that
// must reject it. The renderer itself has no hook for them.
#pragma once

#include <array>

#include "sampling/checks.h"

namespace sampling {

enum class Check { total, cells, rings, jacobian, weights, agreement, reciprocity, formula };
inline constexpr int check_count = 8;
const char* name(Check check);

struct Fault {
  std::string name;
  std::string material;
  float shares[3];  // with which the lobes are chosen; zero: as the renderer does
  bsdf::Lobe lobe;  // the one that stands alone in the Jacobian test
  std::function<Subject(const Bsdf&, const Vec3& wo)> plant;
  std::vector<Check> must_reject;
  const char* source;  // where it happened, if it did
};
const std::vector<Fault>& faults();

// The BRDF the fault is planted in, without it.
Bsdf sound(const Fault& fault, const Vec3& wo);
// Of each check, why it rejects the fault, or nothing: at direction(3), cos .5, but for the Jacobian test,
// which tries four directions, and for those that choose their own.
using Verdicts = std::array<std::string, check_count>;
Verdicts verdicts(const Fault& fault);
// The same of the same BRDF without the fault.
Verdicts verdicts_without(const Fault& fault);

}  // namespace sampling
