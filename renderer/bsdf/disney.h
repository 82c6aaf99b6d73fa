// The BRDF: a sum of lobes, none attenuating another, as a mixture for sampling.
//
// Conventions of this room, which hold for the whole renderer: wo points to the eye, wi to the light, wh is
// the half vector; bare names are in the shading frame (z the shading normal), unit, pointing away from the
// surface. f_cos is BRDF times |cos(wi)|, 1/sr; pdf is a density over solid angle, 1/sr. `roughness` is the
// artist's, alpha its square.
#pragma once

#include <array>
#include <optional>

#include "bsdf/clearcoat.h"
#include "bsdf/diffuse.h"
#include "bsdf/model.h"
#include "bsdf/sheen.h"
#include "bsdf/specular.h"

namespace bsdf {

enum class Lobe { diffuse, specular, clearcoat };  // sheen is sampled with diffuse
inline constexpr int lobe_count = 3;

// The BRDF at one point for one wo, ready to be evaluated and sampled.
struct Bsdf {
  Model model = Model::disney;
  Normals normals;
  Diffuse diffuse;
  Sheen sheen;
  Specular specular;
  Clearcoat clearcoat;
  float mean_diffuse = 0, mean_sheen = 0, mean_f0 = 0;  // over the channels, of the weights above
  float probability[lobe_count] = {0, 0, 0};            // of choosing each lobe; all zero if nothing reflects
  bool only_delta = false;                              // light sampling is useless: eval is zero everywhere
};

struct Sample {
  Vec3 wi;
  Vec3 f_cos;     // is_delta: reflectance; as everywhere, f_cos / pdf is the weight of the sample
  float pdf = 0;  // is_delta: probability of the lobe
  Lobe lobe = Lobe::diffuse;
  bool is_delta = false;
};

// Builds the lobes, which can serve many points. Parameters outside [0,1] are clamped here; alphas as the
// model clamps them.
Bsdf make(Model model, const Gtr& gtr, const Parameters& parameters);
// Readies them for one point and wo. wo.z > 0.
void orient(Bsdf& bsdf, const Normals& normals, const Vec3& wo);
// Both.
Bsdf prepare(Model model, const Gtr& gtr, const Parameters& parameters, const Normals& normals,
             const Vec3& wo);

// f_cos and pdf for a given wi; both zero unless wo.z > 0 and wi.z > 0. Dirac lobes contribute nothing; pdf
// is of sample() returning wi by another.
Value eval(const Bsdf& bsdf, const Vec3& wo, const Vec3& wi);

// The same f_cos lobe by lobe: diffuse, sheen, specular, clearcoat; their sum is eval's but for rounding.
inline constexpr int eval_lobe_count = 4;
std::array<Vec3, eval_lobe_count> eval_lobes(const Bsdf& bsdf, const Vec3& wo, const Vec3& wi);

// Draws wi: `u_lobe` chooses the lobe, (u, v) the direction; all in [0,1). Unless is_delta, f_cos and pdf are
// eval()'s of that wi, bit for bit. nullopt: no reflection (the
// direction fell below the surface, or nothing reflects), which counts as a sample of weight zero.
std::optional<Sample> sample(const Bsdf& bsdf, const Vec3& wo, float u_lobe, float u, float v);
// The same with two numbers: u chooses the lobe, and what it leaves of u is stretched for the direction.
std::optional<Sample> sample(const Bsdf& bsdf, const Vec3& wo, float u, float v);

// Reflectance for the albedo layer: diffuse and metal colour.
Vec3 albedo(const Bsdf& bsdf);

}  // namespace bsdf
