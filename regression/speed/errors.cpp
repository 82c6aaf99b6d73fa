#include "speed/errors.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <utility>

#include "base/error.h"
#include "metric/rmse.h"

namespace speed {
namespace {

using image::Image;

void demand_alike(const Image& a, const Image& b) {
  if (a.empty() || !a.same_shape(b))
    base::fail("speed: wanted renders of one shape, found ", a.width, " x ", a.height, " x ", a.channels,
               " and ", b.width, " x ", b.height, " x ", b.channels);
}

double checked(double sum, std::size_t count) {
  if (!std::isfinite(sum)) base::fail("speed: wanted finite pixels, found NaN or infinity in a render");
  return sum / static_cast<double>(count);
}

}  // namespace

Reference::Reference(Image first, Image second) : c(std::move(first)), d(std::move(second)) {
  demand_alike(c, d);
  mean = c;
  for (std::size_t i = 0; i < mean.data.size(); ++i) mean.data[i] = .5f * (c.data[i] + d.data[i]);
}

Errors variance(const Image& a, const Image& b, const Image& reference) {
  demand_alike(a, b), demand_alike(a, reference);
  double mse = 0, relative = 0;
  for (std::size_t i = 0; i < a.data.size(); ++i) {
    const double off = static_cast<double>(a.data[i]) - b.data[i], r = reference.data[i];
    mse += .5 * off * off;
    relative += .5 * off * off / (r * r + metric::relative_mse_epsilon);
  }
  return {checked(mse, a.data.size()), checked(relative, a.data.size())};
}

Errors against(const Image& a, const Reference& reference) {
  demand_alike(a, reference.mean);
  double mse = 0, relative = 0;
  for (std::size_t i = 0; i < a.data.size(); ++i) {
    const double c = reference.c.data[i], d = reference.d.data[i], r = .5 * (c + d), off = a.data[i] - r;
    const double square = off * off - .25 * (c - d) * (c - d);
    mse += square;
    relative += square / (r * r + metric::relative_mse_epsilon);
  }
  return {checked(mse, a.data.size()), checked(relative, a.data.size())};
}

Estimate bias_squared(const std::vector<const Image*>& renders, const Reference& reference) {
  assert(renders.size() >= 2);
  const Image& shape = reference.mean;
  for (const Image* render : renders) demand_alike(*render, shape);
  double sum = 0, squares = 0;
  const double pairs = static_cast<double>(renders.size() * (renders.size() - 1));
  for (std::size_t pixel = 0; pixel < shape.pixels(); ++pixel) {
    double here = 0;  // channels of a pixel share their noise
    for (int channel = 0; channel < shape.channels; ++channel) {
      const std::size_t i =
          pixel * static_cast<std::size_t>(shape.channels) + static_cast<std::size_t>(channel);
      const double c = reference.c.data[i], d = reference.d.data[i];
      // Sum over ordered pairs a != b of (a - c)(b - d), by sums over all less the diagonal.
      double to_c = 0, to_d = 0, both = 0;
      for (const Image* render : renders) {
        const double a = render->data[i];
        to_c += a - c, to_d += a - d, both += (a - c) * (a - d);
      }
      here += (to_c * to_d - both) / pairs / shape.channels;
    }
    sum += here, squares += here * here;
  }
  const double n = static_cast<double>(shape.pixels()), mean = checked(sum, shape.pixels());
  return {mean, std::sqrt(std::max(squares / n - mean * mean, 0.) / n)};
}

Estimate image_mean(const std::vector<const Image*>& group) {
  assert(group.size() >= 2);
  const Image& shape = *group.front();
  for (const Image* render : group) demand_alike(*render, shape);
  const double n = static_cast<double>(shape.pixels()), count = static_cast<double>(group.size());
  double sum = 0, variances = 0;
  for (std::size_t pixel = 0; pixel < shape.pixels(); ++pixel) {
    double mean = 0, square = 0;
    for (const Image* render : group) {
      double value = 0;
      for (int channel = 0; channel < shape.channels; ++channel)
        value +=
            render
                ->data[pixel * static_cast<std::size_t>(shape.channels) + static_cast<std::size_t>(channel)];
      value /= shape.channels;
      mean += value / count, square += value * value / count;
    }
    sum += mean;
    variances += std::max(square - mean * mean, 0.) / (count - 1);  // of the mean of the group
  }
  return {checked(sum, shape.pixels()), std::sqrt(variances) / n};
}

}  // namespace speed
