// Small scenes built in memory, shared by the closed-form tests.
#pragma once

#include <cmath>

#include "scene/scene.h"

namespace analytic {

using math::Vec3;

// A unit-radius UV sphere with smooth normals, counter-clockwise from outside.
inline scene::Mesh sphere(int segments) {
  scene::Mesh m;
  for (int j = 0; j <= segments; ++j)
    for (int i = 0; i <= 2 * segments; ++i) {
      const double theta = 3.14159265358979 * j / segments, phi = 3.14159265358979 * i / segments;
      const Vec3 p(static_cast<float>(std::sin(theta) * std::cos(phi)), static_cast<float>(std::cos(theta)),
                   static_cast<float>(std::sin(theta) * std::sin(phi)));
      m.positions.push_back(p);
      m.normals.push_back(p);
    }
  const auto at = [&](int i, int j) { return static_cast<unsigned>(j * (2 * segments + 1) + i); };
  for (int j = 0; j < segments; ++j)
    for (int i = 0; i < 2 * segments; ++i) {
      if (j > 0) m.triangles.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
      if (j < segments - 1) m.triangles.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
    }
  return m;
}

inline scene::Mesh quad(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {  // counter-clockwise
  scene::Mesh m;
  m.positions = {a, b, c, d};
  m.triangles = {{0, 1, 2}, {0, 2, 3}};
  return m;
}

inline scene::Camera camera_at(const Vec3& eye, float yfov) {  // looking along -z
  scene::Camera c;
  c.yfov = yfov;
  c.to_world[3] = math::Vec4(eye.x, eye.y, eye.z, 1);
  return c;
}

inline scene::Material lambert(float albedo) {
  scene::Material m;
  m.base_color = Vec3(albedo);
  m.metallic = 0;
  m.specular = 0;
  m.double_sided = true;
  return m;
}

// Inside a closed sphere of albedo a whose wall emits e, every radiance is e / (1 - a) (pbrt-v4's analytic
// scenes).
inline scene::Scene closed_sphere(float albedo, float emission) {
  scene::Scene s;
  s.meshes = {sphere(24)};
  s.meshes[0].normals.clear();
  s.materials = {lambert(albedo)};
  s.materials[0].emission = Vec3(emission);
  s.instances = {{0}};
  s.cameras = {camera_at({0, 0, 0}, 1)};
  return s;
}

}  // namespace analytic
