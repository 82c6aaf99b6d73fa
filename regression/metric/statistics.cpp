#include "metric/statistics.h"

#include <algorithm>
#include <array>
#include <boost/math/distributions/normal.hpp>
#include <boost/math/distributions/students_t.hpp>
#include <cmath>
#include <limits>

#include "base/error.h"

namespace metric {

namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr double luminance_weight[3] = {0.2126, 0.7152, 0.0722};

// Chance with which a bias of the `detectable` size is found.
constexpr double power = 0.9;

// Beyond this many degrees of freedom, Student's distribution is normal to the last digit that matters.
constexpr double normal_from = 1e9;

using Policy = boost::math::policies::policy<
    boost::math::policies::promote_double<false>,
    boost::math::policies::overflow_error<boost::math::policies::ignore_error>,
    boost::math::policies::underflow_error<boost::math::policies::ignore_error>>;
using Student = boost::math::students_t_distribution<double, Policy>;
using Normal = boost::math::normal_distribution<double, Policy>;

// Sums over a region: what a mean, its standard error and its degrees of freedom are made of.
struct Sums {
  double reference = 0, test = 0;    // of the values
  double variance = 0;               // of all variances, both sides
  double variance_over_freedom = 0;  // of variance^2 / degrees of freedom

  void add(const Sums& o) {
    reference += o.reference;
    test += o.test;
    variance += o.variance;
    variance_over_freedom += o.variance_over_freedom;
  }
  void add_variance(double v, double freedom) {
    variance += v;
    variance_over_freedom += v * v / freedom;
  }
};

using Quantities = std::array<Sums, quantity_count>;

// The mean difference of a region of `n` pixels, before it is judged.
Difference difference_of(const Sums& sums, double n) {
  Difference d;
  d.reference = sums.reference / n;
  d.test = sums.test / n;
  d.difference = (sums.test - sums.reference) / n;
  d.standard_error = std::sqrt(sums.variance) / n;
  d.degrees_of_freedom =
      sums.variance_over_freedom > 0 ? sums.variance * sums.variance / sums.variance_over_freedom : infinity;
  if (d.standard_error > 0) {
    d.t = d.difference / d.standard_error;
    d.p = student_two_sided_p(d.t, d.degrees_of_freedom);
  } else if (d.difference != 0) {
    d.t = std::copysign(infinity, d.difference);
    d.p = 0;
  }
  return d;
}

double relative_to(double value, double scale) { return value == 0 ? 0 : value / scale; }

// Judges a difference against the level of a single test and its margin.
void judge(Difference& d, double scale, double level, double margin, const WelchOptions& options) {
  d.scale = scale;
  const double centre = d.relative(), error = relative_to(d.standard_error, scale);
  const double half = error == 0 ? 0 : student_critical(1 - options.confidence, d.degrees_of_freedom) * error;
  d.interval = {centre - half, centre + half};
  if (error > 0)
    d.detectable = (student_critical(level, d.degrees_of_freedom) +
                    student_critical(2 * (1 - power), d.degrees_of_freedom)) *
                   error;
  d.significant = d.p < level && std::abs(centre) > options.rounding;
  d.within_margin = d.interval.low >= -margin && d.interval.high <= margin;
}

double mean_of_channels(const Difference (&d)[quantity_count]) {
  return (d[red].reference + d[green].reference + d[blue].reference) / 3;
}

// From the sums of every tile to the whole comparison. The image is the sum of its tiles.
Comparison conclude(const std::vector<Quantities>& tiles, int width, int height,
                    const WelchOptions& options) {
  Comparison c;
  c.tile_columns = (width + options.tile - 1) / options.tile;
  c.tile_rows = (height + options.tile - 1) / options.tile;
  const double tests = static_cast<double>(quantity_count) * (1.0 + static_cast<double>(tiles.size()));
  c.level = sidak(options.false_alarm, tests);

  Quantities whole;
  for (const Quantities& tile : tiles)
    for (int q = 0; q < quantity_count; ++q) whole[q].add(tile[q]);
  for (int q = 0; q < quantity_count; ++q)
    c.image[q] = difference_of(whole[q], static_cast<double>(width) * height);
  const double image_scale = std::abs(mean_of_channels(c.image));
  for (Difference& d : c.image) judge(d, image_scale, c.level, options.image_margin, options);

  for (int i = 0; i < static_cast<int>(tiles.size()); ++i) {
    Tile tile;
    tile.x = i % c.tile_columns * options.tile;
    tile.y = i / c.tile_columns * options.tile;
    tile.width = std::min(options.tile, width - tile.x);
    tile.height = std::min(options.tile, height - tile.y);
    for (int q = 0; q < quantity_count; ++q)
      tile.difference[q] = difference_of(tiles[i][q], static_cast<double>(tile.width) * tile.height);
    const double scale =
        std::max(std::abs(mean_of_channels(tile.difference)), options.tile_scale_floor * image_scale);
    for (Difference& d : tile.difference) judge(d, scale, c.level, options.tile_margin, options);
    c.tiles.push_back(tile);
  }

  double smallest = 1;
  for (const Difference& d : c.image) smallest = std::min(smallest, d.p);
  for (const Tile& tile : c.tiles)
    for (const Difference& d : tile.difference) smallest = std::min(smallest, d.p);
  c.smallest_p = smallest < 1 ? -std::expm1(tests * std::log1p(-smallest)) : 1;
  return c;
}

std::string shape(const image::Image& i) {
  return std::to_string(i.width) + " x " + std::to_string(i.height) + " x " + std::to_string(i.channels);
}

// Throws if the shapes are wrong; returns why the data cannot be judged, or "".
std::string broken(const Noisy& reference, const Noisy& test) {
  for (const image::Image* i : {&reference.variance, &test.mean, &test.variance})
    if (reference.mean.empty() || reference.mean.channels != 3 || !i->same_shape(reference.mean))
      base::fail("statistics: wanted images of one shape with three channels, found ", shape(reference.mean),
                 " and ", shape(*i));
  for (const auto& [side, name] : {std::pair{&reference, "reference"}, std::pair{&test, "test image"}}) {
    if (side->replicates < 2) return std::string(name) + ": one replicate tells nothing about its own noise";
    if (const std::size_t bad = image::count_non_finite(side->mean))
      return std::string(name) + ": " + std::to_string(bad) + " non-finite pixels";
    std::size_t bad = 0;
    for (const float v : side->variance.data) bad += !(v >= 0 && std::isfinite(v));
    if (bad)
      return std::string(name) + ": " + std::to_string(bad) + " variances that are negative or not finite";
  }
  return "";
}

}  // namespace

double sidak(double budget, double tests) { return -std::expm1(std::log1p(-budget) / tests); }

double case_false_alarm(int cases, int stages) {
  return sidak(suite_false_alarm, static_cast<double>(cases) * stages);
}

double student_two_sided_p(double t, double degrees_of_freedom) {
  const double a = std::abs(t);
  if (std::isnan(a)) return std::numeric_limits<double>::quiet_NaN();
  if (std::isinf(a)) return 0;
  if (degrees_of_freedom > normal_from) return 2 * cdf(complement(Normal(0, 1), a));
  return 2 * cdf(complement(Student(degrees_of_freedom), a));
}

double student_critical(double two_sided_p, double degrees_of_freedom) {
  if (two_sided_p >= 1) return 0;
  if (two_sided_p <= 0) return infinity;
  if (degrees_of_freedom > normal_from) return quantile(complement(Normal(0, 1), two_sided_p / 2));
  return quantile(complement(Student(degrees_of_freedom), two_sided_p / 2));
}

double Difference::relative() const { return relative_to(difference, scale); }

bool Tile::significant() const {
  return std::any_of(std::begin(difference), std::end(difference),
                     [](const Difference& d) { return d.significant; });
}

bool Tile::within_margin() const {
  return std::all_of(std::begin(difference), std::end(difference),
                     [](const Difference& d) { return d.within_margin; });
}

double Tile::t() const {
  return std::max_element(
             std::begin(difference), std::end(difference),
             [](const Difference& a, const Difference& b) { return std::abs(a.t) < std::abs(b.t); })
      ->t;
}

bool Comparison::biased() const {
  if (!ok()) return false;
  for (const Difference& d : image)
    if (d.significant) return true;
  return std::any_of(tiles.begin(), tiles.end(), [](const Tile& t) { return t.significant(); });
}

bool Comparison::equivalent() const {
  if (!ok() || biased()) return false;
  for (const Difference& d : image)
    if (!d.within_margin) return false;
  return std::all_of(tiles.begin(), tiles.end(), [](const Tile& t) { return t.within_margin(); });
}

Comparison compare_welch(const Noisy& reference, const Noisy& test, const WelchOptions& options) {
  if (const std::string why = broken(reference, test); !why.empty()) {
    Comparison failed;
    failed.failure = why;
    return failed;
  }
  const int width = reference.mean.width, height = reference.mean.height, n = options.tile;
  const int columns = (width + n - 1) / n, rows = (height + n - 1) / n;
  std::vector<Quantities> tiles(static_cast<std::size_t>(columns) * rows);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      Quantities& tile = tiles[static_cast<std::size_t>(y / n) * columns + x / n];
      double sigma_reference = 0, sigma_test = 0;
      for (int c = 0; c < 3; ++c) {
        const double r = reference.mean.at(x, y, c), t = test.mean.at(x, y, c);
        const double vr = reference.variance.at(x, y, c), vt = test.variance.at(x, y, c);
        tile[c].reference += r;
        tile[c].test += t;
        tile[c].add_variance(vr, reference.replicates - 1);
        tile[c].add_variance(vt, test.replicates - 1);
        tile[luminance].reference += luminance_weight[c] * r;
        tile[luminance].test += luminance_weight[c] * t;
        sigma_reference += luminance_weight[c] * std::sqrt(vr);
        sigma_test += luminance_weight[c] * std::sqrt(vt);
      }
      tile[luminance].add_variance(sigma_reference * sigma_reference, reference.replicates - 1);
      tile[luminance].add_variance(sigma_test * sigma_test, test.replicates - 1);
    }
  return conclude(tiles, width, height, options);
}

image::Image tile_means(const image::Image& image, int tile) {
  image::Image means((image.width + tile - 1) / tile, (image.height + tile - 1) / tile, image.channels);
  for (int y = 0; y < means.height; ++y)
    for (int x = 0; x < means.width; ++x) {
      const int right = std::min((x + 1) * tile, image.width),
                bottom = std::min((y + 1) * tile, image.height);
      for (int c = 0; c < image.channels; ++c) {
        double sum = 0;
        for (int v = y * tile; v < bottom; ++v)
          for (int u = x * tile; u < right; ++u) sum += image.at(u, v, c);
        means.at(x, y, c) =
            static_cast<float>(sum / (static_cast<double>(right - x * tile) * (bottom - y * tile)));
      }
    }
  return means;
}

Comparison compare_paired(const std::vector<image::Image>& reference, const std::vector<image::Image>& test,
                          int width, int height, const WelchOptions& options) {
  const int n = options.tile, columns = (width + n - 1) / n, rows = (height + n - 1) / n;
  if (reference.size() != test.size())
    base::fail("statistics: wanted as many replicates on both sides, found ", reference.size(), " and ",
               test.size());
  Comparison failed;
  if (reference.size() < 2) {
    failed.failure = "one replicate tells nothing about its own noise";
    return failed;
  }
  for (const auto* side : {&reference, &test})
    for (const image::Image& i : *side) {
      if (i.width != columns || i.height != rows || i.channels != 3)
        base::fail("statistics: wanted tile means of ", columns, " x ", rows, " x 3, found ", shape(i));
      if (const std::size_t bad = image::count_non_finite(i))
        failed.failure = std::to_string(bad) + " non-finite tiles in a replicate";
    }
  if (!failed.failure.empty()) return failed;

  const double count = static_cast<double>(reference.size());
  std::vector<Quantities> tiles(static_cast<std::size_t>(columns) * rows);
  for (int i = 0; i < columns * rows; ++i) {
    const int x = i % columns, y = i / columns;
    const double area = static_cast<double>(std::min(n, width - x * n)) * std::min(n, height - y * n);
    for (int q = 0; q < quantity_count; ++q) {
      const auto value = [&](const image::Image& means) {
        if (q != luminance) return static_cast<double>(means.at(x, y, q));
        double sum = 0;
        for (int c = 0; c < 3; ++c) sum += luminance_weight[c] * means.at(x, y, c);
        return sum;
      };
      double r = 0, t = 0, squares = 0;
      for (std::size_t k = 0; k < reference.size(); ++k) {
        r += value(reference[k]) / count;
        t += value(test[k]) / count;
      }
      for (std::size_t k = 0; k < reference.size(); ++k) {
        const double deviation = value(test[k]) - value(reference[k]) - (t - r);
        squares += deviation * deviation;
      }
      Sums& sums = tiles[i][q];
      sums.reference = r * area;
      sums.test = t * area;
      if (squares > 0) sums.add_variance(squares / (count - 1) / count * area * area, count - 1);
    }
  }
  return conclude(tiles, width, height, options);
}

NoiseRatio noise_ratio(const Noisy& reference, const Noisy& test, const WelchOptions& options) {
  NoiseRatio result;
  if (!broken(reference, test).empty()) return result;

  // Variances summed over the pixels and channels of each tile.
  const image::Image r = tile_means(reference.variance, options.tile),
                     t = tile_means(test.variance, options.tile);
  std::vector<double> vr(r.pixels()), vt(r.pixels());
  double sum_r = 0, sum_t = 0;
  for (std::size_t i = 0; i < r.pixels(); ++i) {
    for (int c = 0; c < 3; ++c) {
      vr[i] += r.data[3 * i + c];
      vt[i] += t.data[3 * i + c];
    }
    sum_r += vr[i];
    sum_t += vt[i];
  }
  result.pooled = sum_r == sum_t ? 1 : sum_t / sum_r;

  // A tile with noise on one side only has a ratio of 0 or infinity: held to a millionth of the mean
  // variance.
  const double floor = 1e-6 * (sum_r + sum_t) / (2 * static_cast<double>(r.pixels()));
  std::vector<double> logs;
  for (std::size_t i = 0; i < r.pixels(); ++i)
    if (vr[i] > 0 || vt[i] > 0) logs.push_back(std::log(std::max(vt[i], floor) / std::max(vr[i], floor)));
  result.tiles = static_cast<int>(logs.size());
  result.interval = {0, infinity};
  if (logs.size() < 8) return result;

  const double n = static_cast<double>(logs.size());
  double mean = 0, squares = 0;
  for (const double l : logs) mean += l / n;
  for (const double l : logs) squares += (l - mean) * (l - mean);
  const double error = std::sqrt(squares / (n - 1) / n);
  const double half = error == 0 ? 0 : student_critical(1 - options.confidence, n - 1) * error;
  result.ratio = std::exp(mean);
  result.interval = {std::exp(mean - half), std::exp(mean + half)};
  result.p = mean == 0 ? 1 : error == 0 ? 0 : student_two_sided_p(mean / error, n - 1);
  return result;
}

bool agrees(const Difference& difference, double margin) {
  return std::abs(difference.difference) + 3.5 * difference.standard_error <= margin * difference.scale;
}

bool flip_agrees(double flip, double noise_floor) { return flip <= 1.25 * noise_floor + 0.005; }

}  // namespace metric
