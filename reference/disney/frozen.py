#!/usr/bin/python3
"""Prints frozen_values.h: Disney's public shader disney.brdf in 50 decimal digits.

A transcription of the GLSL, function by function and name by name, without mon2lin (the colour is linear already) and
subsurface, times NdotL. Directions are rational (Pythagorean quadruples), so that nothing is rounded on the way in.
"""
from decimal import Decimal as D, getcontext

getcontext().prec = 50
PI = D("3.14159265358979323846264338327950288419716939937510582")


def sqr(x):
    return x * x


def mix(a, b, t):
    return a * (1 - t) + b * t


def schlick_fresnel(u):
    m = min(max(1 - u, D(0)), D(1))
    return m * m * m * m * m


def gtr1(ndoth, a):
    if a >= 1:
        return 1 / PI
    a2 = a * a
    t = 1 + (a2 - 1) * ndoth * ndoth
    return (a2 - 1) / (PI * a2.ln() * t)


def gtr2_aniso(ndoth, hdotx, hdoty, ax, ay):
    return 1 / (PI * ax * ay * sqr(sqr(hdotx / ax) + sqr(hdoty / ay) + ndoth * ndoth))


def smithg_ggx(ndotv, alphag):
    a = alphag * alphag
    b = ndotv * ndotv
    return 1 / (ndotv + (a + b - a * b).sqrt())


def smithg_ggx_aniso(ndotv, vdotx, vdoty, ax, ay):
    return 1 / (ndotv + (sqr(vdotx * ax) + sqr(vdoty * ay) + sqr(ndotv)).sqrt())


def brdf_cos(L, V, p):
    base = [D(c) for c in p[0]]
    (metallic, roughness, specular, specular_tint, anisotropic, sheen, sheen_tint, clearcoat,
     clearcoat_alpha) = map(D, p[1:])
    ndotl, ndotv = L[2], V[2]
    H = [a + b for a, b in zip(L, V)]
    length = sum(x * x for x in H).sqrt()
    H = [x / length for x in H]
    ndoth, ldoth = H[2], sum(a * b for a, b in zip(L, H))
    lum = D(".3") * base[0] + D(".6") * base[1] + D(".1") * base[2]
    tint = [c / lum if lum > 0 else D(1) for c in base]
    cspec0 = [mix(specular * D(".08") * mix(D(1), t, specular_tint), c, metallic) for c, t in zip(base, tint)]
    csheen = [mix(D(1), t, sheen_tint) for t in tint]
    fl, fv = schlick_fresnel(ndotl), schlick_fresnel(ndotv)
    fd90 = D(".5") + 2 * ldoth * ldoth * roughness
    fd = mix(D(1), fd90, fl) * mix(D(1), fd90, fv)
    aspect = (1 - anisotropic * D(".9")).sqrt()
    ax = max(D(".001"), sqr(roughness) / aspect)
    ay = max(D(".001"), sqr(roughness) * aspect)
    ds = gtr2_aniso(ndoth, H[0], H[1], ax, ay)
    fh = schlick_fresnel(ldoth)
    fs = [mix(c, D(1), fh) for c in cspec0]
    gs = smithg_ggx_aniso(ndotl, L[0], L[1], ax, ay) * smithg_ggx_aniso(ndotv, V[0], V[1], ax, ay)
    fsheen = [fh * sheen * c for c in csheen]
    dr = gtr1(ndoth, clearcoat_alpha)
    fr = mix(D(".04"), D(1), fh)
    gr = smithg_ggx(ndotl, D(".25")) * smithg_ggx(ndotv, D(".25"))
    return [((1 / PI) * fd * c + s) * (1 - metallic) + gs * f * ds + D(".25") * clearcoat * gr * fr * dr
            for c, s, f in zip(base, fsheen, fs)], ndotl


def direction(x, y, z):
    length = D(x * x + y * y + z * z).sqrt()
    return [x / length, y / length, z / length]


# base; metallic, roughness, specular, specularTint, anisotropic, sheen, sheenTint, clearcoat, GTR1's alpha.
MATERIALS = [
    ((".82", ".67", ".16"), "0", ".5", ".5", "0", "0", "0", ".5", "0", ".0625"),
    (("0", "0", "0"), "0", ".25", ".5", "1", "0", "0", "1", "0", ".0625"),
    ((".5", ".25", ".125"), "0", "1", "1", "1", "0", "1", "1", "0", ".0625"),
    ((".5", ".25", ".125"), "1", ".25", ".5", "0", "0", "1", "1", "0", ".0625"),
    (("1", ".75", ".25"), "1", ".5", ".5", "0", "1", "0", ".5", "0", ".0625"),
    (("1", ".75", ".25"), ".5", ".5", ".75", ".5", ".5", ".5", ".5", "1", ".25"),
    ((".125", ".25", ".5"), "0", "1", "0", "0", "0", "0", ".5", "1", ".0625"),
    (("1", "1", "1"), "0", "0", "0", "0", "0", "0", "0", "1", "1"),
    ((".25", "0", "0"), ".25", ".75", ".25", "1", ".75", ".25", ".75", ".5", ".5625"),
    (("0", "0", "1"), ".75", ".5", "1", "1", ".25", "1", "1", ".25", ".25"),
]
PAIRS = [((0, 0, 1), (0, 0, 1)), ((2, 3, 6), (-2, -3, 6)), ((2, 6, 3), (1, 2, 2)), ((1, 2, 2), (2, 6, 3)),
         ((-6, 2, 3), (8, 4, 1)), ((4, 4, 7), (-9, 6, 2)), ((12, 9, 8), (12, 9, 8)), ((6, 6, 7), (-6, -6, 7)),
         ((0, 0, 1), (18, 6, 1)), ((18, 6, 1), (-18, -6, 1)), ((18, 6, 1), (6, -18, 1)), ((2, -5, 14), (5, 2, 14)),
         ((9, -2, 6), (-7, 4, 4)), ((3, -4, 12), (-3, 4, 12)), ((10, 2, 11), (-10, -2, 11)),
         ((-5, -14, 2), (5, 14, 2)), ((8, 9, 12), (-12, -12, 1)), ((14, 5, 2), (14, -5, 2)), ((0, 3, 4), (0, -4, 3)),
         ((3, 0, 4), (-4, 0, 3))]

print("""// Made by frozen.py: Disney's public shader in 50 decimal digits. Do not edit.
#pragma once

namespace disney::frozen {

// base; metallic, roughness, specular, specular tint, anisotropic, sheen, sheen tint, clearcoat, GTR1's alpha
inline constexpr double materials[][12] = {""")
for material in MATERIALS:
    print(f"    {{{', '.join(str(float(x)) for x in (*material[0], *material[1:]))}}},")
print("""};

// to the viewer, to the light; not of unit length
inline constexpr double pairs[][6] = {""")
for v, l in PAIRS:
    print(f"    {{{', '.join(str(x) for x in (*v, *l))}}},")
print("""};

// BRDF times n.l; row: material, then pair
inline constexpr double values[][3] = {""")
for material in MATERIALS:
    for v, l in PAIRS:
        f, ndotl = brdf_cos(direction(*l), direction(*v), material)
        print(f"    {{{', '.join(repr(float(x * ndotl)) for x in f)}}},")
print("""};

}  // namespace disney::frozen""")
