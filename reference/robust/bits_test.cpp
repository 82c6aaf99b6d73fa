// What may not change a bit of the picture: threads, tiles, powers of two, what the scene does not use. And
// what lets errors grow with the number of samples. docs/robustness.md, A06 to A11, D01 to D03.
#include <immintrin.h>

#include <filesystem>
#include <functional>

#include "gltf/load.h"
#include "robust/robust.h"

namespace robust {
namespace {

// Every scene of the suite that has a camera, with its name.
const std::vector<std::pair<std::string, scene::Scene>>& suite() {
  static const auto scenes = [] {
    std::vector<std::pair<std::string, scene::Scene>> all;
    std::vector<std::filesystem::path> files;
    for (const auto& entry : std::filesystem::directory_iterator(ASSAY_SOURCE_DIR "/regression/scenes"))
      if (entry.path().extension() == ".glb") files.push_back(entry.path());
    std::sort(files.begin(), files.end());
    for (const auto& file : files)
      if (scene::Scene s = gltf::load(file.string()); !s.cameras.empty())
        all.emplace_back(file.stem().string(), std::move(s));
    return all;
  }();
  return scenes;
}

// In how many scenes of the suite a change of the scene changes a pixel, which is told by name; the picture
// is multiplied by `factor` before.
std::string changed_by(const std::function<void(scene::Scene&)>& change, float factor = 1) {
  std::string names;
  int count = 0;
  for (const auto& [name, s] : suite()) {
    scene::Scene other = s;
    change(other);
    Picture a = render(s, settings(16, 4)), b = render(other, settings(16, 4));
    for (Vec3& v : a.mean) v *= factor;
    if (different_pixels(a, b) == 0) continue;
    names += ' ' + name;
    ++count;
  }
  return std::to_string(count) + " of " + std::to_string(suite().size()) + names;
}

std::string none() { return "0 of " + std::to_string(suite().size()); }

// A06.
TEST(Bits, do_not_depend_on_threads_or_tiles) {
  const scene::Scene s = still_life();
  Settings t = settings(50, 8);
  t.threads = 1;
  const Picture one = render(s, t);
  int different = 0;
  for (const int threads : {2, 7, 64}) {
    t.threads = threads;
    different += different_pixels(one, render(s, t));
  }
  // Tiles of other sizes: the picture in crops.
  for (const auto& [width, height] : {std::pair{8, 8}, {32, 32}, {7, 5}, {50, 1}})
    for (int y = 0; y < 50; y += height)
      for (int x = 0; x < 50; x += width) {
        t.crop_x = x, t.crop_y = y, t.crop_width = std::min(width, 50 - x),
        t.crop_height = std::min(height, 50 - y);
        const Picture crop = render(s, t);
        for (int j = 0; j < t.crop_height; ++j)
          for (int i = 0; i < t.crop_width; ++i) different += crop.at(i, j) != one.at(x + i, y + j);
      }
  EXPECT_EQ(different, 0);
  measured(different, " pixels differ; threads 1, 2, 7, 64; tiles of 16, 8, 32, 7 x 5, 50 x 1");
}

// D01. Twice the light is twice the picture, in every bit.
TEST(Bits, of_a_picture_in_light_scaled_by_powers_of_two_scale_with_it) {
  const auto brighter = [](float factor) {
    return [factor](scene::Scene& s) {
      for (scene::Light& l : s.lights) l.intensity *= factor;
      for (scene::Material& m : s.materials) m.emission *= factor;
      if (s.environment) s.environment->strength *= factor;
    };
  };
  const std::string up = changed_by(brighter(1024), 1024), down = changed_by(brighter(1 / 64.f), 1 / 64.f);
  EXPECT_EQ(up, none());
  EXPECT_EQ(down, none());
  measured("light x 2^10: ", up, " scenes differ; x 2^-6: ", down);
}

// D02. A world twice as large, seen and lit alike, is the same picture.
TEST(Bits, do_not_depend_on_the_unit_of_length_by_powers_of_two) {
  const auto larger = [](float factor) {
    return [factor](scene::Scene& s) {
      for (scene::Instance& i : s.instances) i.to_world[3] = math::Vec4(Vec3(i.to_world[3]) * factor, 1);
      for (scene::Mesh& m : s.meshes)
        for (Vec3& p : m.positions) p *= factor;
      for (scene::Camera& c : s.cameras)
        c.to_world[3] = math::Vec4(Vec3(c.to_world[3]) * factor, 1), c.ymag *= factor;
      for (scene::Light& l : s.lights) {
        l.position *= factor;
        if (l.kind != scene::LightKind::directional) l.intensity *= factor * factor;
      }
    };
  };
  const std::string up = changed_by(larger(1024)), down = changed_by(larger(1 / 64.f));
  EXPECT_EQ(up, none());
  EXPECT_EQ(down, none());
  measured("lengths x 2^10: ", up, " scenes differ; x 2^-6: ", down);
}

// D03. What is there and does nothing, is not there.
TEST(Bits, do_not_depend_on_what_a_scene_does_not_use) {
  const std::string parameters = changed_by([](scene::Scene& s) {
    for (scene::Material& m : s.materials) {
      if (m.sheen == 0) m.sheen_tint = .123f;
      if (m.clearcoat == 0) m.clearcoat_roughness = .987f;
      if (m.anisotropic == 0) m.anisotropic_rotation = .4f;
      if (m.normal_texture.bitmap < 0) m.normal_scale = 7;
      if (m.alpha_mode == scene::AlphaMode::opaque) m.alpha = .1f, m.alpha_cutoff = .9f;
    }
  });
  const std::string unused = changed_by([](scene::Scene& s) {
    s.bitmaps.push_back({"unused", 1, 1, {{1, 2, 3, 4}}});
    s.materials.emplace_back();
    s.materials.back().clearcoat = s.materials.back().sheen = 1;
    s.materials.back().emission = Vec3(5);
    s.meshes.push_back(analytic::sphere(4));
    s.meshes.back().material = static_cast<int>(s.materials.size()) - 1;
    s.cameras.push_back(s.cameras[0]);
  });
  const std::string dark = changed_by([](scene::Scene& s) {
    if (!s.environment) s.environment = constant(0);
    s.lights.emplace_back();
    s.lights.back().intensity = Vec3(0);
  });
  EXPECT_EQ(parameters, none());
  EXPECT_EQ(unused, none());
  EXPECT_EQ(dark, none());
  measured("scenes that differ: parameters of lobes of weight 0: ", parameters,
           "; textures, materials, meshes nobody uses: ", unused, "; a black environment and lamp: ", dark);
}

// A11. Denormal numbers are flushed wherever samples are made; Embree asks for it, and each costs ten normal
// ones.
TEST(Denormals, are_flushed_in_every_thread_that_renders) {
  Settings t = settings(128, 64);
  t.threads = 3;
  const scene::Scene s = still_life();
  const integrator::Renderer renderer(s, t);
  image::Film film = renderer.film();
  int asked = 0, flushed = 0;
  renderer.render(film, 0, t.spp, [&](const integrator::Status&) {
    ++asked;
    flushed += (_mm_getcsr() & 0x8040) == 0x8040;
    return true;
  });
  EXPECT_GT(asked, 0);
  EXPECT_EQ(flushed, asked);
  EXPECT_EQ(_mm_getcsr() & 0x8040, 0u) << "and left alone outside";
  measured(flushed, " of ", asked, " looks at MXCSR");
}

// A10, nightly: the error against the closed form, sphere of albedo .5: MSE = a N^-p, no floor.
TEST(Convergence, goes_on_to_sixteen_thousand_samples_without_a_floor) {
  if (std::getenv("ASSAY_NIGHTLY") == nullptr) GTEST_SKIP() << "a minute; ASSAY_NIGHTLY=1 runs it";
  const scene::Scene s = analytic::closed_sphere(.5f, .5f);
  double wanted = 0;
  for (int i = 0; i <= 24; ++i) wanted += .5 * std::pow(.5, i);
  std::vector<double> x, y;
  double bias = 0, error = 0;
  for (const int spp : {16, 64, 256, 1024, 4096, 16384}) {
    const Picture p = render(s, settings(16, spp, Shader::path, 24));
    double square = 0;
    for (const Vec3& v : p.mean) square += math::sqr(v.x - wanted) / static_cast<double>(p.mean.size());
    x.push_back(std::log(spp)), y.push_back(std::log(square));
    bias = p.average / wanted - 1, error = p.error / wanted;
  }
  const double n = static_cast<double>(x.size()), mx = (x.front() + x.back()) / 2;
  double my = 0, xy = 0, xx = 0;
  for (const double v : y) my += v / n;
  for (size_t i = 0; i < x.size(); ++i) xy += (x[i] - mx) * (y[i] - my), xx += (x[i] - mx) * (x[i] - mx);
  const double power = -xy / xx;
  EXPECT_GE(power, .95);
  EXPECT_LE(power, 2);
  EXPECT_LE(std::fabs(bias), std::max(5e-4, 3.3 * error));
  // The last step falls like the rest: a floor would show there first.
  EXPECT_LT(y.back() - y[y.size() - 2], -.8 * std::log(4));
  measured("MSE falls as N^-", power, "; mean at 16384 samples off by ", 100 * bias, " % +- ", 100 * error,
           " %");
}

}  // namespace
}  // namespace robust
