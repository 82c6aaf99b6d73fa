#include "sampling/faults.h"

#include <cmath>
#include <utility>

#include "math/warp.h"
#include "sampling/chi_squared.h"

namespace sampling {
namespace {

using bsdf::HalfVector;
using bsdf::Lobe;
using Sampler = std::function<std::optional<Vec3>(float u_lobe, float u, float v)>;
using Density = std::function<float(const Vec3& wi)>;
using Brdf = std::function<Vec3(const Vec3& wi)>;

Bsdf alone(Bsdf b, Lobe lobe) {
  for (float& p : b.probability) p = 0;
  b.probability[static_cast<int>(lobe)] = 1;
  return b;
}
float share(const Bsdf& b, Lobe lobe) { return b.probability[static_cast<int>(lobe)]; }

Sampler sampler_of(const Bsdf& b, const Vec3& wo) {
  return [=](float u_lobe, float u, float v) -> std::optional<Vec3> {
    const auto s = bsdf::sample(b, wo, u_lobe, u, v);
    return s ? std::optional<Vec3>(s->wi) : std::nullopt;
  };
}
Density density_of(const Bsdf& b, const Vec3& wo) {
  return [=](const Vec3& wi) { return bsdf::eval(b, wo, wi).pdf; };
}
Brdf brdf_of(const Bsdf& b, const Vec3& wo) {
  return [=](const Vec3& wi) { return bsdf::eval(b, wo, wi).f_cos; };
}

// A BRDF put together from three functions.
Subject put_together(const Bsdf& b, const Vec3& wo, const Sampler& sampler, const Density& density,
                     const Brdf& brdf) {
  const auto eval = [=](const Vec3& wi) { return wi.z > 0 ? Value{brdf(wi), density(wi)} : Value{}; };
  const auto sample = [=](float u_lobe, float u, float v) -> std::optional<bsdf::Sample> {
    const std::optional<Vec3> wi = sampler(u_lobe, u, v);
    if (!wi) return std::nullopt;
    const Value value = eval(*wi);
    if (!(value.pdf > 0)) return std::nullopt;
    bsdf::Sample s;
    s.wi = *wi;
    s.f_cos = value.f_cos;
    s.pdf = value.pdf;
    return s;
  };
  return {wo, b, eval, sample};
}
using Plant = std::function<Subject(const Bsdf&, const Vec3&)>;

// The density of one lobe replaced by `faulty`(true density of the lobe, wi).
Plant density_fault(Lobe lobe,
                    std::function<double(double, const Bsdf&, const Vec3& wo, const Vec3& wi)> faulty) {
  return [=](const Bsdf& b, const Vec3& wo) {
    const Bsdf one = alone(b, lobe);
    const float probability = share(b, lobe);
    return put_together(
        b, wo, sampler_of(b, wo),
        [=](const Vec3& wi) {
          const double all = bsdf::eval(b, wo, wi).pdf, part = bsdf::eval(one, wo, wi).pdf;
          return static_cast<float>(all + probability * (faulty(part, b, wo, wi) - part));
        },
        brdf_of(b, wo));
  };
}
using Edit = std::function<void(Bsdf&)>;
Bsdf edited(Bsdf b, const Edit& edit) {
  edit(b);
  return b;
}
Plant edited_density(Edit edit) {
  return [=](const Bsdf& b, const Vec3& wo) {
    return put_together(b, wo, sampler_of(b, wo), density_of(edited(b, edit), wo), brdf_of(b, wo));
  };
}
Plant edited_sampler(Edit edit) {
  return [=](const Bsdf& b, const Vec3& wo) {
    return put_together(b, wo, sampler_of(edited(b, edit), wo), density_of(b, wo), brdf_of(b, wo));
  };
}
Plant edited_brdf(Edit edit) {
  return [=](const Bsdf& b, const Vec3& wo) {
    return put_together(b, wo, sampler_of(b, wo), density_of(b, wo), brdf_of(edited(b, edit), wo));
  };
}
// Directions of one lobe drawn in another way; the density stays.
Plant redrawn(Lobe lobe, std::function<Vec3(const Bsdf&, const Vec3& wo, float u, float v)> draw) {
  return [=](const Bsdf& b, const Vec3& wo) {
    return put_together(
        b, wo,
        [=](float u_lobe, float u, float v) -> std::optional<Vec3> {
          const auto s = bsdf::sample(b, wo, u_lobe, u, v);
          if (!s) return std::nullopt;
          if (s->lobe != lobe) return s->wi;
          const Vec3 wi = draw(b, wo, u, v);
          return wi.z > 0 ? std::optional<Vec3>(wi) : std::nullopt;
        },
        density_of(b, wo), brdf_of(b, wo));
  };
}
// f_cos of the whole changed to `faulty`(f_cos, wi).
Plant brdf_fault(std::function<Vec3(const Vec3& f_cos, const Bsdf&, const Vec3& wo, const Vec3& wi)> faulty) {
  return [=](const Bsdf& b, const Vec3& wo) {
    return put_together(b, wo, sampler_of(b, wo), density_of(b, wo),
                        [=](const Vec3& wi) { return faulty(bsdf::eval(b, wo, wi).f_cos, b, wo, wi); });
  };
}

void scale_alpha(Bsdf& b, float factor) {
  b.specular.ax *= factor;
  b.specular.ay *= factor;
}
void scale_coat(Bsdf& b, float factor) {
  b.clearcoat.alpha *= factor;
  b.clearcoat.log_alpha2 = 2 * std::log(static_cast<double>(b.clearcoat.alpha));
}
double g1(const Vec3& w, float ax, float ay) { return 2. * w.z * bsdf::g1_over_2cos(w, ax, ay); }
double coat_d(const Bsdf& b, const HalfVector& h) {
  return bsdf::d_gtr1(h.sin2_h(), h.cos2_h(), b.clearcoat.alpha, b.clearcoat.log_alpha2);
}

std::vector<Fault> table() {
  using enum Check;
  constexpr float quarter[3] = {.5f, .25f, .25f}, dull[3] = {.25f, .5f, .25f}, own[3] = {0, 0, 0};
  const std::string many = "disney everything, glossy",
                    brushed = "disney metal, all anisotropic, roughness .3",
                    coated = "disney plastic under a coat of gloss 1", rough = "disney metal of roughness .7";
  std::vector<Fault> list;
  const auto add = [&](const char* name, const std::string& material, const float(&shares)[3], Lobe lobe,
                       Plant plant, std::vector<Check> must, const char* source = "") {
    list.push_back(
        {name, material, {shares[0], shares[1], shares[2]}, lobe, std::move(plant), std::move(must), source});
  };

  // Densities.
  const auto too_large = [](double pdf, const Bsdf&, const Vec3&, const Vec3&) { return 1.05 * pdf; };
  add("a pdf 5 % too large in the diffuse lobe, chosen in 25 % of draws", many, dull, Lobe::diffuse,
      density_fault(Lobe::diffuse, too_large), {total, cells, rings, jacobian, weights});
  add("a pdf 5 % too large in the specular lobe, chosen in 25 % of draws", many, quarter, Lobe::specular,
      density_fault(Lobe::specular, too_large), {total, rings, jacobian, weights});
  add("a pdf 5 % too large in the clearcoat, chosen in 25 % of draws", many, quarter, Lobe::clearcoat,
      density_fault(Lobe::clearcoat, too_large), {total, jacobian, weights});
  add("a pdf whose alpha is 3 % too large, in the specular lobe", many, quarter, Lobe::specular,
      edited_density([](Bsdf& b) { scale_alpha(b, 1.03f); }), {rings, jacobian});
  add("a pdf whose alpha is 3 % too small, at alpha .001", "disney plastic of alpha .001", own,
      Lobe::specular, edited_density([](Bsdf& b) { scale_alpha(b, .97f); }), {cells, rings, jacobian});
  add("a pdf whose alpha is 3 % too large, in the clearcoat", many, quarter, Lobe::clearcoat,
      edited_density([](Bsdf& b) { scale_coat(b, 1.03f); }), {jacobian});
  add("a sampler whose alpha is 3 % too large, in the specular lobe", many, quarter, Lobe::specular,
      edited_sampler([](Bsdf& b) { scale_alpha(b, 1.03f); }), {rings, jacobian});
  add("a pdf without the G1 of visible normals", rough, own, Lobe::specular,
      density_fault(Lobe::specular, [](double pdf, const Bsdf& b, const Vec3& wo,
                                       const Vec3&) { return pdf / g1(wo, b.specular.ax, b.specular.ay); }),
      {total, jacobian, weights}, "NVIDIA Donut 23");
  add("visible normals with the pdf of all normals, D cos / (4 wi.wh)", rough, own, Lobe::specular,
      density_fault(Lobe::specular,
                    [](double, const Bsdf& b, const Vec3& wo, const Vec3& wi) {
                      const HalfVector h(wo, wi);
                      return b.specular.d(h) * h.z / std::sqrt(h.length_squared) / (4 * h.cos_d);
                    }),
      {total, cells, rings, jacobian, weights}, "NVIDIA Donut 23");
  add("anisotropy's axes exchanged in the pdf", brushed, own, Lobe::specular,
      edited_density([](Bsdf& b) { std::swap(b.specular.ax, b.specular.ay); }),
      {total, cells, rings, jacobian, weights});
  add("anisotropy's axes exchanged in the sampler", brushed, own, Lobe::specular,
      edited_sampler([](Bsdf& b) { std::swap(b.specular.ax, b.specular.ay); }),
      {total, cells, rings, jacobian, weights});
  add("a clearcoat's pdf without its Jacobian 1 / (4 wi.wh)", coated, own, Lobe::clearcoat,
      density_fault(Lobe::clearcoat,
                    [](double, const Bsdf& b, const Vec3& wo, const Vec3& wi) {
                      const HalfVector h(wo, wi);
                      return coat_d(b, h) * h.z / std::sqrt(h.length_squared);
                    }),
      {total, cells, rings, jacobian, weights}, "pbrt-v3 172");
  add("a clearcoat's Jacobian with wo.z in place of wi.wh", coated, own, Lobe::clearcoat,
      density_fault(Lobe::clearcoat,
                    [](double pdf, const Bsdf&, const Vec3& wo, const Vec3& wi) {
                      return pdf * HalfVector(wo, wi).cos_d / static_cast<double>(wo.z);
                    }),
      {total, jacobian, weights});
  add("a clearcoat's pdf without the cosine of wh", "disney clearcoat alone, gloss 0", own, Lobe::clearcoat,
      density_fault(Lobe::clearcoat,
                    [](double pdf, const Bsdf&, const Vec3& wo, const Vec3& wi) {
                      const HalfVector h(wo, wi);
                      return pdf / h.z * std::sqrt(h.length_squared);
                    }),
      {total, cells, rings, jacobian, weights});
  add("a clearcoat sampled with alpha .25, weighted with that of its gloss", coated, own, Lobe::clearcoat,
      edited_sampler([](Bsdf& b) { scale_coat(b, .25f / b.clearcoat.alpha); }),
      {total, cells, rings, jacobian, weights}, "pbrt-v3 172");
  add("a clearcoat sampled by GGX's visible normals, weighted by GTR1", "disney clearcoat alone, gloss 0",
      own, Lobe::clearcoat,
      redrawn(Lobe::clearcoat,
              [](const Bsdf& b, const Vec3& wo, float u, float v) {
                const float alpha = b.clearcoat.alpha;
                return bsdf::reflect(wo, math::sample_visible_normal(wo, alpha, alpha, u, v));
              }),
      {total, cells, rings, jacobian, weights}, "Blender 3.4.1");
  add("a diffuse pdf of 1 / (2 pi) for cosine-distributed directions", "disney plastic", own, Lobe::diffuse,
      density_fault(Lobe::diffuse,
                    [](double, const Bsdf&, const Vec3&, const Vec3&) { return .5 / bsdf::pi; }),
      {cells, rings, jacobian, weights});
  add("diffuse directions uniform over the hemisphere, weighted by the cosine", "disney cloth", own,
      Lobe::diffuse,
      redrawn(Lobe::diffuse,
              [](const Bsdf&, const Vec3&, float u, float v) {
                Vec3 w = math::sample_sphere(u, v);
                w.z = std::fabs(w.z);
                return w;
              }),
      {cells, rings, jacobian, weights});
  add("directions under the horizon turned up instead of dropped", rough, own, Lobe::specular,
      [](const Bsdf& b, const Vec3& wo) {
        return put_together(
            b, wo,
            [=](float, float u, float v) -> std::optional<Vec3> {
              Vec3 wi = bsdf::reflect(wo, b.specular.sample_half(wo, u, v));
              wi.z = std::fabs(wi.z);
              return wi;
            },
            density_of(b, wo), brdf_of(b, wo));
      },
      {total, cells, rings, jacobian, weights});
  add("the number that chose the lobe used again for the direction", "disney plastic", own, Lobe::diffuse,
      [](const Bsdf& b, const Vec3& wo) {
        const Sampler sampler = sampler_of(b, wo);
        return put_together(
            b, wo, [=](float u_lobe, float, float v) { return sampler(u_lobe, u_lobe, v); },
            density_of(b, wo), brdf_of(b, wo));
      },
      {total, cells, rings, jacobian, weights});
  add("a sample's pdf that is of its own lobe alone", many, own, Lobe::specular,
      [](const Bsdf& b, const Vec3& wo) {
        Subject s = honest(b, wo);
        s.sample = [=](float u_lobe, float u, float v) {
          auto drawn = bsdf::sample(b, wo, u_lobe, u, v);
          if (drawn)
            drawn->pdf = share(b, drawn->lobe) * bsdf::eval(alone(b, drawn->lobe), wo, drawn->wi).pdf;
          return drawn;
        };
        return s;
      },
      {weights, agreement});
  add("the shares of two lobes exchanged in the pdf", many, dull, Lobe::specular,
      edited_density([](Bsdf& b) { std::swap(b.probability[0], b.probability[1]); }),
      {total, cells, rings, jacobian, weights});
  add("GTR of gamma 5 sampled as if gamma were 2", "path_disney metal, gamma 5, roughness .6", own,
      Lobe::specular, edited_sampler([](Bsdf& b) { b.specular.gamma = 2; }),
      {total, cells, rings, jacobian, weights});
  add("GTR's pdf with the report's constant, which does not normalise it",
      "path_disney metal, gamma 2, constant .03", own, Lobe::specular,
      edited_density([](Bsdf& b) { b.specular.normalised_constant = b.specular.constant; }),
      {total, jacobian, weights});

  // Values. Sampling is sound, so chi-squared must accept: these are the other witnesses' to find.
  add("f with an alpha 3 % too large in D and G", many, own, Lobe::specular, edited_brdf([](Bsdf& b) {
        scale_alpha(b, 1.03f);
        b.specular.ax_g *= 1.03f, b.specular.ay_g *= 1.03f;
      }),
      {formula});
  add("f without the G1 of wi", rough, own, Lobe::specular,
      brdf_fault([](const Vec3& f, const Bsdf& b, const Vec3&, const Vec3& wi) {
        return f / static_cast<float>(g1(wi, b.specular.ax_g, b.specular.ay_g));
      }),
      {reciprocity, formula});
  add("f with anisotropy's axes exchanged in D", brushed, own, Lobe::specular,
      edited_brdf([](Bsdf& b) { std::swap(b.specular.ax, b.specular.ay); }), {formula});
  add("f with anisotropy's axes exchanged in G", brushed, own, Lobe::specular,
      edited_brdf([](Bsdf& b) { std::swap(b.specular.ax_g, b.specular.ay_g); }), {formula});
  add("f with Fresnel of wo.z in place of wi.wh", rough, own, Lobe::specular,
      brdf_fault([](const Vec3& f, const Bsdf& b, const Vec3& wo, const Vec3& wi) {
        return f / b.specular.fresnel(HalfVector(wo, wi).cos_d) * b.specular.fresnel(wo.z);
      }),
      {reciprocity, formula});
  add("f with a clearcoat four times too strong", coated, own, Lobe::clearcoat,
      edited_brdf([](Bsdf& b) { b.clearcoat.weight *= 4; }), {formula});
  add("f with sheen over pi", "disney cloth", own, Lobe::diffuse,
      edited_brdf([](Bsdf& b) { b.sheen.weight *= math::inv_pi; }), {formula});
  add("f that forgets the cosine of wi", "disney plastic", own, Lobe::diffuse,
      brdf_fault([](const Vec3& f, const Bsdf&, const Vec3&, const Vec3& wi) { return f / wi.z; }),
      {reciprocity, formula});
  return list;
}

Verdicts verdicts_of(const Fault& fault, const Plant& plant) {
  const Make make = [&](const Vec3& w) { return plant(sound(fault, w), w); };
  const Subject subject = make(direction(3));
  constexpr std::uint64_t any = 20120808;
  Verdicts v;
  const auto of = [&](Check check) -> std::string& { return v[static_cast<std::size_t>(check)]; };

  const ChiSquared r = chi_squared(subject, draws(), any);
  const auto spread = [](const Pearson& p) {
    return p.p < significance() ? "chi-squared " + std::to_string(p.statistic) + " of " +
                                      std::to_string(p.degrees) + " degrees"
                                : "";
  };
  if (r.p_total < significance())
    of(Check::total) =
        "share of successes " + std::to_string(r.share) + ", integral " + std::to_string(r.integral);
  of(Check::cells) = spread(r.cells);
  of(Check::rings) = spread(r.rings);
  for (int d = 1; d <= 4 && of(Check::jacobian).empty(); ++d) {
    const Vec3 w = direction(d);
    of(Check::jacobian) = wrong_jacobian(plant(alone(sound(fault, w), fault.lobe), w));
  }
  of(Check::weights) = wrong_weights(subject, draws(), any);
  of(Check::agreement) = disagreement(subject, 10000, any);
  of(Check::reciprocity) = not_reciprocal(make, 2000, any);
  if (material(fault.material).lobes == all)
    of(Check::formula) = off_the_formula(material(fault.material), make, 2000, any);
  return v;
}

}  // namespace

const char* name(Check check) {
  constexpr const char* names[check_count] = {"total",   "cells",     "rings",       "Jacobian",
                                              "weights", "agreement", "reciprocity", "formula"};
  return names[static_cast<int>(check)];
}

const std::vector<Fault>& faults() {
  static const std::vector<Fault> list = table();
  return list;
}

Bsdf sound(const Fault& fault, const Vec3& wo) {
  Bsdf b = at(material(fault.material), wo);
  if (fault.shares[0] > 0)
    for (int i = 0; i < bsdf::lobe_count; ++i) b.probability[i] = fault.shares[i];
  return b;
}

Verdicts verdicts(const Fault& fault) { return verdicts_of(fault, fault.plant); }
Verdicts verdicts_without(const Fault& fault) { return verdicts_of(fault, honest); }

}  // namespace sampling
