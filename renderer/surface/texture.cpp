#include "surface/texture.h"

#include "math/transcendental.h"

namespace surface {

namespace {

using math::Vec2;
using math::Vec4;

// Texel index of integer coordinate i in a row of n texels.
int wrap(int i, int n, scene::Wrap mode) {
  if (0 <= i && i < n) return i;  // most are
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
  // Texels as they are interpolated: codes, or colours already decoded with alpha a code.
  const bool decoded = srgb && !filter_encoded_;
  const auto texel = [&](int column, int row) {
    const math::U16Vec4& code =
        map.texels[static_cast<size_t>(row) * static_cast<size_t>(w) + static_cast<size_t>(column)];
    return decoded ? Vec4(decoded_[code.x], decoded_[code.y], decoded_[code.z], code.w) : Vec4(code);
  };
  Vec4 c;
  if (t.filter == scene::Filter::nearest) {
    c = texel(wrap(static_cast<int>(std::floor(u)), w, t.wrap_u),
              wrap(static_cast<int>(std::floor(v)), h, t.wrap_v));
  } else {
    const float x = u - .5f, y = v - .5f;  // texel centres are at half integers
    const float fx = std::floor(x), fy = std::floor(y);
    const int i = wrap(static_cast<int>(fx), w, t.wrap_u), i1 = wrap(static_cast<int>(fx) + 1, w, t.wrap_u);
    const int j = wrap(static_cast<int>(fy), h, t.wrap_v), j1 = wrap(static_cast<int>(fy) + 1, h, t.wrap_v);
    const float a = x - fx, b = y - fy;
    c = (texel(i, j) * (1 - a) + texel(i1, j) * a) * (1 - b) +
        (texel(i, j1) * (1 - a) + texel(i1, j1) * a) * b;
  }
  if (decoded) return {c.x, c.y, c.z, c.w / 65535};
  c = {c.x / 65535, c.y / 65535, c.z / 65535, c.w / 65535};
  return srgb ? decode(c) : c;
}

}  // namespace surface
