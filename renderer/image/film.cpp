#include "image/film.h"

#include <cassert>
#include <numeric>

namespace image {

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
  Cell& sum = cells_[index(x, y, replicate)];
  for (int c = 0; c < 3; ++c) sum.sum[c] += radiance[c];
  ++sum.count;
}

std::int64_t Film::samples(int x, int y) const {
  std::int64_t count = 0;
  for (int r = 0; r < replicates_; ++r) count += cell(x, y, r).count;
  return count;
}

std::int64_t Film::rejected() const {
  return std::accumulate(rejected_.begin(), rejected_.end(), std::int64_t{0});
}

math::Vec3 Film::replicate_mean(int x, int y, int replicate) const {
  const Cell& sum = cell(x, y, replicate);
  math::Vec3 mean{0, 0, 0};
  if (sum.count > 0)
    for (int c = 0; c < 3; ++c) mean[c] = static_cast<float>(sum.sum[c] / static_cast<double>(sum.count));
  return mean;
}

math::Vec3 Film::mean(int x, int y) const {
  const double count = static_cast<double>(samples(x, y));
  math::Vec3 mean{0, 0, 0};
  for (int c = 0; c < 3 && count > 0; ++c) {
    double sum = 0;
    for (int r = 0; r < replicates_; ++r) sum += cell(x, y, r).sum[c];
    mean[c] = static_cast<float>(sum / count);
  }
  return mean;
}

// With n_r samples of mean m_r in replicate r and m = sum(n_r m_r) / N: the variance of one sample is
// estimated by sum(n_r (m_r - m)^2) / (R - 1), that of the mean by the Nth part. Replicates without a sample
// do not count; for equal n_r this is the usual variance of the m_r over R.
math::Vec3 Film::variance_of_mean(int x, int y) const {
  const double total = static_cast<double>(samples(x, y));
  math::Vec3 variance{0, 0, 0};
  for (int c = 0; c < 3; ++c) {
    double sum = 0, squares = 0;
    int used = 0;
    for (int r = 0; r < replicates_; ++r) sum += cell(x, y, r).sum[c];
    for (int r = 0; r < replicates_; ++r) {
      const Cell& part = cell(x, y, r);
      if (part.count == 0) continue;
      const double count = static_cast<double>(part.count);
      squares += count * math::sqr(part.sum[c] / count - sum / total);
      ++used;
    }
    if (used >= 2) variance[c] = static_cast<float>(squares / (used - 1) / total);
  }
  return variance;
}

Image Film::mean_image() const {
  Image image(width_, height_);
  for (int y = 0; y < height_; ++y)
    for (int x = 0; x < width_; ++x) image.at(x, y) = mean(x, y);
  return image;
}

Image Film::variance_image() const {
  Image image(width_, height_);
  for (int y = 0; y < height_; ++y)
    for (int x = 0; x < width_; ++x) image.at(x, y) = variance_of_mean(x, y);
  return image;
}

}  // namespace image
