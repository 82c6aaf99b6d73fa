"""glTF material JSON -> the numbers the Principled BSDF needs (plain Python, no Blender).

Names and defaults as in docs/formats.md, Disney parameters: `disney_*` extras win over extensions, which win over the
defaults. Textures become dicts of image, texcoord set, wrap, filter and the 2x3 matrix of KHR_texture_transform.
"""

import math

from gltf import GltfError

EXTRAS = ("specular", "specular_tint", "anisotropic", "anisotropic_rotation", "sheen", "sheen_tint", "clearcoat",
          "clearcoat_gloss", "clearcoat_roughness")
WRAP = {33071: "clamp", 33648: "mirror", 10497: "repeat"}
NEAREST = 9728


def gloss_to_roughness(gloss):
    """Disney's alpha of the coat is mix(.1, .001, gloss); Blender squares its clearcoat roughness to get it."""
    return math.sqrt(.1 + (.001 - .1) * gloss)


def read_material(gltf, index):
    """The material as a dict; `index` None is glTF's default material."""
    material = {} if index is None else gltf.list("materials")[index]
    pbr = material.get("pbrMetallicRoughness", {})
    extensions = material.get("extensions", {})
    factor = pbr.get("baseColorFactor", [1, 1, 1, 1])
    result = {
        "name": material.get("name", f"materials[{index}]"),
        "base_color": factor[:3], "alpha": factor[3],
        "metallic": pbr.get("metallicFactor", 1.0), "roughness": pbr.get("roughnessFactor", 1.0),
        "specular": 0.5, "specular_tint": 0.0, "anisotropic": 0.0, "anisotropic_rotation": 0.0,
        "sheen": 0.0, "sheen_tint": 0.5, "clearcoat": 0.0, "clearcoat_roughness": math.sqrt(.1 ** 1.5),
        "emission": material.get("emissiveFactor", [0, 0, 0]),
        "emission_strength": extensions.get("KHR_materials_emissive_strength", {}).get("emissiveStrength", 1.0),
        "alpha_mode": material.get("alphaMode", "OPAQUE"), "alpha_cutoff": material.get("alphaCutoff", 0.5),
        "double_sided": material.get("doubleSided", False),
        "normal_scale": material.get("normalTexture", {}).get("scale", 1.0),
        "base_color_texture": read_texture(gltf, pbr.get("baseColorTexture")),
        "metallic_roughness_texture": read_texture(gltf, pbr.get("metallicRoughnessTexture")),
        "normal_texture": read_texture(gltf, material.get("normalTexture")),
        "emissive_texture": read_texture(gltf, material.get("emissiveTexture")),
    }
    extras = material.get("extras") or {}
    _apply_extensions(result, extensions, extras)
    for key, value in extras.items():
        if not key.startswith("disney_"):
            continue
        if key[7:] not in EXTRAS:
            raise GltfError(f"{gltf.path}: materials[{index}].extras: wanted disney_* of {', '.join(EXTRAS)}, found {key}")
        result.update({"clearcoat_roughness": gloss_to_roughness(value)} if key == "disney_clearcoat_gloss"
                      else {key[7:]: value})
    return result


def _apply_extensions(result, extensions, extras):
    """Exact where Disney's parameters can say what the extension says, else the approximation of docs/gltf.md."""
    base = result["base_color"]
    specular, ior = extensions.get("KHR_materials_specular"), extensions.get("KHR_materials_ior")
    if specular is not None or ior is not None:
        index = (ior or {}).get("ior", 1.5)
        normal_incidence = ((index - 1) / (index + 1)) ** 2 if index else 1.0  # ior 0: fully reflecting
        color = (specular or {}).get("specularColorFactor", [1, 1, 1])
        strength = (specular or {}).get("specularFactor", 1.0) * _luminance(color)
        result["specular"] = min(normal_incidence * strength / .08, 1.0)  # Disney: F0 = .08 specular
        result["specular_tint"] = _tint(color, base)
    coat = extensions.get("KHR_materials_clearcoat")
    if coat is not None:
        result["clearcoat"] = coat.get("clearcoatFactor", 0.0)
        result["clearcoat_roughness"] = coat.get("clearcoatRoughnessFactor", 0.0)
    sheen = extensions.get("KHR_materials_sheen")
    if sheen is not None:
        color = sheen.get("sheenColorFactor", [0, 0, 0])
        result["sheen"] = max(color)
        result["sheen_tint"] = 1 - min(color) / max(color) if max(color) > 0 else 0.0
    anisotropy = extensions.get("KHR_materials_anisotropy", {})
    strength = anisotropy.get("anisotropyStrength", 0.0)
    if strength > 0 and "disney_anisotropic" not in extras:
        # The same alphas along (t) and across (b): aspect^2 = b / t = 1 - .9 anisotropic, roughness^4 = t b.
        across = result["roughness"] ** 2
        along = across + (1 - across) * strength ** 2
        result["anisotropic"] = min((1 - across / along) / .9, 1.0)
        result["anisotropic_rotation"] = anisotropy.get("anisotropyRotation", 0.0) / (2 * math.pi) % 1
        if result["metallic_roughness_texture"] is None:
            result["roughness"] = (along * across) ** .25


def _luminance(color):
    return .3 * color[0] + .6 * color[1] + .1 * color[2]


def _tint(color, base):
    """The tint t in [0, 1] for which 1 + t (base / lum(base) - 1) comes closest to the hue of `color`."""
    own, lum = _luminance(color), _luminance(base)
    if own <= 0 or lum <= 0 or color[0] == color[1] == color[2]:
        return 0.0
    towards = [b / lum - 1 for b in base]
    square = sum(d * d for d in towards)
    wanted = sum(d * (c / own - 1) for d, c in zip(towards, color))
    return min(max(wanted / square, 0.0), 1.0) if square > 0 else 0.0


def read_texture(gltf, info):
    if info is None:
        return None
    texture = gltf.list("textures")[info["index"]]
    sampler = gltf.list("samplers")[texture["sampler"]] if "sampler" in texture else {}
    transform = info.get("extensions", {}).get("KHR_texture_transform", {})
    (x, y), (sx, sy) = transform.get("offset", (0, 0)), transform.get("scale", (1, 1))
    cos, sin = math.cos(transform.get("rotation", 0.0)), math.sin(transform.get("rotation", 0.0))
    return {
        "image": texture["source"],
        "texcoord": transform.get("texCoord", info.get("texCoord", 0)),
        "wrap": (WRAP[sampler.get("wrapS", 10497)], WRAP[sampler.get("wrapT", 10497)]),
        "nearest": sampler.get("magFilter") == NEAREST,
        # Counter-clockwise as seen in the image, whose v points down, as Khronos' viewer and Blender's importer have
        # it (the GLSL in the extension's text turns the other way).
        "matrix": ((cos * sx, sin * sy, x), (-sin * sx, cos * sy, y)),
    }
