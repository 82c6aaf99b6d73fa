// A camera moved by hand: turned about what it looks at, brought nearer, shifted, or flown.
#pragma once

#include "scene/scene.h"

namespace view {

class FreeCamera {
 public:
  // `distance`: from the camera to what it turns about, metres.
  FreeCamera(const scene::Camera& start, double distance);

  // Angles in radians, by which the eye goes to the right and up about the target. Stops short of looking
  // straight up or down.
  void turn(double right, double up);
  // By which the view goes to the right and up about the eye; stops likewise.
  void look(double right, double up);
  // Brings the target this many times as far away; an orthographic view grows instead.
  void dolly(double factor);
  // Shifts eye and target, in heights of the view at the target.
  void shift(double right, double up);
  // Moves eye and target, metres along the view's axes.
  void fly(double right, double up, double forward);
  void set_aspect(float aspect) { camera_.aspect = aspect; }
  void set_yfov(float yfov) { camera_.yfov = yfov; }

  const scene::Camera& camera() const { return camera_; }    // named "view"
  const math::DMat4& to_world() const { return to_world_; }  // of which gltf::camera_frame() is the camera's
  double distance() const { return distance_; }

  bool operator==(const FreeCamera&) const = default;

 private:
  void rotate(double right, double up, double about);
  void place();

  scene::Camera camera_;
  math::DMat4 to_world_;  // columns right, up, back, eye: orthonormal
  double distance_;
};

}  // namespace view
