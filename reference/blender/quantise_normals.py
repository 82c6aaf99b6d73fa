#!/usr/bin/python3
"""Give a .glb the vertex normals that Blender will use, so that every witness sees the same ones.

    reference/blender/quantise_normals.py IN.glb OUT.glb

Blender keeps custom normals in 16 bits (an error of up to 6.5e-3). This runs IN through the real Blender with the same
importer as render_in_blender.py, reads the normals back, and writes them into the NORMAL accessors; all other bytes
stay. It repeats until nothing changes any more, and prints the largest change. A vertex whose triangles end up with
different normals, or one that several primitives share with different results, is an error: exit code 2, one line.
IN and OUT may be the same file. Needs Blender 3.4 (ASSAY_BLENDER names another program).
"""

import os
import shutil
import subprocess
import sys
import tempfile

sys.dont_write_bytecode = True
sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))

import numpy as np  # noqa: E402

from gltf import Gltf, GltfError, write_glb  # noqa: E402

ROUNDS = 6
SPLIT = 1e-3  # normals of one vertex's corners further apart than this are two normals


def read_back(path, out):
    """Inside Blender: saves, per primitive with normals, its glTF vertices, their normals and how far corners differ."""
    import bpy
    import geometry
    gltf = Gltf(path)
    bpy.ops.wm.read_factory_settings(use_empty=True)
    arrays = {}
    for key, mesh in geometry.import_primitives(gltf).items():
        if "NORMAL" in gltf.list("meshes")[key[0]]["primitives"][key[1]]["attributes"]:
            normals = geometry.loop_normals(mesh)
            arrays[f"{key[0]}.{key[1]}.vertices"] = geometry.used_indices(gltf, key)
            arrays[f"{key[0]}.{key[1]}.normals"] = normals
            arrays[f"{key[0]}.{key[1]}.spread"] = geometry.corner_spread(mesh)
    np.savez(out, **arrays)


def blender_normals(path):
    blender = shutil.which(os.environ.get("ASSAY_BLENDER", "blender"))
    if blender is None:
        raise GltfError("no blender found: install Blender 3.4 (apt-get install blender python3-numpy)")
    with tempfile.TemporaryDirectory() as folder:
        out = os.path.join(folder, "normals.npz")
        run = subprocess.run([blender, "-b", "--factory-startup", "--python-exit-code", "1", "-P", os.path.abspath(__file__),
                              "--", os.path.abspath(path), out], capture_output=True, text=True, errors="replace")
        if not os.path.exists(out):
            lines = [line for line in (run.stdout + run.stderr).splitlines() if "Error" in line]
            raise GltfError(f"{path}: Blender failed: {lines[-1] if lines else run.returncode}")
        with np.load(out) as arrays:
            return dict(arrays)


def patch(path, arrays):
    """The scene's JSON, its BIN chunk with the new normals, and the largest change."""
    gltf = Gltf(path)
    if gltf.bin_chunk is None:
        raise GltfError(f"{path}: wanted a .glb with its own BIN chunk, found none")
    binary, written, largest = bytearray(gltf.bin_chunk), {}, 0.0
    for name in (n[:-9] for n in arrays if n.endswith(".vertices")):
        mesh, primitive = map(int, name.split("."))
        place = f"{path}: meshes[{mesh}].primitives[{primitive}]"
        index = gltf.list("meshes")[mesh]["primitives"][primitive]["attributes"]["NORMAL"]
        accessor = gltf.list("accessors")[index]
        view = gltf.list("bufferViews")[accessor.get("bufferView", 0)]
        if accessor["componentType"] != 5126 or "sparse" in accessor or "uri" in gltf.list("buffers")[view["buffer"]]:
            raise GltfError(f"{place}.NORMAL: wanted plain floats in the file's own buffer, found something else")
        vertices, normals = arrays[name + ".vertices"], arrays[name + ".normals"]
        if arrays[name + ".spread"].max(initial=0) > SPLIT:
            worst = int(vertices[arrays[name + ".spread"].argmax()])
            raise GltfError(f"{place}: wanted one normal per vertex, found that Blender splits vertex {worst}: give its "
                            "triangles vertices of their own")
        start = view.get("byteOffset", 0) + accessor.get("byteOffset", 0)
        table = np.ndarray((accessor["count"], 3), "<f4", binary, start, (view.get("byteStride", 12), 4))
        for vertex, normal in zip(vertices, normals):
            if np.isnan(normal[0]):
                continue
            if not np.array_equal(written.setdefault((index, int(vertex)), normal), normal):
                raise GltfError(f"{place}: wanted one normal for vertex {vertex}, found another for another primitive")
            largest = max(largest, float(np.abs(table[vertex] - normal).max()))
            table[vertex] = normal
        if "min" in accessor:
            accessor["min"], accessor["max"] = table.min(axis=0).tolist(), table.max(axis=0).tolist()
    return gltf.json, binary, largest


def main(arguments):
    if len(arguments) != 2 or arguments[0].startswith("-"):
        print(__doc__.strip())
        return 0 if arguments in (["-h"], ["--help"]) else 2
    source, target = arguments
    changes = []
    try:
        with tempfile.TemporaryDirectory() as folder:
            current = source
            for count in range(ROUNDS):
                document, binary, largest = patch(current, blender_normals(current))
                changes.append(largest)
                if largest == 0:
                    break
                current = os.path.join(folder, f"{count}.glb")
                write_glb(current, document, binary)
            if current != target:
                shutil.copyfile(current, target)
    except GltfError as error:
        print(f"quantise_normals.py: {error}", file=sys.stderr)
        return 2
    print(f"{target}: largest change of a normal {changes[0]:.2g}" +
          ("" if changes[-1] == 0 else f"; still {changes[-1]:.2g} in round {ROUNDS}"))
    return 0


if __name__ == "__main__":
    if "bpy" in sys.modules:
        read_back(*sys.argv[sys.argv.index("--") + 1:])
    else:
        sys.exit(main(sys.argv[1:]))
