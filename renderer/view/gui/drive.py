#!/usr/bin/python3
"""Drives assay-view in a virtual display with xdotool, as a person would, and checks what it did.

usage: drive.py ASSAY_VIEW ASSAY_RENDER SCENE OUT_FOLDER
Needs Xvfb and xdotool; without them it says so and exits with 77 (skipped). Screenshots go to OUT_FOLDER. Where a control is, and
what the picture shows, comes from assay-view's --trace; the screenshots are the pixels of the X server.
"""
import json
import os
import shutil
import struct
import subprocess
import sys
import time
import zlib

VIEW, RENDER, SCENE, OUT = [os.path.abspath(path) for path in sys.argv[1:5]]
PATIENCE = 120  # seconds, for a machine that does other things too


def skip(why):
    print("skipped:", why)
    sys.exit(77)


for program in ("Xvfb", "xdotool"):
    if not shutil.which(program):
        skip(f"there is no {program}")


class Display:
    """An X server without a screen, whose picture is a file."""

    def __init__(self, folder):
        self.folder = folder
        reader, writer = os.pipe()
        self.process = subprocess.Popen(
            ["Xvfb", "-displayfd", str(writer), "-screen", "0", "1280x800x24", "-fbdir", folder, "-nolisten", "tcp"],
            pass_fds=[writer], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        os.close(writer)
        with os.fdopen(reader) as pipe:
            number = pipe.readline().strip()
        if not number:
            skip("Xvfb does not start here")
        self.name = ":" + number
        self.environment = dict(os.environ, DISPLAY=self.name, LIBGL_ALWAYS_SOFTWARE="1")

    def do(self, *words):
        """One command of xdotool."""
        subprocess.run(["xdotool", *map(str, words)], env=self.environment, check=True)

    def pixels(self):
        """Width, height and the rows of the screen as bytes RGB; the file is an X window dump of 32 bits BGRX."""
        with open(os.path.join(self.folder, "Xvfb_screen0"), "rb") as file:
            data = file.read()
        head = struct.unpack(">25I", data[:100])
        size, width, height, line, colours = head[0], head[4], head[5], head[12], head[19]
        start = size + 12 * colours
        rows = []
        for y in range(height):
            row = data[start + y * line:start + y * line + 4 * width]
            rgb = bytearray(3 * width)
            rgb[0::3], rgb[1::3], rgb[2::3] = row[2::4], row[1::4], row[0::4]
            rows.append(bytes(rgb))
        return width, height, rows

    def screenshot(self, name):
        width, height, rows = self.pixels()
        chunk = lambda kind, body: (struct.pack(">I", len(body)) + kind + body
                                    + struct.pack(">I", zlib.crc32(kind + body)))
        with open(os.path.join(OUT, name + ".png"), "wb") as file:
            file.write(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0))
                       + chunk(b"IDAT", zlib.compress(b"".join(b"\0" + row for row in rows))) + chunk(b"IEND", b""))
        return rows

    def close(self):
        self.process.terminate()
        self.process.wait()


class Viewer:
    """assay-view, its trace and the hand that moves the mouse."""

    def __init__(self, display, *options):
        self.display = display
        self.trace = os.path.join(OUT, "trace.jsonl")
        open(self.trace, "w").close()
        self.process = subprocess.Popen([VIEW, SCENE, "--trace", self.trace, *options], env=display.environment, cwd=OUT)
        self.wait("a window", lambda state: True)

    def last(self):
        """The newest whole line of the trace."""
        with open(self.trace, "rb") as file:
            file.seek(max(0, os.path.getsize(self.trace) - 60000))
            lines = file.read().split(b"\n")
        return json.loads(lines[-2]) if len(lines) > 1 else None

    def wait(self, what, condition):
        end = time.time() + PATIENCE
        while time.time() < end:
            if self.process.poll() is not None:
                sys.exit(f"assay-view ended with {self.process.returncode} before: {what}")
            line = self.last()
            if line and condition(line["state"]):
                return line["state"]
            time.sleep(.03)
        self.display.screenshot("failed")
        sys.exit(f"not within {PATIENCE} s: {what}; last: {json.dumps(line and line['state'])}")

    def shown(self, generation=None, samples=1):
        """Waits until the full-size picture of a generation is on the screen."""
        return self.wait(f"the picture of generation {generation}", lambda s: "frame" in s and s["frame"]["divisor"] == 1
                         and s["frame"]["samples"] >= samples
                         and s["frame"]["generation"] == s["generation"] >= (generation or 1))

    def item(self, name):
        """Where a control is, once it rests: a list that opens scrolls to what is chosen."""
        end, last, since = time.time() + PATIENCE, None, 0
        while time.time() < end:
            line = self.last()
            now = line and line["items"].get(name)
            if now != last:
                last, since = now, time.time()
            elif now and time.time() - since > .3:
                return now
            time.sleep(.03)
        self.display.screenshot("failed")
        sys.exit(f"the control '{name}' is not there; there are: {', '.join(self.last()['items'])}")

    def click(self, name, at=.3):
        x, y, width, height = self.item(name)
        self.display.do("mousemove", x + int(width * at), y + height // 2)
        time.sleep(.2)
        self.display.do("mousedown", 1)
        time.sleep(.15)
        self.display.do("mouseup", 1)
        time.sleep(.2)

    def choose(self, menu, entry):
        self.click(menu)
        self.click(f"{menu}: {entry}", .1)

    def drag(self, start, end, button=1, steps=8):
        self.display.do("mousemove", *map(int, start))
        time.sleep(.2)
        self.display.do("mousedown", button)
        time.sleep(.1)
        for i in range(1, steps + 1):
            self.display.do("mousemove", *[int(a + (b - a) * i / steps) for a, b in zip(start, end)])
            time.sleep(.05)
        time.sleep(.1)
        self.display.do("mouseup", button)
        time.sleep(.2)

    def in_picture(self, u, v):
        x, y, width, height = self.item("picture")
        return x + u * width, y + v * height

    def picture(self, name):
        """The pixels where the picture is on the screen, and a screenshot of everything."""
        self.display.do("mousemove", 1270, 790)  # out of the way: no inspector
        time.sleep(.5)
        rows = self.display.screenshot(name)
        x, y, width, height = self.item("picture")
        return [row[3 * x:3 * (x + width)] for row in rows[y:y + height]]

    def close(self):
        self.process.terminate()
        self.process.wait()


failures = []


def check(holds, what):
    print("ok    " if holds else "FAILED", what, flush=True)
    if not holds:
        failures.append(what)


def mean(rows):
    data = b"".join(rows)
    return [sum(data[c::3]) / (len(data) / 3) for c in range(3)]


def run(display):
    reference = os.path.join(OUT, "reference.exr")
    subprocess.run([RENDER, SCENE, "-o", reference, "--width", "300", "--height", "128", "--spp", "8", "--quiet",
                    "--shader", "path"], check=True)
    v = Viewer(display, "--width", "300", "--height", "128", "--spp", "64", "--reference", reference)
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
    time.sleep(.3)
    v.click(next(name for name in v.last()["items"] if name.startswith("camera: 0")), .1)
    check(v.shown(generation + 1)["camera"] == "0", "the camera menu switches back")

    # A click picks the material; its slider changes the picture.
    x, y = v.in_picture(.18, .5)
    display.do("mousemove", int(x), int(y))
    time.sleep(.3)
    display.do("click", 1)
    time.sleep(.5)
    red = v.last()["state"]["material"]
    x, y = v.in_picture(.5, .45)
    display.do("mousemove", int(x), int(y))
    time.sleep(.3)
    display.do("click", 1)
    time.sleep(.5)
    check(v.last()["state"]["material"] != red, "a click on another shape picks another material")
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

    # Every shader of the menu; d_gamma and d_constant restart the picture.
    v.click("tab Picture")
    for shader in ("normal", "albedo", "path_disney"):
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
    v.wait("a saved image", lambda s: not s["saving"] and ": " in s["message"])
    message = v.last()["state"]["message"]
    image = os.path.join(OUT, message.split(":")[0])
    check(os.path.exists(image), "the image was saved: " + message)
    check(os.path.exists(image.replace(".exr", ".scene.glb")), "and its scene")
    info = v.last()["state"]["frame"]
    check(info["problem"] == "", "no problem was reported")
    print(f"preview on the screen {info['preview_ms']:.0f} ms after the last interaction")
    display.screenshot("9-saved")
    v.close()


os.makedirs(OUT, exist_ok=True)
with_display = Display(OUT)
try:
    run(with_display)
finally:
    with_display.close()
if failures:
    sys.exit("failed: " + "; ".join(failures))
