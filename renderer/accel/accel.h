// Which triangle does a ray hit? Embree answers, and only that: the position, the distance and everything
// derived from them are recomputed by surface/ from the vertices, so that the picture does not depend on
// Embree's arithmetic. Embree's types are seen by accel.cpp alone.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "scene/scene.h"

namespace accel {

struct Ray {
  math::Vec3 origin, direction;  // world; direction need not be unit
  float t_max = 3.0e38f;         // open interval (0, t_max)
};

struct Hit {
  int instance = -1;   // index into Scene::instances
  int triangle = -1;   // index into Mesh::triangles
  float u = 0, v = 0;  // barycentric weights of the triangle's second and third vertex, as Embree found them
};

// Decides whether a ray really hits a candidate (alpha, culled back faces). `key` is the ray's own random
// number, so that the decision is the same however often Embree asks.
using Filter = std::function<bool(const Ray&, const Hit&, std::uint32_t key)>;

class Accel {
 public:
  // Builds over all instances. A mesh used once or of few triangles (scene::copied_triangles) is placed
  // directly, others are Embree instances.
  // `filtered[i]` says whether instance i's hits must pass `filter` (empty: none). Triangles with an index
  // out of range or a non-finite vertex must have been removed by the loader.
  Accel(const scene::Scene& scene, bool fastest_isa, const std::vector<bool>& filtered, Filter filter);
  ~Accel();
  Accel(const Accel&) = delete;
  Accel& operator=(const Accel&) = delete;

  // Closest hit in (0, t_max); false if none or if the ray is not valid for Embree (non-finite, huge).
  bool closest(const Ray& ray, std::uint32_t key, Hit& hit) const;
  // Whether anything is hit in (0, t_max).
  bool occluded(const Ray& ray, std::uint32_t key) const;

  double build_seconds() const;
  std::string isa() const;  // what Embree was told to use

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace accel
