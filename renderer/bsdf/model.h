// The four reflection models, and every switch in which they differ.
//
//   disney       Burley 2012, "Physically-Based Shading at Disney", as in Disney's public reference shader
//   (no subsurface) principled   the opaque part of Blender 3.4.1's Principled BSDF (distribution GGX), term
//   by term path_disney  the 2018 report's model: Disney diffuse and D = c / (alpha^2 cos^2 + sin^2)^gamma
//   path         Lambert and GGX with Schlick's Fresnel
#pragma once

#include <cstdint>
#include <optional>

#include "math/vec.h"

namespace bsdf {

enum class Model : std::uint8_t { path, path_disney, principled, disney };

// path_disney's two controls. constant absent: the D that is normalised for the material's alpha.
struct Gtr {
  float gamma = 2;                // (0, 10]
  std::optional<float> constant;  // >= 0
};

// The Disney parameters at one point, after textures; each in [0,1], base_color linear Rec.709.
struct Parameters {
  math::Vec3 base_color{.8f, .8f, .8f};
  float metallic = 0, roughness = .5f;
  float specular = .5f, specular_tint = 0;
  float anisotropic = 0;
  float sheen = 0, sheen_tint = .5f;
  float clearcoat = 0, clearcoat_roughness = .1778279f;
};

// Normals other than the shading normal (0,0,1), in the shading frame, unit. On a flat surface all three
// agree.
struct Normals {
  math::Vec3 smooth{0, 0, 1};     // interpolated vertex normal, before normal map and bending
  math::Vec3 geometric{0, 0, 1};  // of the triangle, on the viewer's side
};

}  // namespace bsdf
