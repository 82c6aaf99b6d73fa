// Disney's diffuse lobe with retro-reflection: Burley 2012, section 5.3. Blender's 3.4.1 kernel has another
// form of the same polynomial. Lambert when `retro` is negative.
#pragma once

#include "bsdf/microfacet.h"

namespace bsdf {

struct Diffuse {
  Vec3 weight{0, 0, 0};  // base colour times (1 - metallic)
  float retro = -1;      // roughness; negative: Lambert

  // f cos(wi), 1/sr. cos_o, cos_i > 0.
  Vec3 f_cos(float cos_o, float cos_i, float cos_d) const {
    if (retro < 0) return weight * (math::inv_pi * cos_i);
    const float fd90 = .5f + 2 * retro * cos_d * cos_d;
    const float fl = 1 + (fd90 - 1) * schlick(cos_i);
    const float fv = 1 + (fd90 - 1) * schlick(cos_o);
    return weight * (math::inv_pi * fl * fv * cos_i);
  }
};

}  // namespace bsdf
