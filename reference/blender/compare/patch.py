"""What Blender's exporter leaves out or rounds, written into its .glb (plain Python).

The camera from Blender's own projection matrix, the environment, the materials' names, one-sided panels, and the
tangents of Blender's default anisotropy, which run round the z axis of the object's bounding box.
"""

import numpy as np

from gltf import Gltf, write_glb

TO_GLTF = np.array([[1, 0, 0, 0], [0, 0, 1, 0], [0, -1, 0, 0], [0, 0, 0, 1]], float)  # (x, y, z) -> (x, z, -y)


def patch(path, extras, camera, names, tangents, notes):
    gltf = Gltf(path)
    document, binary = gltf.json, bytearray(gltf.bin_chunk or b"")
    scene = document["scenes"][document.get("scene", 0)]
    scene["extras"] = extras
    _set_camera(document, scene, *camera)
    radial = {}
    for index, material in enumerate(document.get("materials", [])):
        exported, material["name"] = material["name"], names.get(material["name"], material["name"])
        _set_panel(material)
        if tangents.get(exported) == "radial":
            radial[index] = material["name"]
    _radial_tangents(gltf, document, binary, radial, notes)
    write_glb(path, document, binary)


def _set_camera(document, scene, kind, world):
    nodes = document["nodes"]
    for node in nodes:
        node.pop("camera", None)
    document["cameras"] = [kind]
    nodes.append({"name": "camera", "camera": 0, "matrix": (TO_GLTF @ world).T.ravel().tolist()})
    scene["nodes"].append(len(nodes) - 1)


def _set_panel(material):
    """An area lamp's mesh shines on one side (flatten._add_panel left its radiance in a custom property)."""
    radiance = (material.get("extras") or {}).pop("assay_panel", None)
    if radiance is None:
        return
    name, brightest = material["name"], max(radiance)
    material.clear()
    material.update(
        name=name, doubleSided=False, emissiveFactor=[c / brightest for c in radiance],
        pbrMetallicRoughness={"baseColorFactor": [0, 0, 0, 1], "metallicFactor": 0}, extras={"disney_specular": 0.0},
        extensions={"KHR_materials_emissive_strength": {"emissiveStrength": brightest}})


def _radial_tangents(gltf, document, binary, radial, notes):
    """t = (-(gy - 1/2), gx - 1/2, 0), g being the place in the bounding box: what Cycles takes where nothing is linked."""
    for mesh in document.get("meshes", []):
        positions = [gltf.accessor(p["attributes"]["POSITION"]) for p in mesh["primitives"]]
        low = np.min([p.min(axis=0) for p in positions], axis=0)
        high = np.max([p.max(axis=0) for p in positions], axis=0)
        centre, size = (low + high) / 2, np.maximum(high - low, 1e-6)
        for primitive, points in zip(mesh["primitives"], positions):
            name = radial.get(primitive.get("material"))
            if name is None or "NORMAL" not in primitive["attributes"]:
                continue
            place = (points - centre) / size  # glTF's x, y, z are Blender's x, z, -y
            tangents = np.zeros((len(points), 4), np.float32)
            tangents[:, 0], tangents[:, 2] = place[:, 2], -place[:, 0]
            lengths = np.linalg.norm(tangents, axis=1)
            pole = lengths < 1e-6
            if pole.any():
                notes.lose(f"material '{name}': its tangents whirl about the z axis, where they have no direction "
                           "at a vertex")
            tangents /= np.where(pole, 1, lengths)[:, None]
            tangents[pole, 0] = 1
            tangents[:, 3] = 1
            primitive["attributes"]["TANGENT"] = _append(document, binary, tangents)


def _append(document, binary, values):
    binary += b"\0" * (-len(binary) % 4)
    document["bufferViews"].append({"buffer": 0, "byteOffset": len(binary), "byteLength": values.nbytes})
    binary += values.astype("<f4").tobytes()
    document["buffers"][0]["byteLength"] = len(binary)
    document["accessors"].append({"bufferView": len(document["bufferViews"]) - 1, "componentType": 5126,
                                  "type": "VEC4", "count": len(values)})
    return len(document["accessors"]) - 1
