// Float images and the files they live in. This room owns OpenImageIO for the renderer.
#pragma once

#include <vector>

#include "math/vec.h"

namespace image {

struct Image {  // RGB, row-major from the top
  int width = 0, height = 0;
  std::vector<math::Vec3> pixels;
  Image() = default;
  Image(int w, int h) : width(w), height(h), pixels(static_cast<size_t>(w) * static_cast<size_t>(h)) {}
  math::Vec3& at(int x, int y) {
    return pixels[static_cast<size_t>(y) * static_cast<size_t>(width) + static_cast<size_t>(x)];
  }
  const math::Vec3& at(int x, int y) const {
    return pixels[static_cast<size_t>(y) * static_cast<size_t>(width) + static_cast<size_t>(x)];
  }
};

}  // namespace image
