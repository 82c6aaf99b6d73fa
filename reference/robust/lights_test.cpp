// Hard cases of lights and of how they are sampled: docs/robustness.md, L01 to L10, S13, S14.
#include "light/lights.h"

#include "bsdf/disney.h"
#include "math/sampler.h"
#include "robust/robust.h"

namespace robust {
namespace {

using analytic::quad;
using analytic::sphere;

scene::Environment map_of(int width, int height, float value) {
  scene::Environment e{{"map", width, height, {}}, 1, 0};
  e.map.texels.assign(static_cast<size_t>(width * height), math::Vec4(value, value, value, 1));
  return e;
}

scene::Scene floor_under(const scene::Environment& environment, float albedo = 1) {
  scene::Scene s;
  s.meshes = {quad({-1, 0, 1}, {1, 0, 1}, {1, 0, -1}, {-1, 0, -1})};
  s.materials = {analytic::lambert(albedo)};
  s.instances = {{0}};
  s.environment = environment;
  s.cameras = {looks_down(.1f)};
  return s;
}

// L01. A black environment is no environment.
TEST(Lights, a_black_environment_leaves_every_bit_as_without_one) {
  int different = 0;
  for (const bool other_lights : {false, true}) {
    scene::Scene s = still_life();
    if (!other_lights) s.materials[2].emission = Vec3(0);
    const Picture without = render(s, settings(24, 16));
    for (const auto& [width, height] : {std::pair{1, 1}, {2, 1}, {64, 32}}) {
      s.environment = map_of(width, height, 0);
      different += different_pixels(without, render(s, settings(24, 16)));
    }
    s.environment = map_of(4, 2, 1);
    s.environment->strength = 0;
    different += different_pixels(without, render(s, settings(24, 16)));
  }
  EXPECT_EQ(different, 0);
  measured(different, " of 8 x 576 pixels differ");
}

// L02. One texel of a million: the floor's irradiance by numerical integration of the bilinear map.
TEST(Lights, one_bright_texel_lights_the_floor_as_the_integral_says) {
  double worst = 0;
  for (const float rest : {0.f, 1.f})
    for (const int row : {20, 80, 120}) {
      scene::Environment e = map_of(512, 256, rest);
      e.map.texels[static_cast<size_t>(row * 512 + 100)] = math::Vec4(1e6f);
      // Of the tent of two by two texels: integral of cos sin over it, by midpoints.
      const double pi = 3.14159265358979;
      double wanted = rest * pi, share = 0;
      for (int j = 0; j < 400; ++j) {
        const double v = row - .5 + (j + .5) / 200, theta = pi * v / 256;
        share += (1 - std::fabs(v - row - .5)) * std::cos(theta) * std::sin(theta) * pi / 256 / 200;
      }
      wanted += (1e6 - rest) * share * 2 * pi / 512;
      const Picture p = render(floor_under(e), settings(16, 256, Shader::path, 1));
      worst = std::max(worst, std::fabs(p.average * pi / wanted - 1) - 4 * p.error * pi / wanted);
    }
  EXPECT_LT(worst, .003);
  measured("irradiance within ", 100 * worst, " % beyond four standard errors, six maps");
}

// L03 and S13 need light that only the BRDF looks for: our own estimate of one bounce, from the parts.
double by_brdf_alone(const scene::Scene& s, int size, int samples, bsdf::Model model, double& error) {
  const surface::Surfaces surfaces(s, model);
  const accel::Accel accel(
      s, false, surfaces.filtered(),
      [&](const accel::Ray& r, const accel::Hit& h, std::uint32_t k) { return surfaces.accepts(r, h, k); });
  const light::Lights lights(s, surfaces);
  const scene::Camera& c = s.cameras[0];
  const float half = std::tan(c.yfov / 2);
  double sum = 0, squares = 0;
  const int count = size * size * samples;
  for (int i = 0; i < count; ++i) {
    math::Sampler sampler(math::Sampler::Kind::random, 77, i % size, i / size % size, 0,
                                static_cast<std::uint32_t>(i / size / size));
    const math::Vec4 u = sampler.get(0), v = sampler.get(1);
    const float x = (2 * (static_cast<float>(i % size) + u.x) / static_cast<float>(size) - 1) * half,
                y = (1 - 2 * (static_cast<float>(i / size % size) + u.y) / static_cast<float>(size)) * half;
    accel::Ray ray{Vec3(c.to_world[3]), math::normalize(math::transform_vector(c.to_world, {x, y, -1}))};
    Vec3 found(0), throughput(1);
    for (int bounce = 0; bounce < 2; ++bounce) {
      accel::Hit hit;
      if (!accel.closest(ray, 0, hit)) {
        found += throughput * lights.environment(ray.direction);
        break;
      }
      const surface::Point p = surfaces.at(ray, hit);
      found += throughput * p.emission;
      const Vec3 wo = p.frame.to_local(-ray.direction);
      const auto bsdf = bsdf::prepare(model, {}, p.material, p.normals, wo);
      const auto sample = bsdf::sample(bsdf, wo, v.z, v.x, v.y);
      if (!sample) break;
      throughput *= sample->f_cos / sample->pdf;
      ray.direction = math::normalize(p.frame.to_world(sample->wi));
      ray.origin = surface::origin(p, ray.direction);
    }
    sum += found.x, squares += found.x * static_cast<double>(found.x);
  }
  error = std::sqrt((squares / count - sum / count * sum / count) / count);
  return sum / count;
}

// S13. Only the BRDF's directions, and both ways weighted: the same light. (Light samples alone: the closed
// forms.)
TEST(Lights, both_ways_of_sampling_weighted_give_what_the_brdf_s_alone_gives) {
  double worst = 0;
  std::ostringstream all;
  const auto compare = [&](const char* name, const scene::Scene& s) {
    double error = 0;
    const double alone = by_brdf_alone(s, 32, 1024, bsdf::Model::disney, error);
    const Picture both = render(s, settings(32, 64, Shader::disney, 1));
    const double z = std::fabs(alone - both.average) / std::hypot(error, both.error);
    EXPECT_LT(z, 4) << name << ": " << alone << " against " << both.average;
    EXPECT_LT(std::hypot(error, both.error) / alone, .01) << name;
    worst = std::max(worst, z);
    all << name << ' ' << 100 * (both.average / alone - 1) << " % ";
  };
  scene::Scene s = still_life();
  s.meshes[2] = lamp(2, 3);
  s.meshes[2].material = 2;
  compare("square lamp", s);
  s.meshes[2] = sphere(12);
  s.meshes[2].material = 2;
  s.meshes[2].normals.clear();
  s.instances[2].to_world[3] = math::Vec4(1.5f, 2, 1, 1);
  s.materials[2].double_sided = false;
  compare("sphere", s);
  s.materials[2].emission = Vec3(0);
  scene::Environment sky = map_of(32, 16, .5f);
  for (int i = 0; i < 4; ++i)
    sky.map.texels[static_cast<size_t>((4 + i / 2) * 32 + 8 + i % 2)] = math::Vec4(40);
  s.environment = sky;
  compare("sun and sky", s);
  // Veach's plates: one glossy plate, lamps of many sizes.
  s = still_life();
  s.materials[0].metallic = 1, s.materials[0].roughness = .15f, s.materials[0].specular = .5f;
  for (int i = 0; i < 3; ++i) {
    s.meshes.push_back(lamp(.1f + .4f * static_cast<float>(i), 3));
    for (Vec3& p : s.meshes.back().positions) p.x += static_cast<float>(2 * i - 2), p.z -= 2;
    s.meshes.back().material = 2;
    s.instances.push_back({3 + i});
  }
  compare("plates", s);
  measured(all.str(), "and at most ", worst, " sigma");
}

// L03. The density of directions is that of the bilinear map: else moving light within a texel changes the
// sum.
TEST(Lights, a_map_s_light_is_the_same_whether_looked_for_or_met) {
  double worst = 0;
  for (const bool checker : {true, false}) {
    scene::Environment e = map_of(16, 8, 0);
    for (size_t i = 0; i < e.map.texels.size(); ++i)
      if (checker ? (i + i / 16) % 2 == 0 : i == 2 * 16 + 5)
        e.map.texels[i] = math::Vec4(checker ? 2.f : 50.f);
    const scene::Scene s = floor_under(e, .8f);
    double error = 0;
    const double alone = by_brdf_alone(s, 16, checker ? 2048 : 8192, bsdf::Model::path, error);
    for (const Shader shader : {Shader::path, Shader::path_nomis}) {
      const Picture p = render(s, settings(16, 512, shader, 1));
      worst = std::max(worst, std::fabs(p.average - alone) / std::hypot(error, p.error));
    }
  }
  EXPECT_LT(worst, 4);
  measured("at most ", worst, " sigma apart");
}

// L04. Poles and the seam, by the environment itself.
TEST(Lights, an_environment_is_continuous_at_the_poles_and_the_seam_and_its_density_finite) {
  scene::Environment e = map_of(64, 32, 0);
  for (int y = 0; y < 32; ++y)
    for (int x = 0; x < 64; ++x) {
      const double theta = 3.14159265358979 * (y + .5) / 32, phi = 2 * 3.14159265358979 * (x + .5) / 64;
      const auto v = static_cast<float>(1 + .5 * std::sin(theta) * std::cos(phi - 1) + .3 * std::cos(theta));
      e.map.texels[static_cast<size_t>(y * 64 + x)] = math::Vec4(v);
    }
  const light::Environment env(e, true);
  double seam = 0, jump = 0;
  for (int i = 0; i < 1000; ++i) {
    const float y = -1 + .002f * static_cast<float>(i), r = std::sqrt(1 - y * y);
    seam = std::max(seam, std::fabs(static_cast<double>(env.radiance({-r, y, 1e-7f * r}).x) -
                                    env.radiance({-r, y, -1e-7f * r}).x));
    const float a = .00628f * static_cast<float>(i), tiny = 1e-4f;
    for (const float pole : {1.f, -1.f})
      jump = std::max(
          jump,
          std::fabs(static_cast<double>(
                        env.radiance(math::normalize({tiny * std::cos(a), pole, tiny * std::sin(a)})).x) -
                    env.radiance({0, pole, 0}).x));
  }
  EXPECT_LT(seam, 1e-5);
  EXPECT_LT(jump, .055) << "the texels of the first row differ by .05";
  for (const Vec3& d :
       {Vec3(0, 1, 0), Vec3(0, -1, 0), Vec3(-1, 0, 0), Vec3(-1, 0, -1e-8f), Vec3(1e-20f, 1, 1e-20f)})
    EXPECT_TRUE(std::isfinite(env.look(d).pdf) && env.look(d).pdf > 0);
  // look()'s density is sample()'s own, and integrates to one.
  double sum = 0, worst = 0;
  for (int i = 0; i < 100'000; ++i) {
    const float u = (static_cast<float>(i) + .5f) / 100'000,
                v = static_cast<float>(i * 61803ll % 100'000) / 100'000;
    const auto sample = env.sample(u, v);
    const double ratio = env.look(sample.direction).pdf / sample.seen.pdf;
    worst += std::fabs(ratio - 1) > 1e-3;  // a direction on the edge of a cell may fall into the next
    sum += 1 / sample.seen.pdf / 100'000.;
  }
  EXPECT_LT(worst / 100'000, 2e-4);
  EXPECT_NEAR(sum / (4 * 3.14159265358979), 1, 2e-3);
  measured("largest jump ", seam, " at the seam, ", jump, " at the poles, the density's reciprocal sums to ",
           sum / 3.14159265358979, " pi");
}

// L05. A row of ones with one texel of 1e8: every other texel can still be drawn.
TEST(Lights, a_range_of_a_hundred_million_leaves_no_texel_without_its_share) {
  scene::Environment e = map_of(4096, 1, 1);
  e.map.texels[1000] = math::Vec4(1e8f);
  const light::Environment env(e, true);
  int missing = 0;
  double total = 0;
  for (int i = 0; i < 4096; ++i) {
    const double phi = 2 * 3.14159265358979 * ((i + .5) / 4096 - .5);
    const double pdf =
        env.look({static_cast<float>(std::cos(phi)), 0, static_cast<float>(std::sin(phi))}).pdf;
    missing += !(pdf > 0);
    total += pdf * 4 * 3.14159265358979 / 4096;
  }
  EXPECT_EQ(missing, 0);
  EXPECT_NEAR(total, 1, 1e-3);
  measured(missing, " of 4096 texels have density 0; sum ", total);
}

// L06, G11. Parts of a lamp that have no area, and a lamp that has none at all.
TEST(Lights, triangles_without_area_are_no_lamps) {
  const scene::Scene clean = still_life();
  scene::Scene dirty = clean;
  scene::Mesh& m = dirty.meshes[2];
  m.positions.insert(m.positions.end(), {Vec3(0, 4, 0), Vec3(.1f, 4, .1f), Vec3(.2f, 4, .2f)});
  m.triangles.push_back({4, 5, 6});
  m.triangles.push_back({4, 4, 5});
  const int different = different_pixels(render(clean, settings(32, 16)), render(dirty, settings(32, 16)));
  EXPECT_EQ(different, 0);
  m.triangles = {{4, 5, 6}, {4, 4, 4}};
  const Picture dark = render(dirty, settings(16, 16));
  EXPECT_EQ(dark.average, 0);
  measured(different, " of 1024 pixels differ; a lamp of such triangles alone gives ", dark.average);
}

// L07, L10. Lamps that send nothing.
TEST(Lights, of_no_power_send_exactly_nothing_and_disturb_no_other) {
  scene::Scene s = still_life();
  s.materials[2].emission = Vec3(0);
  for (const Shader shader : {Shader::disney, Shader::principled, Shader::path, Shader::path_disney}) {
    for (const float roughness : {0.f, .1f, 1.f}) {
      s.materials[1].roughness = roughness;
      EXPECT_EQ(render(s, settings(16, 8, shader)).average, 0);
    }
  }
  for (const float tiny : {0.f, 1e-45f, 1e-38f}) {
    s.lights = {point({1, 3, 1}, 0), point({-1, 3, 1}, tiny)};
    EXPECT_LT(render(s, settings(16, 8)).average, 1e-30);
  }
  s.lights = {point({-1, 3, 1}, 9)};
  const Picture one = render(s, settings(24, 16));
  s.lights = {point({1, 3, 1}, 0), point({-1, 3, 1}, 9), point({0, 3, 1}, 0)};
  const int different = different_pixels(one, render(s, settings(24, 16)));
  EXPECT_EQ(different, 0);
  measured("black exactly in 12 pictures; ", different, " of 576 pixels differ with two dead lamps more");
}

// L08. A small receiver before a square lamp, from touching it to a million times its size away: E = pi L F,
// the form factor of a small patch and a parallel square opposite (Howell, B-4).
TEST(Lights, a_square_lamp_gives_its_form_factor_from_touching_to_far_away) {
  double worst = 0;
  for (const float distance : {1e-6f, 1e-3f, .1f, 1.f, 10.f, 1e3f, 1e6f}) {
    scene::Scene s;
    const float r = 1e-4f * distance;
    s.meshes = {quad({-r, 0, r}, {r, 0, r}, {r, 0, -r}, {-r, 0, -r}), lamp(.5f, distance)};
    s.materials = {analytic::lambert(1), analytic::lambert(0)};
    s.materials[1].emission = Vec3(2);
    s.materials[1].double_sided = false;
    s.meshes[1].material = 1;
    s.instances = {{0}, {1}};
    scene::Camera c;
    c.orthographic = true;
    c.ymag = .5f * r;
    c.to_world = math::Mat4(1, 0, 0, 0, 0, 0, -1, 0, 0, 1, 0, 0, 0, .5f * distance, 0, 1);
    s.cameras = {c};
    const Picture p = render(s, settings(8, 1024, Shader::path, 1));
    const double x = .5 / distance, k = x / std::sqrt(1 + x * x),
                 f = 4 / (2 * 3.14159265358979) * (k * std::atan(k) * 2);
    const double off = std::fabs(p.average / (2 * f) - 1) - 4 * p.error / (2 * f);
    EXPECT_LT(off, .005) << distance << ": " << p.average << " against " << 2 * f;
    worst = std::max(worst, off);
  }
  // In the plane of the lamp, touching its edge: nothing, and no NaN.
  scene::Scene s = still_life();
  s.meshes[2] = lamp(1, 0);
  s.meshes[2].material = 2;
  render(s, settings(16, 16));
  measured("within ", 100 * std::max(worst, 0.), " % beyond four standard errors, 1e-6 to 1e6 of its size");
}

// S12. Densities from 1 to 1e30 against each other: a lamp of 1e-12 to 1 m, over Lambert and over a mirror of
// alpha .001.
TEST(Lights, weights_of_the_two_ways_sum_to_one_for_densities_over_thirty_decades) {
  double worst = 0;
  for (const float size : {1e-12f, 1e-8f, 1e-4f, 1e-2f}) {
    scene::Scene s = floor_under(constant(0));
    s.environment.reset();
    s.meshes.push_back(lamp(.5f * size, 1));
    s.meshes[1].material = 1;
    s.materials.emplace_back();
    s.materials[1].emission = Vec3(1e-4f / size / size);
    s.materials[1].double_sided = false;
    s.instances.push_back({1});
    s.cameras[0].yfov = 1e-4f;
    const Picture p = render(s, settings(8, 64, Shader::path, 1));
    worst = std::max(worst, std::fabs(p.average / (1e-4 / 3.14159265358979) - 1));
    s.materials[0] = {};
    s.materials[0].roughness = 0, s.materials[0].double_sided = true;
    for (const Vec3& v : render(s, settings(8, 64)).mean) EXPECT_TRUE(math::is_finite(v));
  }
  EXPECT_LT(worst, 1e-3);
  measured("irradiance within ", 100 * worst, " %, lamps of 1e-12 to 1e-2 m");
}

// L09 (a): pbrt's sphere, seen from inside, with a point light in the middle: radiance 1.
TEST(Lights, inside_a_closed_sphere_with_a_point_light_radiance_is_one) {
  scene::Scene s = analytic::closed_sphere(.5f, 0);
  s.meshes = {sphere(64)};
  s.meshes[0].normals.clear();
  s.lights = {point({0, 0, 0}, 3.14159265f)};
  s.cameras = {analytic::camera_at({0, 0, 0}, 1)};
  const Picture p = render(s, settings(16, 256, Shader::path, 60));
  EXPECT_NEAR(p.average, 1, .005);
  measured("mean ", p.average);
}

// S14. Paths that end by chance carry the light of those that do not: in a sphere of albedo .9, e (1 + a +
// ... + a^64).
TEST(Lights, paths_ended_by_chance_lose_no_light) {
  Settings t = settings(16, 512, Shader::path, 64);
  const Picture p = render(analytic::closed_sphere(.9f, .1f), t);
  const double wanted = .1 * (1 - std::pow(.9, 65)) / .1;
  EXPECT_NEAR(p.average, wanted, 4 * p.error);
  EXPECT_LT(p.error, .003);
  measured(p.average, " against ", wanted, ", standard error ", p.error);
}

}  // namespace
}  // namespace robust
