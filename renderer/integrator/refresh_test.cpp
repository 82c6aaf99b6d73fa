// A renderer that was refreshed after edits against a new one: every bit.

#include <gtest/gtest.h>

#include <functional>
#include <thread>

#include "integrator/render.h"
#include "surface/surface.h"

namespace integrator {
namespace {

using math::Vec3;

// A floor, a tilted wall with a texture, a lamp above; two cameras.
scene::Scene room() {
  const auto square = [](const Vec3& corner, const Vec3& side, const Vec3& other, int material) {
    scene::Mesh m;
    m.positions = {corner, corner + side, corner + side + other, corner + other};
    m.texcoords[0] = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
    m.triangles = {{0, 1, 2}, {0, 2, 3}};
    m.material = material;
    return m;
  };
  scene::Scene s;
  s.meshes = {square({-2, 0, 2}, {4, 0, 0}, {0, 0, -4}, 0), square({-1, .2f, 0}, {2, 0, 0}, {0, 1, -.7f}, 1),
              square({-.5f, 2.5f, -.5f}, {1, 0, 0}, {0, 0, 1}, 2)};
  s.instances = {{0}, {1}, {2}};
  s.materials.resize(3);
  for (scene::Material& m : s.materials) m.double_sided = true, m.metallic = 0;
  s.materials[2].emission = {8, 7, 6};
  s.bitmaps = {
      {"check", 2, 2, {{.9f, .2f, .1f, 1}, {.2f, .8f, .3f, 1}, {.1f, .2f, .9f, .4f}, {.5f, .5f, .5f, 1}}}};
  s.materials[1].base_color_texture.bitmap = 0;
  s.lights = {{"lamp", scene::LightKind::point, {3, 3, 3}, {1, 2, 2}}};
  s.cameras.resize(2);
  s.cameras[0].to_world[3] = {0, 1, 4, 1};
  s.cameras[1].to_world[3] = {.5f, 1.5f, 3, 1};
  return s;
}

std::vector<Vec3> picture(const Renderer& renderer, int spp) {
  image::Film film = renderer.film();
  EXPECT_TRUE(renderer.render(film, 0, spp));
  return film.mean_image().pixels;
}

TEST(Refresh, after_each_of_many_edits_every_bit_is_that_of_a_new_renderer) {
  scene::Scene s = room();
  Settings settings;
  settings.width = 24, settings.height = 16, settings.spp = 4, settings.replicates = 2, settings.depth = 4;
  Renderer kept(s, settings);
  std::vector<Vec3> last = picture(kept, 4);
  const struct {
    const char* name;
    bool lights;
    std::function<void()> apply;
  } edits[] = {
      {"camera", false, [&] { settings.camera = 1; }},
      {"camera moved", false, [&] { s.cameras[1].to_world[3].x = -.4f; }},
      {"roughness", false, [&] { s.materials[1].roughness = .2f; }},
      {"model that filters textures otherwise", false, [&] { settings.shader = Shader::principled; }},
      {"path_disney", false, [&] { settings.shader = Shader::path_disney; }},
      {"d_gamma", false, [&] { settings.d_gamma = 1; }},
      {"d_constant", false, [&] { settings.d_constant = .01f; }},
      {"lamp off", true, [&] { s.materials[2].emission = Vec3(0); }},
      {"another material emits", true,
       [&] {
         s.materials[1].emission = {1, .5f, .2f};
       }},
      {"light moved", true, [&] { s.lights[0].position.x = -1; }},
      {"environment", true,
       [&] {
         s.environment = {{"sky", 1, 1, {{.3f, .4f, .5f, 1}}}, 1, 0};
       }},
      {"path", false, [&] { settings.shader = Shader::path; }},
      {"no BSDF samples of light: the environment is drawn otherwise", false,
       [&] { settings.shader = Shader::path_nomis; }},
      {"culled", true, [&] { s.materials[1].double_sided = false; }},
      {"masked", true, [&] { s.materials[1].alpha_mode = scene::AlphaMode::mask; }},
      {"size", false, [&] { settings.width = 20, settings.height = 20; }},
      // 4 samples of the 94 pixels that see the floor: paths beyond a second bounce need more.
      {"threads", false, [&] { settings.threads = 3, settings.depth = 1; }},
      {"crop", false, [&] { settings.crop_width = settings.crop_height = 9; }}};
  for (const auto& edit : edits) {
    edit.apply();
    kept.refresh(settings, edit.lights);
    const std::vector<Vec3> now = picture(kept, 4);
    EXPECT_NE(now, last) << edit.name;
    EXPECT_EQ(now, picture(Renderer(s, settings), 4)) << edit.name;
    last = now;
  }
}

TEST(Refresh, refuses_what_a_new_renderer_refuses) {
  const scene::Scene s = room();
  Renderer renderer(s, {});
  Settings settings;
  settings.camera = 2;
  EXPECT_ANY_THROW(renderer.refresh(settings, false));
}

TEST(Render, a_raised_stop_ends_the_call_before_the_work_is_done) {
  const scene::Scene s = room();
  Settings settings;
  settings.width = settings.height = 1024;
  const Renderer renderer(s, settings);
  image::Film film = renderer.film();
  std::atomic<bool> stop{true};
  EXPECT_FALSE(renderer.render(film, 0, 8, {}, {}, &stop));
  EXPECT_EQ(renderer.rays(), 0u);
  stop = false;
  std::thread other([&] {
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
    stop = true;
  });
  EXPECT_FALSE(renderer.render(film, 0, 64, {}, {}, &stop)) << "64 million paths in 20 ms?";
  other.join();
}

TEST(Render, the_first_surface_is_what_the_layers_show) {
  const scene::Scene s = room();
  Settings settings;
  settings.width = 30, settings.height = 20;
  const Renderer renderer(s, settings);
  const image::Image positions = renderer.first_hit(Shader::position);
  int hits = 0;
  for (int y = 0; y < 20; ++y)
    for (int x = 0; x < 30; ++x) {
      const auto p = renderer.first_surface(static_cast<float>(x) + .5f, static_cast<float>(y) + .5f);
      EXPECT_EQ(p ? p->position : Vec3(0), positions.at(x, y));
      hits += p.has_value();
    }
  EXPECT_GT(hits, 100);
  EXPECT_LT(hits, 600);
}

}  // namespace
}  // namespace integrator
