// Disney's diffuse lobe with retro-reflection: Burley 2012, section 5.3. Blender's 3.4.1 kernel has another
// form of the same polynomial. Lambert when `retro` is negative.
#pragma once

#include "bsdf/microfacet.h"

namespace bsdf {

struct Diffuse {
  Vec3 weight{0, 0, 0};  // base colour times (1 - metallic)
  float retro = -1;      // roughness; negative: Lambert

  // f cos(wi), 1/sr. cos_o, cos_i > 0. In double, so that swapping the directions changes nothing but the
  // last bit.
  Vec3 f_cos(double cos_o, double cos_i, double cos_d) const {
    double shape = cos_i * (1 / pi);
    if (retro >= 0) {
      const double fd90 = .5 + 2. * retro * cos_d * cos_d;
      shape *= (1 + (fd90 - 1) * schlick(cos_i)) * (1 + (fd90 - 1) * schlick(cos_o));
    }
    return weight * static_cast<float>(shape);
  }
};

}  // namespace bsdf
