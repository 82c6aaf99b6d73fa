// Pearson's chi-squared test of sample() against pdf(), and of the total: does the density integrate to the
// probability that sample() succeeds?
//
// Three verdicts per configuration:
//   total  the share of draws that succeed (by a lobe that is not a Dirac), against the integral of pdf over
//          all cells: binomial, with an allowance of 1e-4 for the quadrature;
//   cells  given how many succeeded, how they spread over the cells of cells.h: chi-squared;
//   rings  the same of the cells' sums over the azimuth. With 27 degrees of freedom in place of hundreds it
//          sees a width that is 3 % off in a lobe that few draws choose.
// Cells are pooled, smallest expectation first, until each pool expects at least 10.
//
// Significance: 1e-6 for the whole suite by Sidak over all verdicts of all configurations. Seeds are fixed,
// so the suite either passes or fails for ever; 1e-6 is how often it would fail with fresh seeds.
#pragma once

#include "sampling/cells.h"

namespace sampling {

inline constexpr double suite_false_alarm = 1e-6;
// Of one verdict, when there are `verdicts` of them.
double significance(std::size_t verdicts);
// Of one verdict of the suite: every material in every direction.
double significance();

struct Pearson {
  double statistic = 0;
  int degrees = 0;
  double p = 1;
};
// Of counts, given densities that sum to anything: they are scaled to the sum of the counts.
Pearson pearson(const std::vector<double>& density, const std::vector<long>& observed);

struct ChiSquared {
  double share = 0, integral = 0;  // of the draws; of the pdf
  double p_total = 1;
  Pearson cells, rings;
};
ChiSquared chi_squared(const Subject& subject, int draws, std::uint64_t seed);

// In the gate; ASSAY_NIGHTLY=1 in the environment takes four times as many, from a seed of the day.
int draws();
std::uint64_t seed();
bool nightly();

}  // namespace sampling
