// Wrong pixels: a dead, hot or misplaced pixel is lost in the mean of its tile, and a firefly is not one of
// them.
//
// A pixel is wrong if the median of its replicates differs from the golden by more than 20 sigma of its 3 x 3
// neighbourhood. A firefly sits in one replicate and leaves the median alone. Sigma is the largest standard
// error of the neighbourhood, golden and render together; the median is the middle replicate, of an even
// number the one of the two middle ones that is nearer to the golden. A golden's mean differs from its own
// median by less than sqrt(R - 1) sigma, whatever the distribution, so 20 sigma leaves room for any skewness.
//
// Where replicates agree by chance (an edge seen as 21/64 by all eight of them, as 22/64 the next time) sigma
// is 0: differences up to four samples' worth of the neighbourhood's contrast are the sample grid's. And
// rounding is rounding: 1e-5 of the pixel or, in dark places, of a tenth of the image's mean.
#pragma once

#include <vector>

#include "image/image.h"
#include "metric/statistics.h"

namespace metric {

struct WrongPixel {
  int x = 0, y = 0;
  double reference = 0, test = 0;  // of the channel that is furthest off: golden, median of the render
  double sigmas = 0;               // infinite where nothing varies
};

inline constexpr double wrong_pixel_sigmas = 20;

// `replicates` are the test's, each as large as the picture; fewer than two find nothing. `test` is its mean
// and variance, `samples` those of one replicate of the golden (1 if unknown). The worst first.
std::vector<WrongPixel> wrong_pixels(const Noisy& reference, const Noisy& test,
                                     const std::vector<const image::Image*>& replicates, double samples,
                                     double rounding = WelchOptions{}.rounding);

}  // namespace metric
