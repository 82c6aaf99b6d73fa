// Edits of every kind, against a new renderer of the edited scene: every bit. Mixing, order, errors.
#include "view/session.h"

#include <gtest/gtest.h>

#include <cmath>

#include "base/error.h"
#include "gltf/load.h"

namespace view {
namespace {

using math::Vec3;

app::Options options(const std::string& scene, std::vector<std::string> more = {}) {
  std::vector<std::string> words = {ASSAY_SOURCE_DIR "/regression/scenes/" + scene};
  words.insert(words.end(), more.begin(), more.end());
  return app::parse_command_line(words);
}
app::Options small(std::vector<std::string> more = {}) {
  more.insert(more.begin(), {"--width", "48", "--height", "20"});
  if (std::count(more.begin(), more.end(), "--spp") == 0) more.insert(more.begin(), {"--spp", "8"});
  return options("basic_pl.glb", more);
}

// A new renderer of the edited scene; `sky` as the viewer should have chosen it.
image::Film fresh(const State& state, int samples, const std::optional<scene::Environment>& sky = {}) {
  scene::Scene scene = gltf::load(state.options.text("scene"));
  scene.materials = state.materials;
  scene.lights = state.lights;
  if (sky) scene.environment = sky;
  integrator::Settings settings = complete_options(state).render;
  if (state.camera) {
    scene.cameras.push_back(state.camera->camera());
    settings.camera = static_cast<int>(scene.cameras.size()) - 1;
  }
  const integrator::Renderer renderer(scene, settings);
  image::Film film = renderer.film();
  renderer.render(film, 0, samples);
  return film;
}

// The session's picture after `edit` is that of a new renderer, and not the one before.
void expect_as_fresh(Session& session, const State& state, const char* what,
                     const std::optional<scene::Environment>& sky = {}) {
  const auto before = session.frame();
  const auto frame = session.wait(session.edit(state), 1, 3);
  ASSERT_TRUE(frame) << what;
  ASSERT_EQ(frame->problem, "") << what;
  EXPECT_EQ(frame->mean.pixels, fresh(state, frame->samples, sky).mean_image().pixels) << what;
  if (before && before->divisor == 1) {
    EXPECT_NE(before->mean.pixels, frame->mean.pixels) << what << ": nothing changed";
  }
}

TEST(Session, after_every_kind_of_edit_the_picture_is_that_of_a_new_renderer) {
  Session session(small());
  State s = session.original().state;
  ASSERT_TRUE(session.wait(1, 1, 3));
  const auto expect = [&](const char* what, const std::optional<scene::Environment>& sky = {}) {
    expect_as_fresh(session, s, what, sky);
  };
  s.materials[1].roughness = .7f, expect("roughness");
  s.materials[1].base_color = {.9f, .1f, .4f}, expect("base colour");
  s.set("shader", "path_disney"), expect("shader");
  s.d_gamma = 1, expect("d_gamma");
  s.d_constant = .05f, expect("d_constant");
  s.d_constant.reset(), expect("d_constant auto");
  s.set("shader", "principled"), expect("another shader");
  s.set("depth", 2), expect("depth");
  s.camera.emplace(session.original().cameras[0], 12), s.camera->turn(.3, .1), expect("camera turned");
  s.camera->dolly(.8), expect("camera nearer");
  s.camera.reset(), expect("the file's camera again");
  s.materials[2].emission = {3, 2, 1}, expect("a material begins to emit");
  s.materials[2].emission = {1, 2, 5}, expect("emits another colour");
  s.materials[2].emission = Vec3(0), expect("emits no more");
  s.lights[0].intensity *= .5f, expect("a lamp dimmed");
  s.lights[1].position.x -= 3, expect("a lamp moved");
  s.lights[0].intensity = s.lights[1].intensity = Vec3(0);
  expect("all dark: a neutral sky", scene::Environment{*session.original().neutral, 1, 0});
  const scene::Bitmap red = {"red", 1, 1, {{1, .2f, .1f, 1}}};
  s.sky = {std::make_shared<const scene::Bitmap>(red), .5f, 90};
  expect("a sky", scene::Environment{red, .5f, 90 * math::pi / 180});
  s.sky->strength = 2, expect("a stronger sky", scene::Environment{red, 2, 90 * math::pi / 180});
  s.camera.emplace(session.original().cameras[0], 12), s.camera->look(0, .4);
  expect("camera up", scene::Environment{red, 2, 90 * math::pi / 180});
  s.set("hide-environment", true), expect("hidden", scene::Environment{red, 2, 90 * math::pi / 180});
  s = session.original().state, s.set("width", 40), s.set("height", 30), expect("size");
  s.set("filter", "triangle"), expect("filter");
  s.set("sampler", "random"), expect("sampler");
  s.materials[0].double_sided = !s.materials[0].double_sided;
  s.materials[1].alpha_mode = scene::AlphaMode::blend, s.materials[1].alpha = .5f, expect("transparent");
}

TEST(Session, edits_of_lamps_and_of_a_spots_cones_make_new_lights) {
  Session session(options("punctual.glb", {"--width", "48", "--height", "36", "--spp", "8"}));
  State s = session.original().state;
  const auto spot = std::find_if(s.lights.begin(), s.lights.end(), [](const scene::Light& light) {
    return light.kind == scene::LightKind::spot;
  });
  ASSERT_NE(spot, s.lights.end());
  ASSERT_TRUE(session.wait(1, 1, 3));
  spot->cos_outer = std::cos(.9f), expect_as_fresh(session, s, "a wider spot");
  spot->cos_inner = std::cos(.85f), expect_as_fresh(session, s, "a sharper edge");
  spot->intensity *= 3.f, expect_as_fresh(session, s, "a brighter spot");
  for (scene::Light& light : s.lights)
    if (light.kind == scene::LightKind::directional) light.intensity = Vec3(0);
  expect_as_fresh(session, s, "no sun");
}

TEST(Session, the_camera_menu_switches_the_rendered_camera) {
  Session session(small());
  ASSERT_EQ(session.original().cameras.size(), 2u);
  State s = session.original().state;
  ASSERT_TRUE(session.wait(1, 1, 3));
  s.set("camera", "1");
  expect_as_fresh(session, s, "camera 1");
  s.set("camera", "0");
  expect_as_fresh(session, s, "camera 0");
}

// What is equal is not rendered again.
TEST(State, every_edit_makes_another_state) {
  Session session(options("punctual.glb", {"--width", "8", "--height", "8", "--spp", "1"}));
  const State before = session.original().state;
  using Edit = void (*)(State&);
  const Edit edits[] = {[](State& s) { s.set("shader", "path_disney"); },
                        [](State& s) { s.set("depth", 3); },
                        [](State& s) { s.d_gamma = 1; },
                        [](State& s) { s.d_constant = .1f; },
                        [](State& s) { s.materials[1].sheen_tint = .25f; },
                        [](State& s) { s.lights[2].cos_inner = 1; },
                        [](State& s) { s.lights[0].intensity.x += 1; },
                        [](State& s) { s.camera.emplace(scene::Camera{}, 2); },
                        [](State& s) { s.sky.emplace(); }};
  for (const Edit& edit : edits) {
    State after = before;
    EXPECT_TRUE(after == before);
    edit(after);
    EXPECT_FALSE(after == before) << "edit " << &edit - edits;
  }
}

// The albedo is the material's colour, noise-free: one look at a pixel tells which state it is of.
TEST(Session, no_frame_mixes_samples_of_two_states) {
  std::mutex mutex;
  std::vector<std::shared_ptr<const Frame>> seen;
  Session* self = nullptr;
  Session session(small({"--shader", "albedo", "--spp", "16"}), [&] {
    const std::lock_guard lock(mutex);
    if (self) seen.push_back(self->frame());
  });
  {
    const std::lock_guard lock(mutex);
    self = &session;
  }
  State s = session.original().state;
  for (int i = 0; i < 300; ++i) {
    for (scene::Material& m : s.materials) {
      m.base_color = Vec3(static_cast<float>(i + 1) / 512);
      m.specular = m.metallic = 0;
      m.base_color_texture = {};
    }
    const std::uint64_t generation = session.edit(s);
    if (i % 20 == 10) {  // however slow the machine: some are seen
      ASSERT_TRUE(session.wait(generation, 64, 1));
    }
    if (i % 7 == 0) std::this_thread::sleep_for(std::chrono::microseconds(300 * (i % 11)));
  }
  ASSERT_TRUE(session.wait(301, 1, 16));
  const std::lock_guard lock(mutex);
  self = nullptr;
  std::uint64_t last = 0;
  size_t full = 0;
  for (const auto& frame : seen) {
    EXPECT_GE(frame->generation, last) << "time runs backwards";
    last = frame->generation;
    full += frame->divisor == 1;
    if (frame->generation < 2) continue;
    // The mean of equal samples may be rounded once.
    const float wanted = static_cast<float>(frame->generation - 1) / 512;
    for (size_t i = frame->mean.pixels.size() / 2; i < frame->mean.pixels.size(); ++i)  // no background there
      ASSERT_NEAR(frame->mean.pixels[i].x, wanted, 1e-6f) << "generation " << frame->generation;
  }
  EXPECT_EQ(last, 301u);
  EXPECT_GE(seen.size(), 10u);
  EXPECT_GE(full, 1u);
}

TEST(Session, previews_come_first_and_get_finer) {
  std::mutex mutex;
  std::vector<int> divisors;
  Session* self = nullptr;
  Session session(options("basic_pl.glb", {"--width", "320", "--height", "136"}), [&] {
    const std::lock_guard lock(mutex);
    if (self && self->frame()->generation == 2) divisors.push_back(self->frame()->divisor);
  });
  ASSERT_TRUE(session.wait(1, 1, 1));
  {
    const std::lock_guard lock(mutex);
    self = &session;
  }
  State s = session.original().state;
  s.materials[1].roughness = .6f;
  ASSERT_TRUE(session.wait(session.edit(s), 1, 2));
  const std::lock_guard lock(mutex);
  self = nullptr;
  ASSERT_GE(divisors.size(), 2u);
  EXPECT_GT(divisors[0], 1);
  for (size_t i = 1; i < divisors.size(); ++i) EXPECT_LE(divisors[i], divisors[i - 1]);
}

TEST(Session, stops_when_all_samples_are_there) {
  Session session(small({"--spp", "24"}));
  const auto frame = session.wait(1, 1, 24);
  ASSERT_TRUE(frame);
  EXPECT_TRUE(frame->complete);
  std::this_thread::sleep_for(std::chrono::milliseconds(50));
  EXPECT_EQ(session.frame(), frame);
  EXPECT_GT(frame->rays, 48u * 20 * 24);
  EXPECT_EQ(frame->variance.pixels, fresh(session.original().state, 24).variance_image().pixels);
}

TEST(Session, an_impossible_state_is_said_and_the_next_one_works) {
  Session session(small());
  State s = session.original().state;
  s.set("shader", "path_disney");
  s.d_gamma = 11;
  const auto frame = session.wait(session.edit(s), 1, 1);
  ASSERT_TRUE(frame);
  EXPECT_NE(frame->problem.find("d-gamma"), std::string::npos) << frame->problem;
  EXPECT_THROW(session.save_image("/tmp/never.exr", {}).get(), base::Error);
  s.d_gamma = 3;
  expect_as_fresh(session, s, "valid again");
}

TEST(Session, what_cannot_be_loaded_is_an_error_and_no_thread_is_left) {
  EXPECT_THROW(Session(options("no_such_scene.glb")), base::Error);
  EXPECT_THROW(Session(small({"--camera", "none"})), base::Error);
  EXPECT_THROW(Session(small({"--crop", "0,0,8,8"})), base::Error);
}

TEST(Session, a_point_names_the_material_that_is_seen_there) {
  Session session(small());
  ASSERT_TRUE(session.wait(1, 1, 1));
  std::optional<surface::Point> middle;
  for (int i = 0; i < 1000 && !middle; ++i) middle = session.pick(.5f, .5f);
  ASSERT_TRUE(middle);
  const scene::Material& green =
      session.original().state.materials[static_cast<size_t>(session.material_of(middle->instance))];
  EXPECT_GT(green.base_color.y, green.base_color.x);
  EXPECT_NEAR(middle->position.x, 0, .1f);
  EXPECT_FALSE(session.pick(.5f, -5));
}

}  // namespace
}  // namespace view
