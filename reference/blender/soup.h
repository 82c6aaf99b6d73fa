// The triangle soup: what Blender's Principled BSDF is at thousands of (material, wo, wi), stored by
// soup/soup.py, and what Assay's shipping bsdf::eval says at the same ones.
//
// A pixel of soup.exr is one configuration. Frames and parameters are what Cycles' shader saw, read back from
// the same render; here they are only turned into the shading frame (in double, then rounded to the float
// that bsdf::eval takes). Values are BRDF times cosine, 1/sr.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "bsdf/disney.h"

namespace blender {

using Vec3d = std::array<double, 3>;

struct Configuration {
  Vec3d wo, wi, normal, geometric, tangent;  // world, as Cycles saw them; tangent neither unit nor orthogonal
  bsdf::Parameters parameters;
  double turns = 0;  // anisotropic rotation
  Vec3d blender;     // Blender's answer
  int subset = 0;    // index into Soup::subsets
};

struct Soup {
  std::vector<std::string> subsets;
  std::vector<Configuration> configurations;
  std::string witness, script_hash;
};

// Throws std::runtime_error naming the file.
Soup read_soup(const std::string& path);

// A mistake to plant in Assay's evaluation, each part optional.
struct Fault {
  const char* name = "";
  void (*parameters)(bsdf::Parameters&, double& turns) = nullptr;
  void (*lobes)(bsdf::Bsdf&, const bsdf::Parameters&) = nullptr;
  // Times the specular lobe and the coat: wo, wi, and the alpha^2 of G1 along each.
  double (*masking)(double cos_o, double cos_i, double alpha2_o, double alpha2_i) = nullptr;
};

// Assay's answer, lobe by lobe, and how far float arithmetic like Cycles' may be from it.
struct Answer {
  Vec3d diffuse{}, specular{}, clearcoat{};  // diffuse with sheen
  // D as a function of the rounding of n.h: the specular lobe is proportional to 1/s^2, the coat to 1/s,
  // s = sin^2 + alpha^2 cos^2 of the half vector; `error` is that of s for one unit of (n.h)^2.
  double specular_s = 1, specular_error = 1, clearcoat_s = 1;

  double total(int k) const;
  // The value if (n.h)^2 were too small by `epsilon`; infinity where an s would not be positive.
  double off(int k, double epsilon) const;
};

Answer ask(const Configuration& configuration, bsdf::Model model, const Fault& fault = {});

}  // namespace blender
