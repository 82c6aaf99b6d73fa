// Texture look-ups. Colours are decoded from sRGB either before filtering (right: light is linear) or after
// it (what Blender does, hence what `principled` does).
#pragma once

#include <vector>

#include "scene/scene.h"

namespace surface {

class Textures {
 public:
  // Keeps a reference to `scene`; `filter_encoded` filters sRGB texels before decoding them.
  Textures(const scene::Scene& scene, bool filter_encoded);

  // RGBA at texture coordinates uv (any float, even non-finite); colour: RGB is decoded from sRGB.
  math::Vec4 colour(const scene::Texture& texture, const math::Vec2& uv) const {
    return lookup(texture, uv, true);
  }
  math::Vec4 data(const scene::Texture& texture, const math::Vec2& uv) const {
    return lookup(texture, uv, false);
  }

 private:
  math::Vec4 lookup(const scene::Texture& texture, const math::Vec2& uv, bool srgb) const;

  const scene::Scene& scene_;
  bool filter_encoded_;
  std::vector<float> decoded_;  // of each code that a colour may have; empty if colours are filtered encoded
};

}  // namespace surface
