// Adaptive sampling without bias. Some samples of every pixel, the pilot, show where the noise is, and the
// rest are spent there, so that the mean squared error becomes least.
//
// Who stops when the samples that are averaged look quiet stops too early where the rare bright ones have not
// come yet: the picture gets darker (16 % in a scene of fireflies). So no sample has a say in how many others
// it is averaged with: the even replicates' pilot decides the counts of the odd replicates and the other way
// round (cross-fitting), each replicate's mean is then unbiased, and the picture is the mean of the
// replicates' means with equal weights. Nothing is thrown away, the spread of the replicates stays an
// estimate of the variance, and counts are a function of scene, settings and seed alone.
#pragma once

#include <span>
#include <vector>

#include "image/film.h"

namespace integrator {

// What some of the replicates say about noise, for others to act on. Counts are per replicate.
class NoiseMap {
 public:
  // Of replicates first, first + step, ...; at least two. Each has `samples` samples.
  NoiseMap(const image::Film& pilot, int first, int step, int samples);
  // Of one replicate, by how its samples between one film of `early` and the next differ: a film, and how
  // many samples each pixel of a replicate had then, at least one film, in their order. Stratified as they
  // are they differ by more than two replicates would: good for counts, not for mean_for_noise.
  struct Early {
    image::Film film;
    int samples;
  };
  NoiseMap(const image::Film& pilot, int replicate, int samples, std::span<const Early> early);

  // Samples of a pixel at a level; never fewer than the pilot's, and none less at a higher level.
  int count(int x, int y, double level) const;
  // The level whose counts have this mean over the picture.
  double level_of_mean(double samples) const;
  // The mean count that brings the picture's noise, as image::Film defines it, down to `noise` if all
  // replicates take these counts, but at most `most`. How noisy that is, others must say: these know their
  // own fireflies only.
  double mean_for_noise(double noise, double most, const NoiseMap& others) const;

 private:
  NoiseMap(const image::Film& pilot, int samples);
  void finish(const std::vector<double>& variance, double mean);
  double mean_count(double level) const;
  int width_, height_, replicates_, pilot_;
  double mean_ = 0;  // of pixels and channels
  // Row by row: variance of one sample, smoothed over neighbours; what it needs of samples, to a factor.
  std::vector<double> variance_, need_;
};

}  // namespace integrator
