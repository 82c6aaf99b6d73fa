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

// With depth 0 a path is what its camera ray found, so paths that share rays count each of them as often: 8
// samples, two by two and then four by four, are 4 camera rays, those of 2 * 1, 2 * 2, 4 * 3.
TEST(Render, paths_that_share_camera_rays_take_the_next_ones_whatever_calls_they_came_in) {
  const scene::Scene s = two_spheres();
  Settings settings = small(Shader::disney, 8);
  settings.depth = 0;
  settings.replicates = 2;
  const Renderer renderer(s, settings);
  const auto until = [](int n) { return [n](int, int, int) { return n; }; };
  const auto together = [](int n) { return [n](int, int) { return Technique{n}; }; };
  image::Film shared = renderer.film(), torn = renderer.film();
  renderer.render(shared, until(0), until(4), {0, 0, together(2)});
  renderer.render(shared, until(4), until(8), {4, 2, together(4)});
  for (int i = 0; i < 8; ++i)
    renderer.render(torn, until(i), until(i + 1), {i < 4 ? 0 : 4, i < 4 ? 0 : 2, together(i < 4 ? 2 : 4)});
  std::vector<image::Film> rays;
  for (int i = 0; i < 3; ++i) {
    rays.push_back(renderer.film());
    renderer.render(rays.back(), until(i), until(i + 1));
  }
  int unlike = 0;
  for (int y = 0; y < 16; ++y)
    for (int x = 0; x < 16; ++x)
      for (int r = 0; r < 2; ++r) {
        const auto found = [&](size_t i) { return rays[i].replicate_mean(x, y, r); };
        const Vec3 expected = found(0) * .25f + found(1) * .25f + found(2) * .5f;
        ASSERT_LT(math::length(shared.replicate_mean(x, y, r) - expected), 1e-6f);
        ASSERT_EQ(shared.replicate_mean(x, y, r), torn.replicate_mean(x, y, r));
        unlike += found(0) != found(2);
      }
  EXPECT_GT(unlike, 10);  // else it would not matter which
}

// Within 4.5 standard errors (of .1 % at most; with fresh seeds a right program fails seven times in a
// million, and twice that for two ways of sharing). Four paths together save three of four camera rays; reuse
// adds the rays that it says, and its counts are those of a block.
TEST(Render, paths_that_share_have_the_same_mean_and_cost_the_rays_they_say) {
  const scene::Scene s = two_spheres();
  const Technique techniques[3] = {{1, false}, {4, false}, {4, true}};
  double sum[3] = {}, squares[3] = {}, of_reuse = 0;
  std::uint64_t rays[3] = {};
  constexpr int pictures = 64, spp = 16;
  for (int k = 0; k < pictures; ++k)
    for (const int way : {0, 1, 2}) {
      Settings settings = small(Shader::disney, spp);
      settings.seed = static_cast<std::uint32_t>(3 * k + way);
      settings.replicates = 1;
      const Renderer renderer(s, settings);
      image::Film film = renderer.film();
      const image::Film data(16, 16, 1, image::Film::Holds::data);
      Spread spread{data, data};
      renderer.render(
          film, [](int, int, int) { return 0; }, [](int, int, int) { return spp; },
          {0, 0, [&](int, int) { return techniques[way]; }}, &spread);
      double mean = 0, within = 0;
      for (int y = 0; y < 16; ++y)
        for (int x = 0; x < 16; ++x) {
          mean += math::luminance(film.mean(x, y)) / 256;
          within += spread.pairs.mean(x, y).x;
          of_reuse += spread.pairs.mean(x, y).z * spp / 2;
        }
      EXPECT_GT(within, 0);  // two paths from one ray differ
      sum[way] += mean, squares[way] += mean * mean;
      rays[way] += renderer.rays();
    }
  const double own = sum[0] / pictures;
  for (const int way : {1, 2}) {
    double error = 0;
    for (const int i : {0, way})
      error += (squares[i] / pictures - math::sqr(sum[i] / pictures)) / (pictures - 1);
    EXPECT_LT(std::sqrt(error) / own, .001);
    EXPECT_NEAR(sum[way] / pictures, own, 4.5 * std::sqrt(error)) << way;
  }
  const double samples = pictures * 256. * spp;
  EXPECT_NEAR(static_cast<double>(rays[0] - rays[1]) / samples, .75, .01);
  EXPECT_GT(of_reuse, .5 * samples);
  EXPECT_NEAR((static_cast<double>(rays[2]) - of_reuse - static_cast<double>(rays[1])) / samples, 0, .02);
}

std::vector<image::Film> render_parts(const scene::Scene& scene, const Settings& settings,
                                      image::Film& whole) {
  const Renderer renderer(scene, settings);
  std::vector<image::Film> parts;
  for (size_t i = 0; i < part_names().size(); ++i) parts.push_back(renderer.film());
  EXPECT_TRUE(renderer.render(whole, 0, settings.spp, {}, parts));
  return parts;
}

TEST(Render, parts_by_lobe_sum_to_the_picture_and_leave_its_bits_alone) {
  scene::Scene s = two_spheres();
  s.materials[1].metallic = .5f, s.materials[1].clearcoat = 1, s.materials[1].sheen = 1;
  for (const Shader shader : {Shader::disney, Shader::principled, Shader::path_nomis}) {
    s.materials[1].roughness = shader == Shader::principled ? 0.f : .3f;  // 0: a mirror among other lobes
    const Settings settings = small(shader, 64);
    const image::Film alone = render(s, settings);
    image::Film whole = Renderer(s, settings).film();
    const std::vector<image::Film> parts = render_parts(s, settings, whole);
    for (int y = 0; y < 16; ++y)
      for (int x = 0; x < 16; ++x) {
        ASSERT_EQ(alone.mean(x, y), whole.mean(x, y)) << x << ", " << y;
        Vec3 sum(0);
        for (const image::Film& part : parts) sum += part.mean(x, y);
        for (int c = 0; c < 3; ++c) ASSERT_NEAR(sum[c], whole.mean(x, y)[c], 2e-6f * whole.mean(x, y)[c]);
      }
  }
}

// The mean of the middle of the picture, red, and its variance.
struct Mean {
  double value = 0, variance = 0;
};
Mean mean_of(const image::Film& film) {
  Mean m;
  for (int y = 4; y < 12; ++y)
    for (int x = 4; x < 12; ++x)
      m.value += film.mean(x, y).x / 64., m.variance += film.variance_of_mean(x, y).x / 4096.;
  return m;
}

// The light of one lobe among the others is that of a material which has no other. Two noisy means, 4.5
// sigma, fixed seeds; a false alarm once in 18,000 sets of seeds.
TEST(Render, a_lobes_part_is_the_picture_of_a_material_with_that_lobe_alone) {
  scene::Scene s = two_spheres();
  s.instances[1].to_world = math::Mat4(.3f);  // fills the middle of the picture, of which mean_of() speaks
  s.instances[1].to_world[3] = math::Vec4(0, 0, -.6f, 1);
  s.materials[0].emission = Vec3(.3f);
  scene::Material& m = s.materials[1];
  m.metallic = 0;
  m.base_color = Vec3(.6f), m.roughness = .4f, m.specular = .8f, m.sheen = 1, m.sheen_tint = 0,
  m.clearcoat = 1;
  m.clearcoat_roughness = .3f;
  const scene::Material all = m;
  Settings settings = small(Shader::disney, 256);
  settings.depth = 2;
  image::Film whole = Renderer(s, settings).film();
  const std::vector<image::Film> parts = render_parts(s, settings, whole);

  // Parts 3 to 8: sheen, specular, clearcoat, each direct and indirect.
  settings.seed = 2;
  for (const int lobe : {1, 2, 3}) {
    m = all;
    m.base_color = Vec3(0);
    if (lobe != 1) m.sheen = 0;
    if (lobe != 2) m.specular = 0;
    if (lobe != 3) m.clearcoat = 0;
    image::Film single = Renderer(s, settings).film();
    const std::vector<image::Film> only = render_parts(s, settings, single);
    for (const int kind : {1 + 2 * lobe, 2 + 2 * lobe}) {
      const Mean a = mean_of(parts[static_cast<size_t>(kind)]), b = mean_of(only[static_cast<size_t>(kind)]);
      EXPECT_GT(a.value, 1e-4) << part_names()[static_cast<size_t>(kind)];
      EXPECT_NEAR(a.value, b.value, 4.5 * std::sqrt(a.variance + b.variance))
          << part_names()[static_cast<size_t>(kind)];
      EXPECT_LT(std::sqrt(b.variance), .03 * b.value) << part_names()[static_cast<size_t>(kind)];
    }
    EXPECT_EQ(mean_of(only[1]).value, 0);
  }
}

// A pass of many samples for a single tile takes seconds; who wants to stop does not wait for its end.
TEST(Render, stops_within_a_tile_and_keeps_what_is_there) {
  const scene::Scene s = two_spheres();
  const Settings settings = small(Shader::path, 1 << 16);
  const Renderer renderer(s, settings);
  image::Film film = renderer.film();
  EXPECT_FALSE(renderer.render(film, 0, settings.spp, [](const Status& status) {
    EXPECT_GT(status.rays, 0u);
    return false;
  }));
  std::int64_t samples = 0;
  for (int y = 0; y < 16; ++y)
    for (int x = 0; x < 16; ++x) samples += film.samples(x, y);
  EXPECT_GT(samples, 0);
  EXPECT_LT(samples, 256ll << 15);  // half of all
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
