#include "surface/surface.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include "math/lanes.h"
#include "math/transcendental.h"

namespace surface {

namespace {

using math::Bits;
using math::cross;
using math::dot;
using math::DVec3;
using math::Lanes;
using math::Mat3;
using math::UVec3;
using math::Vec2;
using math::Vec3;
using math::Vec4;

// Embree's intersection and our own sums each err by a few units of 2^-24 of the coordinates involved.
// Measured over scene sizes from 1e-9 to 1e6: 8 is enough for zero self-hits, 32 skips no gap of ten units or
// more.
constexpr float rounding_factor = 16 * 5.9604645e-8f;

template <typename T>
T interpolate(const std::vector<T>& values, const UVec3& t, const Vec3& b) {
  return values[t.x] * b.x + values[t.y] * b.y + values[t.z] * b.z;
}

// Uniform in [0,1) from a ray's key and the triangle it meets: Embree may ask twice about one hit, and must
// get one answer.
float uniform(std::uint32_t key, const accel::Hit& hit) {
  std::uint32_t x = key ^ (static_cast<std::uint32_t>(hit.instance) * 0x9e3779b9u) ^
                    (static_cast<std::uint32_t>(hit.triangle) * 0x85ebca6bu);
  for (int i = 0; i < 2; ++i) {
    x ^= x >> 16, x *= 0x7feb352du;
    x ^= x >> 15, x *= 0x846ca68bu;
    x ^= x >> 16;
  }
  return static_cast<float>(x >> 8) * 0x1p-24f;
}

// The neighbours of `from` in the direction of `step`'s sign, as std::nextafter finds them for finite
// numbers; `from` itself where `step` is 0.
Lanes next_towards(Lanes from, Lanes step) {
  const auto bits = std::bit_cast<Bits>(from), towards = std::bit_cast<Bits>(step);
  constexpr std::uint32_t sign = 0x80000000;
  const Bits past_0 = (towards & sign) | 1, next = (bits ^ towards) < sign ? bits + 1 : bits - 1;
  return std::bit_cast<Lanes>(step == 0 ? bits : from == 0 ? past_0 : next);
}

}  // namespace

bsdf::Parameters plain(const scene::Material& m) {
  return {m.base_color,  m.metallic, m.roughness,  m.specular,  m.specular_tint,
          m.anisotropic, m.sheen,    m.sheen_tint, m.clearcoat, m.clearcoat_roughness};
}

Vec3 offset(const Vec3& position, const Vec3& error, const Vec3& normal) {
  const float d = dot(math::abs(normal), error);
  const Lanes step = Lanes{normal.x, normal.y, normal.z, 0} * math::all(d);
  // One float further, in case the sum was rounded towards the surface.
  const Lanes o = next_towards(Lanes{position.x, position.y, position.z, 0} + step, step);
  return {o[0], o[1], o[2]};
}

Vec3 origin(const Point& p, const Vec3& direction) {
  return offset(p.position, p.error,
                dot(direction, p.geometric_normal) < 0 ? -p.geometric_normal : p.geometric_normal);
}

Surfaces::Surfaces(const scene::Scene& scene, bsdf::Model model)
    : scene_(scene), textures_(scene, model == bsdf::Model::principled) {
  places_.reserve(scene.instances.size());
  for (const scene::Instance& i : scene.instances) {
    Place place;
    place.identity = i.to_world == math::Mat4(1.0f);
    // Inverse transpose up to a positive factor: the cofactor matrix times the determinant's sign.
    const Vec3 a(i.to_world[0]), b(i.to_world[1]), c(i.to_world[2]);
    place.flipped = dot(cross(a, b), c) < 0;
    const float sign = place.flipped ? -1.f : 1.f;
    place.normal_to_world = Mat3(cross(b, c) * sign, cross(c, a) * sign, cross(a, b) * sign);
    places_.push_back(place);
  }
  for (const scene::Material& m : scene.materials)
    aligned_.push_back({textures_.aligned(m.base_color_texture, m.metallic_roughness_texture),
                        textures_.aligned(m.base_color_texture, m.normal_texture)});
}

std::vector<bool> Surfaces::filtered() const {
  std::vector<bool> result;
  for (const scene::Instance& i : scene_.instances) {
    const scene::Material& m =
        scene_.materials[static_cast<size_t>(scene_.meshes[static_cast<size_t>(i.mesh)].material)];
    result.push_back(!m.double_sided || m.alpha_mode != scene::AlphaMode::opaque);
  }
  return result;
}

const scene::Material& Surfaces::material(int instance) const {
  const auto mesh = static_cast<size_t>(scene_.instances[static_cast<size_t>(instance)].mesh);
  return scene_.materials[static_cast<size_t>(scene_.meshes[mesh].material)];
}

Triangle Surfaces::triangle(int instance, int index) const {
  const scene::Instance& i = scene_.instances[static_cast<size_t>(instance)];
  const scene::Mesh& mesh = scene_.meshes[static_cast<size_t>(i.mesh)];
  const Place& place = places_[static_cast<size_t>(instance)];
  const UVec3& t = mesh.triangles[static_cast<size_t>(index)];
  Triangle r{mesh.positions[t.x], mesh.positions[t.y], mesh.positions[t.z], {}, {}, {}, 0};
  if (!place.identity)
    for (Vec3* p : {&r.p0, &r.p1, &r.p2}) *p = math::transform_point(i.to_world, *p);
  // In double: float loses triangles smaller than 1e-12 and larger than 1e10.
  r.e1 = DVec3(r.p1) - DVec3(r.p0);
  r.e2 = DVec3(r.p2) - DVec3(r.p0);
  const DVec3 n = cross(r.e1, r.e2);
  const double length = math::length(n);
  r.normal = Vec3(n * (length > 0 ? (place.flipped ? -1 : 1) / length : 0));
  r.area = static_cast<float>(.5 * length);
  return r;
}

Vec3 Surfaces::error(int instance, int triangle, const Vec3& b) const {
  const scene::Instance& i = scene_.instances[static_cast<size_t>(instance)];
  const scene::Mesh& mesh = scene_.meshes[static_cast<size_t>(i.mesh)];
  return error(i, places_[static_cast<size_t>(instance)], mesh, mesh.triangles[static_cast<size_t>(triangle)],
               b);
}

Vec3 Surfaces::error(const scene::Instance& i, const Place& place, const scene::Mesh& mesh, const UVec3& t,
                     const Vec3& b) {
  const Vec3 sum = math::abs(mesh.positions[t.x]) * b.x + math::abs(mesh.positions[t.y]) * b.y +
                   math::abs(mesh.positions[t.z]) * b.z;
  if (place.identity) return sum * rounding_factor;
  const math::Mat4& m = i.to_world;
  return (math::abs(Vec3(m[0])) * sum.x + math::abs(Vec3(m[1])) * sum.y + math::abs(Vec3(m[2])) * sum.z +
          math::abs(Vec3(m[3]))) *
         rounding_factor;
}

Vec2 Surfaces::texcoord(const scene::Mesh& mesh, const UVec3& t, const Vec3& b,
                        const scene::Texture& texture) const {
  const auto& set = mesh.texcoords[texture.texcoord_set];
  return set.empty() ? Vec2(0) : interpolate(set, t, b);
}

float Surfaces::coverage(int instance, int triangle, const Vec3& b) const {
  const scene::Material& m = material(instance);
  if (m.alpha_mode == scene::AlphaMode::opaque) return 1;
  const scene::Mesh& mesh =
      scene_.meshes[static_cast<size_t>(scene_.instances[static_cast<size_t>(instance)].mesh)];
  const UVec3& t = mesh.triangles[static_cast<size_t>(triangle)];
  float a = m.alpha;
  if (m.base_color_texture.bitmap >= 0)
    a *= textures_.data(m.base_color_texture, texcoord(mesh, t, b, m.base_color_texture)).w;
  if (!mesh.colors.empty()) a *= interpolate(mesh.colors, t, b).w;
  if (m.alpha_mode == scene::AlphaMode::mask) return a >= m.alpha_cutoff ? 1.f : 0.f;
  return math::saturate(a);
}

bool Surfaces::accepts(const accel::Ray& ray, const accel::Hit& hit, std::uint32_t key) const {
  const scene::Material& m = material(hit.instance);
  if (!m.double_sided && dot(triangle(hit.instance, hit.triangle).normal, ray.direction) >= 0) return false;
  if (m.alpha_mode == scene::AlphaMode::opaque) return true;
  const float a = coverage(hit.instance, hit.triangle, Vec3(1 - hit.u - hit.v, hit.u, hit.v));
  return a >= 1 || uniform(key, hit) < a;
}

namespace {

// Möller-Trumbore in double on the world-space triangle that Embree named. Its own weights serve only where
// the ray runs within the triangle's plane.
Vec3 barycentric(const accel::Ray& ray, const Triangle& t, const accel::Hit& hit) {
  const DVec3 d(ray.direction), s = DVec3(ray.origin) - DVec3(t.p0);
  const DVec3 p = cross(d, t.e2), q = cross(s, t.e1);
  const double scale = 1 / dot(p, t.e1);
  double u = hit.u, v = hit.v;
  if (std::isfinite(scale)) {
    u = dot(s, p) * scale;
    v = dot(d, q) * scale;
  }
  u = std::clamp(u, 0., 1.);
  v = std::clamp(v, 0., 1. - u);
  return {static_cast<float>(1 - u - v), static_cast<float>(u), static_cast<float>(v)};
}

}  // namespace

Vec3 Surfaces::emission(int instance, int triangle, const Vec3& b) const {
  const scene::Material& m = material(instance);
  if (m.emissive_texture.bitmap < 0) return m.emission;
  const scene::Mesh& mesh =
      scene_.meshes[static_cast<size_t>(scene_.instances[static_cast<size_t>(instance)].mesh)];
  const Vec4 c =
      textures_.colour(m.emissive_texture,
                       texcoord(mesh, mesh.triangles[static_cast<size_t>(triangle)], b, m.emissive_texture));
  return m.emission * Vec3(c);
}

// World-space tangent, orthogonal to nothing yet: from the TANGENT attribute or from the texture coordinates'
// gradient.
Vec3 Surfaces::tangent(const scene::Mesh& mesh, const scene::Instance& instance, const UVec3& t,
                       const Vec3& b, int set, const Vec3& normal, float& handedness) const {
  handedness = 1;
  if (!mesh.tangents.empty()) {
    const Vec4 v = interpolate(mesh.tangents, t, b);
    handedness = v.w < 0 ? -1.f : 1.f;
    return math::transform_vector(instance.to_world, Vec3(v));
  }
  const auto& uv = mesh.texcoords[set];
  if (uv.empty()) return Vec3(0);
  const Vec2 d1 = uv[t.y] - uv[t.x], d2 = uv[t.z] - uv[t.x];
  const float det = d1.x * d2.y - d1.y * d2.x;
  if (det == 0) return Vec3(0);
  const Vec3 e1 = mesh.positions[t.y] - mesh.positions[t.x], e2 = mesh.positions[t.z] - mesh.positions[t.x];
  const Vec3 du = math::transform_vector(instance.to_world, (e1 * d2.y - e2 * d1.y) * (det < 0 ? -1.f : 1.f));
  const Vec3 dv = math::transform_vector(instance.to_world, (e2 * d1.x - e1 * d2.x) * (det < 0 ? -1.f : 1.f));
  // glTF's v runs down the image and its bitangent up: B = -dP/dv.
  handedness = dot(cross(normal, du), dv) < 0 ? 1.f : -1.f;
  return du;
}

// Cycles' ensure_valid_reflection in closed form: if the mirror direction of wo at n would dip below the
// surface (its elevation over ng less than min(.9 wo.ng, .01)), n is turned towards ng, in their plane, until
// it has just that elevation. With n = (sin t, cos t) in the plane (x, ng) and wo = (ix, iz) plus a part
// across the plane: elevation = ix sin 2t + iz cos 2t, whose first crossing from t = 0 is the one taken.
Vec3 bend_normal(const Vec3& ng, const Vec3& wo, const Vec3& n) {
  const float iz = dot(wo, ng);
  const float threshold = std::min(.9f * iz, .01f);
  if (2 * dot(n, wo) * dot(n, ng) - iz >= threshold) return n;
  const Vec3 x = math::normalize(n - ng * dot(n, ng), Vec3(0));
  if (math::is_black(x)) return ng;
  const float ix = dot(wo, x);
  const float a = ix * ix + iz * iz;
  if (!(a > 0)) return ng;
  const float cos_2t = (iz * threshold - ix * std::sqrt(std::max(0.f, a - threshold * threshold))) / a;
  const float cos2 = math::saturate(.5f * (1 + cos_2t));
  return math::normalize(x * std::sqrt(1 - cos2) + ng * std::sqrt(cos2), ng);
}

Point Surfaces::at(const accel::Ray& ray, const accel::Hit& hit) const {
  const scene::Instance& instance = scene_.instances[static_cast<size_t>(hit.instance)];
  const scene::Mesh& mesh = scene_.meshes[static_cast<size_t>(instance.mesh)];
  const scene::Material& m = scene_.materials[static_cast<size_t>(mesh.material)];
  const Place& place = places_[static_cast<size_t>(hit.instance)];
  const UVec3& t = mesh.triangles[static_cast<size_t>(hit.triangle)];

  // Recompute where the ray meets the triangle.
  const Triangle world = triangle(hit.instance, hit.triangle);
  Point p;
  p.instance = hit.instance;
  p.triangle = hit.triangle;
  const Vec3 b = barycentric(ray, world, hit);
  // Textures' texels are called for here and read below.
  Textures::Place base_color, metallic_roughness, bumps;
  const auto find = [&](const scene::Texture& texture, bool aligned, Textures::Place& place) {
    if (texture.bitmap < 0) return;
    place = aligned ? textures_.moved(base_color, m.base_color_texture, texture)
                    : textures_.find(texture, texcoord(mesh, t, b, texture));
  };
  const Aligned& aligned = aligned_[static_cast<size_t>(mesh.material)];
  find(m.base_color_texture, false, base_color);
  find(m.metallic_roughness_texture, aligned.metallic_roughness, metallic_roughness);
  find(m.normal_texture, aligned.normal, bumps);
  p.position = world.p0 * b.x + world.p1 * b.y + world.p2 * b.z;
  p.error = error(instance, place, mesh, t, b);
  p.distance = static_cast<float>(dot(DVec3(p.position) - DVec3(ray.origin), DVec3(ray.direction)));

  // Turn the normals to the side the ray came from.
  const Vec3 wo = -ray.direction;
  p.front = dot(world.normal, wo) >= 0;
  p.geometric_normal = p.front ? world.normal : -world.normal;
  Vec3 smooth = world.normal;
  if (!mesh.normals.empty()) {
    Vec3 n = interpolate(mesh.normals, t, b);
    if (!place.identity) n = place.normal_to_world * n;
    smooth = math::normalize(n, world.normal);
  }

  // Look the material up.
  bsdf::Parameters& q = p.material;
  q = plain(m);
  if (m.base_color_texture.bitmap < 0 && m.metallic_roughness_texture.bitmap < 0 && mesh.colors.empty())
    p.plain_material = mesh.material;
  if (m.base_color_texture.bitmap >= 0) q.base_color *= Vec3(textures_.colour(base_color));
  if (!mesh.colors.empty()) q.base_color *= Vec3(interpolate(mesh.colors, t, b));
  if (m.metallic_roughness_texture.bitmap >= 0) {
    const Vec4 c = textures_.data(metallic_roughness);
    q.roughness *= c.y;
    q.metallic *= c.z;
  }
  if (!math::is_black(m.emission)) p.emission = emission(hit.instance, hit.triangle, b);
  p.texcoord = mesh.texcoords[0].empty() ? Vec2(0) : interpolate(mesh.texcoords[0], t, b);

  // Shading normal: smooth, then normal-mapped, then bent so that it can reflect.
  Vec3 normal = smooth;
  Vec3 along(0);
  float handedness = 1;
  if (m.normal_texture.bitmap >= 0 || m.anisotropic > 0)
    along = tangent(mesh, instance, t, b, m.normal_texture.bitmap >= 0 ? m.normal_texture.texcoord_set : 0,
                    smooth, handedness);
  if (m.normal_texture.bitmap >= 0) {
    const Vec4 c = textures_.data(bumps);
    const math::Frame f = math::frame_from_normal_and_tangent(smooth, along);
    normal = math::normalize(f.tangent * ((2 * c.x - 1) * m.normal_scale) +
                                 cross(smooth, f.tangent) * ((2 * c.y - 1) * m.normal_scale * handedness) +
                                 smooth * (2 * c.z - 1),
                             smooth);
  }
  if (!p.front) {
    normal = -normal;
    smooth = -smooth;
  }
  p.normal = normal;
  normal = bend_normal(p.geometric_normal, wo, normal);

  // Frame: x along the tangent, turned by the anisotropic rotation.
  p.frame = m.anisotropic > 0 ? math::frame_from_normal_and_tangent(normal, along)
                              : math::frame_from_normal(normal);
  if (m.anisotropic > 0 && m.anisotropic_rotation != 0) {
    float s, c;
    math::sin_cos(2 * math::pi * m.anisotropic_rotation, s, c);
    const Vec3 x = p.frame.tangent * c + p.frame.bitangent * s;
    p.frame.bitangent = p.frame.bitangent * c - p.frame.tangent * s;
    p.frame.tangent = x;
  }
  if (normal != smooth) p.normals.smooth = p.frame.to_local(smooth);
  if (normal != p.geometric_normal) p.normals.geometric = p.frame.to_local(p.geometric_normal);
  return p;
}

}  // namespace surface
