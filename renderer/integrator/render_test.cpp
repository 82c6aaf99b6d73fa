// Bits, crops, passes and settings. What the pictures should be is asked in reference/.

#include "integrator/render.h"

#include <gtest/gtest.h>

#include <cmath>

namespace integrator {
namespace {

using math::Vec3;

// A unit-radius UV sphere with smooth normals, counter-clockwise from outside.
scene::Mesh sphere(int segments) {
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

// Seen from inside, with a smaller glossy sphere of odd placement.
scene::Scene two_spheres() {
  scene::Scene s;
  s.meshes = {sphere(24), sphere(8)};
  s.meshes[0].normals.clear();
  s.meshes[1].material = 1;
  s.materials.resize(2);
  s.materials[0].base_color = Vec3(.5f);
  s.materials[0].metallic = 0;
  s.materials[0].double_sided = true;
  s.materials[0].emission = Vec3(.2f);
  s.materials[1].roughness = .3f;
  s.instances = {{0}, {1, math::Mat4(.2f)}};
  s.instances[1].to_world[3] = math::Vec4(.1f, 0, -.6f, 1);
  s.cameras.resize(1);
  s.cameras[0].yfov = 1;
  return s;
}

Settings small(Shader shader, int spp) {
  Settings s;
  s.shader = shader;
  s.width = s.height = 16;
  s.spp = spp;
  s.depth = 8;
  return s;
}

image::Film render(const scene::Scene& scene, const Settings& settings) {
  const Renderer renderer(scene, settings);
  image::Film film = renderer.film();
  EXPECT_TRUE(renderer.render(film, 0, settings.spp));
  EXPECT_EQ(film.rejected(), 0);
  return film;
}

TEST(Render, thread_count_passes_and_crop_do_not_change_a_bit) {
  const scene::Scene s = two_spheres();
  Settings settings = small(Shader::disney, 16);
  settings.width = settings.height = 40;
  settings.threads = 1;
  const image::Film one = render(s, settings);

  for (const int threads : {2, 7}) {
    settings.threads = threads;
    const image::Film many = render(s, settings);
    for (int y = 0; y < 40; ++y)
      for (int x = 0; x < 40; ++x)
        ASSERT_EQ(one.mean(x, y), many.mean(x, y)) << x << ", " << y << ", threads " << threads;
  }
  const Renderer renderer(s, settings);
  image::Film passes = renderer.film();
  for (int first = 0; first < 16; first += 4) renderer.render(passes, first, 4);
  settings.crop_x = 5, settings.crop_y = 9, settings.crop_width = 20, settings.crop_height = 13;
  const image::Film crop = render(s, settings);
  for (int y = 0; y < 13; ++y)
    for (int x = 0; x < 20; ++x) {
      ASSERT_EQ(one.mean(5 + x, 9 + y), passes.mean(5 + x, 9 + y));
      ASSERT_EQ(one.mean(5 + x, 9 + y), crop.mean(x, y));
    }
}

TEST(Render, positions_and_normals_may_be_negative) {
  const scene::Scene s = two_spheres();
  for (const Shader shader : {Shader::position, Shader::normal}) {
    const image::Film film = render(s, small(shader, 8));  // which expects no rejected sample
    EXPECT_LT(film.mean(1, 2).x * film.mean(14, 2).x, 0);
  }
}

TEST(Render, settings_that_make_no_sense_are_named) {
  const scene::Scene s = two_spheres();
  Settings settings = small(Shader::path, 10);
  settings.replicates = 3;
  EXPECT_THROW(
      try { Renderer(s, settings); } catch (const std::exception& e) {
        EXPECT_NE(std::string(e.what()).find("--replicates"), std::string::npos);
        throw;
      },
      std::exception);
  settings.replicates = 2;
  settings.d_gamma = std::nanf("");
  EXPECT_ANY_THROW(Renderer(s, settings));
}

}  // namespace
}  // namespace integrator
