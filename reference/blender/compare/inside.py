"""Prepare and render a .blend for comparison. Runs inside Blender:

    blender -b --factory-startup -P inside.py -- job.json

job.json: {"step": "prepare", "blend", "out", "longest", "width", "height", "camera", "frame", "depth"} makes
OUT/scene.glb (what Assay renders) and OUT/prepared.blend (the same scene with the file's own materials);
{"step": "render", "out", "spp", "seeds", "depth", "threads"} renders the latter to OUT/blender.SEED.exr.
Answers are lines `compare: {json}`. The file's own scripts are never run.
"""

import json
import math
import os
import sys
import tempfile
import traceback

HERE = os.path.dirname(os.path.abspath(__file__))
sys.path[:0] = [HERE, os.path.dirname(HERE)]

import bpy  # noqa: E402
import numpy as np  # noqa: E402

if "bool" not in vars(np):
    np.bool = bool  # the exporter of Blender 3.4 spells it so; numpy has dropped the name

import carry  # noqa: E402
import flatten  # noqa: E402
import patch  # noqa: E402
import world  # noqa: E402
from gltf import Gltf  # noqa: E402
from notes import Failure, Notes  # noqa: E402


def witness_settings():
    """render_in_blender.py, whose every setting the comparison shares. It runs its jobs when imported: here, none."""
    handle, path = tempfile.mkstemp(suffix=".json")
    with os.fdopen(handle, "w") as file:
        json.dump({"threads": 1, "jobs": []}, file)
    arguments, sys.argv = sys.argv, ["", "--", path]
    import render_in_blender
    sys.argv = arguments
    os.remove(path)
    return render_in_blender


witness = witness_settings()


def say(**answer):
    print("compare: " + json.dumps(answer), flush=True)


def open_blend(path):
    try:
        bpy.ops.wm.open_mainfile(filepath=path, load_ui=False, use_scripts=False)
    except RuntimeError as error:
        raise Failure(f"{path}: wanted a .blend Blender {bpy.app.version_string} can open, "
                      f"found: {str(error).strip().splitlines()[-1]}") from None


def picture_size(scene, job):
    render = scene.render
    width, height = render.resolution_x, render.resolution_y
    if job["width"]:
        return job["width"], job["height"]
    factor = job["longest"] / max(width, height)
    return max(1, round(width * factor)), max(1, round(height * factor))


def make_plain(scene, notes):
    """The render settings that no glTF knows of."""
    render = scene.render
    for flag, name in (("use_motion_blur", "motion blur"), ("use_freestyle", "Freestyle lines"), ("film_transparent", "transparent film"),
                       ("use_multiview", "stereo")):
        if getattr(render, flag):
            notes.change(f"render: {name} off in both")
            setattr(render, flag, False)
    if render.pixel_aspect_x != render.pixel_aspect_y:
        notes.change("render: square pixels in both")
    if abs(scene.cycles.film_exposure - 1) > 1e-6:
        notes.change("render: film exposure 1 in both")
    render.use_border = render.use_crop_to_border = False
    layer = bpy.context.view_layer
    if layer.material_override:
        notes.change("view layer: no material override in both")
        layer.material_override = None
    for other in scene.view_layers:
        other.use = other == layer


def demand_light(scene, extras, path):
    shining = any(carry.emits(m) for thing in scene.collection.objects if thing.type == "MESH"
                  for m in thing.data.materials if m)
    lamps = any(thing.type == "LIGHT" for thing in scene.collection.objects)
    if not (extras or lamps or shining):
        raise Failure(f"{path}: wanted a lamp, a shining surface or a world that is not black, found none")


def export(scene, out, materials):
    """Through Blender's own exporter, with the copies of the materials that it understands."""
    own = {}
    for thing in [thing for thing in scene.collection.objects if thing.type == "MESH"]:
        mesh = thing.data
        if mesh.name in own:
            continue
        own[mesh.name] = list(mesh.materials)
        for i, material in enumerate(own[mesh.name]):
            mesh.materials[i] = materials.export(material) if material else materials.none()
    tangents = bool(materials.tangents) or any("NORMAL_MAP" == node.type for m in materials.made.values() for node in m.node_tree.nodes)
    result = bpy.ops.export_scene.gltf(
        filepath=os.path.join(out, "scene.glb"), export_format="GLB", use_active_scene=True, export_extras=True,
        export_cameras=True, export_lights=True, export_yup=True, export_tangents=tangents, export_colors=False,
        export_animations=False, export_skins=False, export_morph=False, export_apply=False)
    if result != {"FINISHED"}:
        raise Failure(f"Blender's glTF exporter: wanted FINISHED, found {result}")
    for name, mine in own.items():
        mesh = bpy.data.meshes[name]
        for i, material in enumerate(mine):
            mesh.materials[i] = material or materials.none()


def camera_of(scene, camera, width, height):
    """Position, orientation and the vertical field of view, or half the height, from Blender's own projection matrix."""
    projection = camera.calc_matrix_camera(bpy.context.evaluated_depsgraph_get(), x=width, y=height, scale_x=1, scale_y=1)
    half = 1 / projection[1][1]
    kind = {"type": "orthographic", "orthographic": {"xmag": half * width / height, "ymag": half, "znear": 1e-4, "zfar": 1e6}} \
        if camera.data.type == "ORTHO" else \
        {"type": "perspective", "perspective": {"yfov": 2 * math.atan(half), "aspectRatio": width / height, "znear": 1e-4}}
    return kind, np.array(camera.matrix_world)


def rebuild_spots(scene, path):
    """Blender's spot falls off otherwise than glTF's: these become the witness's lamps, read back from the file."""
    for thing in [thing for thing in scene.collection.objects if thing.type == "LIGHT" and thing.data.type == "SPOT"]:
        bpy.data.objects.remove(thing)
    for light in Gltf(path).lights():
        if light["kind"] == "spot":
            witness.add_light(scene, light)


def prepare(job):
    notes = Notes()
    open_blend(job["blend"])
    if tuple(bpy.data.version)[:2] > tuple(bpy.app.version)[:2]:  # the third number is the file format's
        notes.change(f"the file is from Blender {'.'.join(map(str, bpy.data.version[:2]))}; both see what {bpy.app.version_string} reads of it")
    scene = bpy.context.scene
    if job["frame"] is not None:
        scene.frame_set(job["frame"])
    width, height = picture_size(scene, job)
    make_plain(scene, notes)
    camera = flatten.flatten(scene, notes, job["camera"])
    flatten.finish_meshes(scene)
    bpy.context.view_layer.update()
    extras, seen = world.carry_over(scene, notes, job["out"], witness.make_exact)
    demand_light(scene, extras, job["blend"])
    witness.make_exact(scene, {"spp": 1, "depth": job["depth"], "width": width, "height": height})
    materials = carry.Materials(notes)
    export(scene, job["out"], materials)
    path = os.path.join(job["out"], "scene.glb")
    patch.patch(path, extras, camera_of(scene, camera, width, height), materials.names, materials.tangents, notes)
    rebuild_spots(scene, path)
    bpy.ops.wm.save_as_mainfile(filepath=os.path.join(job["out"], "prepared.blend"), check_existing=False)
    say(width=width, height=height, hide_environment=not seen, notes=notes.json())


def render(job):
    open_blend(os.path.join(job["out"], "prepared.blend"))
    scene = bpy.context.scene
    witness.make_exact(scene, dict(job, width=scene.render.resolution_x, height=scene.render.resolution_y))
    scene.render.threads_mode, scene.render.threads = "FIXED", job["threads"]
    for seed in job["seeds"]:
        scene.cycles.seed = seed
        scene.render.filepath = os.path.join(job["out"], f"blender.{seed}.exr")
        bpy.ops.render.render(write_still=True)
        say(rendered=seed)


def main():
    with open(sys.argv[sys.argv.index("--") + 1]) as file:
        job = json.load(file)
    try:
        {"prepare": prepare, "render": render}[job["step"]](job)
        say(done=True, version=bpy.app.version_string.split()[0])
    except Failure as error:
        say(error=str(error))
    except Exception as error:  # Blender would print it and exit with 0
        traceback.print_exc()
        say(error=f"{type(error).__name__}: {error}")


main()
