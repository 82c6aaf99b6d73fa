#include "app/defaults.h"

#include <CLI/StringTools.hpp>
#include <cmath>
#include <limits>

#include "app/text.h"
#include "base/error.h"
#include "math/transcendental.h"

namespace app {
using math::Vec3;

// A point with coordinates (r, u, b) along right, up and back is inside the view of an eye at (er, eu, eb) if
// |r - er| <= (eb - b) tx and |u - eu| <= (eb - b) ty. So with R = max(r + b tx) and L = max(-r + b tx) over
// all points, the nearest eye has er = (R - L) / 2 and eb = (R + L) / (2 tx); the same in the other axis.
scene::Camera framing_camera(const scene::Scene& scene, float aspect) {
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
  for (const scene::Instance& instance : scene.instances)
    for (const Vec3& position : scene.meshes[static_cast<size_t>(instance.mesh)].positions) {
      const Vec3 p = math::transform_point(instance.to_world, position);
      if (!math::is_finite(p)) continue;
      const float r = math::dot(p, right), u = math::dot(p, up), b = math::dot(p, back);
      to_right = std::fmax(to_right, r + b * tx);
      to_left = std::fmax(to_left, -r + b * tx);
      to_top = std::fmax(to_top, u + b * ty);
      to_bottom = std::fmax(to_bottom, -u + b * ty);
      nearest_b = std::fmax(nearest_b, b);
    }
  if (nearest_b == lowest)
    base::fail(scene.file, ": wanted something to render, found no triangles and no camera");
  float distance = std::fmax((to_right + to_left) / (2 * tx), (to_top + to_bottom) / (2 * ty));
  if (!(distance > nearest_b)) distance = nearest_b + 1;  // a single point

  const Vec3 eye = right * ((to_right - to_left) / 2) + up * ((to_top - to_bottom) / 2) + back * distance;
  camera.to_world =
      math::Mat4(math::Vec4(right, 0), math::Vec4(up, 0), math::Vec4(back, 0), math::Vec4(eye, 1));
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

bool shows_light(integrator::Shader shader) {
  return shader != integrator::Shader::eyelight && shader < integrator::Shader::normal;
}

scene::Environment neutral_environment() {
  constexpr int width = 64, height = 32;
  scene::Environment sky{{"neutral sky", width, height, {}}, 1, 0};
  const Vec3 key = math::normalize({-.6f, .8f, .7f});
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      float sin_theta, cos_theta, sin_phi, cos_phi;
      math::sin_cos(math::pi * (static_cast<float>(y) + .5f) / height, sin_theta, cos_theta);
      math::sin_cos(2 * math::pi * ((static_cast<float>(x) + .5f) / width - .5f), sin_phi, cos_phi);
      const Vec3 d{sin_theta * cos_phi, cos_theta, sin_theta * sin_phi};
      // Floor to sky in a smooth step that hides the horizon's edge, and a broad glow.
      const float t = math::saturate((d.y + .2f) / .4f);
      const float base = math::mix(.2f, .45f, t * t * (3 - 2 * t));
      const float value = base + 4 * math::pow(math::saturate(math::dot(d, key)), 12.f);
      sky.map.texels.push_back({value, value, value, 1});
    }
  return sky;
}

scene::Environment constant_environment(const std::vector<float>& radiance) {
  const math::Vec4 texel{radiance[0], radiance[1], radiance[2], 1};
  return {{"constant", 2, 1, {texel, texel}}, 1, 0};
}

int find_camera(const scene::Scene& scene, const std::string& camera) {
  std::vector<std::string> names, list;
  for (const scene::Camera& c : scene.cameras) {
    if (c.name == camera) return static_cast<int>(names.size());
    list.push_back(std::to_string(names.size()) + " '" + c.name + "'");
    names.push_back(c.name);
  }
  for (size_t i = 0; i < names.size(); ++i)
    if (camera == std::to_string(i)) return static_cast<int>(i);
  base::fail(scene.file, ": --camera: wanted one of ",
             list.empty() ? "none (the file has no camera)" : CLI::detail::join(list, ", "), "; found '",
             camera, "'", nearest(camera, names));
}

}  // namespace app
