"""Blender 3.4's Principled BSDF, opaque part, distribution GGX, in double precision: an evaluator for the tests.

Every function takes arrays of unit vectors (..., 3) in the shading frame (x along the tangent, z the normal).
Cycles 3.4.1: svm_node_closure_bsdf, bsdf_principled_diffuse.h, bsdf_principled_sheen.h, bsdf_microfacet.h.
"""

import numpy as np


def schlick(cosine):
    return np.clip(1 - cosine, 0, 1) ** 5


def dielectric(cosine, eta):
    g = np.sqrt(eta * eta - 1 + cosine * cosine)
    a, b = (g - cosine) / (g + cosine), (cosine * (g + cosine) - 1) / (cosine * (g - cosine) + 1)
    return .5 * a * a * (1 + b * b)


def fresnel(color, cosine, eta):
    normal_incidence = dielectric(1.0, eta)
    t = (dielectric(cosine, eta) - normal_incidence) / (1 - normal_incidence)
    return color + (1 - color) * t[..., None]


def smith(cosine, alpha2):
    return 2 / (1 + np.sqrt(1 + alpha2 * (1 - cosine ** 2) / cosine ** 2))


def along(w, ax, ay):
    return ((w[..., 0] * ax) ** 2 + (w[..., 1] * ay) ** 2) / (w[..., 0] ** 2 + w[..., 1] ** 2)


def eval_cos(p, l, v):
    """BRDF times cosine, (..., 3); `p` as read_material returns it."""
    base = np.array(p["base_color"], float)
    h = (l + v) / np.linalg.norm(l + v, axis=-1, keepdims=True)
    nl, nv, nh, lh = l[..., 2], v[..., 2], h[..., 2], (l * h).sum(-1)
    dielectric_part = 1 - p["metallic"]

    retro = 2 * p["roughness"] * lh ** 2
    sl, sv = schlick(nl), schlick(nv)
    diffuse = ((1 - sl / 2) * (1 - sv / 2) + retro * (sl + sv + sl * sv * (retro - 1))) / np.pi
    result = diffuse[..., None] * base * dielectric_part

    rec709 = base @ (.2126729, .7151522, .0721750)
    tint = base / rec709 if rec709 > 0 else np.ones(3)
    result += (p["sheen"] * dielectric_part * schlick(lh))[..., None] * (1 + p["sheen_tint"] * (tint - 1))

    lum = base @ (.3, .6, .1)
    tint = base / lum if lum > 0 else np.ones(3)
    normal_incidence = .08 * p["specular"] * (1 + p["specular_tint"] * (tint - 1)) * dielectric_part + base * p["metallic"]
    eta = 2 / (1 - np.sqrt(.08 * p["specular"])) - 1
    aspect = np.sqrt(1 - .9 * p["anisotropic"])
    ax, ay = min(p["roughness"] ** 2 / aspect, 1), min(p["roughness"] ** 2 * aspect, 1)
    turn = 2 * np.pi * p["anisotropic_rotation"]
    turned = np.array([[np.cos(turn), np.sin(turn), 0], [-np.sin(turn), np.cos(turn), 0], [0, 0, 1]])
    lt, vt, ht = l @ turned.T, v @ turned.T, h @ turned.T
    d = 1 / (np.pi * ax * ay * ((ht[..., 0] / ax) ** 2 + (ht[..., 1] / ay) ** 2 + nh ** 2) ** 2)
    g = smith(nl, along(lt, ax, ay)) * smith(nv, along(vt, ax, ay))
    if p["specular"] > 0 or p["metallic"] > 0:
        result += fresnel(np.clip(normal_incidence, 0, 1), lh, eta) * (d * g / (4 * nl * nv))[..., None]

    a2 = p["clearcoat_roughness"] ** 4
    d = (a2 - 1) / (np.pi * np.log(a2) * (1 + (a2 - 1) * nh ** 2))
    coat = .25 * p["clearcoat"] * d * smith(nl, .0625) * smith(nv, .0625) / (4 * nl * nv)
    result += fresnel(np.full(3, .04), lh, 1.5) * coat[..., None]
    return result * nl[..., None]
