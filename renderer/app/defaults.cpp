#include "app/defaults.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "app/parse.h"
#include "base/error.h"

namespace app {
namespace {

using math::Vec3;

struct Box {
  Vec3 least{std::numeric_limits<float>::max()}, most{std::numeric_limits<float>::lowest()};
  bool empty() const { return least.x > most.x; }
};

Box bounds(const scene::Scene& scene) {
  Box box;
  for (const scene::Instance& instance : scene.instances)
    for (const Vec3& position : scene.meshes[static_cast<size_t>(instance.mesh)].positions) {
      const Vec3 p = math::transform_point(instance.to_world, position);
      if (!math::is_finite(p)) continue;
      box.least = {std::fmin(box.least.x, p.x), std::fmin(box.least.y, p.y), std::fmin(box.least.z, p.z)};
      box.most = {std::fmax(box.most.x, p.x), std::fmax(box.most.y, p.y), std::fmax(box.most.z, p.z)};
    }
  return box;
}

}  // namespace

std::optional<scene::Camera> framing_camera(const scene::Scene& scene, float aspect) {
  const Box box = bounds(scene);
  if (box.empty()) return {};
  const Vec3 half = (box.most - box.least) * .5f;
  const Vec3 centre = box.least + half;

  scene::Camera camera;
  camera.name = "framed";
  camera.yfov = .6f;
  const Vec3 back = math::normalize({.55f, .45f, 1});
  const Vec3 right = math::normalize(math::cross({0, 1, 0}, back));
  const Vec3 up = math::cross(back, right);

  // A corner q of the box, relative to the centre, is inside the view from distance d if |q.right| and |q.up|
  // are at most (d - q.back) times the tangent of half the angle.
  const float margin = 1.08f;
  const float tan_y = std::tan(camera.yfov / 2), tan_x = tan_y * aspect;
  float distance = 0;
  for (int corner = 0; corner < 8; ++corner) {
    const Vec3 q{(corner & 1) ? half.x : -half.x, (corner & 2) ? half.y : -half.y,
                 (corner & 4) ? half.z : -half.z};
    const float needed =
        std::fmax(std::fabs(math::dot(q, right)) / tan_x, std::fabs(math::dot(q, up)) / tan_y);
    distance = std::fmax(distance, math::dot(q, back) + margin * needed);
  }
  if (!(distance > 0)) distance = 1;  // a single point

  const Vec3 eye = centre + back * distance;
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
  sky.map.width = 4;
  sky.map.height = 32;
  for (int y = 0; y < sky.map.height; ++y) {
    // The cosine to the zenith of the row's middle; a smooth step of .1 hides the horizon's edge.
    const float up = std::cos(math::pi * (static_cast<float>(y) + .5f) / static_cast<float>(sky.map.height));
    const float above = math::mix(.75f, 1.f, math::saturate(up));
    const float t = math::saturate((up + .1f) / .2f);
    const float value = math::mix(.3f, above, t * t * (3 - 2 * t));
    for (int x = 0; x < sky.map.width; ++x) sky.map.texels.push_back({value, value, value, 1});
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
