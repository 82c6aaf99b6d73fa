// Emitters as a receiver sees them, against closed forms. Sums over stratified grids, no randomness.
#include "light/lights.h"

#include <gtest/gtest.h>

#include <cmath>

namespace light {
namespace {

using math::Vec3;

// One emitter of radiance 1: a rectangle of two triangles or the first of them alone, corner, x, y.
scene::Scene one_emitter(const Vec3& corner, const Vec3& x, const Vec3& y, bool rectangle) {
  scene::Scene s;
  s.materials.resize(1);
  s.materials[0].emission = Vec3(1);
  s.materials[0].double_sided = true;
  s.meshes.resize(1);
  s.meshes[0].positions = {corner, corner + x, corner + x + y, corner + y};
  s.meshes[0].triangles = {{0, 1, 3}};
  if (rectangle) s.meshes[0].triangles = {{0, 1, 2}, {0, 2, 3}};
  s.instances = {{0}};
  return s;
}

// Lambert 1760: irradiance from a polygon of radiance 1 that lies above the receiver's horizon.
double lambert(const std::vector<Vec3>& polygon, const Receiver& r) {
  double sum = 0;
  for (size_t i = 0; i < polygon.size(); ++i) {
    const glm::dvec3 from(r.from), n(r.normal);
    const auto unit = [](const glm::dvec3& v) { return v / std::sqrt(v.x * v.x + v.y * v.y + v.z * v.z); };
    const glm::dvec3 a = unit(glm::dvec3(polygon[i]) - from),
                     b = unit(glm::dvec3(polygon[(i + 1) % polygon.size()]) - from);
    const glm::dvec3 c(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x);
    const double length = std::sqrt(c.x * c.x + c.y * c.y + c.z * c.z);
    sum +=
        std::atan2(length, a.x * b.x + a.y * b.y + a.z * b.z) * (c.x * n.x + c.y * n.y + c.z * n.z) / length;
  }
  return std::fabs(sum) / 2;
}

// From far, where emitters are sampled by area, to a thousandth of their size, where by solid angle.
TEST(Lights, irradiance_of_a_rectangle_and_a_triangle_is_lamberts) {
  const Vec3 corner(-.5f, 0, -.3f), x(1, 0, .2f), y(-.12f, 0, .6f);
  for (const bool rectangle : {true, false}) {
    const scene::Scene s = one_emitter(corner, x, y, rectangle);
    const surface::Surfaces surfaces(s, bsdf::Model::disney);
    const Lights lights(s, surfaces);
    ASSERT_EQ(lights.emitters(), 1u);
    for (const Receiver& r : {Receiver{{.1f, -10, 2}, {0, 1, 0}}, Receiver{{.1f, -2, 0}, {0, 1, 0}},
                              Receiver{{-.1f, -.3f, .05f}, {0, 1, 0}}, Receiver{{0, -.001f, 0}, {0, 1, 0}},
                              Receiver{{.3f, -.05f, -1}, math::normalize(Vec3(0, .7f, .9f))}}) {
      double sum = 0;
      const int n = 300;
      for (int j = 0; j < n; ++j)
        for (int i = 0; i < n; ++i) {
          const auto l =
              lights.sample(r, .5, (static_cast<float>(i) + .5f) / n, (static_cast<float>(j) + .5f) / n);
          ASSERT_TRUE(l);
          sum += l->radiance.x * std::max(0.f, math::dot(l->wi, r.normal)) / l->pdf;
        }
      std::vector<Vec3> polygon = {corner, corner + x, corner + x + y, corner + y};
      if (!rectangle) polygon.erase(polygon.begin() + 2);
      EXPECT_NEAR(sum / (n * n) / lambert(polygon, r), 1, 3e-4) << rectangle << " " << r.from.y;
    }
  }
}

TEST(Lights, a_samples_density_is_the_density_of_its_point) {
  const Vec3 corner(-.5f, 0, -.3f), x(1, 0, .2f), y(-.12f, 0, .6f);
  for (const bool rectangle : {true, false}) {
    const scene::Scene s = one_emitter(corner, x, y, rectangle);
    const surface::Surfaces surfaces(s, bsdf::Model::disney);
    const Lights lights(s, surfaces);
    for (const float distance : {.001f, .1f, 1.f, 1.3f, 1.4f, 1.5f, 3.f, 30.f}) {
      const Receiver r{{.1f, -distance, .2f}, {0, 1, 0}};
      for (float u = .05f; u < 1; u += .1f)
        for (float v = .05f; v < 1; v += .1f) {
          const auto l = lights.sample(r, .5, u, v);
          ASSERT_TRUE(l);
          surface::Point p;
          const float t = (0 - r.from.y) / l->wi.y;
          p.position = r.from + l->wi * t;
          p.triangle = rectangle && v > u ? 1 : 0;
          ASSERT_NEAR(lights.pdf(r, p) / l->pdf, 1, 1e-4) << distance;
        }
    }
  }
}

TEST(Lights, only_triangles_that_make_a_rectangle_are_joined) {
  const Vec3 corner(100, 50, -3), x(.6f, .8f, 0), y(-.4f, .3f, 0);
  const auto count = [](const scene::Scene& s) {
    const surface::Surfaces surfaces(s, bsdf::Model::disney);
    return Lights(s, surfaces).emitters();
  };
  scene::Scene s = one_emitter(corner, x, y, true);
  EXPECT_EQ(count(s), 1u);
  s.meshes[0].triangles = {{1, 2, 0}, {3, 0, 2}};  // from any corner
  EXPECT_EQ(count(s), 1u);
  s.meshes[0].triangles = {{1, 2, 0}, {3, 2, 0}};  // one turned over
  EXPECT_EQ(count(s), 2u);
  EXPECT_EQ(count(one_emitter(corner, x, y + x * .01f, true)), 2u);  // a parallelogram
  s = one_emitter(corner, x, y, true);
  s.meshes[0].positions[3].z += .01f;  // folded
  EXPECT_EQ(count(s), 2u);
}

// Each half of a joined rectangle emits what its own texture coordinates say.
TEST(Lights, a_joined_rectangle_shows_its_texture_as_its_triangles_do) {
  const Vec3 corner(-1, 0, -1), x(2, 0, 0), y(0, 0, 2);
  for (const auto& triangles :
       {std::vector<math::UVec3>{{0, 1, 2}, {0, 2, 3}}, {{1, 2, 3}, {3, 0, 1}}, {{2, 0, 1}, {3, 0, 2}}}) {
    scene::Scene s = one_emitter(corner, x, y, true);
    s.meshes[0].triangles = triangles;
    s.meshes[0].texcoords[0] = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
    s.bitmaps.resize(1);
    s.bitmaps[0].width = s.bitmaps[0].height = 8;
    for (int i = 0; i < 64; ++i) {
      const float v = static_cast<float>((i * 37) % 64) / 63;
      s.bitmaps[0].texels.push_back({v, v, v, 1});
    }
    s.materials[0].emissive_texture.bitmap = 0;
    const surface::Surfaces surfaces(s, bsdf::Model::disney);
    const Lights lights(s, surfaces);
    ASSERT_EQ(lights.emitters(), 1u);
    const Receiver r{{.3f, -.5f, .1f}, {0, 1, 0}};
    for (float u = .03f; u < 1; u += .1f)
      for (float v = .03f; v < 1; v += .1f) {
        const auto l = lights.sample(r, .5, u, v);
        ASSERT_TRUE(l);
        const Vec3 p = r.from + l->wi * (-r.from.y / l->wi.y);
        // The texture covers the square: ask the triangle that was written first, whose weights may be
        // outside.
        const float a = (p.x + 1) / 2, b = (p.z + 1) / 2;
        const scene::Scene whole = [&] {
          scene::Scene t = s;
          t.meshes[0].triangles = {{0, 1, 3}};
          return t;
        }();
        const surface::Surfaces plain(whole, bsdf::Model::disney);
        ASSERT_NEAR(l->radiance.x, plain.emission(0, 0, {1 - a - b, a, b}).x, 2e-4);
      }
  }
}

}  // namespace
}  // namespace light
