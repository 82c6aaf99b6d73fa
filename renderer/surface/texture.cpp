#include "surface/texture.h"

#include "math/transcendental.h"

namespace surface {

namespace {

using math::Vec2;
using math::Vec4;

// Texel index of integer coordinate i in a row of n texels.
int wrap(int i, int n, scene::Wrap mode) {
  switch (mode) {
    case scene::Wrap::clamp:
      return i < 0 ? 0 : i >= n ? n - 1 : i;
    case scene::Wrap::repeat:
      return (i % n + n) % n;
    case scene::Wrap::mirror: {
      const int j = (i % (2 * n) + 2 * n) % (2 * n);
      return j < n ? j : 2 * n - 1 - j;
    }
  }
  return 0;
}

// Brings u near [0, 2) without changing what it refers to, so that converting to int is defined.
float reduce(float u, scene::Wrap mode) {
  if (!std::isfinite(u)) return 0;
  if (mode == scene::Wrap::clamp) return u < -1 ? -1 : u > 2 ? 2 : u;
  const float period = mode == scene::Wrap::repeat ? 1 : 2;
  return u - period * std::floor(u / period);
}

Vec4 decode(const Vec4& c) {
  return {math::srgb_to_linear(c.x), math::srgb_to_linear(c.y), math::srgb_to_linear(c.z), c.w};
}

}  // namespace

Textures::Textures(const scene::Scene& scene, bool filter_encoded)
    : scene_(scene), filter_encoded_(filter_encoded) {
  if (filter_encoded || scene.bitmaps.empty()) return;
  for (int code = 0; code < 65536; ++code)
    decoded_.push_back(math::srgb_to_linear(static_cast<float>(code) / 65535));
}

Vec4 Textures::lookup(const scene::Texture& t, const Vec2& uv, bool srgb) const {
  const scene::EncodedBitmap& map = scene_.bitmaps[static_cast<size_t>(t.bitmap)];
  const int w = map.width, h = map.height;
  const float u = reduce(t.a * uv.x + t.b * uv.y + t.c, t.wrap_u) * static_cast<float>(w);
  const float v = reduce(t.d * uv.x + t.e * uv.y + t.f, t.wrap_v) * static_cast<float>(h);
  const auto texel = [&](int i, int j) {
    const math::U16Vec4& code =
        map.texels[static_cast<size_t>(wrap(j, h, t.wrap_v)) * static_cast<size_t>(w) +
                   static_cast<size_t>(wrap(i, w, t.wrap_u))];
    const Vec4 value = scene::fraction(code);
    return srgb && !filter_encoded_ ? Vec4(decoded_[code.x], decoded_[code.y], decoded_[code.z], value.w)
                                    : value;
  };
  Vec4 c;
  if (t.filter == scene::Filter::nearest) {
    c = texel(static_cast<int>(std::floor(u)), static_cast<int>(std::floor(v)));
  } else {
    const float x = u - .5f, y = v - .5f;  // texel centres are at half integers
    const float fx = std::floor(x), fy = std::floor(y);
    const int i = static_cast<int>(fx), j = static_cast<int>(fy);
    const float a = x - fx, b = y - fy;
    c = (texel(i, j) * (1 - a) + texel(i + 1, j) * a) * (1 - b) +
        (texel(i, j + 1) * (1 - a) + texel(i + 1, j + 1) * a) * b;
  }
  return srgb && filter_encoded_ ? decode(c) : c;
}

}  // namespace surface
