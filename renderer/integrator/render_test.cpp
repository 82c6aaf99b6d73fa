// Whole-renderer checks on scenes built in memory whose answers are arithmetic.

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

scene::Mesh quad(Vec3 a, Vec3 b, Vec3 c, Vec3 d) {  // counter-clockwise
  scene::Mesh m;
  m.positions = {a, b, c, d};
  m.triangles = {{0, 1, 2}, {0, 2, 3}};
  return m;
}

scene::Camera camera_at(Vec3 eye, float yfov) {  // looking along -z
  scene::Camera c;
  c.yfov = yfov;
  c.to_world[3] = math::Vec4(eye.x, eye.y, eye.z, 1);
  return c;
}

scene::Material lambert(float albedo) {
  scene::Material m;
  m.base_color = Vec3(albedo);
  m.metallic = 0;
  m.specular = 0;
  m.double_sided = true;
  return m;
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

// Mean over the film and the standard error of that mean, of the red channel.
void mean_and_error(const image::Film& film, double& mean, double& error) {
  mean = error = 0;
  for (int y = 0; y < film.height(); ++y)
    for (int x = 0; x < film.width(); ++x) {
      mean += film.mean(x, y).x;
      error += film.variance_of_mean(x, y).x;
    }
  const double n = film.width() * film.height();
  mean /= n;
  error = std::sqrt(error) / n;
}

// Inside a closed sphere of albedo a whose wall emits e, every radiance is e / (1 - a) (pbrt-v4's analytic
// scenes).
scene::Scene closed_sphere(float albedo, float emission) {
  scene::Scene s;
  s.meshes = {sphere(24)};
  s.meshes[0].normals.clear();
  s.materials = {lambert(albedo)};
  s.materials[0].emission = Vec3(emission);
  s.instances = {{0}};
  s.cameras = {camera_at({0, 0, 0}, 1)};
  return s;
}

TEST(Render, inside_a_closed_emitting_sphere_radiance_is_a_geometric_series) {
  const scene::Scene s = closed_sphere(.5f, .5f);
  for (const Shader shader : {Shader::path, Shader::path_nomis}) {
    Settings settings = small(shader, 256);
    settings.depth = 60;
    double mean, error;
    mean_and_error(render(s, settings), mean, error);
    EXPECT_NEAR(mean, 1, 4 * error + 1e-3) << static_cast<int>(shader);
    EXPECT_LT(error, 2e-3);
  }
}

TEST(Render, depth_counts_scattering_events) {
  const scene::Scene s = closed_sphere(.5f, .5f);
  double expected = 0;
  for (int depth = 0; depth <= 3; ++depth) {
    expected += .5 * std::pow(.5, depth);
    Settings settings = small(Shader::path, 64);
    settings.depth = depth;
    double mean, error;
    mean_and_error(render(s, settings), mean, error);
    EXPECT_NEAR(mean, expected, 4 * error + 1e-3) << "depth " << depth;
  }
}

TEST(Render, a_lambert_floor_under_a_point_light_follows_the_formula) {
  scene::Scene s;
  s.meshes = {quad({-50, -50, 0}, {50, -50, 0}, {50, 50, 0}, {-50, 50, 0})};
  s.materials = {lambert(.8f)};
  s.instances = {{0}};
  s.cameras = {camera_at({0, 0, 4}, .02f)};
  scene::Light light;
  light.intensity = Vec3(10);
  light.position = {1, 2, 3};
  s.lights = {light};
  double mean, error;
  mean_and_error(render(s, small(Shader::path, 16)), mean, error);
  const double d2 = 1 + 4 + 9;
  EXPECT_NEAR(mean, .8 / 3.14159265358979 * 10 / d2 * (3 / std::sqrt(d2)), 2e-5);
}

TEST(Render, parallel_unit_squares_exchange_light_by_their_form_factor) {
  // Unit squares one unit apart: F = 0.19982 (Howell, catalogue C-11). The receiver's mean irradiance is pi L
  // F.
  scene::Scene s;
  s.meshes = {quad({-.5f, -.5f, 0}, {.5f, -.5f, 0}, {.5f, .5f, 0}, {-.5f, .5f, 0}),
              quad({-.5f, -.5f, 1}, {-.5f, .5f, 1}, {.5f, .5f, 1}, {.5f, -.5f, 1})};
  s.materials = {lambert(1), lambert(0)};
  s.materials[1].emission = Vec3(3);
  s.materials[1].double_sided = false;  // seen through from the camera's side
  s.meshes[1].material = 1;
  s.instances = {{0}, {1}};
  scene::Camera c = camera_at({0, 0, 5}, 1);
  c.orthographic = true;
  c.ymag = .5f;
  s.cameras = {c};
  for (const Shader shader : {Shader::path, Shader::path_nomis}) {
    Settings settings = small(shader, 256);
    settings.depth = 1;
    double mean, error;
    mean_and_error(render(s, settings), mean, error);
    EXPECT_NEAR(mean, 3 * .1998249, 4 * error + 2e-4) << static_cast<int>(shader);
    EXPECT_LT(error, .002);
  }
}

TEST(Render, a_lambert_sphere_in_a_white_furnace_shows_its_albedo) {
  scene::Scene s;
  s.meshes = {sphere(32)};
  s.meshes[0].normals.clear();
  s.materials = {lambert(.6f)};
  s.instances = {{0}};
  s.cameras = {camera_at({0, 0, 5}, .2f)};
  s.environment = scene::Environment{{"white", 1, 1, {math::Vec4(1)}}, 1, 0};
  double mean, error;
  mean_and_error(render(s, small(Shader::path, 64)), mean, error);
  EXPECT_NEAR(mean, .6, 4 * error + 1e-4);
}

TEST(Render, thread_count_passes_and_crop_do_not_change_a_bit) {
  scene::Scene s = closed_sphere(.5f, .2f);
  s.meshes.push_back(sphere(8));
  s.materials.push_back(scene::Material{});
  s.materials[1].roughness = .3f;
  s.meshes[1].material = 1;
  s.instances.push_back({1, math::Mat4(.2f)});
  s.instances.back().to_world[3] = math::Vec4(.1f, 0, -.6f, 1);
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

TEST(Render, a_stack_of_blended_layers_dims_by_the_product_of_what_each_lets_through) {
  scene::Scene s;
  for (int i = 0; i < 4; ++i) {
    const float z = static_cast<float>(i);
    s.meshes.push_back(quad({-9, -9, z}, {9, -9, z}, {9, 9, z}, {-9, 9, z}));
    s.instances.push_back({i});
  }
  s.materials = {lambert(0)};
  s.materials[0].alpha_mode = scene::AlphaMode::blend;
  s.materials[0].alpha = .25f;
  s.cameras = {camera_at({0, 0, 8}, .2f)};
  s.environment = scene::Environment{{"white", 1, 1, {math::Vec4(1)}}, 1, 0};
  double mean, error;
  mean_and_error(render(s, small(Shader::path, 256)), mean, error);
  EXPECT_NEAR(mean, std::pow(.75, 4), 4 * error);
  EXPECT_GT(error, 0);
  s.materials[0].alpha_mode = scene::AlphaMode::mask;  // .25 < .5: nothing is left
  mean_and_error(render(s, small(Shader::path, 16)), mean, error);
  EXPECT_EQ(mean, 1);
}

TEST(Render, settings_that_make_no_sense_are_named) {
  const scene::Scene s = closed_sphere(.5f, .5f);
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
