"""Writes glTF 2.0 binary files (.glb) from plain Python data, the same bytes every time.

Numbers are rounded to seven decimals before they become float32, so that the last bit of a C library's sin or acos
does not reach the file. Punctual lights are in W/sr and W/m^2, emission in radiance (docs/formats.md).
"""

import json
import math
import struct

BYTE, SHORT, UINT, FLOAT = 5121, 5123, 5125, 5126  # unsigned byte, unsigned short, unsigned int, float
FORMATS = {BYTE: "B", SHORT: "H", UINT: "I", FLOAT: "f"}
SIZES = {BYTE: 1, SHORT: 2, UINT: 4, FLOAT: 4}
WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4}
ARRAY, ELEMENTS = 34962, 34963
STRIP, FAN = 5, 6


def snap(x):
    """Seven decimals, and never a negative zero."""
    return round(float(x), 7) + 0.0


def snaps(values):
    return [snap(x) for x in values]


def float32(x):
    return struct.unpack("<f", struct.pack("<f", x))[0]


class Glb:
    def __init__(self, environment=None, color=None, strength=None, rotation=None):
        self.bin = bytearray()
        self.doc = {"asset": {"version": "2.0", "generator": "assay make-scenes"}, "scene": 0,
                    "scenes": [{"nodes": []}]}
        extras = {}
        if environment:
            extras["environment"] = environment
        if color:
            extras["environment_color"] = list(color)
        if strength is not None:
            extras["environment_strength"] = strength
        if rotation is not None:
            extras["environment_rotation"] = rotation
        if extras:
            self.doc["scenes"][0]["extras"] = extras
        self.roots = self.doc["scenes"][0]["nodes"]

    def add(self, list_name, item):
        """Append to a top-level list; equal items are stored once (not nodes, which have an identity)."""
        items = self.doc.setdefault(list_name, [])
        if list_name != "nodes" and item in items:
            return items.index(item)
        items.append(item)
        return len(items) - 1

    def uses(self, extension):
        used = self.doc.setdefault("extensionsUsed", [])
        if extension not in used:
            used.append(extension)
            used.sort()

    # --- bytes -------------------------------------------------------------------------------------------------

    def view(self, data, target=None, stride=None):
        self.bin += b"\0" * (-len(self.bin) % 4)
        item = {"buffer": 0, "byteOffset": len(self.bin), "byteLength": len(data)}
        if stride:
            item["byteStride"] = stride
        if target:
            item["target"] = target
        self.bin += data
        return self.add("bufferViews", item)

    def accessor(self, values, kind="VEC3", component=FLOAT, target=ARRAY, normalized=False, bounds=False):
        """One accessor over its own buffer view. `values`: tuples, or numbers for SCALAR."""
        rows = [(v,) if kind == "SCALAR" else tuple(v) for v in values]
        if component == FLOAT:
            rows = [tuple(float32(snap(x)) for x in row) for row in rows]
        width = WIDTHS[kind] * SIZES[component]
        padding = -width % 4 if target == ARRAY else 0  # vertex attributes are aligned to four bytes
        code = "<%d%s%dx" % (WIDTHS[kind], FORMATS[component], padding)
        data = b"".join(struct.pack(code, *row) for row in rows)
        item = {"bufferView": self.view(data, target, width + padding if padding else None),
                "componentType": component, "count": len(rows), "type": kind}
        if normalized:
            item["normalized"] = True
        if bounds:
            item["min"] = [min(column) for column in zip(*rows)]
            item["max"] = [max(column) for column in zip(*rows)]
        return self.add("accessors", item)

    def indices(self, triangles, component=None):
        flat = [i for t in triangles for i in t] if triangles and not isinstance(triangles[0], int) else list(triangles)
        if component is None:
            component = SHORT if max(flat) < 65535 else UINT
        return self.accessor(flat, "SCALAR", component, ELEMENTS)

    # --- things ------------------------------------------------------------------------------------------------

    def image(self, png, mime="image/png"):
        return self.add("images", {"bufferView": self.view(png), "mimeType": mime})

    def texture(self, image, wrap=(10497, 10497), nearest=False):
        sampler = {"wrapS": wrap[0], "wrapT": wrap[1], "magFilter": 9728 if nearest else 9729,
                   "minFilter": 9728 if nearest else 9729}
        return self.add("textures", {"sampler": self.add("samplers", sampler), "source": image})

    def material(self, name, base=(0.8, 0.8, 0.8), rough=0.5, metal=0.0, emit=None, strength=None, double=True,
                 alpha=1.0, textures=None, extensions=None, mode=None, cutoff=None, **disney):
        """`disney` keys without their prefix: specular=0.3 becomes extras.disney_specular. `textures`: glTF's own
        texture slots by name, pbr ones included."""
        textures = dict(textures or {})
        pbr = {"baseColorFactor": snaps(base) + [snap(alpha)], "metallicFactor": metal, "roughnessFactor": rough}
        for slot in ("baseColorTexture", "metallicRoughnessTexture"):
            if slot in textures:
                pbr[slot] = textures.pop(slot)
        item = {"name": name, "pbrMetallicRoughness": pbr, **textures}
        if double:
            item["doubleSided"] = True
        if emit is not None:
            item["emissiveFactor"] = snaps(emit)
        extensions = dict(extensions or {})
        if strength is not None:
            extensions["KHR_materials_emissive_strength"] = {"emissiveStrength": strength}
        for extension in extensions:
            self.uses(extension)
        if extensions:
            item["extensions"] = extensions
        if mode:
            item["alphaMode"] = mode
        if cutoff is not None:
            item["alphaCutoff"] = cutoff
        if disney:
            item["extras"] = {"disney_" + key: value for key, value in sorted(disney.items())}
        return self.add("materials", item)

    def primitive(self, shape, material):
        """`shape`: see shapes.Shape. Its accessors are made once and shared by every primitive that uses it."""
        if not hasattr(shape, "stored") or shape.stored[0] is not self:
            attributes = {"POSITION": self.accessor(shape.positions, bounds=True)}
            if shape.normals:
                attributes["NORMAL"] = self.accessor(shape.normals)
            if shape.tangents:
                attributes["TANGENT"] = self.accessor(shape.tangents, "VEC4")
            if shape.texcoords:
                attributes["TEXCOORD_0"] = self.accessor(shape.texcoords, "VEC2")
            if shape.colors:
                attributes["COLOR_0"] = self.accessor(shape.colors, "VEC%d" % len(shape.colors[0]))
            shape.stored = (self, attributes, self.indices(shape.triangles))
        return {"attributes": dict(shape.stored[1]), "indices": shape.stored[2], "material": material}

    def mesh(self, *pairs, name=None):
        """pairs: (shape, material), ..."""
        item = {"primitives": [self.primitive(shape, material) for shape, material in pairs]}
        if name:
            item["name"] = name
        return self.add("meshes", item)

    def node(self, parent=None, **keys):
        index = self.add("nodes", keys)
        if parent is None:
            self.roots.append(index)
        else:
            self.doc["nodes"][parent].setdefault("children", []).append(index)
        return index

    def put(self, shape, material, at=None, scale=None, turn=None, parent=None, name=None):
        """A node with a mesh of one primitive. turn: quaternion, see `rotation`."""
        keys = {"mesh": self.mesh((shape, material))}
        if at:
            keys["translation"] = snaps(at)
        if turn:
            keys["rotation"] = snaps(turn)
        if scale:
            keys["scale"] = snaps((scale,) * 3 if isinstance(scale, (int, float)) else scale)
        if name:
            keys["name"] = name
        return self.node(parent, **keys)

    def camera(self, eye, target, degrees=None, ymag=None, aspect=1.0, up=(0, 1, 0), name="camera"):
        if ymag:
            lens = {"type": "orthographic", "orthographic": {"xmag": snap(ymag * aspect), "ymag": snap(ymag),
                                                             "znear": 0.01, "zfar": 100.0}}
        else:
            lens = {"type": "perspective", "perspective": {"aspectRatio": snap(aspect), "znear": 0.01,
                                                           "yfov": snap(math.radians(degrees))}}
        self.node(camera=self.add("cameras", lens), matrix=look_at(eye, target, up), name=name)

    def light(self, kind, at=None, color=(1, 1, 1), intensity=1.0, aim=None, cone=None, name=None):
        """aim: the point a spot or directional light looks at from `at`. cone: (inner, outer) in degrees."""
        item = {"type": kind, "color": snaps(color), "intensity": snap(intensity)}
        if cone:
            item["spot"] = {"innerConeAngle": snap(math.radians(cone[0])),
                            "outerConeAngle": snap(math.radians(cone[1]))}
        if name:
            item["name"] = name
        self.uses("KHR_lights_punctual")
        lights = self.doc.setdefault("extensions", {}).setdefault("KHR_lights_punctual", {}).setdefault("lights", [])
        lights.append(item)
        where = {"matrix": look_at(at, aim, (0, 1, 0.001))} if aim else {"translation": snaps(at)}
        self.node(extensions={"KHR_lights_punctual": {"light": len(lights) - 1}}, **where)

    def bytes(self):
        doc = dict(self.doc)
        if self.bin:
            doc["buffers"] = [{"byteLength": len(self.bin)}]
        text = json.dumps(doc, separators=(",", ":")).encode()
        text += b" " * (-len(text) % 4)
        body = bytes(self.bin) + b"\0" * (-len(self.bin) % 4)
        chunks = struct.pack("<II", len(text), 0x4E4F534A) + text
        if body:
            chunks += struct.pack("<II", len(body), 0x004E4942) + body
        return struct.pack("<III", 0x46546C67, 2, 12 + len(chunks)) + chunks


def cross(a, b):
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def minus(a, b):
    return tuple(x - y for x, y in zip(a, b))


def dot(a, b):
    return sum(x * y for x, y in zip(a, b))


def unit(a):
    length = math.sqrt(dot(a, a))
    return tuple(x / length for x in a)


def look_at(eye, target, up=(0, 1, 0)):
    """Column-major matrix of a node at `eye` whose -z looks at `target`."""
    z = unit(minus(eye, target))
    x = unit(cross(up, z))
    y = cross(z, x)
    return snaps((*x, 0, *y, 0, *z, 0, *eye, 1))


def rotation(axis, degrees):
    """Unit quaternion (x, y, z, w)."""
    half = math.radians(degrees) / 2
    return tuple(math.sin(half) * a for a in unit(axis)) + (math.cos(half),)
