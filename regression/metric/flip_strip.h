// FLIP of one rectangle of a pair of images. Walks down the rows with a ring of horizontally filtered rows
// just tall enough for the vertical filters, so that everything between reading a pixel and writing its error
// stays in cache. A pixel's arithmetic does not depend on the rectangle it falls in: maps are the same for
// any division of the work.
#pragma once

#include <memory>
#include <vector>

#include "metric/flip.h"
#include "metric/flip_filter.h"

namespace metric {

struct Rectangle {
  int x, y, width, height;
};

// How samples become linear light in [0,1].
struct Transfer {
  enum Kind { linear, srgb, tone_mapped } kind = linear;
  ToneMapper tone_mapper = ToneMapper::aces;
  float gain = 1;  // of tone_mapped
};

class Strip {
 public:
  // Room for rectangles of up to this width. The kernels must outlive it.
  Strip(const FlipKernels& kernels, int width);
  ~Strip();
  // Calls done(y, errors) for each row of the rectangle, from the top.
  template <typename Done>
  void run(const image::Image& reference, const image::Image& test, const Transfer& transfer,
           const Rectangle& area, const Done& done) {
    start(reference, test, area);
    for (int y = area.y; y < area.y + area.height; ++y) done(y, row(transfer, y));
  }

 private:
  struct Side;
  void start(const image::Image& reference, const image::Image& test, const Rectangle& area);
  const float* row(const Transfer& transfer, int y);

  Rectangle area_{};
  std::unique_ptr<Side> reference_, test_;
  std::vector<float> error_;
};

}  // namespace metric
