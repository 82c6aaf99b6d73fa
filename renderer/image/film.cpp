#include "image/film.h"

#include <cassert>
#include <cmath>
#include <limits>
#include <numeric>

namespace image {
using math::DVec3;
using math::Vec3;

Film::Film(int width, int height, int replicates, Holds holds)
    : width_(width), height_(height), replicates_(replicates), holds_(holds) {
  assert(width > 0 && height > 0 && replicates > 0);
  const size_t pixels = static_cast<size_t>(width) * static_cast<size_t>(height);
  cells_.resize(pixels * static_cast<size_t>(replicates));
  rejected_.resize(pixels);
}

size_t Film::index(int x, int y, int replicate) const {
  assert(x >= 0 && x < width_ && y >= 0 && y < height_ && replicate >= 0 && replicate < replicates_);
  const size_t pixel = static_cast<size_t>(y) * static_cast<size_t>(width_) + static_cast<size_t>(x);
  return pixel * static_cast<size_t>(replicates_) + static_cast<size_t>(replicate);
}

void Film::add(int x, int y, int replicate, const math::Vec3& radiance) {
  const bool negative = radiance.x < 0 || radiance.y < 0 || radiance.z < 0;
  if (!math::is_finite(radiance) || (negative && holds_ == Holds::radiance)) {
    ++rejected_[index(x, y, replicate) / static_cast<size_t>(replicates_)];
    return;
  }
  Cell& cell = cells_[index(x, y, replicate)];
  cell.sum += DVec3(radiance);
  ++cell.count;
}

Film::Cell Film::total(int x, int y) const {
  Cell total;
  for (int r = 0; r < replicates_; ++r) {
    const Cell& part = cell(x, y, r);
    total.sum += part.sum;
    total.count += part.count;
  }
  return total;
}

std::int64_t Film::samples(int x, int y) const {
  std::int64_t count = 0;
  for (int r = 0; r < replicates_; ++r) count += cell(x, y, r).count;
  return count;
}

std::int64_t Film::rejected() const {
  return std::accumulate(rejected_.begin(), rejected_.end(), std::int64_t{0});
}

// With n_r samples of mean m_r in replicate r and m = sum(n_r m_r) / N: the variance of one sample is
// estimated by sum(n_r (m_r - m)^2) / (R - 1), that of the mean by the Nth part. Replicates without a sample
// do not count; for equal n_r this is the usual variance of the m_r over R. Radiance beyond 1e19 has a
// variance beyond float, which stays finite.
Vec3 Film::variance_of_mean(int x, int y) const {
  const Cell all = total(x, y);
  const double samples = static_cast<double>(all.count);
  DVec3 squares(0);
  int used = 0;
  for (int r = 0; r < replicates_; ++r) {
    const Cell& part = cell(x, y, r);
    if (part.count == 0) continue;
    const double count = static_cast<double>(part.count);
    const DVec3 difference = part.sum / count - all.sum / samples;
    squares += count * (difference * difference);
    ++used;
  }
  if (used < 2) return Vec3(0);
  return math::smaller(Vec3(squares / (used - 1.0) / samples), Vec3(std::numeric_limits<float>::max()));
}

double Film::noise() const {
  double variance = 0, sum = 0;
  for (int y = 0; y < height_; ++y)
    for (int x = 0; x < width_; ++x) {
      const Vec3 m = mean(x, y), v = variance_of_mean(x, y);
      sum += static_cast<double>(m.x) + m.y + m.z;
      variance += static_cast<double>(v.x) + v.y + v.z;
    }
  return sum > 0 ? std::sqrt(variance * 3 * width_ * height_) / sum : 0;
}

Image Film::image(math::Vec3 (Film::*pixel)(int, int) const) const {
  Image image(width_, height_);
  for (int y = 0; y < height_; ++y)
    for (int x = 0; x < width_; ++x) image.at(x, y) = (this->*pixel)(x, y);
  return image;
}

}  // namespace image
