// Whole renders of the BRDF: a sphere in a white furnace shows Burley's directional albedos, a glossy mirror
// a disc of light, and edge materials only finite pixels. Rows B07, B10, B19 and B20 of docs/bsdf-tests.md.
#include <gtest/gtest.h>

#include "analytic/scenes.h"
#include "integrator/render.h"

namespace analytic {
namespace {

using integrator::Renderer;
using integrator::Settings;
using integrator::Shader;

scene::Environment white() { return {{"white", 1, 1, {math::Vec4(1)}}, 1, 0}; }

struct Furnace {
  const char* name;
  Shader shader;
  float roughness, metallic, specular;
  double albedo[4];  // at cos 1, .5, .2, .1: hard cases 1.4
};

class WhiteFurnace : public ::testing::TestWithParam<Furnace> {};

// B07. An orthographic camera sees a unit sphere; at distance r from its centre the angle to the eye has the
// cosine sqrt(1 - r^2). At each of four cosines a window of an image of 2048 x 2048 is rendered; the mean
// over the pixels of a bin of cosines is the published albedo within 1 % and 4 standard errors.
TEST_P(WhiteFurnace, sphere_shows_the_published_albedo_at_every_angle) {
  const Furnace& f = GetParam();
  scene::Scene s;
  s.meshes = {sphere(256)};
  scene::Material m;
  m.base_color = math::Vec3(1);
  m.metallic = f.metallic, m.roughness = f.roughness, m.specular = f.specular;
  s.materials = {m};
  s.instances = {{0}};
  scene::Camera c = camera_at({0, 0, 4}, 1);
  c.orthographic = true;
  c.ymag = 1;
  s.cameras = {c};
  s.environment = white();

  constexpr double bins[4][2] = {{.9, 1}, {.45, .55}, {.18, .22}, {.09, .11}};
  constexpr int size = 2048, window = 32;
  for (int b = 0; b < 4; ++b) {
    const double middle = b ? (bins[b][0] + bins[b][1]) / 2 : 1;
    Settings settings;
    settings.shader = f.shader;
    settings.width = settings.height = size;
    settings.crop_width = settings.crop_height = window;
    settings.crop_x = std::min(
        size - window, static_cast<int>(size / 2 * (1 + std::sqrt(1 - middle * middle))) - window / 2);
    settings.crop_y = size / 2 - window / 2;
    settings.spp = 64;
    settings.depth = 1;
    const Renderer renderer(s, settings);
    image::Film film = renderer.film();
    ASSERT_TRUE(renderer.render(film, 0, settings.spp));
    EXPECT_EQ(film.rejected(), 0);
    double sum = 0, variance = 0;
    int n = 0;
    for (int y = 0; y < window; ++y)
      for (int x = 0; x < window; ++x) {
        const double u = (settings.crop_x + x + .5) * 2 / size - 1,
                     v = (settings.crop_y + y + .5) * 2 / size - 1;
        const double cosine = std::sqrt(std::max(0., 1 - u * u - v * v));
        if (cosine < bins[b][0] || cosine > bins[b][1]) continue;
        sum += film.mean(x, y).x;
        variance += film.variance_of_mean(x, y).x;
        ++n;
      }
    ASSERT_GT(n, 30);
    const double mean = sum / n, error = std::sqrt(variance) / n;
    std::printf("%s, cos %.2f: %.4f +- %.4f of %d pixels, published %.4f\n", f.name, middle, mean, error, n,
                f.albedo[b]);
    EXPECT_NEAR(mean, f.albedo[b], .01 * f.albedo[b] + 4 * error) << "at cos " << middle;
  }
}
INSTANTIATE_TEST_SUITE_P(
    Of, WhiteFurnace,
    ::testing::Values(
        Furnace{"metal_of_roughness_50", Shader::disney, .5f, 1, .5f, {.9158, .8551, .8315, .8543}},
        Furnace{"metal_of_roughness_100", Shader::disney, 1, 1, .5f, {.3069, .4091, .5114, .5579}},
        Furnace{
            "principled_metal_of_roughness_50", Shader::principled, .5f, 1, 0, {.9158, .8551, .8315, .8543}},
        Furnace{"principled_diffuse_of_roughness_50",
                Shader::principled,
                .5f,
                0,
                0,
                {1.0060, 1.0083, 1.0248, 1.0235}},
        Furnace{"principled_diffuse_of_roughness_100",
                Shader::principled,
                1,
                0,
                0,
                {1.0357, 1.0569, 1.2453, 1.3801}}),
    [](const auto& info) { return info.param.name; });

// A floor at z = 0 seen along -x and down at 45 degrees, through one narrow pixel.
scene::Scene floor_seen_at_45_degrees(const scene::Material& m) {
  scene::Scene s;
  s.meshes = {quad({-9, -9, 0}, {9, -9, 0}, {9, 9, 0}, {-9, 9, 0})};
  s.materials = {m};
  s.instances = {{0}};
  scene::Camera c;
  c.yfov = 1e-4f;
  const float r = std::sqrt(.5f);
  // Columns: right, up, backwards (towards the eye), position.
  c.to_world = math::Mat4(0, 1, 0, 0, -r, 0, r, 0, r, 0, r, 0, 4 * r, 0, 4 * r, 1);
  s.cameras = {c};
  return s;
}

// B20: alpha = .001 is .06 degrees. A disc of light of 5 degrees radius stands around the mirror direction,
// turned away from it by some degrees. Inside the floor shows its radiance. Outside, a disc whose edge is e
// degrees away needs facets tilted by e/2: of a GGX surface the share with slope beyond s alpha in one
// direction is (1 - s / sqrt(1 + s^2)) / 2 (a half plane of light; the disc is less). That is .003 one degree
// outside.
TEST(NearSpecularFloor, mirrors_a_disc_of_light_with_its_edge) {
  scene::Material m;
  m.base_color = math::Vec3(.9f);
  m.metallic = 1;
  m.roughness = 0;
  for (const double away : {0., 4., 6., 8.}) {
    scene::Scene s = floor_seen_at_45_degrees(m);
    // The disc, 64 triangles at distance 20, about the direction (-cos e, 0, sin e), e = 45 degrees + away.
    const double e = (45 + away) * 3.14159265358979 / 180, radius = 20 * std::tan(5 * 3.14159265358979 / 180);
    const math::Vec3 d(static_cast<float>(-std::cos(e)), 0, static_cast<float>(std::sin(e))), side(0, 1, 0),
        up = math::cross(side, d);
    scene::Mesh disc;
    disc.positions.push_back(d * 20.f);
    for (int i = 0; i <= 64; ++i) {
      const double phi = 2 * 3.14159265358979 * i / 64;
      disc.positions.push_back(d * 20.f + side * static_cast<float>(radius * std::cos(phi)) +
                               up * static_cast<float>(radius * std::sin(phi)));
    }
    for (unsigned i = 1; i <= 64; ++i) disc.triangles.push_back({0, i, i + 1});
    disc.material = 1;
    s.meshes.push_back(disc);
    s.materials.push_back(lambert(0));
    s.materials[1].emission = math::Vec3(2);
    s.instances.push_back({1});
    Settings settings;
    settings.shader = Shader::disney;
    settings.width = settings.height = 4;
    settings.spp = 1024;
    settings.depth = 1;
    const Renderer renderer(s, settings);
    image::Film film = renderer.film();
    ASSERT_TRUE(renderer.render(film, 0, settings.spp));
    double mean = 0;
    for (int y = 0; y < 4; ++y)
      for (int x = 0; x < 4; ++x) mean += film.mean(x, y).x / 16;
    const double f = .9 + .1 * std::pow(1 - std::sqrt(.5), 5);
    std::printf("mirror direction %.0f degrees from the disc's centre: %.5f of F L\n", away, mean / (2 * f));
    if (away < 5) {
      EXPECT_NEAR(mean, 2 * f, .02 * 2 * f);
    } else {
      const double slope = std::tan((away - 5) / 2 * 3.14159265358979 / 180) / .001;
      const double half_plane = (1 - slope / std::sqrt(1 + slope * slope)) / 2;
      EXPECT_LT(mean, half_plane * 2 * f);
      EXPECT_GT(mean, .5 * half_plane * 2 * f);
    }
  }
}

// B10: black, without specular: not a photon.
TEST(BlackFloor, is_exactly_black) {
  for (const Shader shader : {Shader::path, Shader::path_disney, Shader::principled}) {
    scene::Scene s = floor_seen_at_45_degrees(lambert(0));
    s.environment = white();
    Settings settings;
    settings.shader = shader;
    settings.width = settings.height = 4;
    settings.spp = 16;
    const Renderer renderer(s, settings);
    image::Film film = renderer.film();
    ASSERT_TRUE(renderer.render(film, 0, settings.spp));
    for (int y = 0; y < 4; ++y)
      for (int x = 0; x < 4; ++x) EXPECT_TRUE(math::is_black(film.mean(x, y)));
  }
}

// B19: texels of roughness exactly 0 and 1, anisotropic from 0 to 1: pbrt-v4 showed black dots there.
TEST(TexturedRoughness, of_zero_and_one_per_texel_is_finite_and_not_black) {
  scene::Material m;
  m.base_color = math::Vec3(.8f);
  m.metallic_roughness_texture.bitmap = 0;
  m.metallic_roughness_texture.filter = scene::Filter::nearest;
  for (const Shader shader : {Shader::path, Shader::path_disney, Shader::principled, Shader::disney})
    for (const float anisotropic : {0.f, 1.f}) {
      m.anisotropic = anisotropic;
      scene::Scene s = floor_seen_at_45_degrees(m);
      s.cameras[0].yfov = 1;
      s.meshes[0].texcoords[0] = {{0, 0}, {8, 0}, {8, 8}, {0, 8}};
      // G roughness, B metallic.
      constexpr std::uint16_t one = 65535;
      s.bitmaps = {
          {"checks", 2, 2, {{0, 0, one, one}, {0, one, one, one}, {0, one, 0, one}, {0, 0, 0, one}}}};
      s.environment = white();
      Settings settings;
      settings.shader = shader;
      settings.width = settings.height = 32;
      settings.spp = 256;
      settings.depth = 2;
      const Renderer renderer(s, settings);
      image::Film film = renderer.film();
      ASSERT_TRUE(renderer.render(film, 0, settings.spp));
      EXPECT_EQ(film.rejected(), 0);
      for (int y = 0; y < 32; ++y)
        for (int x = 0; x < 32; ++x) {
          ASSERT_TRUE(math::is_finite(film.mean(x, y)));
          ASSERT_GT(film.mean(x, y).x, .05f) << x << " " << y;
          ASSERT_LT(film.mean(x, y).x, 1.7f) << x << " " << y;
        }
    }
}

}  // namespace
}  // namespace analytic
