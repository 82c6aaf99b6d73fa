#include "surface/texture.h"

#include "math/lanes.h"
#include "math/transcendental.h"

namespace surface {

namespace {

using math::Lanes;
using math::Vec2;
using math::Vec4;

// Texel index of integer coordinate i, outside the row, in a row of n texels.
int wrap_outside(int i, int n, scene::Wrap mode) {
  switch (mode) {
    case scene::Wrap::clamp:
      return i < 0 ? 0 : n - 1;
    case scene::Wrap::repeat:
      return (i % n + n) % n;
    case scene::Wrap::mirror: {
      const int j = (i % (2 * n) + 2 * n) % (2 * n);
      return j < n ? j : 2 * n - 1 - j;
    }
  }
  return 0;
}
inline int wrap(int i, int n, scene::Wrap mode) {
  return 0 <= i && i < n ? i : wrap_outside(i, n, mode);  // most are inside
}

// Brings u near [0, 2) without changing what it refers to, so that converting to int is defined.
float reduce(float u, scene::Wrap mode) {
  if (!std::isfinite(u)) return 0;
  if (mode == scene::Wrap::clamp) return u < -1 ? -1 : u > 2 ? 2 : u;
  const float period = mode == scene::Wrap::repeat ? 1 : 2;
  if (std::fabs(u) >= 0x1p24f) return 0;  // an even number
  return u - period * static_cast<float>(math::floor_to_int(u / period));
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

Textures::Place Textures::find(const scene::Texture& t, const Vec2& uv) const {
  const scene::EncodedBitmap& map = scene_.bitmaps[static_cast<size_t>(t.bitmap)];
  const int w = map.width, h = map.height;
  const float u = reduce(t.a * uv.x + t.b * uv.y + t.c, t.wrap_u) * static_cast<float>(w);
  const float v = reduce(t.d * uv.x + t.e * uv.y + t.f, t.wrap_v) * static_cast<float>(h);
  const auto row = [&](int j) {
    return map.texels.data() + static_cast<size_t>(wrap(j, h, t.wrap_v)) * static_cast<size_t>(w);
  };
  if (t.filter == scene::Filter::nearest) {
    const math::U16Vec4* texel = row(math::floor_to_int(v)) + wrap(math::floor_to_int(u), w, t.wrap_u);
    return {{texel, texel, texel, texel}, 0, 0};
  }
  const float x = u - .5f, y = v - .5f;  // texel centres are at half integers
  const int fx = math::floor_to_int(x), fy = math::floor_to_int(y);
  const int i = wrap(fx, w, t.wrap_u), i1 = wrap(fx + 1, w, t.wrap_u);
  const math::U16Vec4 *upper = row(fy), *lower = row(fy + 1);
  __builtin_prefetch(upper + i);
  __builtin_prefetch(lower + i);
  return {
      {upper + i, upper + i1, lower + i, lower + i1}, x - static_cast<float>(fx), y - static_cast<float>(fy)};
}

bool Textures::aligned(const scene::Texture& one, const scene::Texture& other) const {
  if (one.bitmap < 0 || other.bitmap < 0) return false;
  const scene::EncodedBitmap &a = scene_.bitmaps[static_cast<size_t>(one.bitmap)],
                             &b = scene_.bitmaps[static_cast<size_t>(other.bitmap)];
  scene::Texture same = other;
  same.bitmap = one.bitmap;
  return same == one && a.width == b.width && a.height == b.height;
}

Textures::Place Textures::moved(Place place, const scene::Texture& from, const scene::Texture& to) const {
  const math::U16Vec4 *a = scene_.bitmaps[static_cast<size_t>(from.bitmap)].texels.data(),
                      *b = scene_.bitmaps[static_cast<size_t>(to.bitmap)].texels.data();
  for (const math::U16Vec4*& texel : place.texels) texel = b + (texel - a);
  __builtin_prefetch(place.texels[0]);
  __builtin_prefetch(place.texels[2]);
  return place;
}

Vec4 Textures::lookup(const Place& p, bool srgb) const {
  // Texels as they are interpolated: codes, or colours already decoded with alpha a code.
  const bool decoded = srgb && !filter_encoded_;
  const auto texel = [&](int k) {
    const math::U16Vec4& code = *p.texels[k];
    return decoded ? Lanes{decoded_[code.x], decoded_[code.y], decoded_[code.z], static_cast<float>(code.w)}
                   : math::load(code);
  };
  Lanes c = math::bilinear(texel(0), texel(1), texel(2), texel(3), p.a, p.b);
  if (decoded) return {c[0], c[1], c[2], c[3] / 65535};
  c = c / 65535.f;
  const Vec4 encoded(c[0], c[1], c[2], c[3]);
  return srgb ? decode(encoded) : encoded;
}

}  // namespace surface
