#include "view/camera.h"

#include <gtest/gtest.h>

#include <cmath>

#include "gltf/load.h"

namespace view {
namespace {

using math::DVec3;

double length(const DVec3& v) { return std::sqrt(v.x * v.x + v.y * v.y + v.z * v.z); }
double dot(const DVec3& a, const DVec3& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
DVec3 eye(const FreeCamera& c) { return DVec3(c.to_world()[3]); }
DVec3 back(const FreeCamera& c) { return DVec3(c.to_world()[2]); }
DVec3 target(const FreeCamera& c) { return eye(c) - back(c) * c.distance(); }

// Looks at (1, 2, 0) from 5 metres in front.
FreeCamera start() {
  scene::Camera camera;
  camera.to_world[3] = {1, 2, 5, 1};
  return FreeCamera(camera, 5);
}

void expect_near(const DVec3& a, const DVec3& b, double tolerance = 1e-12) {
  EXPECT_LT(length(a - b), tolerance)
      << a.x << " " << a.y << " " << a.z << ", wanted " << b.x << " " << b.y << " " << b.z;
}

TEST(FreeCamera, turns_about_its_target) {
  FreeCamera c = start();
  c.turn(math::pi / 2, 0);
  expect_near(eye(c), {6, 2, 0}, 1e-6);
  for (int i = 0; i < 1000; ++i) c.turn(.1 * std::sin(i), .07 * std::cos(3 * i));
  expect_near(target(c), {1, 2, 0});
  EXPECT_NEAR(length(eye(c) - target(c)), 5, 1e-12);
  // Orthonormal, and upright.
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j)
      EXPECT_NEAR(dot(DVec3(c.to_world()[i]), DVec3(c.to_world()[j])), i == j ? 1 : 0, 1e-12);
  EXPECT_NEAR(c.to_world()[0].y, 0, 1e-12) << "the horizon stays level";
}

TEST(FreeCamera, never_goes_over_the_top) {
  for (const double up : {.3, -.3}) {
    FreeCamera c = start();
    for (int i = 0; i < 100; ++i) c.turn(.1, up);
    EXPECT_GT(std::fabs(back(c).y), .9) << "but close to it";
    EXPECT_GT(c.to_world()[1].y, 0) << "up is up";
  }
}

TEST(FreeCamera, looks_around_from_where_it_is) {
  FreeCamera c = start();
  c.look(.4, .2);
  expect_near(eye(c), {1, 2, 5});
  EXPECT_GT(target(c).x, 2) << "to the right";
  EXPECT_GT(target(c).y, 2.5) << "and up";
}

TEST(FreeCamera, dolly_keeps_the_target_and_an_orthographic_view_grows_instead) {
  FreeCamera c = start();
  c.dolly(.5);
  expect_near(eye(c), {1, 2, 2.5});
  expect_near(target(c), {1, 2, 0});
  scene::Camera flat;
  flat.orthographic = true;
  flat.ymag = 2;
  FreeCamera o(flat, 5);
  o.dolly(.5);
  EXPECT_EQ(o.camera().ymag, 1);
  expect_near(eye(o), {0, 0, 0});
}

TEST(FreeCamera, a_shift_by_one_moves_the_target_by_the_height_of_the_view) {
  FreeCamera c = start();
  c.shift(0, 1);
  expect_near(target(c), {1, 2 + 10 * std::tan(.4), 0}, 1e-6);
  expect_near(eye(c), {1, 2 + 10 * std::tan(.4), 5}, 1e-6);
}

TEST(FreeCamera, flies_along_its_own_axes) {
  FreeCamera c = start();
  c.look(math::pi / 2, 0);  // now along +x
  c.fly(0, 0, 2);
  expect_near(eye(c), {3, 2, 5}, 1e-6);
  c.fly(1, 3, 0);
  expect_near(eye(c), {3, 5, 6}, 1e-6);
}

TEST(FreeCamera, is_at_any_time_the_camera_that_a_file_with_its_frame_gives) {
  FreeCamera c = start();
  for (int i = 0; i < 200; ++i) {
    c.turn(.1, .03);
    c.shift(.1, -.2);
    EXPECT_EQ(c.camera().to_world, *gltf::camera_frame(c.to_world()));
  }
}

}  // namespace
}  // namespace view
