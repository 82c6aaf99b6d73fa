#!/usr/bin/python3
"""Blender and POV-Ray as renderers under test, on one tiny case each, through the real `assay run`.

  adapters_test.py Blender | Povray     exit code 77: not installed, or assay is not built. ASSAY_BIN: folder of assay.

The scene is a white square under a sun of irradiance pi straight above: its radiance is 1 wherever the camera looks. Camera
0 sees nothing else; camera 1 sees it half.
"""

import json
import math
import os
import shutil
import subprocess
import sys
import tempfile
import unittest

sys.dont_write_bytecode = True
HERE = os.path.dirname(os.path.abspath(__file__))
ROOT = os.path.dirname(os.path.dirname(HERE))
sys.path.insert(0, os.path.join(ROOT, "reference", "blender", "tests"))

from tiny_scene import TinyScene, look  # noqa: E402

ASSAY = os.path.join(os.environ.get("ASSAY_BIN", os.path.join(ROOT, "build", "bin")), "assay")
WHITE = {"pbrMetallicRoughness": {"metallicFactor": 0, "roughnessFactor": .5}, "extras": {"disney_specular": 0}}


class Adapter:
    """The same four steps for both. `camera` is what the template says of it."""

    def setUp(self):
        self.folder = tempfile.mkdtemp()
        self.addCleanup(shutil.rmtree, self.folder)
        for name in ("cases", "scenes"):
            os.makedirs(os.path.join(self.folder, "suite", name))
        scene = TinyScene()
        scene.quad(WHITE, half=2.0)
        above = look((0, 0, 2), (0, 0, 0))
        scene.orthographic(above, 1.0)
        scene.orthographic(look((2, 0, 2), (2, 0, 0)), 1.0)
        scene.light(above, type="directional", intensity=math.pi)
        scene.save(os.path.join(self.folder, "suite", "scenes", "square.glb"))
        self.write_case(self.shader)

    def write_case(self, shader):
        case = {"name": "square", "why": "A radiance of 1.", "scene": "square.glb", "shader": shader, "size": [16, 16], "spp": 16,
                "replicates": 2, "seed": 1, "depth": 1, "limits": {"flip": .01, "rmse": .001},
                "witnesses": [{"kind": "analytic", "mean": [1, 1, 1], "margin": .001, "source": "E / pi"}]}
        with open(os.path.join(self.folder, "suite", "cases", "square.json"), "w") as file:
            json.dump(case, file)

    def assay(self, command, *arguments):
        environment = {key: value for key, value in os.environ.items() if key != "CI"}
        return subprocess.run([ASSAY, command, "--suite", os.path.join(self.folder, "suite"), "--build", os.path.join(self.folder, "build"),
                               *arguments], capture_output=True, text=True, env=environment)

    def run_case(self, camera="{camera}"):
        ran = self.assay("run", "--renderer", f"/usr/bin/python3 {os.path.join(HERE, self.script)} {self.template} --camera {camera}")
        with open(os.path.join(self.folder, "build", "results", "square.json")) as file:
            return ran.returncode, json.load(file)

    def test_it_is_right_remembered_and_caught(self):
        code, result = self.run_case()
        self.assertEqual(result["witnesses"][0]["verdict"], "AGREES", result)
        self.assertNotEqual(code, 0, "there is no golden yet")
        accepted = self.assay("accept", "square", "--because", "first")
        self.assertEqual(accepted.returncode, 0, accepted.stdout + accepted.stderr)
        code, result = self.run_case()
        self.assertEqual((code, result["verdict"]), (0, "IDENTICAL"), result["reason"])
        code, result = self.run_case(camera="1")
        self.assertEqual((code, result["verdict"]), (1, "CHANGED"), result["reason"])
        self.assertEqual(result["witnesses"][0]["verdict"], "DIFFERS")

    def test_what_it_cannot_do_is_its_own_one_line(self):
        self.write_case(self.refused)
        code, result = self.run_case()
        self.assertEqual((code, result["verdict"]), (2, "ERROR"))
        self.assertIn(self.line, result["reason"])


class Blender(Adapter, unittest.TestCase):
    script, shader, refused, line = "blender.py", "principled", "path", "shader: wanted principled"
    template = ("{scene} {out} --width {width} --height {height} --spp {spp} --replicates {replicates} --seed {seed} --depth {depth} "
                "--shader {shader} --threads 2")
    program = os.environ.get("ASSAY_BLENDER", "blender")


class Povray(Adapter, unittest.TestCase):
    script, shader, refused, line = "povray.py", "path", "path", "depth: wanted 1"
    template = "{scene} {out} --width {width} --height {height} --depth {depth} --shader {shader}"
    program = os.environ.get("POVRAY", "povray")

    def test_what_it_cannot_do_is_its_own_one_line(self):
        self.template = self.template.replace("{depth}", "2")
        super().test_what_it_cannot_do_is_its_own_one_line()


if __name__ == "__main__":
    part = {"Blender": Blender, "Povray": Povray}.get(sys.argv[1] if len(sys.argv) > 1 else "")
    if part and shutil.which(part.program) is None or not os.access(ASSAY, os.X_OK):
        print(f"no {part.program if part else ASSAY} found")
        sys.exit(77)
    unittest.main(verbosity=2)
