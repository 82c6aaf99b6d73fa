#include "metric/statistics.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "base/error.h"

namespace metric {

namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr double luminance_weight[3] = {0.2126, 0.7152, 0.0722};

// Chance with which a bias of the `detectable` size is found.
constexpr double power = 0.99;

// Noise of less than this share of the mean is the last bits of float arithmetic, which any change of code
// may move. (WelchOptions::rounding, of differences, is wider: a mean may be off by more than its noise.)
constexpr double rounding_noise = 1e-6;

// How uncertain a sum over pixels is.
struct Spread {
  double variance = 0, variance_over_freedom = 0;  // of variance^2 / degrees of freedom

  void add(double v, double freedom) {
    variance += v;
    variance_over_freedom += v * v / freedom;
  }
  void add(const Spread& o) {
    variance += o.variance;
    variance_over_freedom += o.variance_over_freedom;
  }
  Spread times(double factor) const { return {variance * factor, variance_over_freedom * factor * factor}; }
};

// Sums over a region: what a mean, its standard error and its degrees of freedom are made of.
struct Sums {
  double reference = 0, test = 0;             // of the values
  Spread reference_spread, test_spread;       // a paired test knows only that of the difference, the test's
  double absolute = 0, squares = 0;           // of the pixels' differences
  double relative = 0, relative_squares = 0;  // of the same, each in units of the sum of both sides

  void add(const Sums& o) {
    reference += o.reference, test += o.test;
    reference_spread.add(o.reference_spread), test_spread.add(o.test_spread);
    absolute += o.absolute, squares += o.squares;
    relative += o.relative, relative_squares += o.relative_squares;
  }
  void add_pixel(double r, double t) {
    reference += r, test += t;
    const double d = t - r, unit = std::abs(r) + std::abs(t);
    absolute += std::abs(d), squares += d * d;
    if (d != 0) relative += d / unit, relative_squares += d / unit * (d / unit);
  }
};

using Quantities = std::array<Sums, quantity_count>;

// What a comparison knows besides the sums.
struct Design {
  bool paired = false;
  int replicates[2] = {2, 2};
  double samples_ratio = 1;  // test / reference
};

// The side with fewer samples is at least as noisy as the other's samples say.
Spread total_spread(const Sums& sums, const Design& design) {
  Spread reference = sums.reference_spread, test = sums.test_spread;
  const double k = design.samples_ratio;
  if (k > 1 && reference.variance < k * test.variance) reference = test.times(k);
  if (k < 1 && test.variance < reference.variance / k) test = reference.times(1 / k);
  reference.add(test);
  return reference;
}

// What chance alone could give at most, however the noise is distributed.
double bound_of(const Sums& sums, const Design& design) {
  if (sums.squares == 0) return 1;
  if (!design.paired)
    return exchange_p(design.replicates[0], design.replicates[1],
                      sums.absolute * sums.absolute / sums.squares);
  const double plain = symmetric_p((sums.test - sums.reference) / std::sqrt(sums.squares));
  const double relative = symmetric_p(sums.relative / std::sqrt(sums.relative_squares));
  return std::min(1., 2 * std::min(plain, relative));
}

// The mean difference of a region of `n` pixels, before it is judged.
Difference difference_of(const Sums& sums, double n, const Design& design) {
  const Spread spread = total_spread(sums, design);
  Difference d;
  d.reference = sums.reference / n;
  d.test = sums.test / n;
  d.difference = (sums.test - sums.reference) / n;
  d.standard_error = std::sqrt(spread.variance) / n;
  d.degrees_of_freedom = spread.variance_over_freedom > 0
                             ? spread.variance * spread.variance / spread.variance_over_freedom
                             : infinity;
  if (d.standard_error > 0) {
    d.t = d.difference / d.standard_error;
    d.p = student_two_sided_p(d.t, d.degrees_of_freedom);
  } else if (d.difference != 0) {
    d.t = std::copysign(infinity, d.difference);
    d.p = 0;
  }
  d.p = std::max(d.p, bound_of(sums, design));
  if (d.difference == 0) d.p = 1;
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

// Values and differences of all pixels, by tile.
std::vector<Quantities> pixel_sums(const image::Image& reference, const image::Image& test, int n) {
  const int columns = (reference.width + n - 1) / n, rows = (reference.height + n - 1) / n;
  std::vector<Quantities> tiles(static_cast<std::size_t>(columns) * rows);
  for (int y = 0; y < reference.height; ++y)
    for (int x = 0; x < reference.width; ++x) {
      Quantities& tile = tiles[static_cast<std::size_t>(y / n) * columns + x / n];
      double r = 0, t = 0;
      for (int c = 0; c < 3; ++c) {
        tile[c].add_pixel(reference.at(x, y, c), test.at(x, y, c));
        r += luminance_weight[c] * reference.at(x, y, c);
        t += luminance_weight[c] * test.at(x, y, c);
      }
      tile[luminance].add_pixel(r, t);
    }
  return tiles;
}

double mean_of_channels(const Difference (&d)[quantity_count]) {
  return (d[red].reference + d[green].reference + d[blue].reference) / 3;
}

// From the sums of every tile to the whole comparison. The image is the sum of its tiles.
Comparison conclude(const std::vector<Quantities>& tiles, int width, int height, const Design& design,
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
    c.image[q] = difference_of(whole[q], static_cast<double>(width) * height, design);
  const double image_scale = std::abs(mean_of_channels(c.image));
  for (Difference& d : c.image) judge(d, image_scale, c.level, options.image_margin, options);

  for (int i = 0; i < static_cast<int>(tiles.size()); ++i) {
    Tile tile;
    tile.x = i % c.tile_columns * options.tile;
    tile.y = i / c.tile_columns * options.tile;
    tile.width = std::min(options.tile, width - tile.x);
    tile.height = std::min(options.tile, height - tile.y);
    for (int q = 0; q < quantity_count; ++q)
      tile.difference[q] = difference_of(tiles[i][q], static_cast<double>(tile.width) * tile.height, design);
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
  Design design;
  design.replicates[0] = reference.replicates, design.replicates[1] = test.replicates;
  if (reference.samples > 0 && test.samples > 0) design.samples_ratio = test.samples / reference.samples;
  std::vector<Quantities> tiles = pixel_sums(reference.mean, test.mean, options.tile);
  const int columns = (reference.mean.width + options.tile - 1) / options.tile;
  for (int y = 0; y < reference.mean.height; ++y)
    for (int x = 0; x < reference.mean.width; ++x) {
      Quantities& tile = tiles[static_cast<std::size_t>(y / options.tile) * columns + x / options.tile];
      const auto add = [&](const Noisy& side, Spread Sums::*spread) {
        double sigma = 0;
        for (int c = 0; c < 3; ++c) {
          const double v = side.variance.at(x, y, c);
          (tile[c].*spread).add(v, side.replicates - 1);
          sigma += luminance_weight[c] * std::sqrt(v);
        }
        (tile[luminance].*spread).add(sigma * sigma, side.replicates - 1);
      };
      add(reference, &Sums::reference_spread);
      add(test, &Sums::test_spread);
    }
  return conclude(tiles, reference.mean.width, reference.mean.height, design, options);
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

Comparison compare_paired(const Paired& reference, const Paired& test, const WelchOptions& options) {
  const int width = reference.mean.width, height = reference.mean.height, n = options.tile;
  const int columns = (width + n - 1) / n, rows = (height + n - 1) / n;
  if (!test.mean.same_shape(reference.mean) || test.mean.channels != 3)
    base::fail("statistics: wanted images of one shape with three channels, found ", shape(reference.mean),
               " and ", shape(test.mean));
  if (reference.tiles.size() != test.tiles.size())
    base::fail("statistics: wanted as many replicates on both sides, found ", reference.tiles.size(), " and ",
               test.tiles.size());
  Comparison failed;
  if (reference.tiles.size() < 2) {
    failed.failure = "one replicate tells nothing about its own noise";
    return failed;
  }
  for (const Paired* side : {&reference, &test}) {
    if (const std::size_t bad = image::count_non_finite(side->mean))
      failed.failure = std::to_string(bad) + " non-finite pixels";
    for (const image::Image& i : side->tiles) {
      if (i.width != columns || i.height != rows || i.channels != 3)
        base::fail("statistics: wanted tile means of ", columns, " x ", rows, " x 3, found ", shape(i));
      if (const std::size_t bad = image::count_non_finite(i))
        failed.failure = std::to_string(bad) + " non-finite tiles in a replicate";
    }
  }
  if (!failed.failure.empty()) return failed;

  const double count = static_cast<double>(reference.tiles.size());
  std::vector<Quantities> tiles = pixel_sums(reference.mean, test.mean, n);
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
      double mean = 0, squares = 0;
      for (std::size_t k = 0; k < reference.tiles.size(); ++k)
        mean += (value(test.tiles[k]) - value(reference.tiles[k])) / count;
      for (std::size_t k = 0; k < reference.tiles.size(); ++k) {
        const double deviation = value(test.tiles[k]) - value(reference.tiles[k]) - mean;
        squares += deviation * deviation;
      }
      if (squares > 0) tiles[i][q].test_spread.add(squares / (count - 1) / count * area * area, count - 1);
    }
  }
  Design design;
  design.paired = true;
  return conclude(tiles, width, height, design, options);
}

NoiseRatio noise_ratio(const Noisy& reference, const Noisy& test, const WelchOptions& options) {
  NoiseRatio result;
  if (!broken(reference, test).empty()) return result;

  // Variances summed over the pixels and channels of each block.
  const int block = std::max(1, options.tile / 2);
  const image::Image r = tile_means(reference.variance, block), t = tile_means(test.variance, block);
  const image::Image mean = tile_means(reference.mean, block);
  std::vector<double> vr(r.pixels()), vt(r.pixels()), rounding(r.pixels());
  double sum_r = 0, sum_t = 0;
  for (std::size_t i = 0; i < r.pixels(); ++i) {
    for (int c = 0; c < 3; ++c) {
      vr[i] += r.data[3 * i + c];
      vt[i] += t.data[3 * i + c];
      rounding[i] += std::pow(rounding_noise * mean.data[3 * i + c], 2);
    }
    sum_r += vr[i];
    sum_t += vt[i];
  }
  result.pooled = sum_r == sum_t ? 1 : sum_t / sum_r;

  // A block with noise on one side only has a ratio of 0 or infinity: held to a millionth of the mean
  // variance.
  const double floor = 1e-6 * (sum_r + sum_t) / (2 * static_cast<double>(r.pixels()));
  std::vector<double> logs;
  for (std::size_t i = 0; i < r.pixels(); ++i) {
    const double least = std::max(floor, rounding[i]);
    if (vr[i] > rounding[i] || vt[i] > rounding[i])
      logs.push_back(std::log(std::max(vt[i], least) / std::max(vr[i], least)));
  }
  result.blocks = static_cast<int>(logs.size());
  result.interval = {0, infinity};
  if (logs.size() < 8) return result;

  const double n = static_cast<double>(logs.size());
  double sum = 0, squares = 0, deviations = 0;
  for (const double l : logs) sum += l, squares += l * l;
  const double center = sum / n;
  for (const double l : logs) deviations += (l - center) * (l - center);
  const double error = std::sqrt(deviations / (n - 1) / n);
  const double half = error == 0 ? 0 : student_critical(1 - options.confidence, n - 1) * error;
  result.ratio = std::exp(center);
  result.interval = {std::exp(center - half), std::exp(center + half)};
  result.p = squares > 0 ? symmetric_p(sum / std::sqrt(squares)) : 1;
  return result;
}

bool agrees(const Difference& difference, double margin) {
  return std::abs(difference.difference) + 3.5 * difference.standard_error <= margin * difference.scale;
}

bool flip_agrees(double flip, double noise_floor) { return flip <= 1.25 * noise_floor + 0.005; }

}  // namespace metric
