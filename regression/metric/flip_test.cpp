// FLIP against NVIDIA's own program (flip-vectors/), and its rules for images the original cannot compare.
#include "metric/flip.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <cmath>
#include <ctime>
#include <fstream>
#include <limits>
#include <nlohmann/json.hpp>

#include "base/error.h"
#include "image/io.h"

namespace {

using image::Image;
using metric::Flip;
using metric::FlipOptions;
using nlohmann::json;

const std::string vectors = std::string(ASSAY_SOURCE_DIR) + "/regression/metric/flip-vectors/";
constexpr float infinity = std::numeric_limits<float>::infinity();

json load(const std::string& path) { return json::parse(std::ifstream(path)); }
Image picture(const std::string& path) { return image::read_render(path).mean; }

// Values as stored in a PNG: what the vectors were made from.
Image encoded(const std::string& path) {
  Image image = picture(path);
  for (float& v : image.data) v = std::round(image::linear_to_srgb(v) * 255) / 255;
  return image;
}

FlipOptions options_of(const json& result) {
  FlipOptions options;
  options.pixels_per_degree = result.at("ppd");
  const std::string id = result.at("id");
  if (id.find("hable") != std::string::npos) options.tone_mapper = metric::ToneMapper::hable;
  if (id.find("reinhard") != std::string::npos) options.tone_mapper = metric::ToneMapper::reinhard;
  if (id.find("fixed") != std::string::npos) options.exposures = metric::Exposures{-6, 4, 6};
  return options;
}

// A reproducible picture with every scale of detail.
Image noise(int width, int height, unsigned seed, float largest) {
  Image image(width, height, 3);
  for (float& v : image.data) {
    seed = seed * 1664525u + 1013904223u;
    v = static_cast<float>(seed >> 8) / 16777216.0f * largest;
  }
  return image;
}

TEST(Flip, AgreesWithTheAuthorsProgramInEveryPixelAndPooledValue) {
  const json all = load(vectors + "results.json");
  int maps = 0, means = 0;
  double worst_pixel = 0, worst_rms = 0, worst_mean = 0;
  for (const json& pair : all.at("pairs")) {
    const bool ldr = pair.at("kind") == "LDR";
    const std::string reference = vectors + pair.at("reference").get<std::string>();
    const std::string test = vectors + pair.at("test").get<std::string>();
    const Image a = ldr ? encoded(reference) : picture(reference), b = ldr ? encoded(test) : picture(test);
    for (const json& result : pair.at("results")) {
      SCOPED_TRACE(pair.at("name").get<std::string>() + " " + result.at("id").get<std::string>());
      const FlipOptions options = options_of(result);
      const Flip flip =
          ldr ? metric::ldr_flip(a, b, metric::Values::srgb, options) : metric::hdr_flip(a, b, options);
      ASSERT_TRUE(flip.ok()) << flip.failure;
      const json& pooled = result.at("float64_pooling");
      EXPECT_NEAR(flip.mean, pooled.at("mean"), 5e-5);
      EXPECT_NEAR(flip.weighted_quartile1, pooled.at("wq1"), 5e-4);
      EXPECT_NEAR(flip.weighted_median, pooled.at("wmedian"), 5e-4);
      EXPECT_NEAR(flip.weighted_quartile3, pooled.at("wq3"), 5e-4);
      EXPECT_NEAR(flip.min, pooled.at("min"), 5e-4);
      EXPECT_NEAR(flip.max, pooled.at("max"), 5e-4);
      worst_mean = std::max(worst_mean, std::abs(flip.mean - pooled.at("mean").get<double>()));
      ++means;
      if (!result.contains("error_map")) continue;
      const Image map = picture(vectors + result.at("error_map").get<std::string>());
      double squares = 0, worst = 0;
      for (std::size_t p = 0; p < map.pixels(); ++p) {
        const double d = std::abs(flip.map.data[p] - map.data[3 * p]);
        worst = std::max(worst, d);
        squares += d * d;
      }
      EXPECT_LE(worst, 5e-4);
      EXPECT_LE(std::sqrt(squares / static_cast<double>(map.pixels())), 5e-5);
      worst_pixel = std::max(worst_pixel, worst);
      worst_rms = std::max(worst_rms, std::sqrt(squares / static_cast<double>(map.pixels())));
      ++maps;
    }
  }
  EXPECT_EQ(maps, 30);
  EXPECT_EQ(means, 38);
  std::printf("largest difference: pixel %.1e, map RMS %.1e, mean %.1e\n", worst_pixel, worst_rms,
              worst_mean);
}

TEST(Flip, ChoosesTheAuthorsExposuresAndFindsTheMaximumAtTheSameOne) {
  const json all = load(vectors + "results.json");
  for (const json& pair : all.at("pairs")) {
    if (pair.at("kind") == "LDR") continue;
    const Image a = picture(vectors + pair.at("reference").get<std::string>());
    const Image b = picture(vectors + pair.at("test").get<std::string>());
    for (const json& result : pair.at("results")) {
      SCOPED_TRACE(pair.at("name").get<std::string>() + " " + result.at("id").get<std::string>());
      const Flip flip = metric::hdr_flip(a, b, options_of(result));
      EXPECT_NEAR(flip.exposures.start, result.at("start_exposure"), 2e-6);
      EXPECT_NEAR(flip.exposures.stop, result.at("stop_exposure"), 2e-6);
      EXPECT_EQ(flip.exposures.count, result.at("num_exposures"));
      if (!result.contains("exposure_index_map")) continue;
      const Image index = encoded(vectors + result.at("exposure_index_map").get<std::string>());
      std::size_t same = 0;
      for (std::size_t p = 0; p < index.pixels(); ++p)
        same += flip.exposure_map[p] == static_cast<unsigned char>(std::lround(index.data[3 * p] * 255));
      EXPECT_GE(static_cast<double>(same) / static_cast<double>(index.pixels()), 0.99);
    }
  }
}

// One of the unusual HDR pairs, and what the authors' program makes of it.
struct Edge {
  Image reference, test;
  json automatic, fixed;
};

Edge edge(const std::string& name) {
  const json all = load(vectors + "edge/results.json");
  for (const json& c : all.at("cases"))
    if (c.at("name") == name)
      return {picture(vectors + "edge/" + name + ".ref.exr"), picture(vectors + "edge/" + name + ".test.exr"),
              c.at("automatic"), c.at("start-6_stop4_n6")};
  throw std::runtime_error("no edge case " + name);
}

FlipOptions fixed_exposures() {
  FlipOptions options;
  options.exposures = metric::Exposures{-6, 4, 6};
  return options;
}

TEST(FlipEdge, WhereTheOriginalIsWellDefinedWeAgree) {
  for (const std::string name : {"e1_identical", "e7_constant", "e11_median_even"}) {
    SCOPED_TRACE(name);
    const Edge e = edge(name);
    const Flip automatic = metric::hdr_flip(e.reference, e.test);
    EXPECT_NEAR(automatic.mean, e.automatic.at("mean"), 5e-5);
    EXPECT_NEAR(automatic.max, e.automatic.at("max"), 5e-4);
    EXPECT_NEAR(automatic.exposures.start, std::stod(e.automatic.at("start_exposure").get<std::string>()),
                2e-6);
    EXPECT_NEAR(automatic.exposures.stop, std::stod(e.automatic.at("stop_exposure").get<std::string>()),
                2e-6);
    EXPECT_EQ(automatic.exposures.count, e.automatic.at("num_exposures"));
    const Flip fixed = metric::hdr_flip(e.reference, e.test, fixed_exposures());
    EXPECT_NEAR(fixed.mean, e.fixed.at("mean"), 5e-5);
    EXPECT_NEAR(fixed.max, e.fixed.at("max"), 5e-4);
  }
  for (const std::string name : {"e5_black_ref", "e6_median_zero"}) {
    const Edge e = edge(name);
    const Flip fixed = metric::hdr_flip(e.reference, e.test, fixed_exposures());
    EXPECT_NEAR(fixed.mean, e.fixed.at("mean"), 5e-5) << name;
    EXPECT_NEAR(fixed.max, e.fixed.at("max"), 5e-4) << name;
  }
}

TEST(FlipEdge, IdenticalPicturesGiveExactlyZero) {
  const Edge e = edge("e1_identical");
  const Flip hdr = metric::hdr_flip(e.reference, e.test);
  EXPECT_EQ(hdr.mean, 0);
  EXPECT_EQ(hdr.max, 0);
  EXPECT_EQ(hdr.weighted_median, 0);
  for (const unsigned char which : hdr.exposure_map) EXPECT_EQ(which, 255);
  const Image image = noise(33, 21, 5, 1);
  EXPECT_EQ(metric::ldr_flip(image, image, metric::Values::linear).max, 0);
  EXPECT_EQ(metric::ldr_flip(image, image, metric::Values::srgb).max, 0);
}

TEST(FlipEdge, ANaNOrAnInfinityFailsAndIsCounted) {
  for (const std::string name : {"e2_nan_test", "e3_inf_test", "e8_nan_ref", "e10_inf_ref"}) {
    for (const FlipOptions& options : {FlipOptions{}, fixed_exposures()}) {
      SCOPED_TRACE(name);
      const Edge e = edge(name);
      const bool in_test = name.find("test") != std::string::npos;
      const Flip flip = metric::hdr_flip(e.reference, e.test, options);
      EXPECT_FALSE(flip.ok());
      EXPECT_EQ(flip.non_finite_test, in_test ? 1u : 0u);
      EXPECT_EQ(flip.non_finite_reference, in_test ? 0u : 1u);
      EXPECT_FALSE(flip.mean <= 1) << "a limit that holds whatever it is";
      EXPECT_FALSE(flip.max <= 1);
      const Image& bad = in_test ? e.test : e.reference;
      for (std::size_t p = 0; p < bad.pixels(); ++p) {
        EXPECT_TRUE(std::isfinite(flip.map.data[p]));
        EXPECT_TRUE(std::isfinite(bad.data[3 * p]) || flip.map.data[p] == 1);
      }
    }
  }
  Image a(4, 4, 3, 0.5f), b = a;
  b.at(1, 2, 1) = -infinity;
  EXPECT_EQ(metric::ldr_flip(a, b, metric::Values::srgb).non_finite_test, 1u);
}

TEST(FlipEdge, ABlackReferenceIsAnErrorUnlessExposuresAreGiven) {
  const Edge e = edge("e5_black_ref");
  const Flip flip = metric::hdr_flip(e.reference, e.test);
  EXPECT_FALSE(flip.ok());
  EXPECT_FALSE(flip.mean <= 1);
  EXPECT_FALSE(metric::automatic_exposures(e.reference));
  EXPECT_GT(metric::hdr_flip(e.reference, e.test, fixed_exposures()).mean, 0.9);
}

// Only 70 of the 192 pixels of the reference hold light; the original evaluates no exposure and reports a
// match.
TEST(FlipEdge, AReferenceMoreThanHalfBlackIsJudgedByItsLitPixels) {
  const Edge e = edge("e6_median_zero");
  const Flip flip = metric::hdr_flip(e.reference, e.test);
  ASSERT_TRUE(flip.ok());
  EXPECT_GT(flip.mean, 0.001);
  EXPECT_TRUE(std::isfinite(flip.exposures.stop));
  Image lit(0, 0, 3);
  for (std::size_t p = 0; p < e.reference.pixels(); ++p)
    if (e.reference.data[3 * p] > 0) {
      lit.data.insert(lit.data.end(), &e.reference.data[3 * p], &e.reference.data[3 * p] + 3);
      ++lit.width;
    }
  lit.height = 1;
  ASSERT_LT(lit.width, static_cast<int>(e.reference.pixels() / 2));
  EXPECT_EQ(flip.exposures.stop, metric::automatic_exposures(lit)->stop);
}

TEST(FlipEdge, NegativeValuesCountAsZeroAndAreCounted) {
  const Edge e = edge("e4_negative_test");
  Image cut = e.test;
  for (float& v : cut.data) v = std::max(v, 0.0f);
  const Flip flip = metric::hdr_flip(e.reference, e.test);
  EXPECT_TRUE(flip.ok());
  EXPECT_GT(flip.negative_test, 0u);
  EXPECT_EQ(flip.negative_reference, 0u);
  EXPECT_EQ(flip.map.data, metric::hdr_flip(e.reference, cut).map.data);
}

// Its square exceeds a float: the original makes it black, and so nearly misses the brightest error there can
// be.
TEST(FlipEdge, AValueOf1e20IsWhiteNotBlack) {
  const Edge e = edge("e9_overflow_test");
  Image bright = e.test;
  for (float& v : bright.data) v = std::min(v, 1e6f);
  EXPECT_EQ(metric::hdr_flip(e.reference, e.test).map.data, metric::hdr_flip(e.reference, bright).map.data);
}

TEST(FlipEdge, OneExposureIsItsStart) {
  const Image a = noise(40, 30, 1, 3), b = noise(40, 30, 2, 3);
  FlipOptions one, two;
  one.exposures = metric::Exposures{-1.5, 3, 1};
  two.exposures = metric::Exposures{-1.5, -1.5, 2};
  const Flip flip = metric::hdr_flip(a, b, one);
  EXPECT_GT(flip.mean, 0.1);
  EXPECT_EQ(flip.map.data, metric::hdr_flip(a, b, two).map.data);
  const Flip same =
      metric::ldr_flip(metric::tone_map(a, metric::ToneMapper::aces, -1.5),
                       metric::tone_map(b, metric::ToneMapper::aces, -1.5), metric::Values::linear);
  EXPECT_EQ(flip.map.data, same.map.data);
}

TEST(FlipEdge, WhatCannotBeComparedIsAnError) {
  const Image a(4, 4, 3, 0.5f);
  EXPECT_THROW(metric::ldr_flip(a, Image(4, 5, 3), metric::Values::srgb), base::Error);
  EXPECT_THROW(metric::ldr_flip(Image(), Image(), metric::Values::srgb), base::Error);
  EXPECT_THROW(metric::ldr_flip(Image(4, 4, 1), Image(4, 4, 1), metric::Values::srgb), base::Error);
  FlipOptions options;
  for (const double ppd : {0.0, -3.0, std::nan(""), 1e9}) {
    options.pixels_per_degree = ppd;
    EXPECT_THROW(metric::ldr_flip(a, a, metric::Values::srgb, options), base::Error) << ppd;
  }
  options = {};
  for (const metric::Exposures& e :
       {metric::Exposures{0, 1, 0}, metric::Exposures{1, 0, 2}, metric::Exposures{std::nan(""), 1, 2},
        metric::Exposures{0, infinity, 2}}) {
    options.exposures = e;
    EXPECT_THROW(metric::hdr_flip(a, a, options), base::Error);
  }
}

// The values are display values or linear light, and the caller says which.
TEST(Flip, OfEncodedValuesIsThatOfTheLinearLightTheyMean) {
  const Image a = noise(50, 40, 3, 1), b = noise(50, 40, 4, 1);
  Image la = a, lb = b;
  for (float& v : la.data) v = image::srgb_to_linear(v);
  for (float& v : lb.data) v = image::srgb_to_linear(v);
  const Flip srgb = metric::ldr_flip(a, b, metric::Values::srgb);
  const Flip linear = metric::ldr_flip(la, lb, metric::Values::linear);
  for (std::size_t p = 0; p < a.pixels(); ++p) EXPECT_NEAR(srgb.map.data[p], linear.map.data[p], 1e-4);
  EXPECT_GT(std::abs(metric::ldr_flip(a, b, metric::Values::linear).mean - srgb.mean), 1e-3);
}

// 700 x 300 is twelve rectangles of work, so their seams are compared too.
TEST(Flip, IsTheSameToTheBitForAnyNumberOfThreadsAndAnyDivisionOfTheImage) {
  const Image a = noise(700, 300, 7, 4), b = noise(700, 300, 8, 4);
  std::vector<float> maps[2];
  for (const int threads : {1, 5}) {
    tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    maps[threads > 1] = metric::hdr_flip(a, b, fixed_exposures()).map.data;
  }
  EXPECT_EQ(maps[0], maps[1]);

  // A window whose border is further from its centre than the filters reach, cut so that seams fall
  // elsewhere.
  constexpr int x0 = 190, y0 = 200, w = 150, h = 100, reach = 10;
  Image ca(w, h, 3), cb(w, h, 3);
  for (int y = 0; y < h; ++y)
    for (int x = 0; x < w; ++x)
      for (int c = 0; c < 3; ++c) {
        ca.at(x, y, c) = a.at(x0 + x, y0 + y, c);
        cb.at(x, y, c) = b.at(x0 + x, y0 + y, c);
      }
  const Flip cut = metric::hdr_flip(ca, cb, fixed_exposures());
  for (int y = reach; y < h - reach; ++y)
    for (int x = reach; x < w - reach; ++x)
      ASSERT_EQ(cut.map.at(x, y), maps[0][static_cast<std::size_t>(y0 + y) * 700 + x0 + x]) << x << " " << y;
}

// Printed, not asserted: a machine at work measures others' load. Processor time of one thread.
TEST(Flip, SpeedAt1920x1080) {
  tbb::global_control one_thread(tbb::global_control::max_allowed_parallelism, 1);
  const Image a = noise(1920, 1080, 1, 1), b = noise(1920, 1080, 2, 1);
  double best = 1e9;
  for (int i = 0; i < 3; ++i) {
    const std::clock_t start = std::clock();
    EXPECT_GT(metric::ldr_flip(a, b, metric::Values::srgb).mean, 0);
    best = std::min(best, static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC);
  }
  std::printf("LDR-FLIP 1920 x 1080, one thread: %.3f s (NVIDIA's program: 0.585 s on a 2.6 GHz EPYC core)\n",
              best);
}

}  // namespace
