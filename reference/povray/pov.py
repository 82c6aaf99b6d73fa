"""Runs the real POV-Ray and reads back what it computed; everything that touches the program is here.

POV-Ray writes 16-bit PNG. With `File_Gamma=1.0` and `assumed_gamma 1` a pixel is round(65535 * value), value clamped
to [0,1]: no transfer curve, no dither (measured: a formula painted on a sphere comes back within half a last bit).
"""

import os
import re
import shutil
import subprocess
import tempfile

import numpy as np
import OpenImageIO as oiio

FULL = 65535.0

HEADER = """#version 3.7;
global_settings { assumed_gamma 1.0 max_trace_level 32 ambient_light 0 }
background { rgb 0 }
"""


class Failure(Exception):
    """Something a user can mend: one line, exit code 2."""


def program():
    """The povray to run, or None. POVRAY names another one."""
    return shutil.which(os.environ.get("POVRAY", "povray"))


_version = None


def version():
    """For instance "POV-Ray 3.7.0.10": what stands in a witness's header. A missing program is a Failure."""
    global _version
    if _version:
        return _version
    if not program():
        raise Failure("povray: not found; wanted POV-Ray 3.7 in PATH (Debian: apt-get install povray)")
    ran = subprocess.run([program(), "--version"], capture_output=True, text=True)
    found = re.search(r"POV-Ray (\d+(?:\.\d+)*)", ran.stdout + ran.stderr)
    if not found:
        raise Failure(f"{program()}: wanted POV-Ray 3.7, but --version says: {(ran.stdout + ran.stderr).strip()[:80]!r}")
    _version = "POV-Ray " + found.group(1)
    return _version


def render(sdl, width, height, files=()):
    """The picture POV-Ray makes of the scene text: (height, width, 3) float64 in [0,1], top row first.

    `files` are (name, bytes) the scene text refers to. One ray through each pixel's centre, no anti-aliasing.
    """
    version()
    with tempfile.TemporaryDirectory(prefix="assay-povray-") as folder:
        for name, data in files:
            with open(os.path.join(folder, name), "wb") as out:
                out.write(data)
        with open(os.path.join(folder, "scene.pov"), "w") as out:
            out.write(HEADER + sdl)
        # HOME: POV-Ray's I/O restrictions and user settings must not depend on who runs it.
        ran = subprocess.run(
            [program(), "+Iscene.pov", "+Oscene.png", "+FN16", "File_Gamma=1.0", f"+W{width}", f"+H{height}", "-D", "-A",
             "+Q11", "-GA"], cwd=folder, env=dict(os.environ, HOME=folder), capture_output=True, text=True)
        if ran.returncode != 0:
            problem = [line for line in ran.stderr.splitlines() if "rror" in line] or ["no picture"]
            raise Failure(f"povray: exit code {ran.returncode}: {problem[0].strip()}")
        source = oiio.ImageInput.open(os.path.join(folder, "scene.png"))
        pixels = np.array(source.read_image("uint16"), dtype=np.float64).reshape(height, width, -1)
        source.close()
    return pixels[:, :, :3] / FULL


def glow(red, green, blue):
    """A texture that emits three user functions of the world-space point, one per channel; each must be in [0,1).

    (A colour map repeats, so 1 would show as 0; `average` divides by the number of entries, hence the 3.)
    """
    entries = " ".join(f"[1 function {{ {f} }} color_map {{ [0 rgb 0] [1 rgb {c}] }}]"
                       for f, c in ((red, "<3,0,0>"), (green, "<0,3,0>"), (blue, "<0,0,3>")))
    return (f"texture {{ pigment {{ average pigment_map {{ {entries} }} }}\n"
            "  finish { ambient 0 diffuse 0 emission 1 } }\n")


def high_word(f):
    """A function whose 16-bit pixel is the whole part of 65535 f, f in [0,1)."""
    return f"floor(min(max(({f}), 0), 0.9999999) * 65535) / 65535"


def low_word(f):
    """A function whose 16-bit pixel is the fraction that high_word leaves over."""
    return f"mod(min(max(({f}), 0), 0.9999999) * 65535, 1)"


def join(high, low):
    """f itself from the two pictures: 31 bits, so that POV-Ray's own double arithmetic shows, not the file's."""
    return (np.rint(high * FULL) + low) / FULL


def render_function(red, green, blue, body, width, height):
    """What three user functions of the point, each in [0,1), are at each pixel's hit, to about 1e-9.

    `body` makes the scene text from a texture.
    """
    high, low = (render(body(glow(word(red), word(green), word(blue))), width, height) for word in (high_word, low_word))
    return join(high, low)


def linear_png(data, factor, where):
    """An sRGB PNG or JPEG as a 16-bit PNG of linear colour times `factor`."""
    with tempfile.TemporaryDirectory(prefix="assay-povray-") as folder:
        path = os.path.join(folder, "in.png" if data[:4] == b"\x89PNG" else "in.jpg")
        with open(path, "wb") as file:
            file.write(data)
        source = oiio.ImageInput.open(path)
        if not source:
            raise Failure(f"{where}: the texture cannot be read: {oiio.geterror()}")
        spec = source.spec()
        sixteen = spec.format == oiio.UINT16
        codes = np.array(source.read_image("uint16" if sixteen else "uint8"), float) / (FULL if sixteen else 255)
        source.close()
        codes = codes.reshape(spec.height, spec.width, spec.nchannels)
        codes = codes[:, :, :3] if spec.nchannels >= 3 else np.repeat(codes[:, :, :1], 3, axis=2)
        linear = np.where(codes <= 0.04045, codes / 12.92, ((codes + 0.055) / 1.055) ** 2.4) * factor
        path = os.path.join(folder, "out.png")
        out = oiio.ImageOutput.create(path)
        out.open(path, oiio.ImageSpec(spec.width, spec.height, 3, oiio.UINT16))
        out.write_image(np.rint(np.clip(linear, 0, 1) * FULL).astype(np.uint16))
        out.close()
        with open(path, "rb") as file:
            return file.read()
