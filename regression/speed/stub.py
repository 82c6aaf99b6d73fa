#!/usr/bin/python3
"""A renderer for tests whose answers are known: grey plus independent noise of variance NOISE / spp plus BIAS, in
SPEED seconds a sample.

  stub.py SCENE OUT WIDTH HEIGHT SPP SEED SPEED NOISE BIAS
"""

import json
import pathlib
import random
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "scripts" / "scenes"))
sys.dont_write_bytecode = True

import image  # noqa: E402

scene, out = sys.argv[1:3]
width, height, spp, seed = map(int, sys.argv[3:7])
speed, noise, bias = map(float, sys.argv[7:10])
gauss, sigma = random.Random(seed).gauss, (noise / spp) ** .5
pathlib.Path(out).write_bytes(image.exr([[tuple(.5 + bias + gauss(0, sigma) for _ in "RGB") for _ in range(width)]
                                         for _ in range(height)]))
print(json.dumps({"ok": True, "render_seconds": speed * spp, "rays": 3.0 * spp * width * height}))
