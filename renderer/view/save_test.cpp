// What is saved is what assay-render makes with the command that is copied: byte for byte.
#include "view/save.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>

#include "base/error.h"
#include "gltf/load.h"
#include "image/exr.h"
#include "image/read.h"
#include "view/session.h"

namespace view {
namespace {

using math::Vec3;
namespace fs = std::filesystem;

std::string read(const std::string& file) {
  std::ifstream stream(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

// But for the second in which OpenImageIO wrote an .exr.
std::string timeless(const std::string& file) {
  std::string bytes = read(file);
  const size_t date = bytes.find("capDate");
  if (date != std::string::npos) bytes.replace(date + 19, 19, 19, '-');
  return bytes;
}

class Saving : public testing::Test {
 protected:
  void SetUp() override { fs::create_directories(folder_ + "/again"); }
  void TearDown() override { fs::remove_all(folder_); }
  std::string file(const std::string& name) const { return folder_ + "/" + name; }

  static app::Options options(const std::string& scene, std::vector<std::string> more = {}) {
    more.insert(more.begin(), scene.front() == '/' ? scene : ASSAY_SOURCE_DIR "/regression/scenes/" + scene);
    more.insert(more.end(), {"--width", "48", "--height", "32", "--spp", "16"});
    return app::parse_command_line(more);
  }

  // Saves the picture of `state`, runs the copied command for the same name in another folder, and compares.
  void expect_same_file(Session& session, const State& state, const std::string& name,
                        const image::Display& display = {}) {
    ASSERT_TRUE(session.wait(session.edit(state), 1, 16));
    session.save_image(file(name), display).get();
    std::string command = session.command(file(name), 16, display).get();
    ASSERT_TRUE(command.starts_with("assay-render ")) << command;
    const std::string target = " --out " + file(name);
    ASSERT_NE(command.find(target), std::string::npos) << command;
    command.replace(command.find(target), target.size(), " --out " + file("again/" + name));
    command.replace(0, 12, ASSAY_BINARY_DIR "/bin/assay-render");
    ASSERT_EQ(std::system((command + " --quiet").c_str()), 0) << command;
    EXPECT_TRUE(timeless(file(name)) == timeless(file("again/" + name)))
        << "differs from the picture of " << command;
    EXPECT_GT(read(file(name)).size(), 1000u);
  }

 private:
  const std::string folder_ = testing::TempDir() + "assay-view-save-" + std::to_string(getpid());
};

TEST_F(Saving, an_unedited_picture_is_assay_renders_file_exr_and_png) {
  Session session(options("basic_pl.glb", {"--shader", "path_disney", "--d-gamma", "1.3", "--seed", "5"}));
  const State state = session.original().state;
  expect_same_file(session, state, "a.exr");
  expect_same_file(session, state, "a.png", {1.5f, 2.2f, true});
  expect_same_file(session, state, "b.png");
  EXPECT_FALSE(fs::exists(file("a.scene.glb"))) << "nothing was edited";
}

TEST_F(Saving, an_edited_scene_goes_with_the_picture_and_makes_it_again) {
  Session session(options("basic_pl.glb", {"--depth", "4"}));
  State s = session.original().state;
  s.materials[1].roughness = .31f;
  s.materials[1].clearcoat = .9f;
  s.materials[2].anisotropic = .77f;
  s.materials[2].emission = {.123f, 4.5f, .7f};
  s.lights[0].intensity = {11, 222.2f, 33};
  s.lights[1].position = {.1f, 7, 3.3f};
  s.camera.emplace(session.original().cameras[0], 12.5);
  s.camera->turn(.37, .11);
  s.camera->dolly(.83);
  s.camera->shift(.01, .02);
  expect_same_file(session, s, "a.exr");
  EXPECT_TRUE(fs::exists(file("a.scene.glb")));
  scene::Bitmap sky{"sky", 4, 2, {}};
  for (int i = 0; i < 8; ++i) sky.texels.push_back({.1f * static_cast<float>(i), .3f, .2f, 1});
  s.sky = {std::make_shared<const scene::Bitmap>(sky), 1.7f, 33.3f};
  expect_same_file(session, s, "b.exr");
  s.sky = {std::make_shared<const scene::Bitmap>(scene::Bitmap{"one", 1, 1, {{.2f, .3f, .7f, 1}}}), .7f, 0};
  s.set("shader", "path_disney"), s.d_constant = .0123f;
  expect_same_file(session, s, "c.exr");
}

TEST_F(Saving, a_spot_with_other_cones_makes_the_same_picture_again) {
  Session session(options("punctual.glb"));
  State s = session.original().state;
  for (scene::Light& light : s.lights)
    if (light.kind == scene::LightKind::spot)
      light.cos_inner = std::cos(.2f), light.cos_outer = std::cos(1.1f);
  ASSERT_NE(s.lights, session.original().state.lights);
  expect_same_file(session, s, "a.exr");
}

TEST_F(Saving, options_for_light_stay_options_until_the_sky_is_edited) {
  Session session(options("textures.glb", {"--environment", ASSAY_SOURCE_DIR "/regression/scenes/sky.hdr"}));
  State s = session.original().state;
  expect_same_file(session, s, "a.exr");
  s.materials[0].base_color = {.5f, .25f, .125f};
  expect_same_file(session, s, "b.exr");
  s.sky = session.original().sky;
  s.sky->strength = 1.5f;
  expect_same_file(session, s, "c.exr");
  EXPECT_TRUE(fs::exists(file("c.scene.environment.exr")));
}

// expect_same_file() cannot see an option that both forget.
TEST_F(Saving, the_command_says_every_option_that_was_given_or_edited) {
  Session session(options("basic_pl.glb", {"--seed", "5", "--clamp", "3", "--hide-environment"}));
  State s = session.original().state;
  s.set("shader", "path_disney"), s.d_gamma = 1.25f, s.d_constant = .5f;
  s.set("depth", 3), s.set("sampler", "random"), s.set("filter", "triangle"), s.set("camera", "1");
  session.edit(s);
  const std::string command = session.command(file("a.png"), 24, {1.5f, 2.2f, true}).get();
  for (const char* word :
       {" --shader path_disney", " --d-gamma 1.25", " --d-constant 0.5", " --depth 3", " --clamp 3",
        " --camera 1", " --width 48", " --height 32", " --spp 24", " --seed 5", " --sampler random",
        " --filter triangle", " --hide-environment", " --exposure 1.5", " --gamma 2.2", " --filmic"})
    EXPECT_NE(command.find(word), std::string::npos) << word << " is not in " << command;
}

// Neither camera nor light: both are chosen, until somebody edits them.
TEST_F(Saving, what_a_bare_file_gets_by_default_is_what_assay_render_gives_it) {
  const std::string bare = file("bare.gltf");
  const scene::Scene from = gltf::load(ASSAY_SOURCE_DIR "/regression/scenes/basic_pl.glb");
  write_gltf(from.file, from.hash, bare, {});
  std::string text = read(bare);
  for (const char* key : {"\"camera\"", "\"KHR_lights_punctual\""})
    for (size_t at = 0; (at = text.find(key, at)) != std::string::npos; ++at) text[at + 1] = '_';
  std::ofstream(bare) << text;
  ASSERT_TRUE(gltf::load(bare).cameras.empty());
  ASSERT_TRUE(gltf::load(bare).lights.empty());

  Session session(options(bare));
  State s = session.original().state;
  expect_same_file(session, s, "a.exr");
  s.materials[1].metallic = 1;
  expect_same_file(session, s, "b.exr");
  s.camera.emplace(session.file_camera(s), 10);
  s.camera->turn(.5, 0);
  expect_same_file(session, s, "c.exr");
  s.materials[2].emission = {5, 5, 5};  // now there is a light: no sky
  expect_same_file(session, s, "d.exr");
}

TEST_F(Saving, a_scene_saved_as_gltf_reads_back_and_keeps_the_rest) {
  Session session(options("textures.glb"));
  State s = session.original().state;
  s.materials[0].sheen = .25f;
  session.edit(s);
  for (const char* name : {"saved.gltf", "saved.glb"}) {
    session.save_scene(file(name)).get();
    const scene::Scene saved = gltf::load(file(name));
    EXPECT_EQ(saved.materials, s.materials);
    EXPECT_EQ(saved.bitmaps.size(), session.bitmaps().size());
  }
}

TEST_F(Saving, what_cannot_be_written_is_an_error_and_the_session_lives) {
  Session session(options("basic_pl.glb"));
  const std::string scene = session.original().file;
  for (const char* name : {"no/folder/a.exr", "a.tiff", "a"})
    EXPECT_THROW(session.save_image(file(name), {}).get(), base::Error) << name;
  EXPECT_THROW(session.save_image(scene, {}).get(), base::Error);
  EXPECT_THROW(session.save_scene(scene).get(), base::Error);
  EXPECT_THROW(session.save_scene(file("a.obj")).get(), base::Error);
  expect_same_file(session, session.original().state, "a.exr");
}

TEST_F(Saving, what_was_to_be_saved_before_an_edit_is_refused_not_mixed) {
  Session session(options("cornell.glb", {"--depth", "20"}));
  State s = session.original().state;
  s.set("width", 1200), s.set("height", 1200);  // slow
  session.edit(s);
  auto late = session.save_image(file("a.exr"), {});
  s.materials[0].roughness = .5f;
  session.edit(s);
  EXPECT_THROW(late.get(), base::Error);
  EXPECT_FALSE(fs::exists(file("a.exr")));
}

}  // namespace
}  // namespace view
