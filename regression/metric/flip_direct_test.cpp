// Our fast FLIP against the formulas of the papers written down plainly: double precision, whole 2D kernels,
// no symmetry, no separability, the C library's powers; nothing shared with flip.cpp but the images.
#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <numbers>

#include "metric/flip.h"

namespace {

using image::Image;
using Colour = std::array<double, 3>;
constexpr double pi = std::numbers::pi;

// A picture of doubles, edges repeated.
struct Plane {
  int width, height;
  std::vector<double> v;
  double at(int x, int y) const {
    return v[static_cast<std::size_t>(std::clamp(y, 0, height - 1)) * width + std::clamp(x, 0, width - 1)];
  }
};

Colour xyz(const Colour& rgb) {
  return {(10135552 * rgb[0] + 8788810 * rgb[1] + 4435075 * rgb[2]) / 24577794,
          (2613072 * rgb[0] + 8788810 * rgb[1] + 887015 * rgb[2]) / 12288897,
          (1425312 * rgb[0] + 8788810 * rgb[1] + 70074185 * rgb[2]) / 73733382};
}

// Solves xyz(rgb) = wanted by Cramer's rule, so that no inverse matrix has to be trusted.
Colour rgb_of(const Colour& wanted) {
  const Colour r = xyz({1, 0, 0}), g = xyz({0, 1, 0}), b = xyz({0, 0, 1});
  const auto det = [](const Colour& p, const Colour& q, const Colour& s) {
    return p[0] * (q[1] * s[2] - q[2] * s[1]) - q[0] * (p[1] * s[2] - p[2] * s[1]) +
           s[0] * (p[1] * q[2] - p[2] * q[1]);
  };
  const double d = det(r, g, b);
  return {det(wanted, g, b) / d, det(r, wanted, b) / d, det(r, g, wanted) / d};
}

const Colour white = xyz({1, 1, 1});

Colour hunt_lab(const Colour& rgb) {
  const auto f = [](double t) {
    return t > std::pow(6.0 / 29, 3) ? std::cbrt(t) : t / (3 * std::pow(6.0 / 29, 2)) + 4.0 / 29;
  };
  const Colour c = xyz(rgb);
  const double fx = f(c[0] / white[0]), fy = f(c[1] / white[1]), fz = f(c[2] / white[2]), l = 116 * fy - 16;
  return {l, 0.01 * l * 500 * (fx - fy), 0.01 * l * 200 * (fy - fz)};
}

double hyab(const Colour& a, const Colour& b) {
  return std::abs(a[0] - b[0]) + std::sqrt(std::pow(a[1] - b[1], 2) + std::pow(a[2] - b[2], 2));
}

// Convolution with any 2D kernel given as a function of the offset in pixels, after normalising it.
template <typename Kernel>
Plane convolved(const Plane& in, int radius, const Kernel& kernel) {
  Plane out = in;
  for (int y = 0; y < in.height; ++y)
    for (int x = 0; x < in.width; ++x) {
      double sum = 0;
      for (int j = -radius; j <= radius; ++j)
        for (int i = -radius; i <= radius; ++i) sum += kernel(i, j) * in.at(x + i, y + j);
      out.v[static_cast<std::size_t>(y) * in.width + x] = sum;
    }
  return out;
}

struct Filtered {
  std::vector<Colour> lab;
  std::vector<double> edge, point;
};

Filtered filtered(const Image& linear, double ppd) {
  // YCxCz
  const int w = linear.width, h = linear.height;
  std::array<Plane, 3> opponent{Plane{w, h, {}}, Plane{w, h, {}}, Plane{w, h, {}}};
  Plane luminance{w, h, {}};
  for (int y = 0; y < h; ++y)
    for (int x = 0; x < w; ++x) {
      const Colour c = xyz({linear.at(x, y, 0), linear.at(x, y, 1), linear.at(x, y, 2)});
      const double xn = c[0] / white[0], yn = c[1] / white[1], zn = c[2] / white[2];
      opponent[0].v.push_back(116 * yn - 16);
      opponent[1].v.push_back(500 * (xn - yn));
      opponent[2].v.push_back(200 * (yn - zn));
      luminance.v.push_back((116 * yn - 16 + 16) / 116);
    }

  // Contrast sensitivity
  const int radius = static_cast<int>(std::ceil(3 * std::sqrt(0.04 / (2 * pi * pi)) * ppd));
  const double a[3][2] = {{1, 0}, {1, 0}, {34.1, 13.5}}, b[3][2] = {{0.0047, 1}, {0.0053, 1}, {0.04, 0.025}};
  for (int c = 0; c < 3; ++c) {
    const auto raw = [&](int i, int j) {
      const double d2 = (i * i + j * j) / (ppd * ppd);
      double sum = 0;
      for (int k = 0; k < 2; ++k)
        sum += a[c][k] * std::sqrt(pi / b[c][k]) * std::exp(-pi * pi * d2 / b[c][k]);
      return sum;
    };
    double total = 0;
    for (int j = -radius; j <= radius; ++j)
      for (int i = -radius; i <= radius; ++i) total += raw(i, j);
    opponent[c] = convolved(opponent[c], radius, [&](int i, int j) { return raw(i, j) / total; });
  }
  Filtered out;
  for (std::size_t p = 0; p < opponent[0].v.size(); ++p) {
    const double yn = (opponent[0].v[p] + 16) / 116, xn = opponent[1].v[p] / 500 + yn,
                 zn = yn - opponent[2].v[p] / 200;
    Colour rgb = rgb_of({xn * white[0], yn * white[1], zn * white[2]});
    for (double& v : rgb) v = std::clamp(v, 0.0, 1.0);
    out.lab.push_back(hunt_lab(rgb));
  }

  // Edges and points
  const double sigma = 0.041 * ppd;
  const int reach = static_cast<int>(std::ceil(3 * sigma));
  const auto gauss = [&](int i, int j) { return std::exp(-(i * i + j * j) / (2 * sigma * sigma)); };
  const auto edge = [&](int i, int j) { return -i * gauss(i, j); };
  const auto point = [&](int i, int j) { return (i * i / (sigma * sigma) - 1) * gauss(i, j); };
  const auto magnitudes = [&](const auto& kernel) {
    double positive = 0, negative = 0;
    for (int j = -reach; j <= reach; ++j)
      for (int i = -reach; i <= reach; ++i)
        (kernel(i, j) > 0 ? positive : negative) += std::abs(kernel(i, j));
    const auto normalised = [&](int i, int j) {
      return kernel(i, j) / (kernel(i, j) > 0 ? positive : negative);
    };
    const Plane along_x = convolved(luminance, reach, normalised);
    const Plane along_y = convolved(luminance, reach, [&](int i, int j) { return normalised(j, i); });
    std::vector<double> lengths;
    for (std::size_t p = 0; p < along_x.v.size(); ++p)
      lengths.push_back(std::hypot(along_x.v[p], along_y.v[p]));
    return lengths;
  };
  out.edge = magnitudes(edge);
  out.point = magnitudes(point);
  return out;
}

std::vector<double> direct_flip(const Image& reference, const Image& test, double ppd) {
  const Filtered r = filtered(reference, ppd), t = filtered(test, ppd);
  const double largest = std::pow(hyab(hunt_lab({0, 1, 0}), hunt_lab({0, 0, 1})), 0.7), knee = 0.4 * largest;
  EXPECT_NEAR(largest, 41.2761, 1e-4);
  std::vector<double> map;
  for (std::size_t p = 0; p < r.lab.size(); ++p) {
    const double e = std::pow(hyab(r.lab[p], t.lab[p]), 0.7);
    const double colour = e < knee ? 0.95 * e / knee : 0.95 + 0.05 * (e - knee) / (largest - knee);
    const double feature = std::max(std::abs(r.edge[p] - t.edge[p]), std::abs(r.point[p] - t.point[p]));
    map.push_back(std::pow(colour, 1 - std::sqrt(feature / std::sqrt(2))));
  }
  return map;
}

// Detail, flat areas, saturated colours, black and white, within an odd size.
Image picture(int width, int height, unsigned seed) {
  Image image(width, height, 3);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x)
      for (int c = 0; c < 3; ++c) {
        seed = seed * 1664525u + 1013904223u;
        const float noise = static_cast<float>(seed >> 8) / 16777216.0f;
        float v = 0.5f;
        if (x < width / 3) v = noise;
        if (x >= width / 3 && y < height / 2) v = (x + y + c) % 3 == 0 ? 1.0f : 0.0f;
        if (y > 3 * height / 4) v = 0.02f * noise + (c == 1 ? 0.9f : 0.0f);
        image.at(x, y, c) = v;
      }
  return image;
}

TEST(FlipDirect, FastAndPlainAgreeInEveryPixel) {
  for (const double ppd : {10.0, 30.0, metric::default_pixels_per_degree, 90.0})
    for (const auto& [width, height] : {std::pair{37, 29}, std::pair{1, 1}, std::pair{2, 40}}) {
      SCOPED_TRACE(std::to_string(ppd) + " pixels per degree, width " + std::to_string(width));
      const Image a = picture(width, height, 1), b = picture(width, height, 2);
      metric::FlipOptions options;
      options.pixels_per_degree = ppd;
      const metric::Flip fast = metric::ldr_flip(a, b, metric::Values::linear, options);
      const std::vector<double> plain = direct_flip(a, b, ppd);
      double worst = 0, sum = 0;
      for (std::size_t p = 0; p < plain.size(); ++p) {
        worst = std::max(worst, std::abs(fast.map.data[p] - plain[p]));
        sum += plain[p];
      }
      EXPECT_LE(worst, 1e-4);
      EXPECT_NEAR(fast.mean, sum / static_cast<double>(plain.size()), 1e-5);
    }
}

// Both on one thread in the same run, so the ratio means something on any machine: measured 1400 to 1700,
// most of which is what separating the two-dimensional kernels saves.
TEST(FlipDirect, FastIsAHundredTimesAsFastAsPlain) {
  tbb::global_control one_thread(tbb::global_control::max_allowed_parallelism, 1);
  const Image a = picture(160, 90, 1), b = picture(160, 90, 2);
  const auto seconds = [](auto&& flip) {
    const std::clock_t start = std::clock();
    flip();
    return static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC;
  };
  const double plain = seconds([&] { direct_flip(a, b, metric::default_pixels_per_degree); });
  double fast = 1e9;
  for (int i = 0; i < 3; ++i)
    fast = std::min(fast, seconds([&] { metric::ldr_flip(a, b, metric::Values::linear); }));
  std::printf("LDR-FLIP 160 x 90, processor time: plain %.3f s, ours %.4f s, ratio %.1f\n", plain, fast,
              plain / fast);
  EXPECT_GT(plain, 100 * fast);
}

TEST(FlipDirect, PercentilesAreThoseOfASortedList) {
  const Image a = picture(40, 30, 3), b = picture(40, 30, 4);
  const metric::Flip flip = metric::ldr_flip(a, b, metric::Values::linear);
  std::vector<float> sorted = flip.map.data;
  std::sort(sorted.begin(), sorted.end());
  double total = 0;
  for (const float e : sorted) total += e;
  const auto percentile = [&](double share) {
    double running = 0;
    for (const float e : sorted)
      if ((running += e) > share * total) return static_cast<double>(e);
    return 0.0;
  };
  EXPECT_EQ(flip.weighted_quartile1, percentile(0.25));
  EXPECT_EQ(flip.weighted_median, percentile(0.5));
  EXPECT_EQ(flip.weighted_quartile3, percentile(0.75));
}

}  // namespace
