#include "metric/rmse.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/error.h"

namespace metric {

Rmse rmse(const image::Image& reference, const image::Image& test, double epsilon) {
  if (reference.empty() || !reference.same_shape(test))
    base::fail("RMSE: wanted two images of one shape, found ", reference.width, " x ", reference.height,
               " x ", reference.channels, " and ", test.width, " x ", test.height, " x ", test.channels);
  Rmse result;
  double squares = 0, relative = 0;
  for (std::size_t i = 0; i < reference.data.size(); ++i) {
    const double r = reference.data[i], difference = test.data[i] - r;
    result.non_finite += !std::isfinite(r) || !std::isfinite(test.data[i]);
    squares += difference * difference;
    relative += difference * difference / (r * r + epsilon);
    result.max_difference = std::max(result.max_difference, std::abs(difference));
  }
  const double n = static_cast<double>(reference.data.size());
  result.rmse = std::sqrt(squares / n);
  result.relative_mse = relative / n;
  if (result.non_finite > 0)
    result.rmse = result.relative_mse = result.max_difference = std::numeric_limits<double>::quiet_NaN();
  return result;
}

}  // namespace metric
