// Prints the curves that scripts/make-figures draws for docs/disney.md, computed by the code that renders.
//
// Output: blocks of a line "plot/panel/curve" followed by lines "x y" and one empty line. Angles in degrees,
// BRDFs and densities in 1/sr.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <functional>
#include <string>

#include "bsdf/disney.h"

namespace {

using namespace bsdf;

constexpr double degrees = pi / 180;

void curve(const std::string& name, double from, double to, int steps,
           const std::function<double(double)>& f) {
  std::printf("%s\n", name.c_str());
  for (int i = 0; i <= steps; ++i) {
    const double x = from + (to - from) * i / steps;
    const double y = f(x);
    if (std::isfinite(y)) std::printf("%.6g %.6g\n", x, y);
  }
  std::printf("\n");
}

std::string text(double x) {
  char buffer[32];
  std::snprintf(buffer, sizeof buffer, "%g", x);
  return buffer;
}

// In the plane of incidence; positive angles lie on the side opposite to the viewer's, so that the mirror
// direction of a viewer at 45 degrees is +45.
Vec3 light_at(double angle) {
  double sine, cosine;
  math::sin_cos(angle * degrees, sine, cosine);
  return {static_cast<float>(-sine), 0, static_cast<float>(cosine)};
}
Vec3 viewer_at(double angle) { return light_at(-angle); }

Specular gtr_lobe(double alpha, double gamma, std::optional<float> constant) {
  Parameters p;
  p.roughness = static_cast<float>(std::sqrt(alpha));
  return prepare(Model::path_disney, {static_cast<float>(gamma), constant}, p, {}, {0, 0, 1}).specular;
}

// D at a half vector `angle` degrees from the normal: wi = wo = wh.
double d_at(const Specular& lobe, double angle) {
  const Vec3 h = light_at(angle);
  return lobe.d(HalfVector(h, h));
}

void distributions() {
  for (const double gamma : {.5, 1., 1.5, 2., 3., 10.}) {
    const Specular lobe = gtr_lobe(.1, gamma, {});
    curve("distribution/normalised/" + text(gamma), 0, 60, 240, [&](double a) { return d_at(lobe, a); });
  }
  struct Shape {
    const char* name;
    double alpha;
  };
  for (const Shape& shape : {Shape{"red", .0625}, Shape{"green", .01}, Shape{"blue", .0025}})
    for (const double gamma : {1., 2.})
      curve("constant/" + text(gamma) + "/" + shape.name, 0, 0, 1,
            [&](double) { return gtr_constant(shape.alpha, gamma); });
  // The green sphere of the report's figures, roughness .1.
  struct Setting {
    double gamma;
    std::optional<float> constant;
    const char* name;
  };
  for (const Setting& s : {Setting{1, .005f, "1 .005"}, Setting{1, .03f, "1 .03"}, Setting{1, .3f, "1 .3"},
                           Setting{1, {}, "1 auto"}, Setting{2, .005f, "2 .005"}, Setting{2, {}, "2 auto"}}) {
    const Specular lobe = gtr_lobe(.01, s.gamma, s.constant);
    curve(std::string("distribution/report/") + s.name, 0, 10, 200, [&](double a) { return d_at(lobe, a); });
  }
}

void fresnel() {
  for (const double specular : {.5, 1.}) {
    Parameters p;
    p.specular = static_cast<float>(specular);
    for (const Model model : {Model::disney, Model::principled}) {
      const Specular lobe = prepare(model, {}, p, {}, {0, 0, 1}).specular;
      curve(
          std::string("fresnel/F/") + (model == Model::disney ? "schlick " : "dielectric ") + text(specular),
          0, 90, 180,
          [&](double a) { return static_cast<double>(lobe.fresnel(static_cast<double>(light_at(a).z)).x); });
    }
  }
}

void masking() {
  const auto g1 = [](double angle, float alpha) {
    const Vec3 w = light_at(angle);
    return static_cast<double>(2 * w.z * g1_over_2cos(w, alpha, alpha));
  };
  for (const float roughness : {.1f, .25f, .5f, 1.f}) {
    Parameters p;
    p.roughness = roughness;
    for (const Model model : {Model::disney, Model::path_disney}) {
      const Specular lobe = prepare(model, {}, p, {}, {0, 0, 1}).specular;
      curve(std::string("masking/") + (model == Model::disney ? "shader/" : "text/") +
                text(static_cast<double>(roughness)),
            0, 90, 180, [&](double a) { return g1(a, lobe.ax_g); });
    }
  }
  curve("masking/shader/coat", 0, 90, 180, [&](double a) { return g1(a, Clearcoat::alpha_g); });
}

// One lobe's f or f cos, red channel.
double diffuse_at(const Parameters& p, Model model, double view, double angle) {
  const Vec3 wo = viewer_at(view), wi = light_at(angle);
  const Bsdf b = prepare(model, {}, p, {}, wo);
  const HalfVector h(wo, wi);
  const Vec3 f_cos = b.diffuse.f_cos(wo.z, wi.z, h.cos_d) + b.sheen.f_cos(wi.z, h.cos_d);
  return static_cast<double>(f_cos.x / wi.z);
}
double specular_at(const Parameters& p, double view, double angle) {
  const Vec3 wo = viewer_at(view), wi = light_at(angle);
  const Bsdf b = prepare(Model::disney, {}, p, {}, wo);
  return static_cast<double>(b.specular.eval(wo, wi, HalfVector(wo, wi)).f_cos.x);
}
double clearcoat_at(const Parameters& p, double view, double angle) {
  const Vec3 wo = viewer_at(view), wi = light_at(angle);
  return static_cast<double>(
      prepare(Model::disney, {}, p, {}, wo).clearcoat.eval(wo, wi, HalfVector(wo, wi)).f_cos.x);
}

void lobes() {
  Parameters white;
  white.base_color = Vec3(1);
  const auto diffuse = [](const std::string& name, const Parameters& p, Model model, double view) {
    curve(name, -89.75, 89.75, 359, [&](double a) { return diffuse_at(p, model, view, a); });
  };
  diffuse("lobes/diffuse/Lambert", white, Model::path, 60);
  for (const float roughness : {0.f, .5f, 1.f}) {
    Parameters p = white;
    p.roughness = roughness;
    diffuse("lobes/diffuse/" + text(static_cast<double>(roughness)), p, Model::disney, 60);
  }
  for (const float sheen : {.5f, 1.f}) {
    Parameters p;
    p.base_color = Vec3(0);
    p.sheen = sheen;
    diffuse("lobes/sheen/" + text(static_cast<double>(sheen)), p, Model::disney, 75);
  }
  for (const float roughness : {.2f, .4f, .7f, 1.f}) {
    Parameters p;
    p.roughness = roughness;
    curve("lobes/specular/" + text(static_cast<double>(roughness)), -90, 90, 720,
          [&](double a) { return specular_at(p, 45, a); });
  }
  for (const double gloss : {0., .7, 1.}) {
    Parameters p;
    p.clearcoat = 1;
    p.clearcoat_roughness = static_cast<float>(std::sqrt(.1 + (.001 - .1) * gloss));
    curve("lobes/clearcoat/" + text(gloss), -90, 90, 720, [&](double a) { return clearcoat_at(p, 45, a); });
  }
}

// Reflected share of the light from the direction at `angle`, by the model's own sampling on a regular grid.
// Of materials with a specular lobe alone: which lobe is chosen is not varied.
double specular_albedo(Model model, const Gtr& gtr, const Parameters& p, double angle) {
  const Vec3 wo = viewer_at(angle);
  const Bsdf b = prepare(model, gtr, p, {}, wo);
  constexpr int side = 256;
  double sum = 0;
  for (int i = 0; i < side; ++i)
    for (int j = 0; j < side; ++j) {
      const float u = (static_cast<float>(i) + .5f) / side, v = (static_cast<float>(j) + .5f) / side;
      if (const auto s = sample(b, wo, .5f, u, v)) sum += static_cast<double>(s->f_cos.x) / s->pdf;
    }
  return sum / (side * side);
}

void albedos() {
  Parameters metal;
  metal.base_color = Vec3(1);
  metal.metallic = 1;
  for (const float roughness : {.1f, .5f, 1.f}) {
    Parameters p = metal;
    p.roughness = roughness;
    curve("albedo/disney/" + text(static_cast<double>(roughness)), 0, 89, 89,
          [&](double a) { return specular_albedo(Model::disney, {}, p, a); });
  }
  metal.roughness = .25f;
  for (const float gamma : {.5f, 1.f, 2.f, 10.f})
    curve("albedo/path_disney/" + text(static_cast<double>(gamma)), 0, 89, 89, [&](double a) {
      return specular_albedo(Model::path_disney, {gamma, {}}, metal, a);
    });
}

// Density of the half vector's angle to the normal, per degree: the model's and a histogram of its samples.
void sampling() {
  for (const double gamma : {.5, 1., 2., 10.}) {
    const Specular lobe = gtr_lobe(.25, gamma, {});
    curve("sampling/density/" + text(gamma), 0, 90, 180, [&](double a) {
      double sine, cosine;
      math::sin_cos(2 * a * degrees, sine, cosine);  // 2 sin cos
      return d_at(lobe, a) * pi * sine * degrees;
    });
    constexpr int bins = 90, draws = 1 << 16;
    int count[bins] = {};
    for (int i = 0; i < draws; ++i) {
      const Vec3 h = lobe.sample_half({0, 0, 1}, (static_cast<float>(i) + .5f) / draws, .25f);
      ++count[std::min(bins - 1, static_cast<int>(math::acos(static_cast<double>(h.z)) / degrees))];
    }
    curve("sampling/histogram/" + text(gamma), .5, 89.5, bins - 1,
          [&](double a) { return count[static_cast<int>(a)] / static_cast<double>(draws); });
  }
}

}  // namespace

int main() {
  distributions();
  fresnel();
  masking();
  lobes();
  albedos();
  sampling();
}
