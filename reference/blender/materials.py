"""glTF material JSON -> the numbers the Principled BSDF needs (plain Python, no Blender).

Names and defaults as in docs/formats.md, Disney parameters: `disney_*` extras win over extensions, which win over the
defaults. Textures become dicts of image, texcoord set, wrap, filter and the 2x3 matrix of KHR_texture_transform.
"""

import math

from gltf import GltfError

EXTRAS = ("specular", "specular_tint", "anisotropic", "anisotropic_rotation", "sheen", "sheen_tint", "clearcoat",
          "clearcoat_gloss", "clearcoat_roughness")
WRAP = {33071: "clamp", 33648: "mirror", 10497: "repeat"}
NEAREST = (9728, 9984, 9986)  # NEAREST, NEAREST_MIPMAP_NEAREST, NEAREST_MIPMAP_LINEAR


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
    _apply_extensions(result, extensions)
    for key, value in (material.get("extras") or {}).items():
        if not key.startswith("disney_"):
            continue
        if key[7:] not in EXTRAS:
            raise GltfError(f"{gltf.path}: materials[{index}].extras: wanted disney_* of {', '.join(EXTRAS)}, found {key}")
        result.update({"clearcoat_roughness": gloss_to_roughness(value)} if key == "disney_clearcoat_gloss"
                      else {key[7:]: value})
    return result


def _apply_extensions(result, extensions):
    specular, ior = extensions.get("KHR_materials_specular"), extensions.get("KHR_materials_ior")
    if specular is not None or ior is not None:
        index = (ior or {}).get("ior", 1.5)
        # F0 = ((ior-1)/(ior+1))^2 = .08 specular
        result["specular"] = (specular or {}).get("specularFactor", 1.0) * ((index - 1) / (index + 1)) ** 2 / .08
    coat = extensions.get("KHR_materials_clearcoat")
    if coat is not None:
        result["clearcoat"] = coat.get("clearcoatFactor", 0.0)
        result["clearcoat_roughness"] = coat.get("clearcoatRoughnessFactor", 0.0)
    sheen = extensions.get("KHR_materials_sheen")
    if sheen is not None:
        result["sheen"] = max(sheen.get("sheenColorFactor", [0, 0, 0]))
    anisotropy = extensions.get("KHR_materials_anisotropy")
    if anisotropy is not None:
        result["anisotropic"] = anisotropy.get("anisotropyStrength", 0.0)
        result["anisotropic_rotation"] = anisotropy.get("anisotropyRotation", 0.0) / (2 * math.pi)


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
        "nearest": sampler.get("magFilter", sampler.get("minFilter", 9729)) in NEAREST,
        # Counter-clockwise as seen in the image, whose v points down, as Khronos' viewer and Blender's importer have
        # it (the GLSL in the extension's text turns the other way).
        "matrix": ((cos * sx, sin * sy, x), (-sin * sx, cos * sy, y)),
    }
