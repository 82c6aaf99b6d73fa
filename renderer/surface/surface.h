// From "ray hits triangle" to everything shading needs: position, frames, looked-up material. Also the only
// place where a ray's origin is moved off its surface.
#pragma once

#include <cstdint>
#include <vector>

#include "accel/accel.h"
#include "bsdf/model.h"
#include "math/frame.h"
#include "scene/scene.h"
#include "surface/texture.h"

namespace surface {

// A triangle in world space. `normal` is unit, on the side glTF calls the front.
struct Triangle {
  math::Vec3 p0, p1, p2;
  math::DVec3 e1, e2;  // p1 - p0, p2 - p0
  math::Vec3 normal;
  float area = 0;
};

struct Point {
  math::Vec3 position;
  math::Vec3 error;    // bound of the rounding of each coordinate of `position`, Embree's share included
  float distance = 0;  // along the ray
  math::Vec3 geometric_normal;  // world, on the side the ray came from
  bool front = true;            // whether that is the front
  math::Vec3 normal;            // world: smooth and normal-mapped, on the ray's side, before bending
  math::Frame frame;            // shading: z the bent normal, x the rotated tangent
  bsdf::Normals normals;        // in `frame`
  math::Vec2 texcoord{0, 0};
  bsdf::Parameters material;
  int plain_material = -1;       // index of the scene's material if `material` is what it says, untextured
  math::Vec3 emission{0, 0, 0};  // radiance towards the ray's origin
  int instance = 0, triangle = 0;
};

// Where a ray that leaves `p` along `direction` (world) starts: p moved off the surface by its rounding
// bound.
math::Vec3 origin(const Point& p, const math::Vec3& direction);
// The same for a point with the given error bound on a surface with the given normal, towards the normal's
// side.
math::Vec3 offset(const math::Vec3& position, const math::Vec3& error, const math::Vec3& normal);

// The shading normal `n` as it is seen from `wo`: bent towards the geometric normal `ng` where it could not
// reflect. All world, unit, on wo's side.
math::Vec3 bend_normal(const math::Vec3& ng, const math::Vec3& wo, const math::Vec3& n);

// A material's factors, without textures and vertex colours.
bsdf::Parameters plain(const scene::Material& material);

class Surfaces {
 public:
  // Keeps a reference to `scene`. `model` decides how textures are filtered.
  Surfaces(const scene::Scene& scene, bsdf::Model model);

  // Which instances have hits that must pass accepts().
  std::vector<bool> filtered() const;
  // False where the ray goes through: a culled back face, a masked or (by chance, from `key`) a blended
  // point.
  bool accepts(const accel::Ray& ray, const accel::Hit& hit, std::uint32_t key) const;

  // The ray's direction is unit.
  Point at(const accel::Ray& ray, const accel::Hit& hit) const;

  Triangle triangle(int instance, int triangle) const;
  // Bound of the rounding of a point with barycentric weights (b0, b1, b2) on a triangle.
  math::Vec3 error(int instance, int triangle, const math::Vec3& barycentric) const;
  const scene::Material& material(int instance) const;
  // Share of light that a point of a triangle stops: 1 unless its material is masked or blended.
  float coverage(int instance, int triangle, const math::Vec3& barycentric) const;
  // Emitted radiance at a point of a triangle (barycentric weights of the vertices), coverage not applied.
  math::Vec3 emission(int instance, int triangle, const math::Vec3& barycentric) const;

 private:
  struct Place {  // of one instance
    bool identity = true;
    bool flipped = false;              // negative determinant: the front is on the other side of the winding
    math::Mat3 normal_to_world{1.0f};  // inverse transpose
  };
  struct Aligned {  // of a material's textures with that of its base colour
    bool metallic_roughness, normal;
  };
  static math::Vec3 error(const scene::Instance& instance, const Place& place, const scene::Mesh& mesh,
                          const math::UVec3& t, const math::Vec3& barycentric);
  math::Vec3 tangent(const scene::Mesh& mesh, const scene::Instance& instance, const math::UVec3& t,
                     const math::Vec3& barycentric, int texcoord_set, const math::Vec3& normal,
                     float& handedness) const;
  math::Vec2 texcoord(const scene::Mesh& mesh, const math::UVec3& t, const math::Vec3& b,
                      const scene::Texture& texture) const;

  const scene::Scene& scene_;
  Textures textures_;
  std::vector<Place> places_;
  std::vector<Aligned> aligned_;  // of each material, whose textures stay while other things are edited
};

}  // namespace surface
