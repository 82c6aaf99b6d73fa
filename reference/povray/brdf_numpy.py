"""The same BRDFs in numpy double precision, written apart from the SDL: half vectors, frames and dot products are
vectors here, where the SDL has scalar formulas."""

import numpy as np


def _dot(a, b):
    return (a * b).sum(-1)


def sphere_normals(size):
    """(N, N, 3) normals of brdf.py's pixel mapping and which pixels hit."""
    c = (2 * np.arange(size) + 1) / size - 1
    x, y = np.meshgrid(c, -c)
    inside = x * x + y * y < 1
    return np.stack([x, y, np.sqrt(np.where(inside, 1 - x * x - y * y, 1))], -1), inside


def _schlick(u):
    return (1 - u) ** 5


def _dielectric(c, eta):
    """From the amplitude coefficients, not from the rational form the SDL uses."""
    transmitted = np.sqrt(1 - (1 - c * c) / eta**2)
    perpendicular = (c - eta * transmitted) / (c + eta * transmitted)
    parallel = (eta * c - transmitted) / (eta * c + transmitted)
    return (perpendicular**2 + parallel**2) / 2


def _g1(cosine, alpha2):
    """Smith GGX from tan^2."""
    return 2 / (1 + np.sqrt(1 + alpha2 * (1 - cosine**2) / cosine**2))


def evaluate(model, p, light, size, lobe="all"):
    """(N, N, 3): f (n.l)."""
    n, inside = sphere_normals(size)
    light = np.asarray(light, float) / np.linalg.norm(light)
    view = np.array([0.0, 0.0, 1.0])
    h = (light + view) / np.linalg.norm(light + view)
    nl, nv, nh, lh = _dot(n, light), n[..., 2], _dot(n, h), float(light @ h)
    good = inside & (nl > 0) & (nv > 0)
    nl, nv = np.where(good, nl, 1), np.where(good, nv, 1)
    principled = model == "principled"
    base = np.array(p["base"], float)
    metallic, roughness = p["metallic"], p["roughness"]
    lum = base @ [0.3, 0.6, 0.1]
    lum_sheen = base @ [0.2126729, 0.7151522, 0.0721750] if principled else lum
    tint = base / lum if lum > 0 else np.ones(3)
    tint_sheen = base / lum_sheen if lum > 0 else np.ones(3)
    plain = model.startswith("path")
    specular_tint = 0 if plain else p["specular_tint"]
    c0 = (1 - metallic) * 0.08 * p["specular"] * ((1 - specular_tint) + specular_tint * tint) + metallic * base

    def fresnel(f0, eta):
        weight = _schlick(lh)
        if principled:
            weight = (_dielectric(lh, eta) - _dielectric(1, eta)) / (1 - _dielectric(1, eta)) if eta > 1 else 0
        return f0 + (1 - f0) * weight

    total = np.zeros((size, size, 3))
    if lobe in ("all", "diffuse"):
        fd90 = 0.5 + 2 * roughness * lh**2
        f = ((1 + (fd90 - 1) * _schlick(nl)) * (1 + (fd90 - 1) * _schlick(nv)) if model != "path" else np.ones_like(nl)) / np.pi
        total += (1 - metallic) * base * f[..., None]
    if lobe in ("all", "sheen") and not plain:
        total += (1 - metallic) * p["sheen"] * (1 + p["sheen_tint"] * (tint_sheen - 1)) * _schlick(lh)
    if lobe in ("all", "specular") and (model == "disney" or p["specular"] > 0 or metallic > 0):
        aspect = np.sqrt(1 - 0.9 * p["anisotropic"]) if not plain else 1.0
        a = np.array([roughness**2 / aspect, roughness**2 * aspect])
        a = np.minimum(a, 1) if principled else np.maximum(a, 0.001)
        tangent = np.cross([0.0, 1.0, 0.0], n)
        tangent /= np.linalg.norm(tangent, axis=-1, keepdims=True)
        bitangent = np.cross(n, tangent)
        turn = 2 * np.pi * p["anisotropic_rotation"]
        x, y = tangent * np.cos(turn) + bitangent * np.sin(turn), bitangent * np.cos(turn) - tangent * np.sin(turn)

        def width2(w):
            """alpha^2 in the direction of w (equal alphas: their square)."""
            wx, wy = x @ w, y @ w
            across = np.maximum(wx**2 + wy**2, 1e-300)
            return ((wx * a[0]) ** 2 + (wy * a[1]) ** 2) / across

        if model == "path_disney":
            sin2 = _dot(np.cross(n, h), np.cross(n, h))
            gamma, alpha2 = p["d_gamma"], roughness**4
            constant = p["d_constant"]
            if constant is None:  # normalised: by quadrature of its definition, not by the closed form
                t, weight = np.polynomial.legendre.leggauss(400)
                s = np.exp(np.log(alpha2) * (t + 1) / 2)  # s = 1 + (alpha2 - 1) mu^2 from 1 down to alpha2
                integral = (weight / 2 * -np.log(alpha2) * s * s**-gamma).sum() / (1 - alpha2) * np.pi
                constant = 1 / integral
            d = constant / (alpha2 * (1 - sin2) + sin2) ** gamma
            ag2 = (0.5 + roughness / 2) ** 4
            g = _g1(nl, ag2) * _g1(nv, ag2)
        else:
            hx, hy = x @ h, y @ h
            d = 1 / (np.pi * a[0] * a[1] * ((hx / a[0]) ** 2 + (hy / a[1]) ** 2 + nh**2) ** 2)
            g = _g1(nl, width2(light)) * _g1(nv, width2(view))
        eta = 2 / (1 - np.sqrt(0.08 * p["specular"])) - 1
        total += fresnel(c0, eta) * (d * g / (4 * nl * nv))[..., None]
    if lobe in ("all", "clearcoat") and not plain:
        alpha2 = p["clearcoat_roughness"] ** 4
        d = (alpha2 - 1) / (np.pi * np.log(alpha2) * (1 + (alpha2 - 1) * nh**2))
        total += (p["clearcoat"] / 4 * fresnel(0.04, 1.5) * d * _g1(nl, 0.0625) * _g1(nv, 0.0625) / (4 * nl * nv))[..., None]
    return np.where(good, nl, 0)[..., None] * total
