// Rays from the camera through points of the image.
#pragma once

#include "accel/accel.h"
#include "math/transcendental.h"
#include "scene/scene.h"

namespace integrator {

class CameraRays {
 public:
  // width, height: of the full image, pixels.
  CameraRays(const scene::Camera& camera, int width, int height)
      : camera_(camera), width_(width), height_(height) {
    float s, c;
    math::sin_cos(.5f * camera.yfov, s, c);
    half_height_ = camera.orthographic ? camera.ymag : s / c;
    half_width_ = half_height_ * static_cast<float>(width) / static_cast<float>(height);
    eye_ = math::transform_point(camera.to_world, math::Vec3(0));
  }

  // x, y: pixels from the upper left corner, pixel (i, j)'s centre at (i + 1/2, j + 1/2).
  accel::Ray ray(float x, float y) const {
    const float u = (2 * x / static_cast<float>(width_) - 1) * half_width_;
    const float v = (1 - 2 * y / static_cast<float>(height_)) * half_height_;
    accel::Ray r;
    if (camera_.orthographic) {
      r.origin = math::transform_point(camera_.to_world, {u, v, 0});
      r.direction = math::normalize(math::transform_vector(camera_.to_world, {0, 0, -1}));
    } else {
      r.origin = eye_;
      r.direction = math::normalize(math::transform_vector(camera_.to_world, {u, v, -1}));
    }
    return r;
  }

 private:
  scene::Camera camera_;
  int width_, height_;
  float half_width_ = 1, half_height_ = 1;
  math::Vec3 eye_;
};

}  // namespace integrator
