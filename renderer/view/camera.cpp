#include "view/camera.h"

#include <algorithm>
#include <cmath>

#include "gltf/load.h"

namespace view {
using math::DVec3;

namespace {

constexpr double steepest = .9998;  // sine of the elevation, 88.9 degrees

DVec3 cross(const DVec3& a, const DVec3& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
DVec3 unit(const DVec3& v) { return v / std::sqrt(v.x * v.x + v.y * v.y + v.z * v.z); }

}  // namespace

FreeCamera::FreeCamera(const scene::Camera& start, double distance)
    : camera_(start), to_world_(start.to_world), distance_(distance) {
  camera_.name = "view";
  place();
}

// Back to an orthonormal frame, and to the camera that a file with it would give.
void FreeCamera::place() {
  const DVec3 back = unit(DVec3(to_world_[2])), right = unit(cross(DVec3(to_world_[1]), back));
  const DVec3 up = cross(back, right), eye(to_world_[3]);
  to_world_ = math::DMat4(math::DMat4::col_type(right, 0), math::DMat4::col_type(up, 0),
                          math::DMat4::col_type(back, 0), math::DMat4::col_type(eye, 1));
  camera_.to_world = *gltf::camera_frame(to_world_);
}

// About the point `about` metres in front of the eye: first about the world's vertical, then about the
// view's right.
void FreeCamera::rotate(double right, double up, double about) {
  const DVec3 pivot = DVec3(to_world_[3]) - DVec3(to_world_[2]) * about;
  const double s = std::sin(right), c = std::cos(right);
  const auto yaw = [&](const DVec3& v) { return DVec3(c * v.x + s * v.z, v.y, c * v.z - s * v.x); };
  const DVec3 x = yaw(DVec3(to_world_[0]));
  DVec3 y = yaw(DVec3(to_world_[1])), z = yaw(DVec3(to_world_[2]));
  const double sp = std::sin(up), cp = std::cos(up);
  const DVec3 tilted = z * cp + y * sp;
  if (std::fabs(tilted.y) < std::max(steepest, std::fabs(z.y))) {
    y = y * cp - z * sp;
    z = tilted;
  }
  for (int i = 0; i < 3; ++i) to_world_[i] = math::DMat4::col_type(i == 0 ? x : i == 1 ? y : z, 0);
  to_world_[3] = math::DMat4::col_type(pivot + z * about, 1);
  place();
}

void FreeCamera::turn(double right, double up) { rotate(right, up, distance_); }
void FreeCamera::look(double right, double up) { rotate(-right, -up, 0); }

void FreeCamera::dolly(double factor) {
  factor = std::clamp(factor, .01, 100.);
  if (camera_.orthographic) {
    camera_.ymag = static_cast<float>(camera_.ymag * factor);
    return;
  }
  to_world_[3] += to_world_[2] * (distance_ * (factor - 1));
  distance_ *= factor;
  place();
}

void FreeCamera::shift(double right, double up) {
  const double height =
      camera_.orthographic ? 2. * camera_.ymag : 2 * distance_ * std::tan(.5 * camera_.yfov);
  fly(right * height, up * height, 0);
}

void FreeCamera::fly(double right, double up, double forward) {
  to_world_[3] += to_world_[0] * right + to_world_[1] * up - to_world_[2] * forward;
  place();
}

}  // namespace view
