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

  // The texels around texture coordinates uv (any float, even non-finite), and where between them. Found
  // early, they are on their way from memory while other things are computed.
  struct Place {
    const math::U16Vec4* texels[4];  // two of a row, two of the next
    float a, b;
  };
  Place find(const scene::Texture& texture, const math::Vec2& uv) const;
  // Whether both are looked up in the same rows and columns. What find() says of one is then moved to the
  // other for less: most materials' textures are aligned.
  bool aligned(const scene::Texture& one, const scene::Texture& other) const;
  Place moved(Place place, const scene::Texture& from, const scene::Texture& to) const;

  // RGBA there; colour: RGB is decoded from sRGB.
  math::Vec4 colour(const Place& place) const { return lookup(place, true); }
  math::Vec4 data(const Place& place) const { return lookup(place, false); }
  math::Vec4 colour(const scene::Texture& texture, const math::Vec2& uv) const {
    return colour(find(texture, uv));
  }
  math::Vec4 data(const scene::Texture& texture, const math::Vec2& uv) const {
    return data(find(texture, uv));
  }

 private:
  math::Vec4 lookup(const Place& place, bool srgb) const;

  const scene::Scene& scene_;
  bool filter_encoded_;
  std::vector<float> decoded_;  // of each code that a colour may have; empty if colours are filtered encoded
};

}  // namespace surface
