// The scene as plain data, addressed by index. Filled by gltf/, read by everything after it; next to no
// behaviour. World space is glTF's: right-handed, +y up, metres. Angles in radians. Colours and radiances
// linear Rec.709.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "math/vec.h"

namespace scene {

// A texture's image. Row 0 is the top row, which glTF puts at v = 0.
struct EncodedBitmap {
  std::string name;
  int width = 0, height = 0;
  // width * height, row-major: RGBA with alpha unassociated, 65535 is one (8-bit codes times 257), sRGB *not*
  // decoded: whether a texel is a colour depends on who looks it up.
  std::vector<math::U16Vec4> texels;
};

// The value of a texel, before any decoding of sRGB.
inline math::Vec4 fraction(const math::U16Vec4& texel) {
  const auto part = [](std::uint16_t code) { return static_cast<float>(code) / 65535; };
  return {part(texel.x), part(texel.y), part(texel.z), part(texel.w)};
}

// An environment map in the same order: linear radiance in RGB.
struct Bitmap {
  std::string name;
  int width = 0, height = 0;
  std::vector<math::Vec4> texels;  // width * height, row-major
};

enum class Wrap { repeat, mirror, clamp };
enum class Filter { linear, nearest };

struct Texture {
  int bitmap = -1;  // index into Scene::bitmaps; -1: absent
  int texcoord_set = 0;
  Wrap wrap_u = Wrap::repeat, wrap_v = Wrap::repeat;
  Filter filter = Filter::linear;
  // KHR_texture_transform as a 2x3 matrix: u' = a u + b v + c, v' = d u + e v + f.
  float a = 1, b = 0, c = 0, d = 0, e = 1, f = 0;

  bool operator==(const Texture&) const = default;
};

enum class AlphaMode { opaque, mask, blend };

// Disney 2012 parameters (Burley 2012, section 5.1; each in [0,1]) plus what glTF adds.
struct Material {
  std::string name;
  math::Vec3 base_color{1, 1, 1};
  float alpha = 1;
  float metallic = 1, roughness = 1;  // glTF's defaults
  float specular = .5f, specular_tint = 0;
  float anisotropic = 0;
  float anisotropic_rotation = 0;  // turns, counter-clockwise about the normal from the tangent
  float sheen = 0, sheen_tint = .5f;
  float clearcoat = 0;
  float clearcoat_roughness =
      .1778279f;                 // alpha of the coat is its square; Disney's gloss g: sqrt(mix(.1,.001,g))
  math::Vec3 emission{0, 0, 0};  // radiance, W/(sr m^2)
  AlphaMode alpha_mode = AlphaMode::opaque;
  float alpha_cutoff = .5f;
  bool double_sided = false;  // false: back faces let every ray through (glTF's culling)
  float normal_scale = 1;
  Texture base_color_texture;          // RGB sRGB, A linear
  Texture metallic_roughness_texture;  // G roughness, B metallic, linear
  Texture normal_texture;              // tangent space, linear
  Texture emissive_texture;            // sRGB

  bool operator==(const Material&) const = default;
};

struct Mesh {  // one glTF primitive, as indexed triangles, in object space
  std::string name;
  std::vector<math::Vec3> positions;
  std::vector<math::Vec3> normals;  // empty: flat-shaded with the geometric normal
  std::vector<math::Vec4>
      tangents;  // xyz unit, w = +-1 handedness; empty: derived from texcoord set of the normal map
  std::vector<math::Vec2> texcoords[2];  // empty: absent
  std::vector<math::Vec4> colors;        // linear RGBA, multiplies base colour; empty: white
  std::vector<math::UVec3> triangles;    // counter-clockwise seen from the front
  int material = 0;                      // index into Scene::materials
};

struct Instance {
  int mesh = 0;
  math::Mat4 to_world{1.0f};  // affine; a negative determinant flips which side is the front as glTF demands
};

struct Camera {
  std::string name;
  bool orthographic = false;
  float yfov = .8f;  // perspective: full vertical angle; the horizontal one follows from the image's aspect
  float ymag = 1;    // orthographic: half the height of the view, metres
  float aspect =
      0;  // width / height the file has in mind; only who leaves the image's size open asks; 0: none
  math::Mat4 to_world{1.0f};  // looks along -z, up is +y; rigid (scale removed)

  bool operator==(const Camera&) const = default;
};

enum class LightKind { directional, point, spot };
struct Light {  // KHR_lights_punctual
  std::string name;
  LightKind kind = LightKind::point;
  math::Vec3 intensity{0, 0, 0};  // point, spot: W/sr; directional: irradiance W/m^2 on a plane facing it
  math::Vec3 position{0, 0, 0};
  math::Vec3 direction{0, 0, -1};  // unit, the way the light travels
  float cos_inner = 1, cos_outer = .7071068f;
  int node = -1;  // of the file it was read from, for who writes it back

  bool operator==(const Light&) const = default;
};

// Latitude-longitude radiance map. Direction d (unit, world) is looked up at
// u = 1/2 + atan2(d'.z, d'.x) / 2 pi, v = acos(d'.y) / pi (v = 0 the top row), d' = d turned by -rotation
// about +y.
struct Environment {
  Bitmap map;
  float strength = 1;
  float rotation = 0;  // radians about +y
};

struct Scene {
  std::string file;
  std::string hash;  // SHA-256 of the bytes the scene is made of, see docs/formats.md
  std::vector<EncodedBitmap> bitmaps;
  std::vector<Material> materials;
  std::vector<Mesh> meshes;
  std::vector<Instance> instances;
  std::vector<Camera> cameras;
  std::vector<Light> lights;
  std::optional<Environment> environment;
  std::vector<std::string>
      warnings;  // one line each: what the file uses and Assay does not render, approximations
};

// A mesh whose instances have no more triangles together is copied for each of them: a ray that enters an
// instance begins a tree of its own, which costs up to a fifth of a path's time whatever the mesh's size, and
// so many copies cost a millisecond and half a megabyte.
inline constexpr std::size_t copied_triangles = 4096;

// How often the acceleration structure has each mesh: once for each instance of a mesh that is used once or
// copied, else 0, where instances share it.
inline std::vector<std::size_t> copies(const Scene& scene) {
  std::vector<std::size_t> n(scene.meshes.size(), 0);
  for (const Instance& i : scene.instances) ++n[static_cast<std::size_t>(i.mesh)];
  for (std::size_t m = 0; m < n.size(); ++m)
    if (n[m] > 1 && n[m] * scene.meshes[m].triangles.size() > copied_triangles) n[m] = 0;
  return n;
}

}  // namespace scene
