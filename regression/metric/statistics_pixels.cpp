#include "metric/statistics_pixels.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/error.h"

namespace metric {

namespace {

// What surrounds a pixel, itself included, in one channel.
struct Neighbourhood {
  double variance = 0;  // the largest
  double contrast = 0;  // of the reference
};

Neighbourhood around(const Noisy& reference, const Noisy& test, int x, int y, int c) {
  Neighbourhood n;
  double low = std::numeric_limits<double>::infinity(), high = -low;
  for (int v = std::max(0, y - 1); v <= std::min(reference.mean.height - 1, y + 1); ++v)
    for (int u = std::max(0, x - 1); u <= std::min(reference.mean.width - 1, x + 1); ++u) {
      n.variance = std::max(n.variance, double{reference.variance.at(u, v, c)} + test.variance.at(u, v, c));
      low = std::min<double>(low, reference.mean.at(u, v, c));
      high = std::max<double>(high, reference.mean.at(u, v, c));
    }
  n.contrast = high - low;
  return n;
}

// The middle value; of two middle ones the one nearer to `reference`, which is that itself between them.
double median_near(std::vector<double>& values, double reference) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  if (values.size() % 2 == 1) return *middle;
  return std::clamp(reference, *std::max_element(values.begin(), middle), *middle);
}

}  // namespace

std::vector<WrongPixel> wrong_pixels(const Noisy& reference, const Noisy& test,
                                     const std::vector<const image::Image*>& replicates, double samples,
                                     double rounding) {
  std::vector<WrongPixel> wrong;
  if (replicates.size() < 2) return wrong;
  for (const image::Image* r : replicates)
    if (!r->same_shape(reference.mean)) base::fail("statistics: wanted replicates of the picture's size");
  double image_mean = 0;
  for (const float v : reference.mean.data)
    image_mean += std::abs(v) / static_cast<double>(reference.mean.data.size());

  std::vector<double> values(replicates.size());
  for (int y = 0; y < reference.mean.height; ++y)
    for (int x = 0; x < reference.mean.width; ++x) {
      WrongPixel worst{x, y, 0, 0, 0};
      for (int c = 0; c < 3; ++c) {
        const double golden = reference.mean.at(x, y, c);
        for (std::size_t k = 0; k < replicates.size(); ++k) values[k] = replicates[k]->at(x, y, c);
        const double median = median_near(values, golden), off = std::abs(median - golden);
        if (off <= rounding * std::max(std::abs(golden), 0.1 * image_mean)) continue;
        const Neighbourhood n = around(reference, test, x, y, c);
        const double beyond = off - 4 / samples * n.contrast, sigma = std::sqrt(n.variance);
        const double sigmas = beyond <= 0 ? 0
                              : sigma > 0 ? beyond / sigma
                                          : std::numeric_limits<double>::infinity();
        if (sigmas > worst.sigmas) worst = {x, y, golden, median, sigmas};
      }
      if (worst.sigmas > wrong_pixel_sigmas) wrong.push_back(worst);
    }
  std::stable_sort(wrong.begin(), wrong.end(),
                   [](const auto& a, const auto& b) { return a.sigmas > b.sigmas; });
  return wrong;
}

}  // namespace metric
