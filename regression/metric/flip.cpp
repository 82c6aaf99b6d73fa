#include "metric/flip.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/error.h"
#include "metric/flip_colour.h"
#include "metric/flip_filter.h"
#include "metric/flip_pool.h"
#include "metric/flip_strip.h"

namespace metric {

namespace {

// Rectangles of the parallel work: narrow enough for the ring of rows to stay in the second-level cache, tall
// enough that the rows above and below it cost little.
constexpr int strip_width = 256, strip_height = 256;

constexpr unsigned char no_exposure = 255;
constexpr int most_exposures = 254;

void check(const image::Image& reference, const image::Image& test, const FlipOptions& options) {
  const auto shape = [](const image::Image& i) {
    return std::to_string(i.width) + " x " + std::to_string(i.height) + " x " + std::to_string(i.channels);
  };
  if (reference.empty() || reference.channels != 3)
    base::fail("FLIP: reference: wanted three channels, found ", shape(reference));
  if (!reference.same_shape(test))
    base::fail("FLIP: test: wanted ", shape(reference), " as the reference has, found ", shape(test));
  if (!(options.pixels_per_degree > 0 && options.pixels_per_degree <= 10000))
    base::fail("FLIP: pixels per degree: wanted more than 0 and at most 10000, found ",
               options.pixels_per_degree);
  if (!options.exposures) return;
  const Exposures& e = *options.exposures;
  if (e.count < 1 || e.count > most_exposures)
    base::fail("FLIP: exposures: wanted 1 to ", most_exposures, ", found ", e.count);
  if (!(std::abs(e.start) <= 100 && std::abs(e.stop) <= 100 && e.start <= e.stop))
    base::fail("FLIP: exposures: wanted -100 <= start <= stop <= 100, found ", e.start, " to ", e.stop);
}

// A copy without what the formulas cannot take: pixels with a NaN or an infinity are black (and marked),
// negative samples 0. `negative` and `bad` count pixels.
image::Image cleaned(const image::Image& image, std::size_t& negative, std::size_t& bad,
                     std::vector<bool>& is_bad) {
  image::Image copy = image;
  for (std::size_t p = 0; p < image.pixels(); ++p) {
    float* const v = &copy.data[p * 3];
    if (!std::isfinite(v[0]) || !std::isfinite(v[1]) || !std::isfinite(v[2])) {
      v[0] = v[1] = v[2] = 0;
      is_bad.resize(image.pixels());
      is_bad[p] = true;
      ++bad;
    } else if (v[0] < 0 || v[1] < 0 || v[2] < 0) {
      for (int c = 0; c < 3; ++c) v[c] = std::max(v[c], 0.0f);
      ++negative;
    }
  }
  return copy;
}

bool is_clean(const image::Image& image) {
  bool clean = true;
  for (const float v : image.data) clean &= v >= 0 && v <= std::numeric_limits<float>::max();
  return clean;
}

// Calls work(strip, rectangle) for rectangles that cover the image, in parallel.
template <typename Work>
void for_each_strip(const image::Image& image, const FlipKernels& kernels, const Work& work) {
  const int columns = (image.width + strip_width - 1) / strip_width;
  const int rows = (image.height + strip_height - 1) / strip_height;
  const int width = std::min(image.width, strip_width);
  tbb::parallel_for(tbb::blocked_range<int>(0, columns * rows), [&](const tbb::blocked_range<int>& range) {
    Strip strip(kernels, width);
    for (int i = range.begin(); i != range.end(); ++i) {
      const int x = i % columns * strip_width, y = i / columns * strip_height;
      work(strip,
           Rectangle{x, y, std::min(strip_width, image.width - x), std::min(strip_height, image.height - y)});
    }
  });
}

void fail_pooling(Flip& flip, const std::string& why) {
  flip.failure = why;
  constexpr double nan = std::numeric_limits<double>::quiet_NaN();
  flip.mean = flip.min = flip.max = nan;
  flip.weighted_quartile1 = flip.weighted_median = flip.weighted_quartile3 = nan;
}

// What LDR and HDR share: cleaning, counting, and the verdict on bad pixels. evaluate(flip, reference, test)
// fills the map.
template <typename Evaluate>
Flip compare(const image::Image& reference, const image::Image& test, const FlipOptions& options,
             const Evaluate& evaluate) {
  check(reference, test, options);
  Flip flip;
  flip.map = image::Image(reference.width, reference.height, 1);
  std::vector<bool> bad;
  if (is_clean(reference) && is_clean(test)) {
    evaluate(flip, reference, test);
  } else {
    const image::Image r = cleaned(reference, flip.negative_reference, flip.non_finite_reference, bad);
    const image::Image t = cleaned(test, flip.negative_test, flip.non_finite_test, bad);
    evaluate(flip, r, t);
  }
  for (std::size_t p = 0; p < bad.size(); ++p)
    if (bad[p]) flip.map.data[p] = 1;
  if (!flip.failure.empty()) {
    fail_pooling(flip, flip.failure);
  } else if (flip.non_finite_reference + flip.non_finite_test > 0) {
    fail_pooling(flip, "non-finite pixels: " + std::to_string(flip.non_finite_reference) +
                           " in the reference, " + std::to_string(flip.non_finite_test) +
                           " in the test image");
  } else {
    pool(flip);
  }
  return flip;
}

}  // namespace

Flip ldr_flip(const image::Image& reference, const image::Image& test, Values values,
              const FlipOptions& options) {
  return compare(reference, test, options, [&](Flip& flip, const image::Image& r, const image::Image& t) {
    const FlipKernels kernels(options.pixels_per_degree);
    const Transfer transfer{values == Values::srgb ? Transfer::srgb : Transfer::linear};
    for_each_strip(r, kernels, [&](Strip& strip, const Rectangle& area) {
      strip.run(r, t, transfer, area, [&](int y, const float* errors) {
        std::copy(errors, errors + area.width, &flip.map.data[flip.map.index(area.x, y)]);
      });
    });
  });
}

Flip hdr_flip(const image::Image& reference, const image::Image& test, const FlipOptions& options) {
  return compare(reference, test, options, [&](Flip& flip, const image::Image& r, const image::Image& t) {
    const auto exposures =
        options.exposures ? options.exposures : automatic_exposures(r, options.tone_mapper);
    if (!exposures) {
      std::fill(flip.map.data.begin(), flip.map.data.end(), 1.0f);
      flip.failure = "the reference holds no light to choose exposures by; give them";
      return;
    }
    flip.exposures = *exposures;
    flip.exposure_map.assign(r.pixels(), no_exposure);
    const FlipKernels kernels(options.pixels_per_degree);
    const double step =
        exposures->count > 1 ? (exposures->stop - exposures->start) / (exposures->count - 1) : 0;
    for_each_strip(r, kernels, [&](Strip& strip, const Rectangle& area) {
      for (int i = 0; i < exposures->count; ++i) {
        const auto gain = static_cast<float>(std::exp2(exposures->start + i * step));
        strip.run(r, t, {Transfer::tone_mapped, options.tone_mapper, gain}, area,
                  [&](int y, const float* errors) {
                    float* const map = &flip.map.data[flip.map.index(area.x, y)];
                    unsigned char* const which = &flip.exposure_map[flip.map.index(area.x, y)];
                    for (int x = 0; x < area.width; ++x) {
                      if (!(errors[x] > map[x])) continue;
                      map[x] = errors[x];
                      which[x] = static_cast<unsigned char>(i);
                    }
                  });
      }
    });
  });
}

std::optional<Exposures> automatic_exposures(const image::Image& reference, ToneMapper tone_mapper) {
  std::vector<float> luminances;
  luminances.reserve(reference.pixels());
  for (std::size_t p = 0; p < reference.pixels(); ++p) {
    const float* const v = &reference.data[p * 3];
    const float y = 0.2126f * v[0] + 0.7152f * v[1] + 0.0722f * v[2];
    if (y > 0 && std::isfinite(y)) luminances.push_back(y);
  }
  if (luminances.empty()) return std::nullopt;
  const auto middle = luminances.begin() + static_cast<std::ptrdiff_t>(luminances.size() / 2);
  std::nth_element(luminances.begin(), middle, luminances.end());
  const double median = *middle, brightest = *std::max_element(middle, luminances.end());

  // From the brightest pixel to the middle one, each brought to 85 % in turn.
  const double target = tone_mapper_target(tone_mapper);
  Exposures exposures;
  exposures.start = std::log2(target / brightest);
  exposures.stop = std::log2(target / median);
  exposures.count =
      std::clamp(static_cast<int>(std::ceil(exposures.stop - exposures.start)), 2, most_exposures);
  return exposures;
}

image::Image tone_map(const image::Image& linear, ToneMapper tone_mapper, double exposure) {
  if (linear.channels != 3) base::fail("tone mapping: wanted three channels, found ", linear.channels);
  image::Image out(linear.width, linear.height, 3);
  const auto gain = static_cast<float>(std::exp2(exposure));
  std::vector<float> row(3 * linear.width);
  const Planes3 planes{row.data(), row.data() + linear.width, row.data() + 2 * linear.width};
  float* const plane[3] = {planes.r, planes.g, planes.b};
  for (int y = 0; y < linear.height; ++y) {
    for (int x = 0; x < linear.width; ++x)
      for (int c = 0; c < 3; ++c) plane[c][x] = std::max(0.0f, linear.at(x, y, c)) /* NaN too is 0 */;
    tone_map_rows(planes, tone_mapper, gain, linear.width);
    for (int x = 0; x < linear.width; ++x)
      for (int c = 0; c < 3; ++c) out.at(x, y, c) = plane[c][x];
  }
  return out;
}

}  // namespace metric
