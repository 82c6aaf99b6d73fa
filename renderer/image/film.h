// The film: per pixel, one sum per replicate in double precision, so that 1e8 samples lose nothing, and the
// variance of the mean follows from the spread of the replicates (low-discrepancy samples inside one
// replicate are not independent, replicates are).
#pragma once

#include <cstdint>
#include <vector>

#include "image/image.h"

namespace image {

class Film {
 public:
  // What samples are: radiance, or data such as positions and normals, which may be negative.
  enum class Holds { radiance, data };
  Film(int width, int height, int replicates, Holds holds = Holds::radiance);
  int width() const { return width_; }
  int height() const { return height_; }
  int replicates() const { return replicates_; }

  // Adds one sample. A non-finite one, and negative radiance, is counted in rejected() and left out.
  // Different pixels may be added to from different threads; one pixel only from one.
  void add(int x, int y, int replicate, const math::Vec3& radiance);

  // Of the accepted samples; black if there are none.
  math::Vec3 mean(int x, int y) const { return total(x, y).mean(); }
  math::Vec3 variance_of_mean(int x, int y) const;  // 0 for fewer than two replicates
  math::Vec3 replicate_mean(int x, int y, int replicate) const { return cell(x, y, replicate).mean(); }
  std::int64_t samples(int x, int y) const;  // accepted
  std::int64_t rejected() const;             // over the whole film
  // Root of the mean variance of pixels and channels, over their mean; 0 for a black film or one replicate.
  double noise() const;
  Image mean_image() const { return image(&Film::mean); }
  Image variance_image() const { return image(&Film::variance_of_mean); }

 private:
  struct Cell {
    math::DVec3 sum{0, 0, 0};
    std::int64_t count = 0;
    math::Vec3 mean() const {
      return count > 0 ? math::Vec3(sum / static_cast<double>(count)) : math::Vec3(0);
    }
  };
  Image image(math::Vec3 (Film::*pixel)(int, int) const) const;
  Cell total(int x, int y) const;                   // of all replicates
  size_t index(int x, int y, int replicate) const;  // into cells_
  const Cell& cell(int x, int y, int replicate) const { return cells_[index(x, y, replicate)]; }
  int width_, height_, replicates_;
  Holds holds_;
  std::vector<Cell> cells_;             // (y * width + x) * replicates + replicate
  std::vector<std::int32_t> rejected_;  // per pixel
};

}  // namespace image
