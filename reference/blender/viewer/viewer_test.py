#!/usr/bin/python3
"""A scene edited and saved in assay-view's window, in the real Blender.

usage: viewer_test.py ASSAY_VIEW ASSAY_RENDER OUT_FOLDER
The same numbers are typed into the window (material, Disney's extras, emission, a lamp, a spot's cone) and written into the
JSON of the original file here, by hand. Blender renders both files with the same seeds: the pictures must be the same. And
assay-render's picture of the saved file must agree with Blender's. Without Xvfb, xdotool or Blender: skipped (77).
"""
import math
import os
import subprocess
import sys

sys.dont_write_bytecode = True
HERE = os.path.dirname(os.path.abspath(__file__))
ROOT = os.path.dirname(os.path.dirname(os.path.dirname(HERE)))
sys.path[:0] = [os.path.dirname(HERE), os.path.join(ROOT, "renderer", "view", "gui")]

import numpy as np  # noqa: E402

import suite  # noqa: E402
import witness  # noqa: E402
from gltf import Gltf, write_glb  # noqa: E402
from hand import Display, Viewer, skip  # noqa: E402

SCENE = os.path.join(ROOT, "regression", "scenes", "punctual.glb")
WIDTH, HEIGHT, DEPTH, SEEDS, SPP = 96, 72, 3, (1, 2, 3, 4, 5, 6), 96
BASE, EMISSION = (.75, .5, .25), (.5, .25, .125)
FACTORS = {"metallic": .25, "roughness": .55}
EXTRAS = {"specular": .8, "specular tint": .4, "sheen": .6, "sheen tint": .3, "clearcoat": .5, "clearcoat roughness": .45}
LAMP, SPOT, INNER, OUTER = 2.5, 40, 12, 34  # W/sr, W/sr, degrees
RED, GREEN, BLUE = 25, 90, 155  # the fields of a colour, in pixels from its left


def edit_in_the_window(view, folder, saved):
    display = Display(folder)
    try:
        v = Viewer(display, view, SCENE, "--width", str(WIDTH), "--height", str(HEIGHT), "--spp", "8")
        v.shown()
        for place, edits in (((.25, .4), BASE), ((.6, .6), EMISSION)):  # the ball, the box
            x, y = v.in_picture(*place)
            display.do("mousemove", int(x), int(y), "sleep", ".4", "click", 1, "sleep", ".4")
            for offset, value in zip((RED, GREEN, BLUE), edits):
                v.type("base colour" if edits is BASE else "emission", value, offset)
            if edits is BASE:
                for name, value in {**FACTORS, **EXTRAS}.items():
                    v.type(name, value)
        v.click("Material")
        v.type("intensity 1", LAMP)
        v.type("intensity 2", SPOT)
        v.type("outer angle", OUTER)
        v.type("inner angle", INNER)
        display.screenshot("edited")
        v.write("scene file", saved)
        v.click("save scene")
        message = v.wait("a saved scene", lambda s: not s["saving"] and saved in s["message"])["message"]
        print(message)
        v.close()
    finally:
        display.close()


def edit_by_hand(path):
    scene = Gltf(SCENE)
    ball, box = (next(m for m in scene.list("materials") if m["name"] == name) for name in ("ball", "box"))
    ball["pbrMetallicRoughness"].update({name + "Factor": value for name, value in FACTORS.items()})
    ball["pbrMetallicRoughness"]["baseColorFactor"] = [*BASE, 1]
    ball.setdefault("extras", {}).update({"disney_" + name.replace(" ", "_"): value for name, value in EXTRAS.items()})
    box["emissiveFactor"] = list(EMISSION)
    _, lamp, spot = scene.json["extensions"]["KHR_lights_punctual"]["lights"]
    lamp["intensity"], spot["intensity"] = LAMP, SPOT
    spot["spot"] = {"innerConeAngle": math.radians(INNER), "outerConeAngle": math.radians(OUTER)}
    write_glb(path, scene.json, scene.bin_chunk)


def main():
    view, render, folder = map(os.path.abspath, sys.argv[1:4])
    command = os.environ.get("ASSAY_BLENDER", "blender")
    if witness.shutil.which(command) is None:
        skip("there is no Blender")
    os.makedirs(folder, exist_ok=True)
    saved, by_hand, picture = (os.path.join(folder, name) for name in ("saved.glb", "by-hand.glb", "saved.exr"))
    if os.path.exists(saved):
        os.remove(saved)
    edit_in_the_window(view, folder, saved)
    edit_by_hand(by_hand)

    jobs = [{"name": name, "scene": scene, "width": WIDTH, "height": HEIGHT, "camera": 0, "depth": DEPTH, "spp": SPP,
             "seeds": SEEDS, "hide_environment": False, "punctual_units": "auto", "out": os.path.join(folder, name)}
            for name, scene in (("saved", saved), ("by-hand", by_hand), ("original", SCENE))]
    pictures = {}
    for name, error, _ in witness.Blender(command, os.cpu_count()).render(jobs, folder):
        if error:
            sys.exit(error)
        pictures[name] = [suite.read_exr(os.path.join(folder, f"{name}.{seed}.exr"))[0][..., :3] for seed in SEEDS]

    # One edit lost or a little wrong is seen in the picture; the last bits of an angle in degrees are not.
    difference = lambda a, b: max(np.abs(x - y).sum() / y.sum() for x, y in zip(pictures[a], pictures[b]))
    same, edits = difference("saved", "by-hand"), difference("original", "by-hand")
    print(f"in Blender: saved and edited by hand differ by {100 * same:.2g} %, the original by {100 * edits:.2g} %")
    failures = []
    if same > 2e-6:
        failures.append("Blender's pictures of the saved scene and of the one edited by hand differ")
    if edits < .1:
        failures.append("the edits change too little to be seen")

    subprocess.run([render, saved, "-o", picture, "--shader", "principled", "--depth", str(DEPTH), "--width", str(WIDTH),
                    "--height", str(HEIGHT), "--spp", "512", "--quiet"], check=True)
    mean, variance, _ = suite.read_witness(picture)
    blender, blender_variance = suite.merge(pictures["saved"])
    z, limit = witness.worst_z(mean, variance, 8, blender, blender_variance, len(SEEDS))
    print(f"assay-render against Blender: worst z {z:.2f}, limit {limit:.2f}; means {mean.mean():.5f} {blender.mean():.5f}")
    if z > limit:
        failures.append("assay-render and Blender differ")
    if failures:
        sys.exit("FAILED: " + "; ".join(failures))


main()
