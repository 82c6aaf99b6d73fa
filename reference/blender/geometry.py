"""Bring glTF meshes into Blender through its own importer, geometry only (runs inside Blender).

The importer gets a stripped copy of the file: one mesh per glTF primitive, no materials, lights, cameras or node
tree. So nothing but positions, indices, normals and texture coordinates can be misread by it, every primitive can be
found again by name, and instances get the exact matrices of the file (the importer splits them into location,
rotation and scale and loses shear). Tangents and vertex colours, which it ignores or rounds to 8 bits, are added as
float attributes. y-up becomes z-up: (x, y, z) -> (x, -z, y).
"""

import os
import tempfile

import bmesh
import bpy
import numpy as np
from mathutils import Matrix

from gltf import GltfError, write_glb

Z_UP = np.array([[1, 0, 0, 0], [0, 0, -1, 0], [0, 1, 0, 0], [0, 0, 0, 1]], float)
TANGENT, TANGENT_SIGN, COLOR = "assay_tangent", "assay_tangent_sign", "assay_color"
KEPT = ("POSITION", "NORMAL", "TEXCOORD_0", "TEXCOORD_1")
TRIANGLE_MODES = (4, 5, 6)
LIGHT_TRIANGLES = 1024  # of one emissive primitive, about


def to_blender(world):
    """World matrix of a node whose local axes stay (cameras, lights)."""
    return Matrix((Z_UP @ world).tolist())


def to_blender_mesh(world):
    """World matrix of a mesh, whose vertices are turned to z-up themselves."""
    return Matrix((Z_UP @ world @ Z_UP.T).tolist())


def import_primitives(gltf):
    """{(mesh, primitive): bpy mesh}, triangles only; vertex k is the k-th smallest glTF index the primitive uses."""
    keys = [(m, p) for m, mesh in enumerate(gltf.list("meshes")) for p, primitive in enumerate(mesh["primitives"])
            if primitive.get("mode", 4) in TRIANGLE_MODES and "POSITION" in primitive["attributes"]]
    if not keys:
        return {}
    with tempfile.TemporaryDirectory() as folder:
        stripped = os.path.join(folder, "geometry.glb")
        _write_stripped(gltf, keys, stripped)
        if "bool" not in vars(np):
            np.bool = bool  # the importer of Blender 3.4 spells it so; numpy has dropped the name
        result = bpy.ops.import_scene.gltf(filepath=stripped, merge_vertices=False, import_shading="NORMALS")
        if result != {"FINISHED"}:
            raise GltfError(f"{gltf.path}: Blender's glTF importer: wanted FINISHED, found {result}")
    found = {}
    for key in keys:
        imported = bpy.data.objects[_name(key)]
        found[key] = imported.data
        bpy.data.objects.remove(imported)
        _check_faces(gltf, key, found[key])
        _add_attributes(gltf, key, found[key])
    return found


def used_indices(gltf, key):
    """The glTF vertex of each Blender vertex: what the importer's np.unique keeps."""
    primitive = gltf.list("meshes")[key[0]]["primitives"][key[1]]
    if "indices" in primitive:
        return np.unique(gltf.accessor(primitive["indices"]))
    return np.arange(gltf.list("accessors")[primitive["attributes"]["POSITION"]]["count"])


def subdivide_lights(gltf, meshes):
    """Cut flat emissive triangles into small ones; the surface stays the same.

    Cycles 3.4 samples a light triangle by its solid angle where an edge is longer than the distance to its plane, with
    an approximate arc cosine whose error is of the order of 1e-4 sr: points that see a light at a grazing angle come
    out up to 5 % too dark (measured against closed forms and against Cycles without light sampling). Small triangles
    are sampled by area, which is exact; with 256 pieces per triangle the bias falls below what can be measured."""
    for (m, p), mesh in meshes.items():
        index = gltf.list("meshes")[m]["primitives"][p].get("material")
        emissive = index is not None and any(gltf.list("materials")[index].get("emissiveFactor", [0]))
        cuts = min(15, int((LIGHT_TRIANGLES / max(1, len(mesh.polygons))) ** .5) - 1)
        if not emissive or cuts < 1 or any(polygon.use_smooth for polygon in mesh.polygons):
            continue
        work = bmesh.new()
        work.from_mesh(mesh)
        bmesh.ops.subdivide_edges(work, edges=work.edges[:], cuts=cuts, use_grid_fill=True)
        bmesh.ops.triangulate(work, faces=work.faces[:])
        work.to_mesh(mesh)
        work.free()


def add_instances(gltf, meshes):
    """One object per node and primitive, with the node's exact matrix (an object's own matrix cannot shear)."""
    collection = bpy.context.scene.collection
    origin = bpy.data.objects.new("origin", None)
    collection.objects.link(origin)
    for node, world in gltf.nodes():
        if "mesh" not in node:
            continue
        for p in range(len(gltf.list("meshes")[node["mesh"]]["primitives"])):
            mesh = meshes.get((node["mesh"], p))
            if mesh is None:
                continue
            instance = bpy.data.objects.new(node.get("name", mesh.name), mesh)
            collection.objects.link(instance)
            instance.parent = origin
            instance.matrix_parent_inverse = to_blender_mesh(world)
            instance.cycles.shadow_terminator_offset = 0
            instance.cycles.shadow_terminator_geometry_offset = 0


def _corner_normals(mesh):
    """(vertex, normal) per face corner, in the order of the faces and in glTF's axes."""
    mesh.calc_normals_split()
    normals = np.empty(len(mesh.loops) * 3, np.float32)
    vertices = np.empty(len(mesh.loops), np.int32)
    mesh.loops.foreach_get("normal", normals)
    mesh.loops.foreach_get("vertex_index", vertices)
    return vertices, normals.reshape(-1, 3)[:, [0, 2, 1]] * np.array([1, 1, -1], np.float32)


def loop_normals(mesh):
    """The normals Cycles will use, one per vertex and NaN where a vertex has none: Blender keeps custom normals per face
    corner in 16 bits, and of a vertex's corners Cycles takes the last."""
    vertices, normals = _corner_normals(mesh)
    result = np.full((len(mesh.vertices), 3), np.nan, np.float32)
    for vertex, normal in zip(vertices, normals):
        result[vertex] = normal
    return result


def corner_spread(mesh):
    """How far each vertex's corners differ from the normal Cycles takes."""
    vertices, normals = _corner_normals(mesh)
    spread = np.zeros(len(mesh.vertices), np.float32)
    np.maximum.at(spread, vertices, np.abs(normals - loop_normals(mesh)[vertices]).max(axis=1))
    return spread


def _name(key):
    return f"mesh{key[0]}.primitive{key[1]}"


def _write_stripped(gltf, keys, path):
    binary, offsets = b"", []
    for index in range(len(gltf.list("buffers"))):
        offsets.append(len(binary))
        binary += gltf.buffer(index) + b"\0" * (-len(gltf.buffer(index)) % 4)
    views = [dict(view, buffer=0, byteOffset=view.get("byteOffset", 0) + offsets[view["buffer"]])
             for view in gltf.list("bufferViews")]
    meshes = []
    for key in keys:
        primitive = gltf.list("meshes")[key[0]]["primitives"][key[1]]
        kept = {"attributes": {k: v for k, v in primitive["attributes"].items() if k in KEPT},
                "mode": primitive.get("mode", 4)}
        if "indices" in primitive:
            kept["indices"] = primitive["indices"]
        meshes.append({"name": _name(key), "primitives": [kept]})
    document = {
        "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": list(range(len(keys)))}],
        "nodes": [{"mesh": index, "name": _name(key)} for index, key in enumerate(keys)],
        "meshes": meshes, "accessors": gltf.list("accessors"), "bufferViews": views,
        "buffers": [{"byteLength": len(binary)}],
    }
    write_glb(path, document, binary)


def _triangles(gltf, key):
    primitive = gltf.list("meshes")[key[0]]["primitives"][key[1]]
    if "indices" in primitive:
        indices = gltf.accessor(primitive["indices"])[:, 0].astype(np.int64)
    else:
        indices = np.arange(gltf.list("accessors")[primitive["attributes"]["POSITION"]]["count"])
    mode = primitive.get("mode", 4)
    if mode == 4:
        return indices[:len(indices) // 3 * 3].reshape(-1, 3)
    first = indices[:-2] if mode == 5 else np.full(len(indices) - 2, indices[0])
    return np.stack([first, indices[1:-1], indices[2:]], axis=1)


def _check_faces(gltf, key, mesh):
    """Blender drops a triangle that uses the vertices of another one (a sheet modelled from both sides)."""
    triangles = np.sort(_triangles(gltf, key), axis=1)
    proper = triangles[(triangles[:, 0] != triangles[:, 1]) & (triangles[:, 1] != triangles[:, 2])]
    if len(mesh.polygons) != len(proper):
        raise GltfError(f"{gltf.path}: meshes[{key[0]}].primitives[{key[1]}]: wanted {len(proper)} triangles in Blender,"
                        f" found {len(mesh.polygons)}: triangles that share all three vertices cannot be imported")


def _add_attributes(gltf, key, mesh):
    attributes = gltf.list("meshes")[key[0]]["primitives"][key[1]]["attributes"]
    used = used_indices(gltf, key)
    if "TANGENT" in attributes:
        tangents = gltf.accessor(attributes["TANGENT"])[used].astype(np.float32)
        z_up = np.stack([tangents[:, 0], -tangents[:, 2], tangents[:, 1]], axis=1)
        mesh.attributes.new(TANGENT, "FLOAT_VECTOR", "POINT").data.foreach_set("vector", z_up.ravel())
        mesh.attributes.new(TANGENT_SIGN, "FLOAT", "POINT").data.foreach_set("value", tangents[:, 3].copy())
    if "COLOR_0" in attributes:
        colors = gltf.accessor(attributes["COLOR_0"])[used].astype(np.float32)
        rgba = np.ones((len(colors), 4), np.float32)
        rgba[:, :colors.shape[1]] = colors
        mesh.attributes.new(COLOR, "FLOAT_COLOR", "POINT").data.foreach_set("color", rgba.ravel())
