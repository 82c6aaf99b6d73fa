#!/usr/bin/python3
"""Tests of scripts/compare-blend: the judging on made-up pictures, and the real Blender end to end.

  compare_test.py PlainPython | Agreement | Scenes | BadInput      exit code 77: no Blender, or the programs are not built
ASSAY_BIN names the folder of assay and assay-render (build/bin).
"""

import contextlib
import copy
import io
import json
import os
import shutil
import subprocess
import sys
import tempfile
import unittest

import numpy as np

sys.dont_write_bytecode = True
HERE = os.path.dirname(os.path.abspath(__file__))
sys.path[:0] = [HERE, os.path.dirname(HERE)]

import compare  # noqa: E402
import gltf  # noqa: E402
import judge  # noqa: E402
import suite  # noqa: E402
import witness  # noqa: E402

BIN = os.environ.get("ASSAY_BIN", os.path.join(suite.ROOT, "build", "bin"))
BLENDER = os.environ.get("ASSAY_BLENDER", "blender")
THREADS = "2"


def run(*arguments):
    """(exit code, stdout, stderr) of scripts/compare-blend."""
    out, errors = io.StringIO(), io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(errors):
        try:
            code = compare.main([*arguments, "--bin", BIN, "--threads", THREADS, "--blender", BLENDER, "--quiet"])
        except SystemExit as stop:
            code = stop.code
    return code, out.getvalue(), errors.getvalue()


class Folder(unittest.TestCase):
    names = ()

    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.mkdtemp()
        cls.addClassCleanup(shutil.rmtree, cls.folder)
        if cls.names:
            subprocess.run([BLENDER, "-b", "--factory-startup", "-P", os.path.join(HERE, "examples.py"), "--", cls.folder, *cls.names],
                           check=True, capture_output=True, env=dict(os.environ, PYTHONDONTWRITEBYTECODE="1"))

    def at(self, *parts):
        return os.path.join(self.folder, *parts)

    def blend(self, name, size="48x32", depth="4"):
        """The prepared scene of one of the examples, and its notes."""
        out = self.at(name)
        os.makedirs(out, exist_ok=True)
        arguments = compare.arguments_of([self.at(name + ".blend"), "--size", size, "--depth", depth, "--bin", BIN])
        scene = compare.Blend(arguments, witness.Blender(BLENDER, int(THREADS)), out)
        return scene, scene.prepare()


class PlainPython(Folder):
    """Two pictures of known noise: 64 x 48, 8 replicates."""

    def picture(self, name, seed, change=lambda image: image, noise=.02):
        random = np.random.default_rng(seed)
        y, x = np.mgrid[:48, :64]
        truth = np.stack([.5 + .4 * np.sin(x / 9), .5 + .3 * np.cos(y / 7), .6 + 0 * x], axis=2)
        parts = change(truth)[None] * (1 + noise * random.standard_normal((8, 48, 64, 3)))
        mean, variance = suite.merge(parts)
        path = self.at(name + ".exr")
        suite.write_witness(path, mean, variance, {"assay:replicates": 8})
        # With its replicates, as assay-render --layers replicates writes them.
        import OpenImageIO as oiio
        names = [c for c in "RGB"] + ["variance." + c for c in "RGB"] + [f"replicate{r}.{c}" for r in range(8) for c in "RGB"]
        spec = oiio.ImageSpec(64, 48, len(names), oiio.FLOAT)
        spec.channelnames = tuple(names)
        spec.attribute("assay:replicates", 8)
        output = oiio.ImageOutput.create(path)
        output.open(path, spec)
        output.write_image(np.ascontiguousarray(np.concatenate([mean, variance, *parts], axis=2), np.float32))
        output.close()
        return path

    def judge(self, change, **noise):
        return judge.judge(os.path.join(BIN, "assay"), self.picture("a", 1), self.picture("b", 2, change, **noise), .005, self.folder)

    def test_noise_alone_agrees(self):
        result = self.judge(lambda image: image)
        self.assertEqual(result["verdict"], "AGREES", result["reasons"] + result["too_noisy"])

    def test_one_per_cent_of_red_differs_and_is_named(self):
        result = self.judge(lambda image: image * [1.02, 1, 1])
        self.assertTrue(result["shown"])
        self.assertTrue(any(reason.startswith("red +") for reason in result["reasons"]), result["reasons"])
        self.assertFalse(any(reason.startswith("green") for reason in result["reasons"]))

    def test_a_spot_that_leaves_the_mean_alone_is_found_by_its_tiles(self):
        def change(image):
            image = image.copy()
            image[8:16, 8:16] *= 1.2
            image[16:24, 8:16] -= (image[8:16, 8:16] * (1 - 1 / 1.2)).mean(axis=(0, 1))
            return image

        result = self.judge(change)
        self.assertTrue(all(abs(d["relative"]) < .005 for d in result["bias"].values()), result["bias"])
        shown = {(tile["x"], tile["y"]) for tile in result["tiles"] if tile["shown"]}
        self.assertEqual(shown, {(8, 8), (8, 16)})
        self.assertIn("2 of 48 tiles beyond 5 %", result["reasons"])

    def test_structured_texture_is_found_by_flip(self):
        def change(image):
            image = image.copy()
            image[::2] *= 1.12
            image[1::2] *= .88
            return image

        result = self.judge(change)
        self.assertFalse([tile for tile in result["tiles"] if tile["shown"]])
        self.assertTrue(any("FLIP" in reason for reason in result["reasons"]), result)

    def test_too_much_noise_is_no_difference_but_said(self):
        result = self.judge(lambda image: image, noise=2.0)
        self.assertEqual((result["verdict"], result["reasons"]), ("UNDECIDED", []))
        self.assertTrue(result["too_noisy"])

    def test_pictures_that_differ_by_noise_raise_no_alarm(self):
        # Tiles may raise one in 1e-4 of the pairs; 10 fixed pairs.
        for seed in range(10):
            a, b = self.picture("a", 100 + seed), self.picture("b", 500 + seed)
            self.assertFalse(judge.judge(os.path.join(BIN, "assay"), a, b, .005, self.folder)["shown"], seed)


FAULTS = {
    "roughness": lambda m: m["pbrMetallicRoughness"].update(roughnessFactor=m["pbrMetallicRoughness"]["roughnessFactor"] * 1.25),
    "specular": lambda m: m["extras"].update(disney_specular=m["extras"]["disney_specular"] * .7),
    "colour": lambda m: m["pbrMetallicRoughness"].update(
        baseColorFactor=[c * k for c, k in zip(m["pbrMetallicRoughness"]["baseColorFactor"], (1, 1, 1.1, 1))]),
}


class Agreement(Folder):
    names = ("specular",)

    def test_the_script_end_to_end(self):
        out = self.at("end to end")
        code, printed, errors = run(self.at("specular.blend"), "--out", out, "--size", "48x32", "--depth", "4", "--spp", "512", "--json")
        self.assertEqual((code, errors), (0, ""), printed + errors)
        result = json.loads(printed)
        self.assertEqual(result["verdict"], "AGREES")
        self.assertEqual((result["width"], result["height"], len(result["tiles"])), (48, 32, 24))
        self.assertEqual(sorted(os.listdir(out)), ["assay.exr", "blender.exr", "index.html", "result.json"])
        with open(os.path.join(out, "index.html"), encoding="utf-8") as file:
            page = file.read()
        self.assertIn("AGREES", page)
        self.assertGreaterEqual(page.count("data:image/png;base64,"), 6)
        self.assertNotIn("http", page)

    def test_a_planted_fault_in_assays_scene_differs(self):
        scene, _ = self.blend("specular")
        quiet = compare.Progress(True)
        reference = compare.render_blender(scene, 512, 0, quiet)
        original = scene.scene
        document = gltf.Gltf(original)
        for name, fault in FAULTS.items():
            with self.subTest(name):
                changed = copy.deepcopy(document.json)
                for material in changed["materials"]:
                    if material["name"] in ("gold", "plastic"):
                        fault(material)
                scene.scene = self.at("fault.glb")
                gltf.write_glb(scene.scene, changed, document.bin_chunk)
                test = compare.render_assay(os.path.join(BIN, "assay-render"), scene, 512, 0, 4, int(THREADS))
                result = judge.judge(os.path.join(BIN, "assay"), reference, test, .005, self.folder)
                self.assertEqual((result["verdict"], result["shown"]), ("DIFFERS", True))
        scene.scene = original
        test = compare.render_assay(os.path.join(BIN, "assay-render"), scene, 512, 0, 4, int(THREADS))
        result = judge.judge(os.path.join(BIN, "assay"), reference, test, .005, self.folder)
        self.assertEqual(result["verdict"], "AGREES", result["reasons"] + result["too_noisy"])


class Scenes(Folder):
    names = ("geometry", "not_carried", "lamps", "sky_picture", "sheen", "alpha", "anisotropic")

    def glb(self, name):
        scene, notes = self.blend(name)
        return gltf.Gltf(scene.scene), notes

    def test_flattening_does_not_change_blenders_picture(self):
        scene, notes = self.blend("geometry")
        self.assertEqual((notes["lost"], notes["changed"]), ([], []))
        prepared = compare.render_blender(scene, 256, 0, compare.Progress(True))
        plain = self.at("plain.py")
        with open(plain, "w") as file:
            file.write(PLAIN.format(here=HERE, blend=self.at("geometry.blend"), out=self.at("plain")))
        subprocess.run([BLENDER, "-b", "--factory-startup", "--python-exit-code", "1", "-P", plain], check=True, capture_output=True)
        parts = [suite.read_exr(self.at(f"plain.{seed}.exr"))[0][..., :3] for seed in range(8)]
        mean, variance = suite.merge(parts)
        there = judge.read(prepared)
        shown = [t for t in judge.tiles(mean, variance, 8, there[0], there[1], 8, .005) if t["shown"]]
        self.assertEqual(shown, [])
        self.assertLess(abs(there[0].mean() / mean.mean() - 1), .003)

    def test_glass_and_procedural_textures_are_named(self):
        _, notes = self.glb("not_carried")
        for wanted in ("'marble': Base Color is linked to Noise Texture", "'marble': Normal is linked to Bump", "'glass': transmission"):
            self.assertTrue(any(wanted in line for line in notes["lost"]), notes["lost"])

    def test_lamps_are_made_alike_and_named(self):
        scene, notes = self.glb("lamps")
        for wanted in ("'spot': radius 0.1 m", "'spot': its cone", "'sun': angle 2.86°", "'area': its area"):
            self.assertTrue(any(wanted in line for line in notes["changed"]), notes["changed"])
        self.assertEqual(sorted(light["kind"] for light in scene.lights()), ["directional", "spot"])
        panel = next(m for m in scene.list("materials") if m["name"] == "area")
        self.assertFalse(panel["doubleSided"])
        # 60 W over a disk one metre wide: P / (4 A).
        radiance = max(panel["emissiveFactor"]) * panel["extensions"]["KHR_materials_emissive_strength"]["emissiveStrength"]
        self.assertAlmostEqual(radiance, 60 / (4 * np.pi / 4), delta=1e-3)

    def test_a_studio_light_becomes_the_environment_with_its_turn(self):
        scene, notes = self.glb("sky_picture")
        environment = scene.environment()
        self.assertAlmostEqual(environment["rotation"], -1.0, places=5)
        self.assertTrue(any("'sunset.exr' that are no radiance" in line for line in notes["changed"]), notes["changed"])
        pixels = suite.read_exr(environment["file"])[0]
        self.assertGreaterEqual(pixels.min(), 0)
        self.assertGreater(pixels.max(), 1000)  # floats, not a display's picture

    def test_sockets_become_disney_extras(self):
        scene, _ = self.glb("sheen")
        extras = next(m for m in scene.list("materials") if m["name"] == "velvet")["extras"]
        self.assertEqual({k: extras["disney_" + k] for k in ("sheen", "sheen_tint", "specular", "clearcoat", "anisotropic")},
                         {"sheen": 1.0, "sheen_tint": .8, "specular": .1, "clearcoat": 0.0, "anisotropic": 0.0})

    def test_alpha_blends_and_both_sides_show(self):
        scene, _ = self.glb("alpha")
        thin = next(m for m in scene.list("materials") if m["name"] == "thin")
        self.assertEqual((thin["alphaMode"], thin["doubleSided"]), ("BLEND", True))
        self.assertAlmostEqual(thin["pbrMetallicRoughness"]["baseColorFactor"][3], .4, places=6)

    def test_tangents_of_unlinked_anisotropy_run_round_the_axis(self):
        scene, _ = self.glb("anisotropic")
        for mesh in scene.list("meshes"):
            primitive = mesh["primitives"][0]
            if scene.list("materials")[primitive["material"]]["name"] not in ("turned", "across"):
                continue
            points, tangents = (scene.accessor(primitive["attributes"][key]) for key in ("POSITION", "TANGENT"))
            off_axis = np.hypot(points[:, 0], points[:, 2]) > 1e-3
            radius = points[off_axis] * [1, 0, 1]
            self.assertLess(np.abs((radius * tangents[off_axis, :3]).sum(axis=1)).max(), 1e-4)
            # Counter-clockwise seen from above: y of r x t is positive.
            self.assertGreater(np.cross(radius, tangents[off_axis, :3])[:, 1].min(), 0)


PLAIN = """
import bpy, sys, json
sys.path[:0] = [{here!r}, {here!r} + "/.."]
open({out!r} + ".json", "w").write(json.dumps(dict(threads=1, jobs=[])))
sys.argv = ["", "--", {out!r} + ".json"]
import render_in_blender
bpy.ops.wm.open_mainfile(filepath={blend!r}, load_ui=False)
render_in_blender.make_exact(bpy.context.scene, dict(spp=32, depth=4, width=48, height=32))
for seed in range(8):
    bpy.context.scene.cycles.seed = 50 + seed
    bpy.context.scene.render.filepath = {out!r} + "." + str(seed) + ".exr"
    bpy.ops.render.render(write_still=True)
"""


class BadInput(Folder):
    names = ("empty", "no_camera", "dark", "alpha")

    def refused(self, wanted, *arguments):
        code, printed, errors = run(*arguments, "--out", self.at("bad"))
        self.assertEqual((code, printed), (2, ""), errors)
        self.assertEqual(errors.count("\n"), 1, errors)
        self.assertIn(wanted, errors)
        self.assertFalse(os.path.exists(self.at("bad", "result.json")))

    def test_a_missing_file(self):
        self.refused("wanted a .blend, .glb or .gltf file, found none", self.at("nowhere.blend"))

    def test_bytes_that_are_no_blend(self):
        with open(self.at("text.blend"), "w") as file:
            file.write("not a .blend")
        self.refused("text.blend: wanted a .blend (or .glb, .gltf) file, found other bytes", self.at("text.blend"))

    def test_a_blend_that_breaks_off(self):
        with open(self.at("alpha.blend"), "rb") as file, open(self.at("half.blend"), "wb") as half:
            half.write(file.read(2000))
        self.refused("half.blend", self.at("half.blend"))

    def test_bytes_that_are_no_glb(self):
        with open(self.at("text.glb"), "w") as file:
            file.write("no")
        self.refused("text.glb: wanted glTF 2.0 JSON", self.at("text.glb"))

    def test_no_camera(self):
        self.refused("no_camera.blend: wanted a camera, found none active", self.at("no_camera.blend"))

    def test_a_camera_that_is_not_there(self):
        self.refused("alpha.blend: camera: wanted one of camera, found side", self.at("alpha.blend"), "--camera", "side")

    def test_an_empty_scene(self):
        self.refused("empty.blend: wanted something to see, found no mesh", self.at("empty.blend"))

    def test_no_light(self):
        self.refused("dark.blend: wanted a lamp, a shining surface or a world that is not black, found none", self.at("dark.blend"))

    def test_options(self):
        self.refused("wanted WIDTHxHEIGHT", self.at("alpha.blend"), "--size", "12")
        self.refused("wanted a whole number of at least 16", self.at("alpha.blend"), "--spp", "3")
        self.refused("wanted more than 0 and less than 1", self.at("alpha.blend"), "--margin", "7")


if __name__ == "__main__":
    BLENDER = shutil.which(BLENDER) or BLENDER
    os.environ["PATH"] = "/usr/bin:" + os.environ.get("PATH", "")  # see compare.py
    if shutil.which(BLENDER) is None or not os.access(os.path.join(BIN, "assay"), os.X_OK):
        print(f"no {BLENDER} found, or no assay in {BIN}")
        sys.exit(77)
    unittest.main(verbosity=2)
