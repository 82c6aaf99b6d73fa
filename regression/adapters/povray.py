#!/usr/bin/python3
"""POV-Ray as the renderer under test: one scene -> one EXR, as `assay run --renderer` wants it (docs/other-renderers.md).

  povray.py SCENE OUT --width W --height H [--shader NAME] [--depth D] [--camera C]

Shaders `position` and `normal` are those layers at the pixels' centres. Any other is direct light (--depth 1) on Lambert
surfaces under point and directional lamps, or with perfect mirrors the light they pass on; what POV-Ray has no word for
is refused. There is no randomness: the variance is what a grid of 16 x 16 rays per pixel leaves undecided. Exit codes: 0
done, 2 could not.
"""

import argparse
import os
import sys

sys.dont_write_bytecode = True
ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
sys.path.insert(0, os.path.join(ROOT, "reference", "povray"))

import exr  # noqa: E402
import pov  # noqa: E402
import scene_to_pov  # noqa: E402
import witness  # noqa: E402


def fail(message):
    print(f"povray.py: {message}", file=sys.stderr)
    sys.exit(2)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.error = fail
    parser.add_argument("scene")
    parser.add_argument("out")
    for name, default in (("width", None), ("height", None), ("depth", 1), ("camera", 0)):
        parser.add_argument("--" + name, type=int, default=default, required=default is None)
    parser.add_argument("--shader", default="path")
    a = parser.parse_args()
    try:
        scene = scene_to_pov.Scene(a.scene, a.camera)
        if a.shader in ("position", "normal"):
            pixels, hit = (witness.position if a.shader == "position" else witness.normal)(scene, a.width, a.height)
            return exr.write(a.out, pixels, {"assay:witness": pov.version()}, coverage=hit)
        mirrors = any(mesh.material.is_mirror for mesh in scene.meshes)
        if not mirrors and a.depth != 1:
            raise pov.Failure(f"{a.scene}: depth: wanted 1, direct light, found {a.depth}: POV-Ray has no unbiased indirect light")
        pixels, variance = witness.radiance(scene, "mirror" if mirrors else "direct", a.width, a.height, a.depth)
        exr.write(a.out, pixels, {"assay:witness": pov.version(), "assay:spp": witness.GRID ** 2}, variance=variance)
    except pov.Failure as error:
        fail(error)


if __name__ == "__main__":
    main()
