"""Render jobs with Cycles, every approximation of which is switched off. Runs inside Blender:

    blender -b --factory-startup -P render_in_blender.py -- jobs.json

jobs.json: {"threads": N, "jobs": [{"name", "scene", "width", "height", "camera", "depth", "spp", "seeds": [..],
"hide_environment", "punctual_units", "out"}]}. Seed s of a job is written to OUT.s.exr (float, linear).
Each finished or failed job prints one line `witness: {json}`, which witness.py reads. The principled BSDF stands
against the renderer's shader `principled`; see docs/formats.md for the scene's contract.
"""

import json
import math
import os
import sys
import time
import traceback

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))

import bpy  # noqa: E402
from mathutils import Vector  # noqa: E402

import geometry  # noqa: E402
import materials  # noqa: E402
import shading  # noqa: E402
from gltf import Gltf, GltfError  # noqa: E402


def make_exact(scene, job):
    """Cycles without approximations. `depth` counts scattering events; Cycles counts the bounces between them."""
    scene.render.engine = "CYCLES"
    cycles = scene.cycles
    bounces = max(job["depth"] - 1, 0)
    settings = {
        "device": "CPU", "samples": job["spp"], "use_adaptive_sampling": False, "use_denoising": False,
        "time_limit": 0, "max_bounces": bounces, "diffuse_bounces": bounces, "glossy_bounces": bounces,
        "transmission_bounces": bounces, "volume_bounces": 0, "transparent_max_bounces": 64,
        # No Russian roulette before these, so none at all.
        "min_light_bounces": 1024, "min_transparent_bounces": 1024,
        "sample_clamp_direct": 0, "sample_clamp_indirect": 0, "light_sampling_threshold": 0, "blur_glossy": 0,
        "caustics_reflective": True, "caustics_refractive": True, "use_fast_gi": False,
        "pixel_filter_type": "BOX", "film_exposure": 1, "use_auto_tile": False,
    }
    # Cycles takes sample number 0 of every pixel at its centre, whatever the seed: a bias of one part in `spp` wherever
    # a pixel is not uniform. So start later, by a whole pattern; but a single sample (tests) is wanted at the centre.
    settings["sample_offset"] = job["spp"] if job["spp"] > 1 else 0
    for name, value in settings.items():
        setattr(cycles, name, value)
    if hasattr(cycles, "use_guiding"):
        cycles.use_guiding = False
    render = scene.render
    render.resolution_x, render.resolution_y, render.resolution_percentage = job["width"], job["height"], 100
    render.pixel_aspect_x = render.pixel_aspect_y = 1
    render.film_transparent = False
    render.use_compositing = render.use_sequencer = False
    render.use_persistent_data = True  # seeds of one job share the scene
    render.image_settings.file_format = "OPEN_EXR"
    render.image_settings.color_mode = "RGB"
    render.image_settings.color_depth = "32"
    render.image_settings.exr_codec = "ZIP"


def add_camera(scene, gltf, index):
    cameras = gltf.cameras()
    if not 0 <= index < len(cameras):
        raise GltfError(f"{gltf.path}: camera: wanted an index below {len(cameras)}, found {index}")
    description, world = cameras[index]
    data = bpy.data.cameras.new("camera")
    data.sensor_fit = "VERTICAL"
    data.clip_start, data.clip_end = 1e-4, 1e6
    if description["type"] == "perspective":
        data.lens = 50
        data.sensor_height = 2 * data.lens * math.tan(description["perspective"]["yfov"] / 2)
    else:
        data.type = "ORTHO"
        data.ortho_scale = 2 * description["orthographic"]["ymag"]
    camera = bpy.data.objects.new("camera", data)
    scene.collection.objects.link(camera)
    camera.matrix_world = geometry.to_blender(world)
    scene.camera = camera


def add_light(scene, light):
    """Delta lamps. Blender's spot multiplies by an extra cosine and a smoothstep, so glTF's spot is a point lamp whose
    shader computes the falloff from the direction in which it is seen."""
    sun = light["kind"] == "directional"
    data = bpy.data.lights.new(light["kind"], "SUN" if sun else "POINT")
    brightest = max(light["intensity"])
    if brightest <= 0:
        return
    data.color = [c / brightest for c in light["intensity"]]
    data.energy = brightest * (1 if sun else 4 * math.pi)
    if sun:
        data.angle = 0
    else:
        data.shadow_soft_size = 0
    data.cycles.max_bounces = 1024
    lamp = bpy.data.objects.new(light["kind"], data)
    scene.collection.objects.link(lamp)
    lamp.matrix_world = geometry.to_blender(light["matrix"])
    if light["kind"] == "spot":
        add_spot_falloff(data, -Vector(lamp.matrix_world.col[2][:3]), light["cos_inner"], light["cos_outer"])


def add_spot_falloff(data, axis, cos_inner, cos_outer):
    """KHR_lights_punctual: saturate((cos - cos outer) / max(.001, cos inner - cos outer)) squared."""
    data.use_nodes = True
    nodes = shading.Nodes(data.node_tree)
    towards_surface = nodes.add("ShaderNodeNewGeometry").outputs["Incoming"]
    cosine = nodes.vector("DOT_PRODUCT", towards_surface, axis)
    scale = 1 / max(.001, cos_inner - cos_outer)
    falloff = nodes.math("MULTIPLY_ADD", cosine, scale, -cos_outer * scale)
    falloff = nodes.math("MINIMUM", nodes.math("MAXIMUM", falloff, 0.0), 1.0)
    emission = nodes.add("ShaderNodeEmission", {"Color": (1, 1, 1), "Strength": nodes.math("MULTIPLY", falloff, falloff)})
    nodes.add("ShaderNodeOutputLight", {"Surface": emission.outputs[0]})


def demand_light(gltf):
    """The renderer lights a scene without any light by a sky of its own; such a picture is nobody's truth."""
    emissive = any(any(material.get("emissiveFactor", [0])) for material in gltf.list("materials"))
    if not emissive and gltf.environment() is None and not gltf.lights():
        raise GltfError(f"{gltf.path}: wanted a light, an emissive material or an environment, found none")


def assign_materials(gltf, meshes, depth):
    maker, made = shading.Shading(gltf, emission_only=depth == 0), {}
    for (m, p), mesh in meshes.items():
        primitive = gltf.list("meshes")[m]["primitives"][p]
        key = (primitive.get("material"), *sorted(primitive["attributes"]))
        if key not in made:
            made[key] = maker.material(materials.read_material(gltf, key[0]), primitive["attributes"])
        mesh.materials.clear()
        mesh.materials.append(made[key])


def build(job):
    gltf = Gltf(job["scene"])
    demand_light(gltf)
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    meshes = geometry.import_primitives(gltf)
    geometry.subdivide_lights(gltf, meshes)
    assign_materials(gltf, meshes, job["depth"])
    geometry.add_instances(gltf, meshes)
    add_camera(scene, gltf, job["camera"])
    if job["depth"] > 0:
        for light in gltf.lights(job["punctual_units"]):
            add_light(scene, light)
    shading.build_world(gltf, job["hide_environment"])
    make_exact(scene, job)
    return scene


def render(job, threads):
    scene = build(job)
    scene.render.threads_mode = "FIXED"
    scene.render.threads = threads
    for seed in job["seeds"]:
        scene.cycles.seed = seed
        scene.render.filepath = f"{job['out']}.{seed}.exr"
        bpy.ops.render.render(write_still=True)


def main():
    with open(sys.argv[sys.argv.index("--") + 1]) as file:
        jobs = json.load(file)
    for job in jobs["jobs"]:
        start, report = time.time(), {"name": job["name"], "version": bpy.app.version_string.split()[0]}
        try:
            render(job, jobs["threads"])
        except GltfError as error:
            report["error"] = str(error)
        except Exception as error:  # Blender would print it and go on with exit code 0
            traceback.print_exc()
            report["error"] = f"{job['scene']}: {type(error).__name__}: {error}"
        report["seconds"] = time.time() - start
        print("witness: " + json.dumps(report), flush=True)


main()
