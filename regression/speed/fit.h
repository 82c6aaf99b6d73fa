// Numbers out of curves of error against time: interpolation, equal error, and the fit
//
//   MSE(N) = a N^-p + b^2
//
// where b^2, the bias that no number of samples removes, is not fitted but measured without bias (errors.h).
#pragma once

#include <optional>
#include <vector>

namespace speed {

// Render time and mean squared error (or any other error) of one renderer; any order.
struct Point {
  double seconds = 0, error = 0;
};
using Curve = std::vector<Point>;

struct Equal {
  double seconds = 0;
  bool extrapolated = false;  // the curve did not reach: prolonged by its own slope, by `reach` at most
};

inline constexpr double reach = 8;

// The time at which the curve's error falls to `error`: linear between logarithms. Points that are not
// positive are left out. Nothing if the curve has no two points, rises, or would have to be prolonged by more
// than `reach` in time.
std::optional<Equal> time_to(Curve curve, double error);

struct PowerFit {
  double a = 0, p = 0;  // a N^-p
  double b2 = 0;        // as given
  double residual = 0;  // root mean square of the logarithm's: .01 is 1 %
};

struct Level {
  double samples = 0, mse = 0;
};

// Least squares in logarithms of MSE - b2. Nothing with fewer than two usable levels.
std::optional<PowerFit> fit_power(const std::vector<Level>& levels, double b2);

double median(std::vector<double> values);

// A number and the half width of its interval at 99.9 %.
inline constexpr double normal_999 = 3.2905;

}  // namespace speed
