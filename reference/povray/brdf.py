#!/usr/bin/python3
"""A BRDF over the visible half of a unit sphere, computed by POV-Ray: one directional light, orthographic eye.

    brdf.py MODEL [name=value ...] [lobe=NAME] [light=x,y,z] [--size N] [-o out.exr]
    brdf.py --all [--out DIR]      remake renders/brdf_*.exr from brdf.json

MODEL and the names are those of disney_sdl.py. Pixel (i, j), j counted from the top, of an N x N picture is the
normal n = (X, Y, sqrt(1 - X^2 - Y^2)), X = (2i+1)/N - 1, Y = 1 - (2j+1)/N, with the eye at +z; its value is f (n.l),
the radiance under irradiance 1. Pixels off the sphere, or with the light behind, are 0.
"""

import argparse
import concurrent.futures
import json
import math
import os
import sys

import numpy as np

import disney_sdl
import exr
import pov

HERE = os.path.dirname(os.path.abspath(__file__))
LIST = os.path.join(HERE, "brdf.json")

_SPHERE = """camera {{ orthographic location <0,0,4> direction <0,0,-1> right <2,0,0> up <0,2,0> }}
{declarations}
sphere {{ <0,0,0>, 1 {texture} }}
"""


def evaluate(model, parameters, light, size, lobe="all"):
    """(N, N, 3) float64. Three renders: one on a logarithmic scale to find the maximum, then two 16-bit words of
    the value divided by it."""
    declarations, names = disney_sdl.declarations(model, parameters, light, lobe)

    def body(texture):
        return _SPHERE.format(declarations=declarations, texture=texture)

    # 16 bits over e^-20 .. e^20 find the maximum to 0.06 %.
    logs = [f"min(max((ln(max({n}, 1e-30)) + 20)/40, 0), 0.9999999)" for n in names]
    top = pov.render(body(pov.glow(*logs)), size, size).max()
    full = math.exp(40 * top - 20) * 1.002
    return full * pov.render_function(*(f"({n})/{full:.17g}" for n in names), body, size, size)


def parse(items):
    """name=value words -> (parameters, light, lobe)."""
    parameters, light, lobe = {}, (0.0, 0.0, 1.0), "all"
    for item in items:
        name, equals, value = item.partition("=")
        if not equals:
            raise pov.Failure(f"brdf: wanted name=value, found '{item}'")
        if name == "lobe":
            lobe = value
            continue
        try:
            numbers = tuple(float(v) for v in value.split(","))
        except ValueError:
            raise pov.Failure(f"brdf: {name}: wanted a number, found '{value}'") from None
        wanted = 3 if name in ("base", "light") else 1
        if len(numbers) != wanted or not all(map(math.isfinite, numbers)):
            raise pov.Failure(f"brdf: {name}: wanted {wanted} finite number{'s' * (wanted > 1)}, found '{value}'")
        if name == "light":
            light = numbers
        else:
            parameters[name] = numbers if wanted == 3 else numbers[0]
    return disney_sdl.complete(parameters), light, lobe


def listing():
    """brdf.json, with each entry's stored file and the header string that says what it is."""
    with open(LIST) as file:
        content = json.load(file)
    for entry in content["configurations"]:
        entry["options"] = json.dumps(entry, sort_keys=True, separators=(",", ":"))
    return content["size"], content["configurations"]


def path_of(entry, out):
    return os.path.join(out, f"brdf_{entry['name']}.exr")


def stale(out):
    """(entry, why) of each stored picture that is not today's."""
    found = []
    for entry in listing()[1]:
        path = path_of(entry, out)
        header = exr.read(path)[2] if os.path.exists(path) else None
        if header is None:
            found.append((entry, "missing"))
        elif header.get("assay:options") != entry["options"]:
            found.append((entry, "stale: options differ"))
        elif header.get("assay:script_hash") != exr.script_hash():
            found.append((entry, "stale: script hash differs"))
    return found


def remake(entries, out):
    """Renders these entries of brdf.json, with progress."""
    size = listing()[0]
    os.makedirs(out, exist_ok=True)
    pov.version()

    def render(entry):
        return evaluate(entry["model"], entry["parameters"], entry["light"], size, entry["lobe"])

    # POV-Ray spends most of a small render waiting for its own threads: four at a time.
    with concurrent.futures.ThreadPoolExecutor(4) as pool:
        for number, (entry, pixels) in enumerate(zip(entries, pool.map(render, entries)), 1):
            exr.write(path_of(entry, out), pixels, {"assay:witness": pov.version(), "assay:script_hash": exr.script_hash(),
                                                    "assay:options": entry["options"]})
            print(f"[{number}/{len(entries)}] brdf_{entry['name']}: full scale {pixels.max():.6g}", flush=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("model", nargs="?", choices=disney_sdl.MODELS)
    parser.add_argument("values", nargs="*", metavar="name=value")
    parser.add_argument("--size", type=int, default=64)
    parser.add_argument("-o", default="brdf.exr", metavar="FILE")
    parser.add_argument("--all", action="store_true", help="remake the stored renders listed in brdf.json")
    parser.add_argument("--out", default=os.path.join(HERE, "renders"), metavar="DIR", help="where --all writes")
    arguments = parser.parse_args()
    if arguments.all:
        return remake(listing()[1], arguments.out)
    if not arguments.model or not 1 <= arguments.size <= 4096:
        parser.error("wanted a MODEL and a size in [1, 4096]")
    parameters, light, lobe = parse(arguments.values)
    pixels = evaluate(arguments.model, parameters, light, arguments.size, lobe)
    exr.write(arguments.o, pixels, {"assay:witness": pov.version(), "assay:script_hash": exr.script_hash()})
    print(f"{arguments.o}: full scale {pixels.max():.9g}, mean {np.mean(pixels):.9g}")


if __name__ == "__main__":
    try:
        main()
    except pov.Failure as failure:
        print(failure, file=sys.stderr)
        sys.exit(2)
