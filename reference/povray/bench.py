"""A test bench: small glTF scenes, and the ray-triangle arithmetic in numpy that POV-Ray's first hits are held against."""

import math
import os

import numpy as np

import scene_to_pov


class Builder:
    """Triangles, lights and a camera as a .glb."""

    def __init__(self):
        self.binary = bytearray()
        self.json = {"asset": {"version": "2.0"}, "scenes": [{"nodes": []}], "scene": 0, "nodes": [], "meshes": [],
                     "materials": [], "accessors": [], "bufferViews": [], "cameras": [],
                     "extensions": {"KHR_lights_punctual": {"lights": []}}}

    def _accessor(self, values, kind, component):
        data = np.ascontiguousarray(values).tobytes()
        self.json["bufferViews"].append({"buffer": 0, "byteOffset": len(self.binary), "byteLength": len(data)})
        self.binary += data + b"\0" * (-len(data) % 4)
        self.json["accessors"].append({"bufferView": len(self.json["bufferViews"]) - 1, "componentType": component,
                                       "count": len(values), "type": kind})
        return len(self.json["accessors"]) - 1

    def _node(self, **node):
        self.json["nodes"].append(node)
        self.json["scenes"][0]["nodes"].append(len(self.json["nodes"]) - 1)

    def mesh(self, positions, triangles, material, normals=None, texcoords=None, **node):
        attributes = {"POSITION": self._accessor(np.float32(positions), "VEC3", 5126)}
        if normals is not None:
            attributes["NORMAL"] = self._accessor(np.float32(normals), "VEC3", 5126)
        if texcoords is not None:
            attributes["TEXCOORD_0"] = self._accessor(np.float32(texcoords), "VEC2", 5126)
        self.json["materials"].append(material)
        self.json["meshes"].append({"primitives": [{
            "attributes": attributes, "material": len(self.json["materials"]) - 1,
            "indices": self._accessor(np.uint16(np.ravel(triangles)), "SCALAR", 5123)}]})
        self._node(mesh=len(self.json["meshes"]) - 1, **node)

    def image(self, png):
        self.json["bufferViews"].append({"buffer": 0, "byteOffset": len(self.binary), "byteLength": len(png)})
        self.binary += png + b"\0" * (-len(png) % 4)
        self.json["images"] = [{"bufferView": len(self.json["bufferViews"]) - 1, "mimeType": "image/png"}]
        self.json["samplers"] = [{"wrapS": 10497, "wrapT": 10497}]
        self.json["textures"] = [{"source": 0, "sampler": 0}]

    def light(self, kind, intensity, **node):
        lights = self.json["extensions"]["KHR_lights_punctual"]["lights"]
        lights.append({"type": kind, "intensity": intensity, "color": [1, 0.5, 0.25]})
        self._node(extensions={"KHR_lights_punctual": {"light": len(lights) - 1}}, **node)

    def perspective(self, yfov, **node):
        self.json["cameras"].append({"type": "perspective", "perspective": {"yfov": yfov, "znear": 0.01}})
        self._node(camera=len(self.json["cameras"]) - 1, **node)

    def orthographic(self, ymag, **node):
        self.json["cameras"].append({"type": "orthographic", "orthographic": {"xmag": ymag, "ymag": ymag, "znear": 0, "zfar": 99}})
        self._node(camera=len(self.json["cameras"]) - 1, **node)

    def scene(self, folder):
        path = os.path.join(folder, "scene.glb")
        self.json["buffers"] = [{"byteLength": len(self.binary)}]
        scene_to_pov.gltf.write_glb(path, self.json, self.binary)
        return scene_to_pov.Scene(path)


def lambert(colour=(0.8, 0.4, 0.2), **more):
    return {"pbrMetallicRoughness": {"baseColorFactor": [*colour, 1], "metallicFactor": 0}, "doubleSided": True,
            "extras": {"disney_specular": 0}, **more}


def mirror():
    return {"pbrMetallicRoughness": {"metallicFactor": 1, "roughnessFactor": 0}, "doubleSided": True}


def glowing(colour):
    return lambert((0, 0, 0), emissiveFactor=colour)


def square(half=1.0, y=0.0):
    """Corners of a horizontal square, front up."""
    return [(-half, y, half), (half, y, half), (half, y, -half), (-half, y, -half)], [(0, 1, 2), (0, 2, 3)]


DOWN = [-math.sqrt(0.5), 0, 0, math.sqrt(0.5)]  # looks, or shines, along -y; -z of the world is up in the picture


def camera_rays(scene, width, height):
    """Origins and directions through the pixel centres, from glTF's definition."""
    c = scene.camera_world
    u, v = np.meshgrid((2 * np.arange(width) + 1) / width - 1, 1 - (2 * np.arange(height) + 1) / height)
    if scene.camera["type"] == "perspective":
        t = math.tan(scene.camera["perspective"]["yfov"] / 2)
        local = np.stack([u * t * width / height, v * t, -np.ones_like(u)], -1)
        return np.broadcast_to(c[:3, 3], local.shape), local @ c[:3, :3].T
    m = scene.camera["orthographic"]["ymag"]
    local = np.stack([u * m * width / height, v * m, np.zeros_like(u)], -1)
    return local @ c[:3, :3].T + c[:3, 3], np.broadcast_to(-c[:3, 2], local.shape)


def trace(scene, origins, directions, cull=True):
    """Nearest hit by Moeller and Trumbore's test of every triangle: distance, position, shading normal (eye's side)."""
    shape = directions.shape[:2]
    nearest = np.full(shape, np.inf)
    normals = np.zeros(directions.shape)
    for mesh in scene.meshes:
        cofactor = np.linalg.inv(mesh.world[:3, :3]).T
        sign = np.sign(np.linalg.det(mesh.world[:3, :3]))
        for a, b, c in mesh.triangles:
            p = mesh.world_positions
            e1, e2 = p[b] - p[a], p[c] - p[a]
            h = np.cross(directions, e2)
            with np.errstate(divide="ignore", invalid="ignore"):
                f = 1 / (h @ e1)
                s = origins - p[a]
                u = f * (s * h).sum(-1)
                q = np.cross(s, e1)
                v = f * (directions * q).sum(-1)
                t = f * (q @ e2)
            geometric = sign * np.cross(e1, e2)
            hit = (u >= 0) & (v >= 0) & (u + v <= 1) & (t > 1e-9) & (t < nearest)
            if cull and not mesh.material.double_sided:
                hit &= directions @ geometric < 0
            if mesh.normals is None:
                n = np.broadcast_to(geometric, directions.shape)
            else:
                n = ((1 - u - v)[..., None] * mesh.normals[a] + u[..., None] * mesh.normals[b] + v[..., None] * mesh.normals[c]) @ cofactor.T
            n = n / np.linalg.norm(n, axis=-1, keepdims=True)
            n = np.where((directions @ geometric > 0)[..., None], -n, n)
            nearest = np.where(hit, t, nearest)
            normals = np.where(hit[..., None], n, normals)
    hit = np.isfinite(nearest)
    positions = np.where(hit[..., None], origins + np.where(hit, nearest, 0)[..., None] * directions, 0)
    return hit, positions, normals


def tangle(folder, orthographic=False):
    """Turned, sheared by non-uniform scales, mirrored; single- and double-sided; smooth and flat."""
    random = np.random.default_rng(7)
    b = Builder()
    for number in range(24):
        corners = random.uniform(-1, 1, (3, 3))
        normals = np.cross(corners[1] - corners[0], corners[2] - corners[0]) + random.normal(0, 0.2, (3, 3))
        normals /= np.linalg.norm(normals, axis=1, keepdims=True)
        quaternion = random.normal(size=4)
        scale = random.uniform(0.5, 2, 3) * ((-1, 1, 1) if number % 3 == 0 else 1)
        b.mesh(corners, [(0, 1, 2)], dict(lambert(), doubleSided=bool(number % 2)), normals if number % 4 < 2 else None,
               rotation=list(quaternion / np.linalg.norm(quaternion)), translation=list(random.uniform(-1, 1, 3)),
               scale=list(scale))
    quaternion = np.array([0.1, 0.35, -0.05, 1.0])
    pose = {"rotation": list(quaternion / np.linalg.norm(quaternion)), "translation": [4, -1, 5]}
    b.orthographic(2.5, **pose) if orthographic else b.perspective(0.7, **pose)
    return b.scene(folder)
