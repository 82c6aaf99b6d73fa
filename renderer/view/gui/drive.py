#!/usr/bin/python3
"""Drives assay-view in a virtual display, as a person would, and checks what it did.

usage: drive.py ASSAY_VIEW ASSAY_RENDER SCENE OUT_FOLDER
Screenshots go to OUT_FOLDER. Needs Xvfb and xdotool, else exits with 77 (skipped).
"""
import json
import os
import shlex
import subprocess
import sys
import time

sys.dont_write_bytecode = True
from hand import Display, Viewer  # noqa: E402

SHADERS = ("normal", "albedo", "texcoord", "position", "eyelight", "direct", "path-nomis", "path", "principled", "disney",
           "path_disney")
VIEW, RENDER, SCENE, OUT = [os.path.abspath(path) for path in sys.argv[1:5]]
failures = []


def check(holds, what):
    print("ok    " if holds else "FAILED", what, flush=True)
    if not holds:
        failures.append(what)


def mean(rows):
    data = b"".join(rows)
    return [sum(data[c::3]) / (len(data) / 3) for c in range(3)]


def same_pixels(a, b):
    """Two .exr of one program, but for dates and names in the header: the pixels stand behind it."""
    a, b = open(a, "rb").read(), open(b, "rb").read()
    half = min(len(a), len(b)) // 2
    return a[-half:] == b[-half:]


def run_textured(display):
    """Texture view, an environment from a file, a .png and a .gltf."""
    scenes = os.path.dirname(SCENE)
    v = Viewer(display, VIEW, os.path.join(scenes, "textures.glb"), "--width", "160", "--height", "120", "--spp", "16")
    v.shown()
    display.do("mousemove", *map(int, v.in_picture(.5, .6)), "sleep", ".4", "click", 1, "sleep", ".5")
    v.click("show base colour")
    check(v.wait("the texture view", lambda s: s["texture shown"] >= 0), "a texture is shown")
    display.do("sleep", ".3")
    display.screenshot("10-texture")
    v.click("Material")
    v.click("Environment", .1)
    generation = v.last()["state"]["generation"]
    v.write("environment file", os.path.join(scenes, "sky.hdr"))
    v.click("load map")
    check(v.shown(generation + 1)["sky"] == "sky.hdr", "an environment is loaded")
    v.write("image file", "textured.png")
    v.click("save image")
    v.wait("a saved image", lambda s: not s["saving"] and s["message"].startswith("textured.png: "))
    with open(os.path.join(OUT, "textured.png"), "rb") as file:
        check(file.read(8) == b"\x89PNG\r\n\x1a\n", "a .png was saved")
    v.write("scene file", "textured.gltf")
    v.click("save scene")
    v.wait("a saved scene", lambda s: not s["saving"] and s["message"].startswith("textured.gltf: "))
    with open(os.path.join(OUT, "textured.gltf")) as file:
        extras = json.load(file)["scenes"][0]["extras"]
    check(extras["environment"] == "textured.environment.exr", "a .gltf was saved with its environment")
    display.screenshot("11-environment")
    v.close()


def run(display):
    reference = os.path.join(OUT, "reference.exr")
    subprocess.run([RENDER, SCENE, "-o", reference, "--width", "300", "--height", "128", "--spp", "8", "--quiet",
                    "--shader", "path"], check=True)
    v = Viewer(display, VIEW, SCENE, "--width", "300", "--height", "128", "--spp", "64", "--reference", reference)
    v.shown()
    first = v.picture("1-start")
    check(max(mean(first)) > 40, "the picture is on the screen")

    # The wipe: the reference is to the right of a line that is dragged.
    x, y, width, height = v.item("line of the wipe")
    v.drag((x + width / 2, y + height / 2), v.in_picture(.2, .5))
    check(abs(v.last()["state"]["wipe_at"] - .2) < .02, "the line of the wipe was dragged")
    check(v.last()["state"]["generation"] == 1, "which is no edit")
    wiped = v.picture("2-wipe")
    check(wiped != first, "and shows more of the reference")

    # Mouse: turn, nearer, shift, each a new picture that is another one.
    for button, name, end in ((1, "turn", (.7, .55)), (3, "nearer", (.5, .3)), (2, "shift", (.6, .6))):
        before, old = v.last()["state"], v.picture("before")
        v.drag(v.in_picture(.5, .5), v.in_picture(*end), button)
        now = v.wait(f"the edit by {name}", lambda s: s["generation"] > before["generation"])
        now = v.shown(now["generation"])
        check(now["camera"] == "view", f"{name}: the camera is a free one")
        check(v.picture(f"3-{name}") != old, f"{name}: another picture")

    # The camera menu gets back to the file's camera.
    generation = v.last()["state"]["generation"]
    v.click("tab Picture")
    v.click("camera")
    v.click(v.named("camera: 0"), .1)
    check(v.shown(generation + 1)["camera"] == "0", "the camera menu switches back")

    # A click picks the material; its slider changes the picture.
    for place in ((.18, .5), (.5, .45)):
        before = v.last()["state"]["material"]
        x, y = v.in_picture(*place)
        display.do("mousemove", int(x), int(y), "sleep", ".3", "mousedown", 1, "sleep", ".15", "mouseup", 1)
        v.wait("another material", lambda s: s["material"] != before)
        check(True, "a click on another shape picks another material")
    display.do("mousemove", int(x), int(y))
    time.sleep(.6)
    display.screenshot("4-inspector")
    check(v.last()["state"]["hover"][0] >= 0, "the pixel under the mouse is known")
    before = v.last()["state"]
    v.click("tab Scene")
    x, y, width, height = v.item("metallic")
    old = v.picture("before")
    v.drag((x + 6, y + height / 2), (x + width * .6, y + height / 2))
    v.shown(before["generation"] + 1)
    check(v.picture("5-metallic") != old, "the slider of metallic changes the picture")

    # A typed number, and back.
    generation, metallic = v.last()["state"]["generation"], v.last()["state"]["metallic"]
    v.type("metallic", .25)
    check(v.wait("the typed number", lambda s: s["generation"] > generation)["metallic"] == .25, "a number can be typed")
    generation = v.last()["state"]["generation"]
    v.click("undo")
    check(v.shown(generation + 1)["metallic"] == metallic, "undo takes the whole number back")
    generation += 1
    v.control("z")
    check(v.shown(generation + 1)["metallic"] != metallic, "ctrl-Z takes the whole drag back")

    # The fly camera.
    v.click("tab Picture")
    v.choose("mouse", "fly (keys W A S D Q E)")
    display.do("mousemove", *map(int, v.in_picture(.5, .3)), "sleep", ".3", "keydown", "w", "sleep", ".4", "keyup", "w")
    now = v.wait("the flight", lambda s: s["camera"] == "view")
    before = v.shown(now["generation"])["generation"]
    v.drag(v.in_picture(.5, .3), v.in_picture(.55, .35))
    check(v.shown(before + 1)["camera"] == "view", "W flies, a drag looks around")
    v.choose("mouse", "turntable")

    # Every shader of the menu; d_gamma and d_constant restart the picture.
    for shader in SHADERS:
        before = v.last()["state"]
        v.choose("shader", shader)
        check(v.shown(before["generation"] + 1)["shader"] == shader, f"shader {shader} is rendered")
    v.picture("6-path_disney")
    for control, place in (("d_gamma", .3), ("d_constant auto", .05), ("d_constant", .5)):
        before = v.last()["state"]
        v.click(control, place)
        check(v.shown(before["generation"] + 1)["generation"] > before["generation"], f"{control} restarts the picture")

    # Error in false colours, then the picture again.
    v.shown(samples=16)
    old = v.picture("7-path_disney")
    v.choose("show", "relative standard error")
    check(v.picture("8-error") != old, "the error is shown in false colours")
    v.choose("show", "picture")

    # Save the picture: it is assay-render's, of the scene saved beside it.
    v.click("save image")
    v.wait("a saved image", lambda s: not s["saving"] and s["message"].startswith("basic_pl-view.exr: "))
    message = v.last()["state"]["message"]
    image = os.path.join(OUT, message.split(":")[0])
    check(os.path.exists(image), "the image was saved: " + message)
    check(os.path.exists(image.replace(".exr", ".scene.glb")), "and its scene")
    v.click("save scene, copy command" if "save scene, copy command" in v.last()["items"] else "copy command")
    command = v.wait("the command", lambda s: not s["saving"] and s["message"].startswith("assay-render"))["message"]
    words = shlex.split(command)
    words[0], words[words.index("--out") + 1] = RENDER, os.path.join(OUT, "again.exr")
    words[words.index("--spp") + 1] = message.split(": ")[1].split()[0]
    subprocess.run(words + ["--quiet"], cwd=OUT, check=True)
    check(same_pixels(image, os.path.join(OUT, "again.exr")), "the command makes the saved picture: " + command)
    info = v.last()["state"]["frame"]
    check(info["problem"] == "", "no problem was reported")
    print(f"preview on the screen {info['preview_ms']:.0f} ms after the last interaction")
    display.screenshot("9-saved")
    v.close()


with_display = Display(OUT)
try:
    run(with_display)
    run_textured(with_display)
finally:
    with_display.close()
if failures:
    sys.exit("failed: " + "; ".join(failures))
