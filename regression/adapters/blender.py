#!/usr/bin/python3
"""Blender as the renderer under test: one scene -> one EXR, as `assay run --renderer` wants it (docs/other-renderers.md).

  blender.py SCENE OUT --width W --height H --spp N [--replicates K] [--seed S] [--depth D] [--camera C] [--shader NAME]
             [--threads T]

Every replicate is a render with a seed of its own; their mean, the variance of that mean and the replicates themselves
are written. Cycles' Principled BSDF is the shader `principled`; any other is refused. Exit codes: 0 done, 2 could not.
"""

import argparse
import os
import sys
import tempfile

sys.dont_write_bytecode = True
ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
sys.path.insert(0, os.path.join(ROOT, "reference", "blender"))

import numpy as np  # noqa: E402
import OpenImageIO as oiio  # noqa: E402

import suite  # noqa: E402
import witness  # noqa: E402


def fail(message):
    print(f"blender.py: {message}", file=sys.stderr)
    sys.exit(2)


def write(path, replicates, samples):
    """Channels as docs/formats.md has them, all float."""
    mean, variance = suite.merge(replicates)
    names = [*"RGB", *("variance." + c for c in "RGB"), *(f"replicate{r}.{c}" for r in range(len(replicates)) for c in "RGB")]
    spec = oiio.ImageSpec(mean.shape[1], mean.shape[0], len(names), oiio.FLOAT)
    spec.channelnames = tuple(names)
    spec.attribute("assay:replicates", len(replicates))
    spec.attribute("assay:spp", samples)
    output = oiio.ImageOutput.create(path)
    pixels = np.concatenate([mean, variance, *replicates], axis=2).astype(np.float32)
    if output is None or not output.open(path, spec) or not output.write_image(np.ascontiguousarray(pixels)) or not output.close():
        fail(f"{path}: cannot be written: {output.geterror() if output else oiio.geterror()}")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.error = fail
    parser.add_argument("scene")
    parser.add_argument("out")
    for name, default in (("width", None), ("height", None), ("spp", None), ("replicates", 8), ("seed", 1), ("depth", 8), ("camera", 0),
                          ("threads", 0)):
        parser.add_argument("--" + name, type=int, default=default, required=default is None)
    parser.add_argument("--shader", default="principled")
    a = parser.parse_args()
    if a.shader != "principled":
        fail(f"{a.scene}: shader: wanted principled, which is what Cycles has, found {a.shader}")
    if a.replicates < 2 or a.spp % a.replicates:
        fail(f"--replicates: wanted 2 or more that divide {a.spp} samples, found {a.replicates}")
    blender = witness.Blender(os.environ.get("ASSAY_BLENDER", "blender"), a.threads or os.cpu_count())
    # Debian's Blender takes the modules of the first python3 in PATH: with a virtual environment's it would find no numpy.
    os.environ["PATH"] = "/usr/bin:" + os.environ.get("PATH", "")
    # Different seeds of ours have no seed of Cycles in common; those are 31 bits.
    seeds = [(a.seed * a.replicates + r) % 2 ** 31 for r in range(a.replicates)]
    with tempfile.TemporaryDirectory() as folder:
        job = {"name": "scene", "scene": a.scene, "width": a.width, "height": a.height, "camera": a.camera, "depth": a.depth,
               "spp": a.spp // a.replicates, "seeds": seeds, "hide_environment": False, "punctual_units": "auto",
               "out": os.path.join(folder, "scene")}
        for _, error, _ in blender.render([job], folder):
            if error:
                fail(error)
        write(a.out, [suite.read_exr(f"{job['out']}.{seed}.exr")[0][..., :3] for seed in seeds], a.spp)


if __name__ == "__main__":
    main()
