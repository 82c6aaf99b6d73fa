"""Runs inside Blender for worker.py. Geometry, materials, lights and camera are the witness's (reference/blender); what
costs Cycles time and gives no accuracy that matters here is left out: no subdivided lights, no rebuilt texture
coordinates, no guard at the poles of the environment; Russian roulette and light threshold as Cycles has them by default.
"""

import json
import os
import resource
import sys
import tempfile
import time
import traceback

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__)))))
sys.path.insert(0, os.path.join(ROOT, "reference", "blender"))

import bpy  # noqa: E402

import geometry  # noqa: E402
import shading  # noqa: E402
from gltf import Gltf  # noqa: E402


def witness_script():
    """render_in_blender.py; it runs its jobs when imported: here, none."""
    with tempfile.NamedTemporaryFile("w", suffix=".json") as file:
        json.dump({"threads": 1, "jobs": []}, file)
        file.flush()
        arguments, sys.argv = sys.argv, ["", "--", file.name]
        import render_in_blender
        sys.argv = arguments
    return render_in_blender


class PlainShading(shading.Shading):
    """An image texture straight from the UV map where the witness's detour would give the same picture."""

    def texture(self, nodes, texture, is_color):
        if texture["matrix"] != ((1, 0, 0), (0, 1, 0)) or any(wrap != "repeat" for wrap in texture["wrap"]) or texture["nearest"]:
            return super().texture(nodes, texture, is_color)
        name = "UVMap" if texture["texcoord"] == 0 else f"UVMap.{texture['texcoord']:03d}"
        uv = nodes.add("ShaderNodeUVMap", uv_map=name).outputs[0]
        return nodes.add("ShaderNodeTexImage", {0: uv}, image=self.image(texture["image"], is_color)).outputs


def plain_environment(nodes, environment):
    image = bpy.data.images.load(environment["file"])
    image.colorspace_settings.name = "Non-Color"  # texels are linear Rec.709 already
    inputs = {}
    if environment["rotation"]:
        direction = nodes.add("ShaderNodeTexCoord").outputs["Generated"]
        inputs[0] = nodes.add("ShaderNodeVectorRotate", {"Vector": direction, "Angle": -environment["rotation"]},
                              rotation_type="Z_AXIS").outputs[0]
    return nodes.add("ShaderNodeTexEnvironment", inputs, image=image).outputs[0]


witness = witness_script()
shading.Shading, shading._environment_map = PlainShading, plain_environment


def build(job):
    gltf = Gltf(job["scene"])
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    meshes = geometry.import_primitives(gltf)
    witness.assign_materials(gltf, meshes, depth=1)
    geometry.add_instances(gltf, meshes)
    witness.add_camera(scene, gltf, 0)
    for light in gltf.lights():
        witness.add_light(scene, light)
    shading.build_world(gltf, hide_environment=False)
    witness.make_exact(scene, job)  # once: setting the engine again would throw Cycles' scene and BVH away
    return scene


def render(scene, job):
    """The witness's exact settings (bounces, clamps, filter, no denoiser), Cycles' own defaults where they only cost noise."""
    cycles = scene.cycles
    cycles.samples = job["spp"]
    cycles.sample_offset = job["spp"] if job["spp"] > 1 else 0  # sample 0 of every pixel is at its centre
    cycles.min_light_bounces, cycles.min_transparent_bounces, cycles.light_sampling_threshold = 0, 0, 0.01
    cycles.use_adaptive_sampling = job["adaptive"]
    cycles.adaptive_threshold, cycles.adaptive_min_samples = 0.01, 0
    cycles.seed = job["seed"] % 2 ** 31
    scene.render.threads_mode, scene.render.threads = "FIXED", job["threads"]
    scene.render.resolution_x, scene.render.resolution_y = job["width"], job["height"]
    # Without this, persistent data would also keep the number of samples.
    scene.frame_set(scene.frame_current)
    scene.render.filepath = job["out"]
    bpy.ops.render.render(write_still=True)


def main():
    scene = key = None
    for line in sys.stdin:
        job = json.loads(line)
        answer = {"out": job["out"], "ok": True, "error": "", "version": "Blender " + bpy.app.version_string}
        start = time.perf_counter()
        try:
            if key != job["scene"]:
                key, scene = None, build(dict(job))
                key = job["scene"]
            answer["load_seconds"] = time.perf_counter() - start
            render(scene, job)
        except Exception as error:  # Blender would print it and go on
            traceback.print_exc()
            answer.update(ok=False, error=f"{job['scene']}: {type(error).__name__}: {error}")
        answer["rss_mb"] = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
        print("speed: " + json.dumps(answer), flush=True)


main()
