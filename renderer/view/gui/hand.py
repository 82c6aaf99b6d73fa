"""An X server without a screen, assay-view in it, and the hand that drives it with xdotool, as a person would.

Where a control is, and what the picture shows, comes from assay-view's --trace; screenshots are the pixels of the X server.
Without Xvfb and xdotool: says so and exits with 77 (skipped).
"""
import json
import os
import shutil
import struct
import subprocess
import sys
import time
import zlib

PATIENCE = float(os.environ.get("ASSAY_PATIENCE", 120))  # seconds, for a machine that does other things too


def skip(why):
    print("skipped:", why)
    sys.exit(77)


class Display:
    """An X server without a screen, whose picture is a file."""

    def __init__(self, folder):
        for program in ("Xvfb", "xdotool"):
            if not shutil.which(program):
                skip(f"there is no {program}")
        os.makedirs(folder, exist_ok=True)
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
        with open(os.path.join(self.folder, name + ".png"), "wb") as file:
            file.write(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0))
                       + chunk(b"IDAT", zlib.compress(b"".join(b"\0" + row for row in rows))) + chunk(b"IEND", b""))
        return rows

    def close(self):
        self.process.terminate()
        self.process.wait()


class Viewer:
    """assay-view, its trace and the hand that moves the mouse."""

    def __init__(self, display, program, scene, *options):
        self.display = display
        self.trace = os.path.join(display.folder, "trace.jsonl")
        open(self.trace, "w").close()
        self.process = subprocess.Popen([program, scene, "--trace", self.trace, *options], env=display.environment,
                                        cwd=display.folder)
        self.wait("a window", lambda state: True)

    def last(self):
        """The newest whole line of the trace."""
        with open(self.trace, "rb") as file:
            file.seek(max(0, os.path.getsize(self.trace) - 60000))
            lines = file.read().split(b"\n")
        return json.loads(lines[-2]) if len(lines) > 1 else None

    def until(self, what, found):
        """Waits for a line of which `found` says something, and returns that."""
        end = time.time() + PATIENCE
        while time.time() < end:
            if self.process.poll() is not None:
                sys.exit(f"assay-view ended with {self.process.returncode} before: {what}")
            line = self.last()
            result = line and found(line)
            if result:
                return result
            time.sleep(.03)
        self.display.screenshot("failed")
        sys.exit(f"not within {PATIENCE} s: {what}; last: {json.dumps(line and line['state'])}")

    def wait(self, what, condition):
        return self.until(what, lambda line: condition(line["state"]) and line["state"])

    def shown(self, generation=None, samples=1):
        """Waits until the full-size picture of a generation is on the screen."""
        return self.wait(f"the picture of generation {generation}", lambda s: "frame" in s and s["frame"]["divisor"] == 1
                         and s["frame"]["samples"] >= samples
                         and s["frame"]["generation"] == s["generation"] >= (generation or 1))

    def named(self, start):
        """The name of the control that begins so, once it is there: a menu's take a frame to appear."""
        return self.until(f"a control named {start}...", lambda line: next((n for n in line["items"] if n.startswith(start)), None))

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

    def control(self, key):
        """A key with ctrl, held as long as a person does: what begins and ends between two frames is not seen."""
        self.display.do("keydown", "ctrl", "sleep", ".15", "keydown", key, "sleep", ".15", "keyup", key, "keyup", "ctrl",
                        "sleep", ".15")

    def type(self, name, value, offset=60):
        """Types a value into a slider, as a person does: ctrl-click, the number, return."""
        x, y, width, height = self.item(name)
        self.display.do("mousemove", x + offset, y + height // 2)
        time.sleep(.2)
        self.display.do("keydown", "ctrl", "sleep", ".15", "click", 1, "sleep", ".15", "keyup", "ctrl")
        time.sleep(.2)
        self.control("a")
        self.display.do("type", "--delay", "60", str(value))
        time.sleep(.2)
        self.display.do("key", "Return")
        time.sleep(.2)

    def write(self, name, text):
        """Replaces the text of a field."""
        self.click(name)
        self.control("a")
        self.display.do("type", "--delay", "40", text)
        time.sleep(.3)

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
