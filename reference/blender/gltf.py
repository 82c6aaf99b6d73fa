"""Read a glTF 2.0 scene (.gltf or .glb) in plain Python: no Blender, so the same module serves inside and outside it.

An independent reading of the file, on purpose: nothing here comes from the renderer's loader, only the contract in
docs/formats.md. World space stays glTF's (right-handed, +y up, metres); angles in radians; colours linear Rec.709.
"""

import base64
import hashlib
import json
import math
import os
import struct
import urllib.parse

import numpy as np

COMPONENTS = {5120: np.int8, 5121: np.uint8, 5122: np.int16, 5123: np.uint16, 5125: np.uint32, 5126: np.float32}
WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT2": 4, "MAT3": 9, "MAT4": 16}


class GltfError(Exception):
    """One line for the user: file, place, what was wanted, what was found."""


class Gltf:
    def __init__(self, path):
        self.path = path
        self.folder = os.path.dirname(os.path.abspath(path))
        try:
            with open(path, "rb") as file:
                data = file.read()
        except OSError as error:
            raise GltfError(f"{path}: cannot be read: {error.strerror}") from None
        try:
            self.json, self.bin_chunk = _split_glb(path, data) if data[:4] == b"glTF" else (json.loads(data), None)
        except (ValueError, struct.error) as error:
            raise GltfError(f"{path}: wanted glTF 2.0 JSON, found: {error}") from None
        self._buffers = {}

    def list(self, key):
        return self.json.get(key, [])

    def buffer(self, index):
        if index not in self._buffers:
            uri = self.list("buffers")[index].get("uri")
            self._buffers[index] = self.bin_chunk if uri is None else self._read_uri(uri, f"buffers[{index}]")
        return self._buffers[index]

    def buffer_view(self, index):
        view = self.list("bufferViews")[index]
        start = view.get("byteOffset", 0)
        return self.buffer(view["buffer"])[start:start + view["byteLength"]]

    def accessor(self, index, normalize=True):
        """The accessor's elements as an (n, width) array: floats stay, normalised integers become floats."""
        accessor = self.list("accessors")[index]
        dtype, width, count = COMPONENTS[accessor["componentType"]], WIDTHS[accessor["type"]], accessor["count"]
        if "bufferView" in accessor:
            view = self.list("bufferViews")[accessor["bufferView"]]
            data = self._elements(accessor["bufferView"], accessor.get("byteOffset", 0), view.get("byteStride"),
                                  dtype, width, count, f"accessors[{index}]")
        else:
            data = np.zeros((count, width), dtype)
        if "sparse" in accessor:
            sparse = accessor["sparse"]
            where = self._elements(sparse["indices"]["bufferView"], sparse["indices"].get("byteOffset", 0), None,
                                   COMPONENTS[sparse["indices"]["componentType"]], 1, sparse["count"],
                                   f"accessors[{index}].sparse.indices")
            data[where[:, 0]] = self._elements(sparse["values"]["bufferView"], sparse["values"].get("byteOffset", 0),
                                               None, dtype, width, sparse["count"], f"accessors[{index}].sparse.values")
        if normalize and accessor.get("normalized"):
            data = np.maximum(data.astype(np.float32) / np.float32(np.iinfo(dtype).max), -1)
        return data

    def _elements(self, view, offset, stride, dtype, width, count, place):
        size = np.dtype(dtype).itemsize
        stride = stride or size * width
        data = self.buffer_view(view)
        if count and offset + stride * (count - 1) + size * width > len(data):
            raise GltfError(f"{self.path}: {place}: wanted {count} elements, found {len(data)} bytes in its bufferView")
        array = np.ndarray((count, width), np.dtype(dtype).newbyteorder("<"), data, offset, (stride, size))
        return np.array(array)

    def image_bytes(self, index):
        image = self.list("images")[index]
        if "bufferView" in image:
            return self.buffer_view(image["bufferView"])
        return self._read_uri(image["uri"], f"images[{index}]")

    def _read_uri(self, uri, place):
        if uri.startswith("data:"):
            return base64.b64decode(uri.split(",", 1)[1])
        try:
            with open(os.path.join(self.folder, urllib.parse.unquote(uri)), "rb") as file:
                return file.read()
        except OSError as error:
            raise GltfError(f"{self.path}: {place}: wanted the file {uri}, found: {error.strerror}") from None

    # --- the node tree

    def scene(self):
        scenes = self.list("scenes")
        return scenes[self.json.get("scene", 0)] if scenes else {"nodes": self._roots()}

    def _roots(self):
        children = {child for node in self.list("nodes") for child in node.get("children", [])}
        return [index for index in range(len(self.list("nodes"))) if index not in children]

    def nodes(self):
        """(node, world matrix) of the default scene, parents before children, in the order of the file."""
        found = []

        def visit(index, parent):
            node = self.list("nodes")[index]
            world = parent @ _local_matrix(node)
            found.append((node, world))
            for child in node.get("children", []):
                visit(child, world)

        for root in self.scene().get("nodes", []):
            visit(root, np.eye(4))
        return found

    def cameras(self):
        """[(camera, rigid world matrix)] in the order in which the node tree meets them."""
        return [(self.list("cameras")[node["camera"]], rigid(world)) for node, world in self.nodes() if "camera" in node]

    def lights(self, units="auto"):
        """Punctual lights as dicts: kind, rgb intensity in W/sr or W/m2, rigid world matrix, spot's cosines."""
        table = self.json.get("extensions", {}).get("KHR_lights_punctual", {}).get("lights", [])
        candela = units == "candela" or units == "auto" and "Blender" in self.json.get("asset", {}).get("generator", "")
        found = []
        for node, world in self.nodes():
            reference = node.get("extensions", {}).get("KHR_lights_punctual")
            if reference is None:
                continue
            light = table[reference["light"]]
            spot = light.get("spot", {})
            scale = light.get("intensity", 1.0) / (683.0 if candela else 1.0)
            found.append({
                "kind": light["type"],
                "intensity": [c * scale for c in light.get("color", [1, 1, 1])],
                "matrix": rigid(world),
                "cos_inner": math.cos(spot.get("innerConeAngle", 0.0)),
                "cos_outer": math.cos(spot.get("outerConeAngle", math.pi / 4)),
            })
        return found

    def environment(self):
        """None, {"color"} or {"file", "strength", "rotation"}; see docs/formats.md, Environment."""
        extras = self.scene().get("extras") or {}
        if "environment" in extras:
            return {"file": os.path.join(self.folder, extras["environment"]),
                    "strength": extras.get("environment_strength", 1.0),
                    "rotation": math.radians(extras.get("environment_rotation", 0.0))}
        if "environment_color" in extras:
            return {"color": extras["environment_color"], "strength": extras.get("environment_strength", 1.0)}
        return None


def _split_glb(path, data):
    magic, version, length = struct.unpack_from("<4sII", data)
    if version != 2 or length > len(data):
        raise GltfError(f"{path}: header: wanted glTF 2 of {len(data)} bytes, found version {version}, {length} bytes")
    document, binary, offset = None, None, 12
    while offset + 8 <= length:
        size, kind = struct.unpack_from("<I4s", data, offset)
        chunk = data[offset + 8:offset + 8 + size]
        if kind == b"JSON" and document is None:
            document = json.loads(chunk)
        elif kind == b"BIN\0" and binary is None:
            binary = chunk
        offset += 8 + size
    if document is None:
        raise GltfError(f"{path}: wanted a JSON chunk, found none")
    return document, binary


def write_glb(path, document, binary):
    text = json.dumps(document, separators=(",", ":")).encode()
    text += b" " * (-len(text) % 4)
    binary = bytes(binary) + b"\0" * (-len(binary) % 4)
    chunks = struct.pack("<I4s", len(text), b"JSON") + text + struct.pack("<I4s", len(binary), b"BIN\0") + binary
    with open(path, "wb") as file:
        file.write(struct.pack("<4sII", b"glTF", 2, 12 + len(chunks)) + chunks)


def _local_matrix(node):
    if "matrix" in node:
        return np.array(node["matrix"], float).reshape(4, 4).T
    x, y, z, w = node.get("rotation", (0, 0, 0, 1))
    rotation = np.array([[1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
                         [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
                         [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)]])
    local = np.eye(4)
    local[:3, :3] = rotation * np.array(node.get("scale", (1, 1, 1)), float)
    local[:3, 3] = node.get("translation", (0, 0, 0))
    return local


def rigid(matrix):
    """Without its scale: cameras and lights have none."""
    result = matrix.copy()
    result[:3, :3] /= np.linalg.norm(result[:3, :3], axis=0)
    return result


def scene_hash(path):
    """docs/formats.md, Hashes: the scene file, then every external buffer, image and environment it names."""
    scene = Gltf(path)
    digest = hashlib.sha256()
    with open(path, "rb") as file:
        digest.update(file.read())
    environments = [{"uri": s["extras"]["environment"]} for s in scene.list("scenes")
                    if "environment" in (s.get("extras") or {})]
    for place, entries in (("buffers", scene.list("buffers")), ("images", scene.list("images")),
                           ("environment", environments)):
        for index, entry in enumerate(entries):
            uri = entry.get("uri")
            if uri is not None and not uri.startswith("data:"):
                digest.update(scene._read_uri(uri, f"{place}[{index}]"))
    return digest.hexdigest()
