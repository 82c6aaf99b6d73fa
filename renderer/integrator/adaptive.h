// Adaptive sampling without bias. Some samples of every pixel, the pilot, show where the noise is, and the
// rest are spent there, so that the mean squared error becomes least.
//
// Who stops when the samples that are averaged look quiet stops too early where the rare bright ones have not
// come yet: the picture gets darker (16 % in a scene of fireflies). So no sample has a say in how many others
// it is averaged with: on a checkerboard the pilot of the black pixels decides the counts of the white ones
// and the other way round (cross-fitting), from neighbours of the other colour. Each pixel's mean is then
// unbiased, nothing is thrown away, and counts are a function of scene, settings and seed alone. (With
// --noise the total is decided by both colours: a picture that is stopped before its end owes a trace of its
// counts to all pixels.)
#pragma once

#include <array>
#include <span>
#include <utility>
#include <vector>

#include "image/film.h"
#include "integrator/render.h"

namespace integrator {

// The spread of fewer replicates says too little: NoiseMap is then given `early`.
constexpr int enough_replicates = 4;

// 0 or 1: the squares are blocks, whose pixels may share paths.
inline int checkerboard(int x, int y) { return (x / block_side + y / block_side) % 2; }

// Where reuse is worth its rays, as pixels of the other colour say.
class ReuseMap {
 public:
  // spread: of samples that were all made with reuse; rays: of all of them.
  ReuseMap(const Spread& spread, std::uint64_t rays);
  bool at(int x, int y) const { return reuse_[index(x, y)]; }

 private:
  size_t index(int x, int y) const {
    return static_cast<size_t>(y) * static_cast<size_t>(width_) + static_cast<size_t>(x);
  }
  int width_;
  std::vector<bool> reuse_;
};

// What the pixels of one colour say about noise, for those of the other to act on. Counts are per replicate.
class NoiseMap {
 public:
  // The pilot has `samples` samples in each replicate. Noise is how its replicates differ, at least two, or,
  // given `early`, how the samples between one of these films and the next differ: a film, and how many
  // samples each replicate had then, in their order. Stratified as they are those differ by more than
  // replicates would: good for counts, not for mean_for_noise.
  struct Early {
    image::Film film;
    int samples;
  };
  // `spread`: of a pilot whose samples shared camera rays two by two, what Renderer::render says of them.
  // path_rays: of a path after its camera ray, on average.
  NoiseMap(const image::Film& pilot, int color, int samples, std::span<const Early> early = {},
           const Spread* spread = nullptr, double path_rays = 1);

  // How many samples of a pixel are to share a camera ray after the pilot: 1, 2 or 4; 1 without `spread`.
  int together(int x, int y) const { return together_[index(x, y)]; }
  // Samples of a pixel at a level; never fewer than the pilot's, and none less at a higher level.
  int count(int x, int y, double level) const;
  // The level whose counts have this mean over the picture.
  double level_of_mean(double samples) const;
  // The mean count that brings the picture's noise, as image::Film defines it, down to `noise` if all
  // replicates take these counts, but at most `most`.
  double mean_for_noise(double noise, double most) const;

 private:
  double mean_count(double level) const;
  size_t index(int x, int y) const {
    return static_cast<size_t>(y) * static_cast<size_t>(width_) + static_cast<size_t>(x);
  }
  int group_of(size_t pixel) const;  // samples that are added to it together
  int width_, height_, replicates_, pilot_;
  double mean_ = 0;  // of these pixels and channels
  // Row by row: variance of one sample, mean of the neighbours of the colour; what it needs of samples, to a
  // factor.
  std::vector<double> variance_, need_;
  std::vector<int> together_;
};

// What both colours say, each of the other's pixels.
class Plan {
 public:
  // Of colors 0 and 1.
  Plan(NoiseMap black, NoiseMap white) : says_{std::move(black), std::move(white)} {}
  using Levels = std::array<double, 2>;
  // At which the counts that color k decides have the mean samples[k].
  Levels levels_of_mean(const std::array<double, 2>& samples) const {
    return {says_[0].level_of_mean(samples[0]), says_[1].level_of_mean(samples[1])};
  }
  int count(int x, int y, const Levels& levels) const {
    const auto other = static_cast<size_t>(1 - checkerboard(x, y));
    return says_[other].count(x, y, levels[other]);
  }
  int together(int x, int y) const {
    return says_[static_cast<size_t>(1 - checkerboard(x, y))].together(x, y);
  }

 private:
  std::array<NoiseMap, 2> says_;
};

}  // namespace integrator
