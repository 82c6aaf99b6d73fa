// Rays leave a surface a little off it, and a light as near as that looks very different from there:
// sampling, shadow ray and density must all use that one origin. (Seen from the true point, floors beside
// glowing walls were up to 11 % too dark.)

#include <gtest/gtest.h>

#include <cmath>

#include "accel/accel.h"
#include "light/lights.h"

namespace integrator {
namespace {

using math::Vec3;

// A floor and, two thousandths above it, a lamp that faces it; far from the origin, so that offsets are
// large.
TEST(Origin, a_light_as_near_as_the_offset_is_sampled_shot_at_and_weighted_from_one_point) {
  const Vec3 at(900, 1200, -700);
  const float gap = .002f;
  scene::Scene s;
  s.materials.resize(2);
  s.materials[0].double_sided = s.materials[1].double_sided = true;
  s.materials[1].emission = Vec3(1);
  s.meshes.resize(2);
  s.meshes[0].positions = {at + Vec3(-1, 0, 1), at + Vec3(1, 0, 1), at + Vec3(1, 0, -1),
                           at + Vec3(-1, 0, -1)};
  s.meshes[1].positions = {at + Vec3(-.5f, gap, -.5f), at + Vec3(.5f, gap, -.5f), at + Vec3(.5f, gap, .5f),
                           at + Vec3(-.5f, gap, .5f)};
  s.meshes[0].triangles = s.meshes[1].triangles = {{0, 1, 2}, {0, 2, 3}};
  s.meshes[1].material = 1;
  s.instances = {{0}, {1}};
  const surface::Surfaces surfaces(s, bsdf::Model::disney);
  const accel::Accel accel(s, false, {}, {});
  const light::Lights lights(s, surfaces);

  double worst_at_the_point = 0;
  int seen = 0;
  for (int k = 0; k < 40; ++k) {
    // A point of the floor as a camera finds it, off the lamp's edge or under it.
    const Vec3 target = at + Vec3(.45f + .0025f * static_cast<float>(k), 0, .1f);
    const accel::Ray camera{target + Vec3(.3f, .5f, 0) * (k < 20 ? .001f : 1.f), Vec3(-.3f, -.5f, 0)};
    accel::Hit hit;
    ASSERT_TRUE(accel.closest(camera, 0, hit));
    if (hit.instance != 0) continue;
    const surface::Point p = surfaces.at(camera, hit);
    const light::Receiver receiver{surface::origin(p, p.geometric_normal), p.frame.normal};
    for (float u = .05f; u < 1; u += .1f)
      for (float v = .05f; v < 1; v += .1f) {
        const auto l = lights.sample(receiver, .5, u, v);
        if (!l) continue;
        // The shadow ray meets nothing, not even the lamp it ends at.
        accel::Ray shadow{receiver.from, l->target - receiver.from, 1};
        ASSERT_FALSE(accel.occluded(shadow, 0)) << k << " " << u << " " << v;
        // A BSDF sample in that direction would be given the same density.
        const accel::Ray ray{receiver.from, l->wi};
        if (!accel.closest(ray, 0, hit) || hit.instance != 1) continue;  // past the edge by rounding
        const surface::Point found = surfaces.at(ray, hit);
        ASSERT_NEAR(lights.pdf(receiver, found) / l->pdf, 1, 1e-3) << k << " " << u << " " << v;
        worst_at_the_point = std::max(
            worst_at_the_point,
            std::fabs(static_cast<double>(lights.pdf({p.position, p.frame.normal}, found)) / l->pdf - 1));
        ++seen;
      }
  }
  EXPECT_GT(seen, 1000);
  EXPECT_GT(worst_at_the_point, .05);  // the trap is there
}

}  // namespace
}  // namespace integrator
