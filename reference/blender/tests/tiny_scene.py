"""A small glTF writer for the tests: quads, cameras, punctual lights, anything else as plain JSON."""

import os
import sys

import numpy as np

sys.path.insert(0, os.path.dirname(os.path.dirname(os.path.abspath(__file__))))

from gltf import write_glb  # noqa: E402

KINDS = {1: "SCALAR", 2: "VEC2", 3: "VEC3", 4: "VEC4"}


def look(eye, target, up=(0, 1, 0)):
    """World matrix of a camera or light: looks along its -z."""
    back = np.subtract(eye, target).astype(float)
    back /= np.linalg.norm(back)
    right = np.cross(up, back)
    right /= np.linalg.norm(right)
    matrix = np.eye(4)
    matrix[:3] = np.stack([right, np.cross(back, right), back, eye], axis=1)
    return matrix


class TinyScene:
    def __init__(self, **extras):
        self.binary = b""
        self.json = {"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [], "extras": extras}], "nodes": [],
                     "accessors": [], "bufferViews": []}

    def add(self, key, entry):
        self.json.setdefault(key, []).append(entry)
        return len(self.json[key]) - 1

    def view(self, data):
        self.binary += b"\0" * (-len(self.binary) % 4)
        self.binary += data
        return self.add("bufferViews", {"buffer": 0, "byteOffset": len(self.binary) - len(data), "byteLength": len(data)})

    def accessor(self, values, dtype=np.float32):
        values = np.atleast_2d(np.array(values, dtype))
        entry = {"bufferView": self.view(values.tobytes()), "componentType": 5126 if dtype is np.float32 else 5125,
                 "type": KINDS[values.shape[1]], "count": len(values)}
        if values.shape[1] == 3:
            entry.update(min=values.min(axis=0).tolist(), max=values.max(axis=0).tolist())
        return self.add("accessors", entry)

    def node(self, matrix=np.eye(4), **entry):
        index = self.add("nodes", dict(entry, matrix=np.asarray(matrix).T.ravel().tolist()))
        self.json["scenes"][0]["nodes"].append(index)

    def mesh(self, positions, triangles, material, matrix=np.eye(4), **attributes):
        accessors = {"POSITION": self.accessor(positions)}
        accessors.update({name: self.accessor(values) for name, values in attributes.items()})
        indices = self.accessor(np.reshape(triangles, (-1, 1)), np.uint32)
        primitive = {"attributes": accessors, "indices": indices, "material": self.add("materials", material)}
        self.node(matrix, mesh=self.add("meshes", {"primitives": [primitive]}))

    def quad(self, material, half=1.0, z=0.0, matrix=np.eye(4), **attributes):
        """In the xy plane, facing +z; corners (-,-) (+,-) (+,+) (-,+)."""
        corners = [(-half, -half, z), (half, -half, z), (half, half, z), (-half, half, z)]
        self.mesh(corners, (0, 1, 2, 0, 2, 3), material, matrix, NORMAL=[(0, 0, 1)] * 4, **attributes)

    def texture(self, png, wrap=(10497, 10497), nearest=False):
        image = self.add("images", {"bufferView": self.view(png), "mimeType": "image/png"})
        sampler = self.add("samplers", {"wrapS": wrap[0], "wrapT": wrap[1], "magFilter": 9728 if nearest else 9729})
        return self.add("textures", {"source": image, "sampler": sampler})

    def orthographic(self, matrix, ymag=1.0):
        camera = {"type": "orthographic", "orthographic": {"xmag": ymag, "ymag": ymag, "znear": .01, "zfar": 100}}
        self.node(matrix, camera=self.add("cameras", camera))

    def perspective(self, matrix, yfov):
        self.node(matrix, camera=self.add("cameras", {"type": "perspective", "perspective": {"yfov": yfov, "znear": .01}}))

    def light(self, matrix, **entry):
        table = self.json.setdefault("extensions", {"KHR_lights_punctual": {"lights": []}})["KHR_lights_punctual"]["lights"]
        table.append(entry)
        self.json["extensionsUsed"] = ["KHR_lights_punctual"]
        self.node(matrix, extensions={"KHR_lights_punctual": {"light": len(table) - 1}})

    def save(self, path):
        self.json["buffers"] = [{"byteLength": len(self.binary)}]
        write_glb(path, self.json, self.binary)
