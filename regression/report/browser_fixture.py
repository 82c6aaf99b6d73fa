"""A build folder as `assay run` leaves it (docs/formats.md, "Results"), with pictures whose every value is known here."""
import json
import os

import numpy
import OpenImageIO as oiio

WIDTH, HEIGHT = 20, 12
TILES = [(0, 0, 8, 8, 9.5), (8, 0, 8, 8, -6.7), (16, 0, 4, 8, .5), (0, 8, 8, 4, 0), (8, 8, 8, 4, None), (16, 8, 4, 4, 3.35)]


def write_exr(file, layers, **attributes):
    """layers: {"": h x w x 3, "variance": ..., "normal": ...}"""
    names, planes = [], []
    for layer, pixels in layers.items():
        for c, letter in enumerate("XYZ" if layer in ("normal", "position") else "RGB"):
            names.append(layer + "." + letter if layer else letter)
            planes.append(pixels[..., c])
    stack = numpy.ascontiguousarray(numpy.stack(planes, -1), dtype=numpy.float32)
    height, width, count = stack.shape
    spec = oiio.ImageSpec(width, height, count, oiio.FLOAT)
    spec.channelnames = names
    for key, value in attributes.items():
        spec["assay:" + key] = value
    os.makedirs(os.path.dirname(file), exist_ok=True)
    out = oiio.ImageOutput.create(file)
    assert out and out.open(file, spec) and out.write_image(stack) and out.close(), file


def pictures(seed, width=WIDTH, height=HEIGHT):
    """Radiance over nine stops, the same for ours and golden but for 10 % in the right half and one very bright pixel."""
    random = numpy.random.default_rng(seed)
    golden = numpy.exp2(random.uniform(-6, 3, (height, width, 3)))
    ours = golden.copy()
    ours[:, width // 2:] *= 1.1
    ours[3, 2] = (20000, 3e-4, 0)
    return ours.astype(numpy.float32), golden.astype(numpy.float32)


class Build:
    """Makes the folder; `pixels` keeps what was written, by path."""

    def __init__(self, folder):
        self.folder, self.pixels, self.results = folder, {}, []

    def picture(self, path, pixels, layer="", **layers):
        self.pixels[path] = pixels
        write_exr(os.path.join(self.folder, path), {"": pixels, **layers}, replicates=8)
        return path

    def case(self, name, verdict, tags, **more):
        passed = verdict in ("IDENTICAL", "EQUIVALENT")
        result = {"case": name, "verdict": verdict, "passed": passed, "exit_code": 0 if passed else 1,
                  "reason": "" if passed else "bias of the image +5 %", "seconds": .5, "why": f"Notices what {name} notices.",
                  "scene": name + ".glb", "shader": "disney", "size": [WIDTH, HEIGHT], "spp": 64, "replicates": 8, "seed": 1,
                  "depth": 4, "options": {}, "tags": tags, "margins": {"image": .005, "tile": .05},
                  "golden": {"measures": [{"name": "flip", "value": .2, "limit": .05, "ok": passed}], "images": {}},
                  "witnesses": [], "provenance": {"render": {"commit": "0123456789ab"}, "golden": {"flip_exposures": [1, 3, 2]}},
                  "accept": "" if passed else f"build/bin/assay accept {name} --because \"…\""}
        result.update(more)
        self.results.append(result)
        return result

    def save(self):
        os.makedirs(os.path.join(self.folder, "results"), exist_ok=True)
        for result in self.results:
            with open(os.path.join(self.folder, "results", result["case"] + ".json"), "w") as out:
                json.dump(result, out)
        with open(os.path.join(self.folder, "run.json"), "w") as out:
            json.dump({"finished": "2026-01-02T03:04:05Z", "seconds": 9, "exit_code": 1, "renderer": "assay-render",
                       "suite": "../regression", "cases": [r["case"] for r in self.results], "orphans": []}, out)


def difference(p, relative=.05):
    one = {"reference": 1, "test": 1 + relative, "relative": relative, "low": relative - .01, "high": relative + .01,
           "standard_error": .004, "t": 12, "p": p, "detectable": .02, "significant": p < 1e-6, "within_margin": False}
    return {name: one for name in ("red", "green", "blue", "luminance")}


def small_suite(folder):
    """Five cases: one CHANGED with Blender, one BROKEN with a NaN, three IDENTICAL: alone, with normals, and large."""
    build = Build(folder)
    ours, golden = pictures(1)
    variance = numpy.full_like(ours, 1e-4)
    images = {"render": build.picture("renders/bright.exr", ours, variance=variance),
              "golden": build.picture("goldens/bright.exr", golden, variance=variance),
              "flip": build.picture("results/bright.flip.exr", numpy.repeat(numpy.linspace(0, 1, WIDTH * HEIGHT).reshape(HEIGHT, WIDTH, 1), 3, 2))}
    bright = build.case("bright", "CHANGED", ["light", "disney"])
    bright["golden"]["images"] = images
    bright["golden"]["welch"] = {
        "biased": True, "smallest_p": 1e-9, "image": difference(1e-9), "tile_columns": 3, "tile_rows": 2,
        "tiles": [{"x": x, "y": y, "width": w, "height": h, "t": t, "relative": .08, "low": .07, "high": .09,
                   "significant": t is not None and t > 9} for x, y, w, h, t in TILES]}
    bright["golden"]["wrong_pixels"] = [{"x": 2, "y": 3, "reference": 1, "test": 20000, "sigmas": 99}]
    blender = build.picture("reference/bright.exr", golden * 1.05, variance=variance)
    bright["witnesses"] = [{"label": "blender", "kind": "blender", "quantity": "", "verdict": "DIFFERS", "passed": False,
                            "expect": "agrees", "reason": "bias +5 %", "said_by": "Blender 3.4.1", "margin": .005,
                            "measures": [], "image": difference(1e-9),
                            "images": {"render": images["render"], "witness": blender, "map": images["flip"], "map_is": "flip"}}]

    bad = golden.copy()
    bad[1, 1] = numpy.nan
    broken = build.case("broken", "BROKEN", ["light"])
    broken["golden"]["images"] = {"render": build.picture("renders/broken.exr", bad), "golden": images["golden"]}

    same = build.case("same", "IDENTICAL", ["disney"])
    same["golden"]["images"] = {"render": images["golden"], "golden": images["golden"]}

    normals = build.case("normals", "IDENTICAL", ["disney", "geometry"])
    up = numpy.dstack([numpy.linspace(-1, 1, WIDTH * HEIGHT).reshape(HEIGHT, WIDTH)] * 3).astype(numpy.float32)
    render = build.picture("renders/normals.exr", golden, normal=up)
    normals["golden"]["images"] = {"render": render, "golden": render}
    normals["witnesses"] = [{"label": "povray-normal", "kind": "povray", "quantity": "normal", "verdict": "AGREES", "passed": True,
                             "expect": "agrees", "said_by": "POV-Ray 3.7", "margin": .001, "measures": [],
                             "images": {"render": render, "witness": build.picture("reference/normals.exr", up), "map": None, "map_is": ""}}]

    large = build.case("large", "IDENTICAL", ["geometry"])
    wide = build.picture("renders/large.exr", numpy.full((500, 600, 3), (.25, .5, 1), numpy.float32))
    large["golden"]["images"] = {"render": wide, "golden": wide}
    build.save()
    return build


def hundred_cases(folder):
    """A hundred cases of 64 x 64: every fifth CHANGED, every second with Blender."""
    build = Build(folder)
    for i in range(100):
        ours, golden = pictures(i, 64, 64)
        noise = numpy.random.default_rng(1000 + i).normal(1, .05, golden.shape).astype(numpy.float32)
        variance = golden * golden * 1e-3
        case = build.case(f"case{i:02}", "IDENTICAL" if i % 5 else "CHANGED", [f"tag{i % 7}"])
        golden_file = build.picture(f"goldens/{i}.exr", golden, variance=variance)
        case["golden"]["images"] = {"render": golden_file if i % 5 else build.picture(f"renders/{i}.exr", ours, variance=variance),
                                    "golden": golden_file}
        if i % 2:
            case["witnesses"] = [{"label": "blender", "kind": "blender", "verdict": "AGREES", "passed": True, "margin": .005,
                                  "measures": [], "image": difference((i % 20) / 20 + .01, 0),
                                  "images": {"render": case["golden"]["images"]["render"],
                                             "witness": build.picture(f"reference/{i}.exr", golden * noise, variance=variance)}}]
    build.save()
    return build
