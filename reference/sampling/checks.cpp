#include "sampling/checks.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <numeric>

#include "disney/disney.h"
#include "sampling/cells.h"

namespace sampling {
namespace {

std::string text(const char* format, double a, double b, double c = 0) {
  char line[200];
  std::snprintf(line, sizeof line, format, a, b, c);
  return line;
}

bool same_bits(float a, float b) { return std::memcmp(&a, &b, sizeof a) == 0; }
bool same_bits(const Vec3& a, const Vec3& b) {
  return same_bits(a.x, b.x) && same_bits(a.y, b.y) && same_bits(a.z, b.z);
}

// A wi for wo: at random over the hemisphere, or sampled.
Vec3 partner(const Subject& subject, Random& random, bool sampled) {
  const float a = random.uniform(), b = random.uniform(), c = random.uniform();
  if (sampled)
    if (const auto s = subject.sample(a, b, c); s && s->wi.z > .01f) return s->wi;
  return direction(.02 + .98 * static_cast<double>(a), 6.283185307 * static_cast<double>(b));
}

disney::Colour formula(const Material& m, const Vec3& wo, const Vec3& wi) {
  const bsdf::Parameters& p = m.parameters;
  const disney::Material d{{p.base_color.x, p.base_color.y, p.base_color.z},
                           p.metallic,
                           p.roughness,
                           p.specular,
                           p.specular_tint,
                           p.anisotropic,
                           p.sheen,
                           p.sheen_tint,
                           p.clearcoat,
                           p.clearcoat_roughness};
  const disney::Vector v{wo.x, wo.y, wo.z}, l{wi.x, wi.y, wi.z};
  switch (m.model) {
    case bsdf::Model::disney:
      return disney::burley_2012(d, v, l);
    case bsdf::Model::principled:
      return disney::blender_341(d, v, l);
    case bsdf::Model::path:
      return disney::lambert_ggx(d, v, l);
    case bsdf::Model::path_disney:
      break;
  }
  const std::optional<double> constant =
      m.gtr.constant ? std::optional<double>(*m.gtr.constant) : std::nullopt;
  return disney::report_2018(d, m.gtr.gamma, constant, v, l);
}

}  // namespace

std::string disagreement(const Subject& subject, int draws, std::uint64_t seed) {
  Random random(seed);
  for (int i = 0; i < draws; ++i) {
    const float a = random.uniform(), b = random.uniform(), c = random.uniform();
    const auto s = subject.sample(a, b, c);
    if (!s || s->is_delta) continue;
    const Value value = subject.eval(s->wi);
    if (!same_bits(value.pdf, s->pdf)) return text("pdf %.9g, eval says %.9g", s->pdf, value.pdf);
    if (!same_bits(value.f_cos, s->f_cos))
      return text("f_cos %.9g, eval says %.9g", s->f_cos.x, value.f_cos.x);
  }
  return "";
}

std::string wrong_weights(const Subject& subject, int draws, std::uint64_t seed) {
  double sum[2] = {0, 0}, squares[2] = {0, 0};  // plain, and times (1 + wi.z)^2
  Random random(seed);
  for (int i = 0; i < draws; ++i) {
    const float a = random.uniform(), b = random.uniform(), c = random.uniform();
    const auto s = subject.sample(a, b, c);
    if (!s || s->is_delta) continue;
    const double w = static_cast<double>(math::mean(s->f_cos)) / static_cast<double>(s->pdf);
    for (int k = 0; k < 2; ++k) {
      const double x = k ? w * math::sqr(1. + s->wi.z) : w;
      sum[k] += x;
      squares[k] += x * x;
    }
  }
  const Cells cells(subject.bsdf, subject.wo);
  for (int k = 0; k < 2; ++k) {
    const std::vector<double> parts = cells.integrate([&](const Vec3& wi) {
      const double f = static_cast<double>(math::mean(subject.eval(wi).f_cos));
      return k ? f * math::sqr(1. + wi.z) : f;
    });
    const double exact = std::accumulate(parts.begin(), parts.end(), 0.);
    const double mean = sum[k] / draws;
    const double error = std::sqrt(std::max(0., squares[k] / draws - mean * mean) / draws);
    if (!(std::fabs(mean - exact) <= 6 * error + 1e-4 * exact + 1e-9))
      return text(k ? "mean weight times (1 + cos)^2 %.6g +- %.1g, integral %.6g"
                    : "mean weight %.6g +- %.1g, integral of f_cos %.6g",
                  mean, error, exact);
  }
  return "";
}

std::string not_reciprocal(const Make& make, int pairs, std::uint64_t seed) {
  Random random(seed);
  for (int i = 0; i < pairs; ++i) {
    const float u = random.uniform(), v = random.uniform();
    const Vec3 a = direction(.02 + .98 * static_cast<double>(u), 6.283185307 * static_cast<double>(v));
    const Subject at_a = make(a);
    const Vec3 b = partner(at_a, random, i % 2);
    const Vec3 forward = at_a.eval(b).f_cos / b.z, backward = make(b).eval(a).f_cos / a.z;
    for (int c = 0; c < 3; ++c)
      if (!(std::fabs(forward[c] - backward[c]) <= 2e-6f * std::max(forward[c], backward[c]) + 1e-7f))
        return text("f %.9g from one side, %.9g from the other", forward[c], backward[c]);
  }
  return "";
}

// Points whose stencil crosses a fold of the disk's mapping, or where the direction is under the horizon, are
// told by two step sizes that disagree, and left out.
Stretch stretch(const Subject& subject) {
  struct Vector {
    double x, y, z;
  };
  const auto derivative = [&](float u, float v, bool along_u, float h, Vector& d) {
    constexpr double weights[4] = {1 / 12., -8 / 12., 8 / 12., -1 / 12.};
    constexpr float steps[4] = {-2, -1, 1, 2};
    d = {0, 0, 0};
    for (int k = 0; k < 4; ++k) {
      const float step = steps[k] * h;
      const auto s = subject.sample(.5f, along_u ? u + step : u, along_u ? v : v + step);
      if (!s || s->is_delta) return false;
      const double w = weights[k] / static_cast<double>(h);
      d.x += w * static_cast<double>(s->wi.x);
      d.y += w * static_cast<double>(s->wi.y);
      d.z += w * static_cast<double>(s->wi.z);
    }
    return true;
  };
  const auto area = [&](float u, float v, float h) {
    Vector a{}, b{};
    if (!derivative(u, v, true, h, a) || !derivative(u, v, false, h, b)) return -1.;
    const double x = a.y * b.z - a.z * b.y, y = a.z * b.x - a.x * b.z, z = a.x * b.y - a.y * b.x;
    return std::sqrt(x * x + y * y + z * z);
  };
  Stretch result;
  constexpr int n = 12;
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j) {
      const float u = .12f + .72f * static_cast<float>(i) / (n - 1),
                  v = .15f + .71f * static_cast<float>(j) / (n - 1);
      const auto s = subject.sample(.5f, u, v);
      const double small = area(u, v, 0x1p-6f), large = area(u, v, 0x1.8p-6f);
      if (!s || small < 0 || large < 0 || std::fabs(small / large - 1) > .003) continue;
      ++result.points;
      result.worst =
          std::max(result.worst, std::fabs(small * static_cast<double>(subject.eval(s->wi).pdf) - 1));
    }
  return result;
}

std::string wrong_jacobian(const Subject& subject) {
  const Stretch s = stretch(subject);
  if (s.points < 30) return text("only %.0f of %.0f points have a Jacobian", s.points, 144);
  return s.worst > .01 ? text("pdf times area is off by %.3g at one of %.0f points", s.worst, s.points) : "";
}

std::string off_the_formula(const Material& m, const Make& make, int pairs, std::uint64_t seed) {
  Random random(seed);
  for (int i = 0; i < pairs; ++i) {
    const float u = random.uniform(), v = random.uniform();
    const Vec3 wo = direction(.02 + .98 * static_cast<double>(u), 6.283185307 * static_cast<double>(v));
    const Subject subject = make(wo);
    const Vec3 wi = partner(subject, random, i % 2);
    const Vec3 ours = subject.eval(wi).f_cos;
    const disney::Colour truth = formula(m, wo, wi);
    const double wanted[3] = {truth.r, truth.g, truth.b};
    for (int c = 0; c < 3; ++c)
      if (!(std::fabs(static_cast<double>(ours[c]) - wanted[c]) <= 1e-5 * wanted[c] + 1e-9))
        return text("f_cos %.9g, the formula says %.9g", ours[c], wanted[c]);
  }
  return "";
}

}  // namespace sampling
