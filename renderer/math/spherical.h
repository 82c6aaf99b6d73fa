// Points of a rectangle and of a triangle drawn uniformly in the solid angle they subtend, so that a light is
// sampled without the noise of cosine and distance. In double, and everything relative to the eye, which is
// the origin. Angles are arguments of complex products: one arc tangent for a solid angle, one sine and
// cosine for a point.
//
// Rectangle: Ureña, Fajardo & King 2013, "An Area-Preserving Parametrization for Spherical Rectangles".
// Triangle: Arvo 1995, "Stratified Sampling of Spherical Triangles"; its solid angle by Van Oosterom &
// Strackee 1983. Both lose precision for solid angles below 1e-9, where sampling by area is as good.
#pragma once

#include "math/vec.h"

namespace math {

using DVec2 = glm::dvec2;

// A rectangle with unit axes x and y, seen from the origin, which is not in its plane.
class SphericalRectangle {
 public:
  SphericalRectangle(const DVec3& corner, const DVec3& x, const DVec3& y, double width, double height);
  double solid_angle() const { return solid_angle_; }
  // Coordinates from the corner in units of width and height, in [0,1].
  DVec2 sample(double u, double v) const;

 private:
  double x0_, x1_, y0_, y1_, z_;  // z_ < 0: the distance of the plane
  double solid_angle_;
};

// A triangle seen from the origin, which is not in its plane.
class SphericalTriangle {
 public:
  SphericalTriangle(const DVec3& a, const DVec3& b, const DVec3& c);
  double solid_angle() const { return solid_angle_; }
  DVec3 sample(double u, double v) const;  // barycentric weights of a, b, c

 private:
  DVec3 corner_[3], unit_[3];
  double volume_;  // of the unit vectors: six times that of their tetrahedron
  double solid_angle_;
};

}  // namespace math
