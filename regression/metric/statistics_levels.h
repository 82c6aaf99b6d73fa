// Chances: how a false-alarm budget is split, and the distributions that p-values are read from.
//
// Student's t is right for sums of many pixels. Where few pixels or replicates carry a difference (caustics,
// fireflies, an edge that a sample grid sees as 21/64 or 22/64) its far tail, where a budget of 1e-9 lives,
// is not. Two bounds that hold for *any* distribution of the noise guard it:
//
//   symmetric_p   if golden and test are exchangeable, the difference of each pixel is as likely positive as
//                 negative. Then S = sum x / sqrt(sum x^2) is a weighted sum of fair signs, and
//                 P(|S| >= s) <= 3.178 P(|N(0,1)| >= s) (Bentkus and Dzindzalieta 2015, "A tight Gaussian
//                 bound for weighted sums of Rademacher random variables", Bernoulli 21(2)).
//   exchange_p    R replicates of a pixel against R others: even if all of one side lie above all of the
//   other,
//                 chance alone does that once in C(2R, R) / 2; m such pixels cannot be surer than (2 / C(2R,
//                 R))^m.
#pragma once

namespace metric {

// The chance that a test out of `tests` may give a false alarm so that all together give one with chance
// `budget`. Holds for tests that depend on each other, too (Sidak 1967).
double sidak(double budget, double tests);

// Suite-wide: at most 1e-6 per run of 100 cases; what one case may use.
inline constexpr double suite_false_alarm = 1e-6;
double case_false_alarm(int cases = 100);

// Student's t: chance of |t| or more, either side; and the t that has this chance.
double student_two_sided_p(double t, double degrees_of_freedom);
double student_critical(double two_sided_p, double degrees_of_freedom);

// The interval of a rate of which `found` of `trials` were counted (Clopper and Pearson 1934).
struct Interval {
  double low = 0, high = 0;
};
Interval rate_interval(int found, int trials, double confidence = .95);

double symmetric_p(double s);
double exchange_p(int replicates_a, int replicates_b, double pixels);

}  // namespace metric
