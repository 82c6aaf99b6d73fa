// Hard cases of geometry, as pictures: docs/robustness.md, G04 to G24.
#include "gltf/sample_test.h"
#include "robust/robust.h"

namespace robust {
namespace {

using analytic::quad;
using analytic::sphere;

constexpr float not_a_number = std::numeric_limits<float>::quiet_NaN(),
                infinity = std::numeric_limits<float>::infinity();

// Mean radiance inside a closed box in a bright world, as a share of what is outside.
double leak(const Vec3& c, float r) {
  scene::Scene s;
  const auto corner = [&](int i) { return c + Vec3(i & 1 ? r : -r, i & 2 ? r : -r, i & 4 ? r : -r); };
  for (const auto& [a, b, d, e] :
       {std::array{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}}) {
    s.instances.push_back({static_cast<int>(s.meshes.size())});
    s.meshes.push_back(quad(corner(a), corner(b), corner(d), corner(e)));
  }
  s.materials = {analytic::lambert(.5f)};
  s.environment = constant(1e6f);
  s.cameras = {analytic::camera_at(c, 1.5f)};
  return render(s, settings(64, 32, Shader::path, 8)).average / 1e6;
}

// G04. What gets in, leaks. At coordinates of 10^5 the last place is 1/256 of a box of 4 metres, and a point
// of one wall may by its own rounding lie behind the next wall: nothing that a ray could be offset by mends
// that.
TEST(Geometry, a_closed_box_in_a_bright_world_is_dark_and_far_away_nearly_so) {
  const Vec3 far(148376, 1234, -223423);
  const double near = leak(Vec3(0), 2), far_large = leak(far, 200), far_small = leak(far, 2);
  EXPECT_EQ(near, 0);
  EXPECT_LT(far_large, 1e-4);
  EXPECT_LT(far_small, 2e-3);
  measured("share of the light outside: ", near, " at the origin; at 2e5 m ", far_large, " (box of 400 m), ",
           far_small, " (4 m)");
}

// G07. A million times its size away, a lit plane has no acne. It is tilted, so that the ray's length and
// direction are not exact.
TEST(Geometry, a_plane_seen_and_lit_from_a_million_times_its_size_away_is_even) {
  scene::Scene s;
  const auto corner = [](float x, float y) { return Vec3(x, y, .31f * x + .17f * y); };
  s.meshes = {quad(corner(-5, -5), corner(5, -5), corner(5, 5), corner(-5, 5))};
  s.materials = {analytic::lambert(1)};
  s.instances = {{0}};
  scene::Light sun;
  sun.kind = scene::LightKind::directional;
  sun.direction = math::normalize({.31f, .17f, -1});
  sun.intensity = Vec3(math::pi);
  s.lights = {sun};
  s.cameras = {analytic::camera_at({0, 0, 1e6f}, 1e-6f)};
  const Picture p = render(s, settings(32, 16, Shader::path, 1));
  float low = 9, high = 0;
  for (const Vec3& v : p.mean) low = std::min(low, v.x), high = std::max(high, v.x);
  EXPECT_NEAR(low, 1, .005);
  EXPECT_NEAR(high, 1, .005);
  measured("pixels from ", low, " to ", high, " of E/pi");
}

// G10. Half of the mesh without area, in places where it is seen.
TEST(Geometry, triangles_without_area_leave_every_bit_of_the_picture_alone) {
  const scene::Scene clean = still_life();
  scene::Scene dirty = clean;
  scene::Mesh& m = dirty.meshes[1];
  const size_t good = m.triangles.size();
  for (size_t i = 0; i < good; ++i) {
    const math::UVec3 t = m.triangles[i];
    m.triangles.push_back({t.x, t.x, t.y});  // a line
    m.positions.push_back(m.positions[t.x] * .5f + m.positions[t.y] * .5f);
    m.normals.push_back(m.normals[t.x]);
    m.triangles.push_back({t.x, t.z, t.z});  // another
    m.triangles.push_back({t.y, t.y, t.y});  // a point
  }
  const int different = different_pixels(render(clean, settings(48, 16)), render(dirty, settings(48, 16)));
  EXPECT_EQ(different, 0);
  measured(different, " of 2304 pixels differ with ", 3 * good, " such triangles among ", good);
}

// A floor of two triangles and a third that has `bad` in one coordinate, as a file.
scene::Scene file_with(const std::optional<float>& bad, const std::vector<float>& normal = {},
                       const std::vector<float>& tangent = {}) {
  gltf::sample::File f;
  const float b = bad.value_or(0);
  std::initializer_list<float> good = {-1, -1, 0, 1, -1, 0, 1, 1, 0, -1, -1, 0, 1, 1, 0, -1, 1, 0};
  if (bad)
    f.data<float>("VEC3", 5126, 9,
                  {-1, -1, 0, 1, -1, 0, 1, 1, 0, -1, -1, 0, 1, 1, 0, -1, 1, 0, 0, 0, 1, b, 1, 1, 1, b, b});
  else
    f.data<float>("VEC3", 5126, 6, good);
  f.root["meshes"] = gltf::sample::json::parse(R"([{"primitives": [{"attributes": {"POSITION": 0}}]}])");
  auto& attributes = f.root["meshes"][0]["primitives"][0]["attributes"];
  const auto add = [&](const char* name, const char* type, const std::vector<float>& v) {
    if (v.empty()) return;
    attributes[name] = f.root["accessors"].size();
    const bool four = v.size() == 4;
    const float x = v[0], y = v[1], z = v[2], w = four ? v[3] : 0;
    if (four)
      f.data<float>(type, 5126, 6, {x, y, z, w, x, y, z, w, x, y, z, w, x, y, z, w, x, y, z, w, x, y, z, w});
    else
      f.data<float>(type, 5126, 6, {x, y, z, x, y, z, x, y, z, x, y, z, x, y, z, x, y, z});
  };
  add("NORMAL", "VEC3", normal);
  add("TANGENT", "VEC4", tangent);
  f.root["nodes"] = gltf::sample::json::parse(R"([{"mesh": 0}])");
  f.root["scenes"] = gltf::sample::json::parse(R"([{"nodes": [0]}])");
  scene::Scene s = gltf::sample::load_file(f);
  s.materials[0] = analytic::lambert(.7f);
  s.cameras = {analytic::camera_at({0, 0, 4}, .8f)};
  s.lights = {point({1, .5f, 2}, 10)};
  s.environment = constant(.3f);
  return s;
}

// G08 and G09, through the loader.
TEST(Geometry, triangles_with_vertices_that_are_no_numbers_or_huge_leave_every_bit_alone) {
  const Picture clean = render(file_with({}), settings(32, 16));
  int different = 0;
  for (const float bad : {not_a_number, infinity, -infinity, 1e30f, -3e38f}) {
    const scene::Scene s = file_with(bad);
    EXPECT_EQ(s.meshes[0].triangles.size(), 2u);
    different += different_pixels(clean, render(s, settings(32, 16)));
  }
  EXPECT_EQ(different, 0);
  measured(different, " of 5 x 1024 pixels differ for NaN, Inf, -Inf, 1e30, -3e38");
}

// G16, through the loader.
TEST(Geometry, normals_of_no_use_are_the_geometric_one) {
  const Picture flat = render(file_with({}), settings(32, 16));
  double worst = 0;
  for (const float bad : {0.f, 1e-30f, 1e30f, not_a_number}) {
    const Picture p = render(file_with({}, {bad, 0, bad}), settings(32, 16));  // would lean by 45 degrees
    for (size_t i = 0; i < p.mean.size(); ++i)
      worst = std::max(worst, static_cast<double>(math::max_component(math::abs(p.mean[i] - flat.mean[i]))));
  }
  EXPECT_LE(worst, 1e-6);
  measured("largest difference ", worst);
}

// G15, G14. A flat normal map and anisotropy on whatever tangents.
TEST(Geometry, tangents_of_no_use_and_a_flat_normal_map_change_little) {
  double worst_mean = 0, worst_8_bit = 0, worst_16_bit = 0;
  for (const std::vector<float>& tangent : std::vector<std::vector<float>>{
           {}, {0, 0, 0, 1}, {0, 0, 1, 1}, {1, 0, 0, 0}, {not_a_number, 0, 0, 1}, {1, 0, 0, -1}})
    for (const bool equal_uvs : {false, true}) {
      scene::Scene s = file_with({}, {0, 0, 1}, tangent);
      for (const Vec3& p : s.meshes[0].positions)
        s.meshes[0].texcoords[0].push_back(equal_uvs ? math::Vec2(.5f) : math::Vec2(p.x, -p.y));
      s.materials[0].metallic = 1, s.materials[0].roughness = .4f, s.materials[0].anisotropic = .8f;
      const Picture plain = render(s, settings(24, 64));
      s.bitmaps = {{"8 bits", 1, 1, {{128 * 257, 128 * 257, 65535, 65535}}},
                   {"16 bits", 1, 1, {{32768, 32768, 65535, 65535}}}};
      for (const int map : {0, 1}) {
        s.materials[0].normal_texture.bitmap = map;
        const Picture p = render(s, settings(24, 64));
        worst_mean = std::max(worst_mean, std::fabs(p.average / plain.average - 1));
        for (size_t i = 0; i < p.mean.size(); ++i) {
          if (plain.mean[i].x == 0) continue;
          const double off = std::fabs(p.mean[i].x / plain.mean[i].x - 1.);
          (map == 0 ? worst_8_bit : worst_16_bit) = std::max(map == 0 ? worst_8_bit : worst_16_bit, off);
          EXPECT_GT(p.mean[i].x, 0);
        }
      }
    }
  EXPECT_LT(worst_mean, .03);
  EXPECT_LT(worst_16_bit, .01);
  measured("means within ", 100 * worst_mean, " %; a pixel within ", 100 * worst_8_bit,
           " % (8-bit map, which tilts by .32 degrees), ", 100 * worst_16_bit, " % (16-bit)");
}

scene::Mesh baked(scene::Mesh m, const math::Mat4& to_world, const math::Mat3& normal_matrix, bool flip) {
  for (Vec3& p : m.positions) p = math::transform_point(to_world, p);
  for (Vec3& n : m.normals) n = math::normalize(normal_matrix * n);
  if (flip)
    for (math::UVec3& t : m.triangles) std::swap(t.y, t.z);
  return m;
}

// G18 and G19. A mesh under a mirroring or stretching node is the mesh with the node worked in.
TEST(Geometry, mirrored_and_stretched_instances_equal_meshes_made_so) {
  double worst = 0;
  for (const Vec3& scale :
       {Vec3(-1, 1, 1), Vec3(-1, -1, 1), Vec3(-1, -1, -1), Vec3(1, 10, .1f), Vec3(-.5f, 2, 1)})
    for (const bool double_sided : {false, true})
      for (const bool smooth : {false, true}) {
        scene::Scene s = still_life();
        s.meshes[1] = sphere(12);
        for (Vec3& p : s.meshes[1].positions) p.x += .3f * p.y;  // not symmetric
        if (!smooth) s.meshes[1].normals.clear();
        s.materials[1].double_sided = double_sided;
        // And a one-sided lamp, which the sign of the determinant turns on or off.
        s.materials[2].double_sided = false;
        math::Mat4& ball = s.instances[1].to_world;
        for (int i = 0; i < 3; ++i)
          ball[i][i] = scale[i] * (i == 1 ? .2f : 1.f),
          s.instances[2].to_world[i][i] = scale[i] < 0 ? -1.f : 1.f;
        if (scale.y < 0) s.instances[2].to_world[3].y = 8;  // mirrored in y about its own height
        s.environment = constant(.1f);
        scene::Scene made = s;
        for (const size_t i : {1u, 2u}) {
          const math::Mat4& m = s.instances[i].to_world;
          const bool flip = m[0][0] * m[1][1] * m[2][2] < 0;
          const math::Mat3 normals(1 / m[0][0], 0, 0, 0, 1 / m[1][1], 0, 0, 0, 1 / m[2][2]);
          made.meshes[i] = baked(s.meshes[i], m, normals, flip);
          made.instances[i].to_world = math::Mat4(1);
        }
        const Picture a = render(s, settings(24, 32)), b = render(made, settings(24, 32));
        EXPECT_GT(b.average, 0);
        EXPECT_NEAR(a.average, b.average, 4 * std::hypot(a.error, b.error) + 1e-5);
        worst = std::max(worst, largest_z(a, b, 1e-3f));
      }
  EXPECT_LT(worst, 4.5);
  measured("20 pairs, largest pixel difference ", worst, " sigma");
}

// G20.
TEST(Geometry, coplanar_surfaces_are_a_mixture_that_every_thread_count_gives) {
  scene::Scene s;
  s.meshes = {quad({-5, -5, 0}, {5, -5, 0}, {5, 5, 0}, {-5, 5, 0}),
              quad({-5, -5, 0}, {5, -5, 0}, {5, 5, 0}, {-5, 5, 0})};
  s.materials = {analytic::lambert(1), analytic::lambert(1)};
  s.materials[0].base_color = {1, 0, 0}, s.materials[1].base_color = {0, 1, 0};
  s.meshes[1].material = 1;
  s.instances = {{0}, {1}};
  scene::Light sun;
  sun.kind = scene::LightKind::directional;
  sun.intensity = Vec3(math::pi);
  s.lights = {sun};
  s.cameras = {analytic::camera_at({0, 0, 4}, .8f)};
  Settings t = settings(32, 16, Shader::path, 1);
  t.threads = 1;
  const Picture one = render(s, t);
  int different = 0;
  for (const int threads : {2, 7}) {
    t.threads = threads;
    different += different_pixels(one, render(s, t));
  }
  EXPECT_EQ(different, 0);
  for (const Vec3& v : one.mean) {
    EXPECT_NEAR(v.x + v.y, 1, 1e-5);
    EXPECT_EQ(v.z, 0);
  }
  measured(different, " of 2048 pixels differ between 1, 2 and 7 threads");
}

// G21. Layers that let everything through, 40 of them in one plane.
TEST(Geometry, a_thousand_transparent_layers_let_all_light_through) {
  const auto layers = [](int count) {
    scene::Scene s;
    s.materials = {analytic::lambert(.5f)};
    s.materials[0].alpha = 0;
    s.materials[0].alpha_mode = scene::AlphaMode::mask;
    for (int i = 0; i < count; ++i) {
      const float z = static_cast<float>(i < 40 ? 0 : i) * .01f;
      s.meshes.push_back(quad({-9, -9, z}, {9, -9, z}, {9, 9, z}, {-9, 9, z}));
      s.instances.push_back({i});
    }
    s.environment = constant(1);
    s.cameras = {analytic::camera_at({0, 0, 15}, .2f)};
    return s;
  };
  double worst = 0;
  for (const int count : {4, 64, 1000})
    worst = std::max(worst, std::fabs(render(layers(count), settings(8, 8, Shader::path, 2)).average - 1));
  EXPECT_LE(worst, 1e-3);
  measured("largest error ", worst, " behind 4, 64 and 1000 layers");
}

// G23, G24. Nothing to see, and an eye where it should not be.
TEST(Geometry, nothing_and_an_eye_inside_or_on_a_surface_are_rendered) {
  scene::Scene s;
  s.environment = constant(.25f);
  s.cameras = {analytic::camera_at({0, 0, 0}, 1)};
  for (const bool degenerate : {false, true}) {
    if (degenerate) {
      s.meshes = {{}, quad({0, 0, -1}, {0, 0, -1}, {0, 0, -1}, {1, 0, -1})};
      s.materials = {analytic::lambert(1)};
      s.instances = {{0}, {1}};
    }
    for (const Vec3& v : render(s, settings(16, 8)).mean) EXPECT_EQ(v, Vec3(.25f));
  }
  s = still_life();
  for (const Vec3& eye : {Vec3(0, 1, 0), Vec3(0, 0, 0), Vec3(.5f, 0, .5f), Vec3(0, 2, 0)})
    for (const float fov : {1e-6f, 3.1415f}) {
      s.cameras = {analytic::camera_at(eye, fov)};
      for (const Vec3& v : render(s, settings(16, 8)).mean) EXPECT_TRUE(math::is_finite(v));
    }
  measured("the background exactly; 8 odd cameras finite");
}

}  // namespace
}  // namespace robust
