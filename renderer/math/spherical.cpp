#include "math/spherical.h"

#include <algorithm>
#include <cmath>

#include "math/transcendental.h"

namespace math {

namespace {

constexpr double two_pi = 6.283185307179586;

DVec3 unit(const DVec3& v) {
  const double square = dot(v, v);
  return square > 0 ? v / std::sqrt(square) : v;
}

// A complex number: its argument is an angle, and angles add when they are multiplied.
struct Turn {
  double cosine, sine;
};
Turn operator*(const Turn& a, const Turn& b) {
  return {a.cosine * b.cosine - a.sine * b.sine, a.cosine * b.sine + a.sine * b.cosine};
}
Turn unit(const Turn& t) {
  const double length = std::sqrt(t.cosine * t.cosine + t.sine * t.sine);
  return length > 0 ? Turn{t.cosine / length, t.sine / length} : Turn{1, 0};
}
double angle(const Turn& t) {  // in [0, 2 pi)
  const double a = atan2(t.sine, t.cosine);
  return a < 0 ? a + two_pi : a;
}

// Angle of the spherical rectangle between the sides at a and b, signed outwards; z the distance of the
// plane.
Turn corner(double a, double b, double z) {
  return {-a * b, std::fabs(z) * std::sqrt(z * z + a * a + b * b)};
}

// Unit vector in the plane of `from` and `to`, perpendicular to `from`, on the side of `to`.
DVec3 across(const DVec3& from, const DVec3& to) { return unit(to - from * dot(from, to)); }

}  // namespace

SphericalRectangle::SphericalRectangle(const DVec3& c, const DVec3& x, const DVec3& y, double width,
                                       double height)
    : x0_(dot(c, x)),
      x1_(x0_ + width),
      y0_(dot(c, y)),
      y1_(y0_ + height),
      z_(-std::fabs(dot(c, cross(x, y)))) {
  // The sum of the four angles less 2 pi.
  solid_angle_ = angle((corner(-y0_, x1_, z_) * corner(x1_, y1_, z_)) *
                       (corner(y1_, -x0_, z_) * corner(-x0_, -y0_, z_)));
}

DVec2 SphericalRectangle::sample(double u, double v) const {
  // The paper's section 4. phi_u = u S - (g2 + g3) + 2 pi.
  const double b0 = -y0_ / std::sqrt(z_ * z_ + y0_ * y0_), b1 = y1_ / std::sqrt(z_ * z_ + y1_ * y1_);
  const Turn two_corners = unit(corner(y1_, -x0_, z_) * corner(-x0_, -y0_, z_));
  Turn part{};
  sin_cos(u * solid_angle_, part.sine, part.cosine);
  const Turn phi = part * Turn{two_corners.cosine, -two_corners.sine};
  const double f = (phi.cosine * b0 - b1) / phi.sine;
  const double c = std::clamp(std::copysign(1 / std::sqrt(f * f + b0 * b0), f), -1., 1.);
  // c is 0 / 0 for u = 0 at a corner's own foot.
  const double x = c == c ? std::clamp(-c * z_ / std::sqrt(std::max(1 - c * c, 1e-300)), x0_, x1_) : x0_;
  const double d2 = x * x + z_ * z_;
  const double h0 = y0_ / std::sqrt(d2 + y0_ * y0_), h1 = y1_ / std::sqrt(d2 + y1_ * y1_);
  const double h = h0 + v * (h1 - h0);
  const double y = std::clamp(h * std::sqrt(d2 / std::max(1 - h * h, 1e-300)), y0_, y1_);
  return {(x - x0_) / (x1_ - x0_), (y - y0_) / (y1_ - y0_)};
}

SphericalTriangle::SphericalTriangle(const DVec3& a, const DVec3& b, const DVec3& c)
    : corner_{a, b, c}, unit_{unit(a), unit(b), unit(c)} {
  volume_ = std::fabs(dot(unit_[0], cross(unit_[1], unit_[2])));
  solid_angle_ =
      2 * angle({1 + dot(unit_[0], unit_[1]) + dot(unit_[1], unit_[2]) + dot(unit_[2], unit_[0]), volume_});
}

DVec3 SphericalTriangle::sample(double u, double v) const {
  // Arvo's algorithm. `alpha` is the angle at a: of the planes of a, b and of a, c.
  const auto& [a, b, c] = unit_;
  const Turn alpha = unit(Turn{dot(cross(a, b), cross(a, c)), volume_});
  Turn part{};
  sin_cos(u * solid_angle_, part.sine, part.cosine);
  const Turn phi = part * Turn{alpha.cosine, -alpha.sine};
  const double cos_ab = dot(a, b);
  const double p = phi.cosine - alpha.cosine, q = phi.sine + alpha.sine * cos_ab;
  const double cut = (q * phi.cosine - p * phi.sine) * alpha.cosine - q;
  const double scale = (q * phi.sine + p * phi.cosine) * alpha.sine;
  const double cos_side = scale != 0 ? std::clamp(cut / scale, -1., 1.) : 1;
  const DVec3 on_side = a * cos_side + across(a, c) * std::sqrt((1 - cos_side) * (1 + cos_side));
  const double z = 1 - v * (1 - dot(on_side, b));
  const DVec3 d = b * z + across(b, on_side) * std::sqrt(std::max(0., (1 - z) * (1 + z)));
  // Where that direction meets the triangle: the weights are in proportion to volumes.
  const double wa = dot(d, cross(corner_[1], corner_[2])), wb = dot(d, cross(corner_[2], corner_[0])),
               wc = dot(d, cross(corner_[0], corner_[1]));
  const double sum = wa + wb + wc;
  if (!(std::fabs(sum) > 0)) return {1. / 3, 1. / 3, 1. / 3};
  const double x = std::clamp(wa / sum, 0., 1.), y = std::clamp(wb / sum, 0., 1. - x);
  return {x, y, 1 - x - y};
}

}  // namespace math
