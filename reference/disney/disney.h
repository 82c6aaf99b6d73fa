// The four reflection models once more, written from the published formulas alone: the witness against which
// the renderer's BRDF is tested. Nothing here is shared with renderer/; everything is double (long double
// where a difference cancels), literal, and slow. disney.cpp is meant to be read as the explanation of the
// models.
//
//   burley_2012   B. Burley, "Physically-Based Shading at Disney", SIGGRAPH 2012 course notes, as in Disney's
//   public shader disney.brdf (github.com/wdas/brdf); no subsurface blender_341   the opaque part of
//   Principled BSDF of Blender 3.4.1 (distribution GGX, default IOR) report_2018   Disney diffuse + one GTR
//   lobe of any exponent gamma and constant c (the seed's path_disney) lambert_ggx   Lambert + GGX
//   (Trowbridge-Reitz) with Schlick's Fresnel: the plain model `path`
//
// Conventions of the paper: l to the light, v to the viewer, h = (l+v)/|l+v|, n = (0,0,1), x the tangent and
// y = n x x. Colours are linear Rec.709. Every model returns the BRDF
// times n.l, in 1/sr, and zero unless n.l > 0 and n.v > 0. Mirrors (Dirac lobes) contribute nothing.
#pragma once

#include <optional>

namespace disney {

struct Vector {
  double x = 0, y = 0, z = 0;
};
struct Colour {
  double r = 0, g = 0, b = 0;
};

// Section 5.2, "Parameters", each in [0,1]. The coat is given by its roughness, whose square is its alpha:
// clearcoat_roughness = sqrt(mix(.1, .001, clearcoatGloss)).
struct Material {
  Colour base{.8, .8, .8};
  double metallic = 0, roughness = .5, specular = .5, specular_tint = 0, anisotropic = 0;
  double sheen = 0, sheen_tint = .5, clearcoat = 0, clearcoat_roughness = .1778279;
};

Colour burley_2012(const Material& m, const Vector& v, const Vector& l);
Colour blender_341(const Material& m, const Vector& v, const Vector& l);
Colour report_2018(const Material& m, double gamma, std::optional<double> constant, const Vector& v,
                   const Vector& l);
Colour lambert_ggx(const Material& m, const Vector& v, const Vector& l);

// The c for which the integral of D cos over the hemisphere is 1, D = c / (alpha^2 cos^2 + sin^2)^gamma.
double gtr_constant(double gamma, double alpha);

// Reflectance of Blender's specular lobe and coat at angle l.h: F, with clearcoat/4 for the coat.
Colour blender_specular_fresnel(const Material& m, double l_h);
double blender_coat_fresnel(const Material& m, double l_h);
// Whether these lobes are mirrors.
bool blender_specular_is_mirror(const Material& m);
bool blender_coat_is_mirror(const Material& m);

}  // namespace disney
