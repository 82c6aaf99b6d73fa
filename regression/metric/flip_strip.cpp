#include "metric/flip_strip.h"

#include <algorithm>
#include <array>

#include "metric/flip_colour.h"

namespace metric {

namespace {

// What the ring keeps of every row, filtered along x.
enum Plane { luminance, red_green, blue_yellow_1, blue_yellow_2, gauss, edge, point, plane_count };

// Samples of padding beside and between arrays, so that neighbours do not share a cache line.
int rounded(int n) { return (n + 15) / 16 * 16; }

}  // namespace

// One of the two images on its way through the filters.
struct Strip::Side {
  Side(const FlipKernels& kernels, int width)
      : kernels_(kernels),
        pairs_(static_cast<int>(std::max(kernels.a.size(), kernels.by1.size())) - 1),
        stride_(rounded(width)),
        slots_(2 * kernels.radius + 1),
        ring_(static_cast<std::size_t>(slots_) * plane_count * stride_),
        source_(static_cast<std::size_t>(3) * rounded(width + 2 * pairs_)),
        filtered_(static_cast<std::size_t>(7) * stride_),
        rows_(2 * pairs_ + 1) {}

  void start(const image::Image& image, const Rectangle& area) {
    image_ = &image;
    area_ = area;
    next_ = std::max(0, area.y - kernels_.radius);
  }

  // Everything of output row y: colour() and features() are valid afterwards.
  void row(const Transfer& transfer, int y) {
    while (next_ <= std::min(y + kernels_.radius, image_->height - 1)) read(transfer, next_++);
    const int n = area_.width;
    filter(column(luminance, y), kernels_.a, out(0), n);
    filter(column(red_green, y), kernels_.rg, out(1), n);
    filter(column(blue_yellow_1, y), kernels_.by1, out(2), n);
    filter(column(blue_yellow_2, y), kernels_.by2, out(3), n);
    add(out(3), out(2), n);
    opponent_to_hunt_lab(colour(), n);

    // Edges: (edge, Gauss) along (x, y) and the other way round; points likewise.
    filter_derivatives(column(gauss, y), kernels_.point, kernels_.edge, out(4), out(5), n);
    filter(column(edge, y), kernels_.g, out(3), n);
    magnitude(out(3), out(5), out(5), n);
    filter(column(point, y), kernels_.g, out(3), n);
    magnitude(out(3), out(4), out(4), n);
  }

  Planes3 colour() { return {out(0), out(1), out(2)}; }
  const float* points() { return out(4); }
  const float* edges() { return out(5); }

 private:
  float* out(int i) { return filtered_.data() + static_cast<std::size_t>(i) * stride_; }
  float* slot(int plane, int y) {
    return ring_.data() + (static_cast<std::size_t>(y % slots_) * plane_count + plane) * stride_;
  }

  // The rows of a plane above and below y, the image's first and last row standing for those beyond it.
  Rows column(Plane plane, int y) {
    for (int k = -pairs_; k <= pairs_; ++k) {
      const int near = std::clamp(k, -kernels_.radius, kernels_.radius);  // further away, weights are 0
      rows_[k + pairs_] = slot(plane, std::clamp(y + near, 0, image_->height - 1));
    }
    return rows_.data() + pairs_;
  }

  // The samples of a row to the left and right of x.
  Rows line(const float* samples) {
    for (int k = -pairs_; k <= pairs_; ++k) rows_[k + pairs_] = samples + pairs_ + k;
    return rows_.data() + pairs_;
  }

  // Reads row y, edges repeated, and filters it along x into the ring.
  void read(const Transfer& transfer, int y) {
    const int n = area_.width + 2 * pairs_, stride = rounded(n);
    const Planes3 source{source_.data(), source_.data() + stride, source_.data() + 2 * stride};
    const float* const row = image_->data.data() + static_cast<std::size_t>(y) * image_->width * 3;
    const int first = area_.x - pairs_, last = image_->width - 1;
    const auto copy = [&](int i, const float* pixel) {
      source.r[i] = pixel[0];
      source.g[i] = pixel[1];
      source.b[i] = pixel[2];
    };
    const int inside = std::clamp(-first, 0, n), outside = std::clamp(last + 1 - first, inside, n);
    for (int i = 0; i < inside; ++i) copy(i, row);
    for (int i = inside; i < outside; ++i) copy(i, row + static_cast<std::size_t>(first + i) * 3);
    for (int i = outside; i < n; ++i) copy(i, row + static_cast<std::size_t>(last) * 3);
    if (transfer.kind == Transfer::tone_mapped) {
      tone_map_rows(source, transfer.tone_mapper, transfer.gain, n);
    } else {
      clamp01(source, n);
      if (transfer.kind == Transfer::srgb) decode_srgb(source, n);
    }
    to_opponent(source, n);

    filter_luminance(line(source.r), kernels_.a, kernels_.g, kernels_.point, kernels_.edge,
                     slot(luminance, y), slot(gauss, y), slot(point, y), slot(edge, y), area_.width);
    filter(line(source.g), kernels_.rg, slot(red_green, y), area_.width);
    filter_two(line(source.b), kernels_.by1, kernels_.by2, slot(blue_yellow_1, y), slot(blue_yellow_2, y),
               area_.width);
  }

  const FlipKernels& kernels_;
  const int pairs_, stride_, slots_;
  const image::Image* image_ = nullptr;
  Rectangle area_{};
  int next_ = 0;
  std::vector<float> ring_, source_, filtered_;
  std::vector<const float*> rows_;
};

Strip::Strip(const FlipKernels& kernels, int width)
    : reference_(std::make_unique<Side>(kernels, width)),
      test_(std::make_unique<Side>(kernels, width)),
      error_(width) {}

Strip::~Strip() = default;

void Strip::start(const image::Image& reference, const image::Image& test, const Rectangle& area) {
  area_ = area;
  reference_->start(reference, area);
  test_->start(test, area);
}

const float* Strip::row(const Transfer& transfer, int y) {
  reference_->row(transfer, y);
  test_->row(transfer, y);
  colour_difference(reference_->colour(), test_->colour(), error_.data(), area_.width);
  combine(reference_->edges(), test_->edges(), reference_->points(), test_->points(), error_.data(),
          area_.width);
  return error_.data();
}

}  // namespace metric
