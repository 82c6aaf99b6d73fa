#include "app/defaults.h"

#include <cmath>
#include <limits>

#include "app/parse.h"
#include "base/error.h"
#include "math/transcendental.h"

namespace app {
namespace {

using math::Vec3;

// Calls visit(p) with every vertex of every instance in world space.
template <typename Visit>
void for_each_vertex(const scene::Scene& scene, const Visit& visit) {
  for (const scene::Instance& instance : scene.instances)
    for (const Vec3& position : scene.meshes[static_cast<size_t>(instance.mesh)].positions) {
      const Vec3 p = math::transform_point(instance.to_world, position);
      if (math::is_finite(p)) visit(p);
    }
}

}  // namespace

// A point with coordinates (r, u, b) along right, up and back is inside the view of an eye at (er, eu, eb) if
// |r - er| <= (eb - b) tx and |u - eu| <= (eb - b) ty. So with R = max(r + b tx) and L = max(-r + b tx) over
// all points, the nearest eye has er = (R - L) / 2 and eb = (R + L) / (2 tx); the same in the other axis.
std::optional<scene::Camera> framing_camera(const scene::Scene& scene, float aspect) {
  scene::Camera camera;
  camera.name = "framed";
  camera.yfov = .6f;
  const Vec3 back = math::normalize({.55f, .45f, 1});
  const Vec3 right = math::normalize(math::cross({0, 1, 0}, back));
  const Vec3 up = math::cross(back, right);
  const float margin = 1.08f;
  float sine, cosine;
  math::sin_cos(camera.yfov / 2, sine, cosine);
  const float ty = sine / cosine / margin, tx = ty * aspect;

  constexpr float lowest = std::numeric_limits<float>::lowest();
  float to_right = lowest, to_left = lowest, to_top = lowest, to_bottom = lowest, nearest_b = lowest;
  for_each_vertex(scene, [&](const Vec3& p) {
    const float r = math::dot(p, right), u = math::dot(p, up), b = math::dot(p, back);
    to_right = std::fmax(to_right, r + b * tx);
    to_left = std::fmax(to_left, -r + b * tx);
    to_top = std::fmax(to_top, u + b * ty);
    to_bottom = std::fmax(to_bottom, -u + b * ty);
    nearest_b = std::fmax(nearest_b, b);
  });
  if (nearest_b == lowest) return {};
  float distance = std::fmax((to_right + to_left) / (2 * tx), (to_top + to_bottom) / (2 * ty));
  if (!(distance > nearest_b)) distance = nearest_b + 1;  // a single point

  const Vec3 eye = right * ((to_right - to_left) / 2) + up * ((to_top - to_bottom) / 2) + back * distance;
  camera.to_world[0] = {right.x, right.y, right.z, 0};
  camera.to_world[1] = {up.x, up.y, up.z, 0};
  camera.to_world[2] = {back.x, back.y, back.z, 0};
  camera.to_world[3] = {eye.x, eye.y, eye.z, 1};
  return camera;
}

bool has_light(const scene::Scene& scene) {
  if (scene.environment) return true;
  for (const scene::Light& light : scene.lights)
    if (!math::is_black(light.intensity)) return true;
  for (const scene::Instance& instance : scene.instances) {
    const scene::Mesh& mesh = scene.meshes[static_cast<size_t>(instance.mesh)];
    if (!math::is_black(scene.materials[static_cast<size_t>(mesh.material)].emission)) return true;
  }
  return false;
}

scene::Environment neutral_environment() {
  scene::Environment sky;
  sky.map.name = "neutral sky";
  sky.map.width = 64;
  sky.map.height = 32;
  const Vec3 key = math::normalize({-.6f, .8f, .7f});
  for (int y = 0; y < sky.map.height; ++y)
    for (int x = 0; x < sky.map.width; ++x) {
      const float theta = math::pi * (static_cast<float>(y) + .5f) / static_cast<float>(sky.map.height);
      const float phi =
          2 * math::pi * ((static_cast<float>(x) + .5f) / static_cast<float>(sky.map.width) - .5f);
      float sin_theta, cos_theta, sin_phi, cos_phi;
      math::sin_cos(theta, sin_theta, cos_theta);
      math::sin_cos(phi, sin_phi, cos_phi);
      const Vec3 d{sin_theta * cos_phi, cos_theta, sin_theta * sin_phi};
      // Floor to sky in a smooth step that hides the horizon's edge, and a broad glow.
      const float t = math::saturate((d.y + .2f) / .4f);
      const float base = math::mix(.2f, .45f, t * t * (3 - 2 * t));
      const float value = base + 4 * math::pow(math::saturate(math::dot(d, key)), 12.f);
      sky.map.texels.push_back({value, value, value, 1});
    }
  return sky;
}

scene::Environment constant_environment(const Vec3& radiance) {
  scene::Environment constant;
  constant.map.name = "constant";
  constant.map.width = 2;
  constant.map.height = 1;
  constant.map.texels.assign(2, {radiance.x, radiance.y, radiance.z, 1});
  return constant;
}

int find_camera(const scene::Scene& scene, const std::string& camera) {
  std::vector<std::string> names;
  std::string list;
  for (size_t i = 0; i < scene.cameras.size(); ++i) {
    if (scene.cameras[i].name == camera) return static_cast<int>(i);
    names.push_back(scene.cameras[i].name);
    list += (i == 0 ? "" : ", ") + std::to_string(i) + " '" + scene.cameras[i].name + "'";
  }
  const bool is_index = !camera.empty() && camera.find_first_not_of("0123456789") == std::string::npos;
  if (is_index && camera.size() < 9 && std::stoul(camera) < names.size()) return std::stoi(camera);
  const std::string near = nearest(camera, names);
  base::fail(scene.file, ": --camera: wanted one of ", list.empty() ? "none (the file has no camera)" : list,
             "; found '", camera, "'", near.empty() ? "" : ", near '" + near + "'");
}

}  // namespace app
