#!/usr/bin/python3
"""Writes the seeds of the fuzzer, which the tests replay: small good files, and one of each kind of attack.

What the fuzzer finds is added beside them by hand, as finding-*.
"""
import base64
import json
import struct
import zlib
from pathlib import Path

here = Path(__file__).parent
images = here.parents[1] / "image" / "testdata"


def png(width, height, kind, bits, rows, extra=b"", interlaced=0):
    def chunk(name, data):
        return struct.pack(">I", len(data)) + name + data + struct.pack(">I", zlib.crc32(name + data))
    header = struct.pack(">IIBBBBB", width, height, bits, kind, 0, 0, interlaced)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + extra + chunk(b"IDAT", zlib.compress(rows, 9)) + chunk(b"IEND", b"")


def palette(data):
    return struct.pack(">I", len(data)) + b"PLTE" + data + struct.pack(">I", zlib.crc32(b"PLTE" + data))


GREY = png(2, 2, 0, 8, b"\0\x10\x80\0\xff\x40")
RGBA = png(2, 1, 6, 8, b"\0\xff\0\0\xff\0\xff\0\x80")
PNGS = {
    "grey": GREY, "rgba": RGBA, "rgb": png(2, 1, 2, 8, b"\0\x01\x02\x03\x04\x05\x06"),
    "grey16": png(1, 1, 0, 16, b"\0\x12\x34"), "grey1": png(8, 1, 0, 1, b"\0\x55"), "grey_alpha": png(1, 1, 4, 8, b"\0\x77\x03"),
    "palette": png(2, 1, 3, 8, b"\0\0\1", palette(bytes([1, 2, 3, 4, 5, 6]))), "interlaced": png(2, 2, 0, 8, b"\0\1\0\2\0\3\4", interlaced=1),
    "no_palette": png(2, 1, 3, 8, b"\0\0\1"), "too_little": png(100, 100, 2, 8, b"\0\1\2\3"), "huge": png(100_000, 100_000, 0, 8, b"\0\1"),
    "bomb": png(8192, 4096, 0, 8, bytes(8193 * 4096)), "truncated": GREY[:-20], "crc": GREY[:-1] + b"\0",
    "filter": png(2, 2, 0, 8, b"\7\x10\x80\0\xff\x40"),
}


def binary(*parts):
    """Buffer and bufferViews of the parts, each at a multiple of 4."""
    buffer, views = b"", []
    for part in parts:
        views.append({"buffer": 0, "byteOffset": len(buffer), "byteLength": len(part)})
        buffer += part + bytes(-len(part) % 4)
    return buffer, views


def triangle(images=(RGBA,)):
    buffer, views = binary(struct.pack("<9f", 0, 0, 0, 1, 0, 0, 0, 1, 0), struct.pack("<3H", 0, 1, 2), struct.pack("<9f", *[0, 0, 1] * 3),
                           bytes([0, 0, 9, 9, 255, 0, 9, 9, 0, 255]), struct.pack("<12f", *[1, 0, 0, 1] * 3), bytes([255, 128, 0, 255] * 3), *images)
    views[3]["byteStride"] = 4
    return {
        "asset": {"version": "2.0", "generator": "hand"}, "scene": 0, "extensionsUsed": ["KHR_lights_punctual"],
        "scenes": [{"nodes": [0], "extras": {"environment_color": [1, 1, 1], "environment_rotation": 90}}],
        "nodes": [{"mesh": 0, "children": [1, 2], "translation": [1, 2, 3], "rotation": [0, 0, 0, 1], "scale": [1, -2, 3]},
                  {"camera": 0, "matrix": [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 3, 1]}, {"extensions": {"KHR_lights_punctual": {"light": 0}}}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0, "NORMAL": 2, "TEXCOORD_0": 3, "TANGENT": 4, "COLOR_0": 5}, "indices": 1,
                                    "material": 0, "mode": 4}]}],
        "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3",
                       "sparse": {"count": 1, "indices": {"bufferView": 1, "componentType": 5123, "byteOffset": 2}, "values": {"bufferView": 0, "byteOffset": 12}}},
                      {"bufferView": 1, "componentType": 5123, "count": 3, "type": "SCALAR"}, {"bufferView": 2, "componentType": 5126, "count": 3, "type": "VEC3"},
                      {"bufferView": 3, "componentType": 5121, "count": 3, "type": "VEC2", "normalized": True},
                      {"bufferView": 4, "componentType": 5126, "count": 3, "type": "VEC4"},
                      {"bufferView": 5, "componentType": 5121, "count": 3, "type": "VEC4", "normalized": True}],
        "bufferViews": views, "buffers": [{"byteLength": len(buffer)}],
        "cameras": [{"type": "perspective", "perspective": {"yfov": 1, "znear": .1, "aspectRatio": 1}}],
        "images": [{"bufferView": 6 + i, "mimeType": "image/png"} for i in range(len(images))],
        "samplers": [{"wrapS": 33071, "wrapT": 33648, "magFilter": 9728}],
        "textures": [{"source": i, "sampler": 0} for i in range(len(images))],
        "extensions": {"KHR_lights_punctual": {"lights": [{"type": "spot", "color": [1, 1, 1], "intensity": 5, "spot": {"innerConeAngle": .1, "outerConeAngle": .5}}]}},
        "materials": [{"doubleSided": True, "alphaMode": "MASK", "alphaCutoff": .4, "emissiveFactor": [1, 1, 1], "normalTexture": {"index": 0, "scale": 1},
                       "pbrMetallicRoughness": {"baseColorFactor": [1, .5, .25, 1], "metallicFactor": 0, "roughnessFactor": .5,
                                                "baseColorTexture": {"index": 0, "extensions": {"KHR_texture_transform": {"offset": [0, 1], "rotation": 1, "scale": [2, 2]}}}},
                       "extras": {"disney_sheen": .5, "disney_clearcoat_gloss": 1, "disney_anisotropic": 1},
                       "extensions": {"KHR_materials_ior": {"ior": 1.4}, "KHR_materials_emissive_strength": {"emissiveStrength": 2}}}],
    }, buffer


def glb(document, buffer):
    text = json.dumps(document).encode()
    text += b" " * (-len(text) % 4)
    buffer += bytes(-len(buffer) % 4)
    chunks = struct.pack("<I4s", len(text), b"JSON") + text + struct.pack("<I4s", len(buffer), b"BIN\0") + buffer
    return struct.pack("<4sII", b"glTF", 2, 12 + len(chunks)) + chunks


def gltf(document, buffer):
    document["buffers"][0]["uri"] = "data:application/octet-stream;base64," + base64.b64encode(buffer).decode()
    return json.dumps(document).encode()


# Each changes a good document into one attack.
def set_at(*path_and_value):
    *path, value = path_and_value

    def change(document):
        for step in path[:-1]:
            document = document[step]
        document[path[-1]] = value
    return change


ATTACKS = {
    "good": lambda d: None, "count": set_at("accessors", 0, "count", 1_000_000), "wraps": set_at("bufferViews", 1, "byteOffset", 2**64 - 6),
    "stride": set_at("bufferViews", 3, "byteStride", 3), "no_view": lambda d: d["accessors"][0].pop("bufferView"),
    "index": set_at("meshes", 0, "primitives", 0, "indices", 99), "cycle": set_at("nodes", 1, "children", [0]),
    "shared": set_at("nodes", 1, "children", [2]), "image_past_end": set_at("bufferViews", 6, "byteLength", 70_000),
    "strip": set_at("meshes", 0, "primitives", 0, "mode", 5), "fan": set_at("meshes", 0, "primitives", 0, "mode", 6),
    "zero_scale": set_at("nodes", 0, "scale", [0, 0, 0]), "huge_scale": set_at("nodes", 0, "scale", [1e30, 1, 1]), "quaternion": set_at("nodes", 0, "rotation", [0, 0, 0, 0]),
    "fov": set_at("cameras", 0, "perspective", "yfov", 3.1415), "orthographic": set_at("cameras", 0, {"type": "orthographic", "orthographic": {"xmag": 1, "ymag": 1, "znear": 0, "zfar": 9}}),
    "bright": set_at("materials", 0, "extensions", "KHR_materials_emissive_strength", "emissiveStrength", 1e38), "blend": set_at("materials", 0, "alphaMode", "BLEND"),
    "uri_out": set_at("images", 0, {"uri": "../../etc/hostname"}), "required": set_at("extensionsRequired", ["KHR_draco_mesh_compression"]),
    "flat_instances": lambda d: (d["nodes"].append({"mesh": 0, "scale": [1, 1e-30, 1]}), d["scenes"][0]["nodes"].append(3)),
    "deep": set_at("extras", json.loads("[" * 100 + "]" * 100)), "point": set_at("extensions", "KHR_lights_punctual", "lights", 0, {"type": "point", "intensity": 1e38}),
}


def main():
    for kind, pack in (("glb", glb), ("gltf", gltf)):
        (here / kind).mkdir(exist_ok=True)
        for name, attack in ATTACKS.items():
            document, buffer = triangle()
            attack(document)
            (here / kind / name).write_bytes(pack(document, buffer))
    (here / "image").mkdir(exist_ok=True)
    for name, data in PNGS.items():
        (here / "image" / f"{name}.png").write_bytes(data)
    for file in sorted(images.glob("*.jpg")):
        (here / "image" / file.name).write_bytes(file.read_bytes())
    hdr = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 2 +X 2\n" + bytes([128, 64, 32, 129] * 4)
    run = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 8\n" + bytes([2, 2, 0, 8] + [136, 100] * 4)
    (here / "image" / "flat.hdr").write_bytes(hdr)
    (here / "image" / "run.hdr").write_bytes(run)
    words = sorted({w for w in json.dumps(triangle()[0]).replace("[", " ").split('"')[1::2]})
    (here / "gltf.dict").write_text("".join(f'"\\"{w}\\""\n' for w in words))
    (here / "glb.dict").write_text('"glTF"\n"JSON"\n"BIN\\x00"\n' + "".join(f'"\\"{w}\\""\n' for w in words))
    (here / "image.dict").write_text("".join(f'"{w}"\n' for w in ("IHDR", "IDAT", "PLTE", "tRNS", "gAMA", "IEND", "\\xff\\xd8", "\\xff\\xc0", "\\xff\\xc2", "\\xff\\xda",
                                                                  "\\xff\\xc4", "\\xff\\xdb", "#?RADIANCE", "-Y 2 +X 2", "channels", "compression", "dataWindow")))


if __name__ == "__main__":
    main()
