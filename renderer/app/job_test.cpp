// Renders of a small scene through the same calls as the program: what may not matter does not, and the file
// says what happened.
#include "app/job.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "app/defaults.h"
#include "app/energy.h"
#include "app/test_scene.h"
#include "base/error.h"
#include "image/read_exr_test.h"

namespace app {
namespace {

using Words = std::vector<std::string>;

struct JobTest : testing::Test {
  Folder folder;
  std::string scene = write_scene(folder);
  Stage stage;
  Console console{true};

  Options options(Words words) {
    words.insert(words.begin(), {scene, "--width", "40", "--height", "24"});
    if (std::count(words.begin(), words.end(), "--spp") == 0) words.insert(words.end(), {"--spp", "16"});
    Options o = parse_command_line(words);
    complete(o);
    return o;
  }
  image::Exr rendered(const Words& words) {
    const std::string out = folder.file("out.exr");
    Words all = {"-o", out};
    all.insert(all.end(), words.begin(), words.end());
    Options o = options(all);
    run(o, stage, console);
    return image::read_exr(out);
  }
};

bool same(const image::Image& a, const image::Image& b) {
  return a.width == b.width && a.height == b.height && a.pixels == b.pixels;
}

template <typename Type>
Type header(const image::Exr& exr, const std::string& name) {
  const image::Metadata::Value* value = exr.metadata.find("assay:" + name);
  return value != nullptr && std::holds_alternative<Type>(*value) ? std::get<Type>(*value) : Type{};
}

TEST_F(JobTest, gives_the_same_bits_for_any_number_of_threads) {
  const image::Exr one = rendered({"--threads", "1"});
  EXPECT_GT(math::max_component(one.mean.at(20, 12)), .01f);
  for (const char* threads : {"2", "7"}) {
    const image::Exr many = rendered({"--threads", threads});
    EXPECT_TRUE(same(one.mean, many.mean)) << threads;
    EXPECT_TRUE(same(one.variance, many.variance)) << threads;
  }
  EXPECT_FALSE(same(one.mean, rendered({"--seed", "2"}).mean));
}

TEST_F(JobTest, renders_a_crop_as_the_same_pixels_of_the_whole) {
  const image::Exr whole = rendered({}), part = rendered({"--crop", "13,5,19,17"});
  ASSERT_EQ(part.mean.width, 19);
  ASSERT_EQ(part.mean.height, 17);
  for (int y = 0; y < 17; ++y)
    for (int x = 0; x < 19; ++x) ASSERT_EQ(part.mean.at(x, y), whole.mean.at(x + 13, y + 5)) << x << " " << y;
}

TEST_F(JobTest, gives_the_bits_of_one_pass_though_it_renders_in_many) {
  Options o = options({"-o", folder.file("passes.exr"), "--save-progress"});
  run(o, stage, console);
  const scene::Scene& s = stage.prepare(o);
  const integrator::Renderer renderer(s, o.render);
  image::Film film = renderer.film();
  renderer.render(film, 0, o.render.spp);
  EXPECT_TRUE(same(image::read_exr(o.text("out")).mean, film.mean_image()));
}

TEST_F(JobTest, adaptive_spends_its_samples_unevenly_and_the_same_for_any_number_of_threads) {
  const Words adaptive = {"--adaptive", "--spp", "64", "--layers", "samples,replicates"};
  const auto with = [&](const Words& more) {
    Words words = adaptive;
    words.insert(words.end(), more.begin(), more.end());
    return rendered(words);
  };
  const image::Exr one = with({"--threads", "1"}), many = with({"--threads", "5"});
  EXPECT_TRUE(same(one.mean, many.mean));
  EXPECT_TRUE(same(one.variance, many.variance));
  const auto layer = [&](const std::string& name) -> const image::Image& {
    return std::find_if(one.layers.begin(), one.layers.end(), [&](const auto& l) { return l.name == name; })
        ->image;
  };
  for (const char* replicates : {"1", "2"})  // too few to tell the noise by their spread
    EXPECT_TRUE(same(with({"--threads", "1", "--replicates", replicates}).mean,
                     with({"--threads", "5", "--replicates", replicates}).mean));
  const image::Image& counts = layer("samples");
  double sum = 0, least = 1e9, most = 0;
  for (const math::Vec3& n : counts.pixels)
    sum += n.x, least = std::min<double>(least, n.x), most = std::max<double>(most, n.x);
  EXPECT_NEAR(sum / static_cast<double>(counts.pixels.size()), 64, 1);
  EXPECT_GE(least, 16);  // the pilot
  EXPECT_GT(most, 100);
  EXPECT_NEAR(header<int>(one, "spp"), 64, 1);
  for (int c = 0; c < 3; ++c) {  // the picture is the mean of the replicates, whatever their counts
    float mean = 0;
    for (int k = 0; k < 8; ++k) mean += layer("replicate" + std::to_string(k)).at(21, 13)[c] / 8;
    EXPECT_NEAR(mean, one.mean.at(21, 13)[c], 1e-6f);
  }
}

TEST_F(JobTest, adaptive_wants_pixels_of_both_colors) {
  Options o = options({"--adaptive", "--spp", "64", "--crop", "5,5,1,1", "-o", folder.file("one.exr")});
  EXPECT_THROW(run(o, stage, console), base::Error);
}

TEST_F(JobTest, stops_at_the_noise_or_the_time_asked_for) {
  const auto run_with = [&](Words words) {
    words.insert(words.end(), {"-o", folder.file("stop.exr")});
    Options o = options(words);
    return run(o, stage, console);
  };
  // Low-discrepancy numbers converge faster than the pilot's spread promises: the noise is that or less.
  const Result loose = run_with({"--adaptive", "--spp", "64", "--noise", "0.2"}),
               tight = run_with({"--adaptive", "--spp", "64", "--noise", "0.1"});
  EXPECT_GT(tight.samples, 1.5 * loose.samples);
  EXPECT_LT(tight.noise, .11);
  EXPECT_GT(tight.noise, .02);
  Options timed = parse_command_line(
      {scene, "--width", "40", "--height", "24", "--time", "0.2", "-o", folder.file("stop.exr")});
  complete(timed);
  const Result result = run(timed, stage, console);
  EXPECT_GE(result.samples, 8);
  EXPECT_EQ(result.samples % 8, 0);
  EXPECT_LT(result.samples, 1 << 24);
  EXPECT_FALSE(result.partial);
  EXPECT_EQ(header<int>(image::read_exr(folder.file("stop.exr")), "spp"), result.samples);
}

TEST_F(JobTest, writes_the_whole_header) {
  const image::Exr exr =
      rendered({"--shader", "path_disney", "--d-constant", "0.005", "--clamp", "10", "--depth", "3"});
  EXPECT_EQ(header<std::string>(exr, "shader"), "path_disney");
  EXPECT_EQ(header<std::string>(exr, "scene_hash").size(), 64u);
  for (const char* name : {"version", "commit", "isa", "command"})
    EXPECT_NE(header<std::string>(exr, name), "") << name;
  EXPECT_EQ(header<std::string>(exr, "command")
                .rfind("assay-render scene.gltf --shader path_disney --d-constant 0.005", 0),
            0u);
  EXPECT_EQ(header<int>(exr, "spp"), 16);
  EXPECT_EQ(header<int>(exr, "replicates"), 8);
  EXPECT_EQ(header<int>(exr, "seed"), 1);
  EXPECT_EQ(header<int>(exr, "depth"), 3);
  EXPECT_EQ(header<int>(exr, "biased"), 1);
  EXPECT_NE(exr.metadata.find("assay:rejected"), nullptr);
  EXPECT_NE(exr.metadata.find("assay:partial"), nullptr);
  EXPECT_EQ(header<int>(exr, "partial"), 0);

  const std::string text = header<std::string>(exr, "options");
  const nlohmann::json decisive = nlohmann::json::parse(text);
  EXPECT_EQ(decisive.dump(), text) << "canonical: keys sorted, no blanks";
  EXPECT_EQ(decisive.at("d-constant"), .005);
  EXPECT_NE(text.find("\"d-constant\":0.005"), std::string::npos) << text;
  EXPECT_FALSE(decisive.contains("threads"));
}

TEST_F(JobTest, writes_the_environment_s_name_and_the_hash_of_its_bytes) {
  rendered({});  // any picture is an environment
  std::filesystem::rename(folder.file("out.exr"), folder.file("sky.exr"));
  const auto decides = [&] {
    return nlohmann::json::parse(
        header<std::string>(rendered({"--environment", folder.file("sky.exr")}), "options"));
  };
  const std::string hash = decides().at("environment_hash");
  EXPECT_EQ(decides().at("environment"), "sky.exr");
  std::FILE* sum = popen(("sha256sum " + folder.file("sky.exr")).c_str(), "r");
  char expected[65] = {};
  EXPECT_EQ(std::fread(expected, 1, 64, sum), 64u);
  pclose(sum);
  EXPECT_EQ(hash, expected);
  rendered({"--seed", "2"});
  std::filesystem::rename(folder.file("out.exr"), folder.file("sky.exr"));
  EXPECT_NE(decides().at("environment_hash"), hash) << "another picture of the same name";
}

TEST_F(JobTest, says_biased_only_if_clamped) { EXPECT_EQ(header<int>(rendered({}), "biased"), 0); }

TEST_F(JobTest, writes_the_layers_asked_for_and_replicates_whose_mean_is_the_picture) {
  EXPECT_TRUE(rendered({}).layers.empty());
  const image::Exr exr = rendered({"--layers", "albedo,normal,depth,position,replicates"});
  Words names;
  for (const image::Layer& layer : exr.layers) names.push_back(layer.name);
  for (const char* name : {"albedo", "normal", "depth", "position", "replicate0", "replicate7"})
    EXPECT_EQ(std::count(names.begin(), names.end(), name), 1) << name;
  math::Vec3 sum{0, 0, 0};
  for (const image::Layer& layer : exr.layers)
    if (layer.name.rfind("replicate", 0) == 0) sum += layer.image.at(20, 12);
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(sum[c] / 8, exr.mean.at(20, 12)[c], 1e-5f * sum[c]);
}

TEST_F(JobTest, writes_the_light_by_lobe_which_sums_to_the_picture) {
  for (const char* clamp : {"0", "0.2"}) {
    const image::Exr plain = rendered({"--clamp", clamp}),
                     exr = rendered({"--clamp", clamp, "--layers", "lobes"});
    EXPECT_TRUE(same(plain.mean, exr.mean));
    ASSERT_EQ(exr.layers.size(), 18u);
    math::Vec3 sum{0, 0, 0};
    int means = 0;
    for (const image::Layer& layer : exr.layers) {
      if (layer.name.ends_with(".variance")) continue;
      sum += layer.image.at(20, 12);
      ++means;
    }
    EXPECT_EQ(means, 9);
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(sum[c], exr.mean.at(20, 12)[c], 2e-6f * sum[c]);
  }
  EXPECT_ANY_THROW(rendered({"--layers", "lobes", "--shader", "normal"}));
}

TEST_F(JobTest, writes_each_kind_of_picture) {
  for (const char* name : {"a.hdr", "a.png", "a.jpg", "A.PNG"}) {
    Options o = options({"-o", folder.file(name)});
    run(o, stage, console);
    EXPECT_GT(std::filesystem::file_size(o.text("out")), 100u) << name;
  }
}

TEST_F(JobTest, finds_out_that_nothing_can_be_written_before_the_scene_is_even_read) {
  scene = folder.file("absent.glb");
  Options o = options({"-o", folder.file("no/such/folder/a.exr")});
  try {
    run(o, stage, console);
    FAIL();
  } catch (const base::Error& error) {
    EXPECT_NE(std::string(error.what()).find("there is no folder"), std::string::npos) << error.what();
  }
}

TEST_F(JobTest, takes_a_camera_by_index_or_name_and_names_those_there_are) {
  const image::Exr first = rendered({});
  EXPECT_TRUE(same(first.mean, rendered({"--camera", "0"}).mean));
  EXPECT_TRUE(same(first.mean, rendered({"--camera", "main"}).mean));
  try {
    rendered({"--camera", "mian"});
    FAIL();
  } catch (const base::Error& error) {
    EXPECT_NE(std::string(error.what()).find("0 'main'"), std::string::npos) << error.what();
    EXPECT_NE(std::string(error.what()).find("near 'main'"), std::string::npos) << error.what();
  }
  EXPECT_THROW(rendered({"--camera", "1"}), base::Error);
}

TEST_F(JobTest, leaves_the_scene_of_the_next_job_as_it_was_in_the_file) {
  const image::Exr before = rendered({});
  EXPECT_FALSE(same(before.mean, rendered({"--environment-color", "1,2,3"}).mean));
  EXPECT_TRUE(same(before.mean, rendered({}).mean));
}

TEST_F(JobTest, frames_everything_if_there_is_no_camera_and_lights_it_if_there_is_no_light) {
  scene = write_scene(folder, "bare", {false, false});
  Options o = options({"-o", folder.file("bare.exr"), "--layers", "depth"});
  run(o, stage, console);
  EXPECT_EQ(o.notes.size(), 2u);
  const image::Exr exr = image::read_exr(o.text("out"));
  const image::Image& depth = exr.layers.at(0).image;
  double lit = 0;
  int inside = 0, at_edge = 0;
  for (int y = 0; y < depth.height; ++y)
    for (int x = 0; x < depth.width; ++x) {
      lit += math::mean(exr.mean.at(x, y));
      if (depth.at(x, y).x == 0) continue;
      ++inside;
      at_edge += x == 0 || y == 0 || x == depth.width - 1 || y == depth.height - 1;
    }
  EXPECT_GT(inside, depth.width * depth.height / 8);
  EXPECT_EQ(at_edge, 0);
  EXPECT_GT(lit / (depth.width * depth.height), .1);

  // Neither default is there for the asking of another shader or colour.
  o = options({"-o", folder.file("bare.exr"), "--environment-color", "0,0,0"});
  run(o, stage, console);
  for (const math::Vec3& pixel : image::read_exr(o.text("out")).mean.pixels)
    ASSERT_TRUE(math::is_black(pixel));
}

TEST(FramingCamera, fills_the_view_to_a_margin_at_any_aspect) {
  scene::Scene box;
  box.meshes.emplace_back();
  for (int i = 0; i < 8; ++i)
    box.meshes[0].positions.push_back({(i & 1) ? 7.f : 3.f, (i & 2) ? 1.f : -1.f, (i & 4) ? 90.f : 89.5f});
  box.instances.emplace_back();
  for (const float aspect : {.3f, 1.f, 2.35f}) {
    const scene::Camera camera = framing_camera(box, aspect);
    float most_x = -1e9f, least_x = 1e9f, most_y = -1e9f, least_y = 1e9f;
    for (const math::Vec3& p : box.meshes[0].positions) {
      const math::Vec3 q = p - math::Vec3(camera.to_world[3]);
      const float z = -math::dot(q, math::Vec3(camera.to_world[2])) * std::tan(camera.yfov / 2);
      ASSERT_GT(z, 0);
      const float x = math::dot(q, math::Vec3(camera.to_world[0])) / (z * aspect);
      const float y = math::dot(q, math::Vec3(camera.to_world[1])) / z;
      most_x = std::max(most_x, x), least_x = std::min(least_x, x);
      most_y = std::max(most_y, y), least_y = std::min(least_y, y);
    }
    // The axis that decides is filled to the margin on both sides, the other holds less.
    const bool wide = most_x > most_y;
    EXPECT_NEAR(wide ? most_x : most_y, 1 / 1.08f, 1e-3f);
    EXPECT_NEAR(wide ? -least_x : -least_y, 1 / 1.08f, 1e-3f);
    EXPECT_LT(wide ? most_y : most_x, 1 / 1.08f);
    EXPECT_LT(wide ? -least_y : -least_x, 1 / 1.08f);
  }
}

TEST(Energy, warns_of_figure_7_and_not_of_figure_4) {
  scene::Scene scene;
  scene.materials.emplace_back();
  scene.materials[0].name = "blue";
  scene.materials[0].base_color = {.2f, .2f, .5f};
  scene.materials[0].metallic = 0;
  scene.materials[0].roughness = .05f;
  scene.meshes.emplace_back();
  scene.instances.emplace_back();
  integrator::Settings settings;
  settings.shader = integrator::Shader::path_disney;
  settings.d_constant = .005f;
  const std::string warning = energy_warning(scene, settings);
  EXPECT_NE(warning.find("material 'blue' (roughness 0.05) reflects up to "), std::string::npos) << warning;
  settings.d_constant = 1.989e-6f;
  EXPECT_EQ(energy_warning(scene, settings), "");
  // The lobe is proportional to its constant: 2513 times the normalised one adds 2513 times its albedo, about
  // .04.
  const double normalised = directional_albedo(scene.materials[0], 2, 1.989e-6f, 1);
  const double none = directional_albedo(scene.materials[0], 2, 0, 1);
  const double figure_7 = directional_albedo(scene.materials[0], 2, .005f, 1);
  EXPECT_NEAR((normalised - none) / .04, 1, .05);
  EXPECT_NEAR((figure_7 - none) / 2514 / (normalised - none), 1, .05);
}

}  // namespace
}  // namespace app
