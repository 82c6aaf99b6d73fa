// The whole renderer on scenes whose answers are arithmetic. Fixed seeds; a fresh seed would fail a 4 sigma
// check once in 16,000.

#include <gtest/gtest.h>

#include "analytic/scenes.h"
#include "integrator/render.h"

namespace analytic {
namespace {

using integrator::Renderer;
using integrator::Settings;
using integrator::Shader;

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

TEST(ClosedForm, inside_a_closed_emitting_sphere_radiance_is_a_geometric_series) {
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

TEST(ClosedForm, depth_counts_scattering_events) {
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

TEST(ClosedForm, a_lambert_floor_under_a_point_light_follows_the_formula) {
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

TEST(ClosedForm, parallel_unit_squares_exchange_light_by_their_form_factor) {
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

TEST(ClosedForm, a_lambert_sphere_in_a_white_furnace_shows_its_albedo) {
  scene::Scene s;
  s.meshes = {sphere(32)};
  s.meshes[0].normals.clear();
  s.materials = {lambert(.6f)};
  s.instances = {{0}};
  s.cameras = {camera_at({0, 0, 5}, .2f)};
  s.environment = scene::Environment{{"white", 1, 1, {math::Vec4(1)}}, 1, 0};
  for (const Shader shader : {Shader::path, Shader::path_nomis}) {
    double mean, error;
    mean_and_error(render(s, small(shader, 64)), mean, error);
    EXPECT_NEAR(mean, .6, 4 * error + 1e-4) << static_cast<int>(shader);
    EXPECT_LT(error, 3e-3);
  }
}

TEST(ClosedForm, a_stack_of_blended_layers_dims_by_the_product_of_what_each_lets_through) {
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

}  // namespace
}  // namespace analytic
