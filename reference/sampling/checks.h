// What is asked of eval() and sample(), each as a function that says what is wrong, or nothing. The tests
// apply them to the renderer's BRDF, which must pass, and to planted faults, which must not.
#pragma once

#include "sampling/subject.h"

namespace sampling {

// A BRDF as a function of wo.
using Make = std::function<Subject(const Vec3& wo)>;

// sample() returns what eval() says of the direction it returns, bit for bit.
std::string disagreement(const Subject& subject, int draws, std::uint64_t seed);

// The mean weight f_cos / pdf of samples is the integral of f_cos, and times (1 + wi.z)^2 as well (pbrt's
// SamplingConsistency, with a factor that gives rare directions no great part). Against quadrature. Rejects
// beyond 6 standard errors of the mean and 1e-4 of it.
std::string wrong_weights(const Subject& subject, int draws, std::uint64_t seed);

// f(wo, wi) = f(wi, wo) within 2e-6 and 1e-7, at `pairs` random pairs, half of them sampled.
std::string not_reciprocal(const Make& make, int pairs, std::uint64_t seed);

// lajolla's test, without seed or statistics: where one lobe stands alone, pdf times the area by which
// sample() stretches the unit square, |dwi/du x dwi/dv|, is 1. Central differences of fourth order from float
// directions: within 1 %.
std::string wrong_jacobian(const Subject& subject);
// The largest |pdf |dwi/du x dwi/dv| - 1| on the grid, and at how many of its points that could be taken.
struct Stretch {
  double worst = 0;
  int points = 0;
};
Stretch stretch(const Subject& subject);

// f_cos equals the published formula in double (reference/disney) within 1e-5, at `pairs` random pairs, half
// of them sampled. Materials with all their lobes only.
std::string off_the_formula(const Material& material, const Make& make, int pairs, std::uint64_t seed);

}  // namespace sampling
