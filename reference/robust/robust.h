// What the hard cases share: pictures as numbers, and how a test says what it measured (scripts/robustness
// reads it).
#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <sstream>

#include "analytic/scenes.h"
#include "integrator/render.h"

namespace robust {

using analytic::Vec3;
using integrator::Settings;
using integrator::Shader;

template <typename... Parts>
void measured(const Parts&... parts) {
  std::ostringstream text;
  text.precision(3);
  (text << ... << parts);
  testing::Test::RecordProperty("measured", text.str());
}

inline Settings settings(int size, int spp, Shader shader = Shader::disney, int depth = 4) {
  Settings s;
  s.shader = shader;
  s.width = s.height = size;
  s.spp = spp;
  s.replicates = spp % 8 == 0 ? 8 : 1;
  s.depth = depth;
  return s;
}

struct Picture {
  int width = 0;
  std::vector<Vec3> mean, variance;
  double average = 0, error = 0;  // of the red channel over the picture, and its standard error

  const Vec3& at(int x, int y) const { return mean[static_cast<size_t>(y * width + x)]; }
};

inline Picture render(const scene::Scene& scene, const Settings& settings) {
  const integrator::Renderer renderer(scene, settings);
  image::Film film = renderer.film();
  EXPECT_TRUE(renderer.render(film, 0, settings.spp));
  EXPECT_EQ(film.rejected(), 0);
  Picture p;
  p.width = film.width();
  for (int y = 0; y < film.height(); ++y)
    for (int x = 0; x < film.width(); ++x) {
      p.mean.push_back(film.mean(x, y));
      p.variance.push_back(film.variance_of_mean(x, y));
      p.average += p.mean.back().x, p.error += p.variance.back().x;
    }
  const double n = static_cast<double>(p.mean.size());
  p.average /= n, p.error = std::sqrt(p.error) / n;
  return p;
}

inline scene::Environment constant(float radiance) {
  return {{"constant", 1, 1, {math::Vec4(radiance, radiance, radiance, 1)}}, 1, 0};
}

inline scene::Light point(const Vec3& position, float intensity) {
  scene::Light l;
  l.position = position;
  l.intensity = Vec3(intensity);
  return l;
}

// From 6 metres above the origin, straight down.
inline scene::Camera looks_down(float yfov) {
  scene::Camera c;
  c.yfov = yfov;
  c.to_world = math::Mat4(1, 0, 0, 0, 0, 0, -1, 0, 0, 1, 0, 0, 0, 6, 0, 1);
  return c;
}

// A square lamp of half side `half` at height y over the origin, shining down.
inline scene::Mesh lamp(float half, float y) {
  return analytic::quad({-half, y, -half}, {half, y, -half}, {half, y, half}, {-half, y, half});
}

// Floor, glossy ball, lamp: everything an ordinary picture has.
inline scene::Scene still_life() {
  scene::Scene s;
  s.meshes = {analytic::quad({-3, 0, 3}, {3, 0, 3}, {3, 0, -3}, {-3, 0, -3}), analytic::sphere(16),
              lamp(.7f, 4)};
  s.materials.resize(3);
  s.materials[0] = analytic::lambert(.6f);
  s.materials[1].base_color = {.8f, .5f, .3f};
  s.materials[1].metallic = .5f, s.materials[1].roughness = .3f, s.materials[1].clearcoat = 1;
  s.materials[2].emission = Vec3(5);
  s.materials[2].double_sided = true;
  s.instances = {{0}, {1}, {2}};
  for (int i = 0; i < 3; ++i) s.meshes[static_cast<size_t>(i)].material = i;
  s.instances[1].to_world[3] = math::Vec4(0, 1, 0, 1);
  s.cameras = {analytic::camera_at({0, 1.2f, 6}, .6f)};
  return s;
}

inline int different_pixels(const Picture& a, const Picture& b) {
  int count = a.mean.size() == b.mean.size() ? 0 : 1 << 30;
  for (size_t i = 0; i < a.mean.size() && count < 1 << 30; ++i) count += a.mean[i] != b.mean[i];
  return count;
}

// Largest distance of two pictures' pixels in their common standard deviations, all channels.
inline double largest_z(const Picture& a, const Picture& b, float floor = 1e-5f) {
  double worst = 0;
  for (size_t i = 0; i < a.mean.size(); ++i)
    for (int c = 0; c < 3; ++c)
      worst = std::max(
          worst, std::fabs(static_cast<double>(a.mean[i][c]) - b.mean[i][c]) /
                     std::sqrt(static_cast<double>(a.variance[i][c]) + b.variance[i][c] + floor * floor));
  return worst;
}

}  // namespace robust
