// Disney's sheen lobe: Burley 2012, section 5.5: sheen * tint * (1 - wi.wh)^5, without a 1/pi.
#pragma once

#include "bsdf/microfacet.h"

namespace bsdf {

struct Sheen {
  Vec3 weight{0, 0, 0};  // sheen * (1 - metallic) * mix(1, tint colour, sheen_tint)

  Vec3 f_cos(float cos_i, double cos_d) const {
    return weight * (static_cast<float>(schlick(cos_d)) * cos_i);
  }
};

}  // namespace bsdf
