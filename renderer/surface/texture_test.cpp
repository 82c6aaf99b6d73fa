// Texture look-ups at coordinates no artist meant, and the sRGB curve.
#include "surface/texture.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <sstream>

#include "math/transcendental.h"

namespace surface {
namespace {

using math::Vec2;
using math::Vec4;

scene::Scene checker() {
  scene::Scene s;
  s.bitmaps.push_back({"", 3, 2, {}});
  for (std::uint16_t i = 0; i < 6; ++i) s.bitmaps[0].texels.emplace_back(i * 10'000, 65535, 0, 65535 - i);
  return s;
}

// I07. Run with -fsanitize=address,undefined,float-cast-overflow too.
TEST(Lookup, is_defined_at_every_texture_coordinate) {
  const scene::Scene s = checker();
  constexpr float inf = std::numeric_limits<float>::infinity();
  const std::vector<float> values = {0,      -.5f / 3, .5f / 3,   .5f,    1,     -1,     1.5f,
                                     2,      -2,       1 - 6e-8f, 1e9f,   -1e9f, 2.5e9f, 1e18f,
                                     -1e18f, 3e38f,    -3e38f,    1e-45f, inf,   -inf,   std::nanf("")};
  int lookups = 0;
  for (const bool encoded : {false, true}) {
    const Textures textures(s, encoded);
    for (const scene::Wrap u : {scene::Wrap::repeat, scene::Wrap::mirror, scene::Wrap::clamp})
      for (const scene::Wrap v : {scene::Wrap::repeat, scene::Wrap::mirror, scene::Wrap::clamp})
        for (const scene::Filter filter : {scene::Filter::linear, scene::Filter::nearest})
          for (const float scale : {1.f, 0.f, 1e6f}) {
            scene::Texture t;
            t.bitmap = 0, t.wrap_u = u, t.wrap_v = v, t.filter = filter, t.a = scale;
            for (const float x : values)
              for (const float y : values)
                for (const Vec4& c : {textures.colour(t, {x, y}), textures.data(t, {x, y})})
                  for (int i = 0; i < 4; ++i, ++lookups)
                    ASSERT_TRUE(c[i] >= 0 && c[i] <= 1.0001f) << x << ' ' << y << ' ' << c[i];
          }
  }
  RecordProperty("measured", std::to_string(lookups) + " values, all in [0, 1]");
}

TEST(Lookup, of_aligned_textures_moves_from_one_to_the_other) {
  scene::Scene s = checker();
  s.bitmaps.push_back(s.bitmaps[0]);
  s.bitmaps.push_back(s.bitmaps[0]);
  std::reverse(s.bitmaps[1].texels.begin(), s.bitmaps[1].texels.end());
  std::swap(s.bitmaps[2].width, s.bitmaps[2].height);
  const Textures textures(s, true);
  scene::Texture one;
  one.bitmap = 0, one.a = 1.7f, one.c = .3f, one.wrap_v = scene::Wrap::mirror;
  scene::Texture other = one;
  other.bitmap = 1;
  ASSERT_TRUE(textures.aligned(one, other));
  for (int i = 0; i < 100; ++i) {
    const Vec2 uv(static_cast<float>(i) * .37f - 9, static_cast<float>(i) * .61f - 20);
    const Vec4 there = textures.data(textures.moved(textures.find(one, uv), one, other));
    EXPECT_EQ(there, textures.data(other, uv)) << i;
    EXPECT_NE(there, textures.data(one, uv)) << i;
  }
  for (const auto& change :
       {+[](scene::Texture& t) { t.bitmap = -1; }, +[](scene::Texture& t) { t.bitmap = 2; },
        +[](scene::Texture& t) { t.texcoord_set = 1; },
        +[](scene::Texture& t) { t.wrap_u = scene::Wrap::clamp; },
        +[](scene::Texture& t) { t.filter = scene::Filter::nearest; },
        +[](scene::Texture& t) { t.f = .01f; }}) {
    scene::Texture changed = other;
    change(changed);
    EXPECT_FALSE(textures.aligned(one, changed));
    EXPECT_FALSE(textures.aligned(changed, one));
  }
}

TEST(Lookup, finds_texel_centres_exactly_and_wraps_as_glTF_says) {
  const scene::Scene s = checker();
  const Textures textures(s, true);
  scene::Texture t;
  t.bitmap = 0;
  for (const scene::Filter filter : {scene::Filter::linear, scene::Filter::nearest}) {
    t.filter = filter;
    for (int i = 0; i < 6; ++i) {
      const Vec2 uv(static_cast<float>(i % 3 * 2 + 1) / 6, static_cast<float>(i / 3 * 2 + 1) / 4);
      EXPECT_NEAR(textures.data(t, uv).x, static_cast<float>(i * 10'000) / 65535, 1e-6f);
    }
  }
  const auto column = [&](scene::Wrap wrap, float u) {
    t.wrap_u = wrap;
    return std::lround(textures.data(t, {u, .25f}).x * 65535 / 10'000);
  };
  EXPECT_EQ(column(scene::Wrap::repeat, 7 / 6.f), 0);
  EXPECT_EQ(column(scene::Wrap::repeat, -1 / 6.f), 2);
  EXPECT_EQ(column(scene::Wrap::mirror, 7 / 6.f), 2);
  EXPECT_EQ(column(scene::Wrap::mirror, -1 / 6.f), 0);
  EXPECT_EQ(column(scene::Wrap::clamp, 7 / 6.f), 2);
  EXPECT_EQ(column(scene::Wrap::clamp, -9), 0);
}

// I03. IEC 61966-2-1 in double, and back to the same code.
TEST(Srgb, is_the_standard_s_curve_for_every_code) {
  double worst = 0;
  for (int code = 0; code < 65536; ++code) {
    const double s = code / 65535.;
    const double linear = s <= .04045 ? s / 12.92 : std::pow((s + .055) / 1.055, 2.4);
    const float ours = math::srgb_to_linear(static_cast<float>(code) / 65535);
    worst = std::max(worst, std::fabs(ours - linear));
    if (code % 257 != 0) continue;
    const double back =
        ours <= .0031308 ? 12.92 * ours : 1.055 * std::pow(static_cast<double>(ours), 1 / 2.4) - .055;
    EXPECT_EQ(std::lround(255 * back), code / 257);
  }
  EXPECT_LT(worst, 1e-7);
  std::ostringstream text;
  text << "absolute error at most " << worst << "; 256 of 256 codes return";
  RecordProperty("measured", text.str());
}

TEST(Fraction, of_every_8_bit_code_is_the_correctly_rounded_one) {
  for (int code = 0; code < 256; ++code) {
    const auto wide = static_cast<std::uint16_t>(code * 257);
    EXPECT_EQ(scene::fraction({wide, wide, wide, wide}).z, static_cast<float>(code) / 255);
  }
}

}  // namespace
}  // namespace surface
