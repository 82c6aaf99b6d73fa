#!/usr/bin/python3
"""Does POV-Ray, driven by our scripts, say what it should? The real program against closed forms and numpy.

Run by ctest (label povray). Without povray what needs it is skipped, and says so; `witness_test.py Files` does not.
"""

import hashlib
import math
import os
import subprocess
import sys
import tempfile
import unittest
import unittest.mock

import numpy as np

sys.dont_write_bytecode = True
sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))

import brdf  # noqa: E402
import brdf_numpy  # noqa: E402
import disney_sdl  # noqa: E402
import exr  # noqa: E402
import pov  # noqa: E402
import witness  # noqa: E402
from bench import DOWN, Builder, camera_rays, glowing, lambert, mirror, square, tangle, trace  # noqa: E402

needs_povray = unittest.skipUnless(pov.program(), "povray is not installed")
LSB = 1 / pov.FULL


class Temporary(unittest.TestCase):
    def setUp(self):
        holder = tempfile.TemporaryDirectory()
        self.addCleanup(holder.cleanup)
        self.folder = holder.name


@needs_povray
class FirstHit(Temporary):
    def test_positions_are_those_of_ray_triangle_arithmetic_for_both_kinds_of_camera(self):
        for orthographic in (False, True):
            scene = tangle(self.folder, orthographic)
            hit, expected, _ = trace(scene, *camera_rays(scene, 48, 32))
            found, coverage = witness.position(scene, 48, 32)
            self.assertGreater(hit.mean(), 0.1)
            self.assertLess((hit != coverage).sum(), 4)  # rays that graze an edge
            both = hit & coverage
            self.assertLess(np.abs(found - expected)[both].max() / scene.size, 1e-6)

    def test_normals_are_interpolated_transformed_and_turned_to_the_eye(self):
        scene = tangle(self.folder)
        hit, _, expected = trace(scene, *camera_rays(scene, 48, 32))
        found, coverage = witness.normal(scene, 48, 32)
        # An interpolated normal that points away from the eye: POV-Ray turns it by itself, glTF by its triangle.
        plain = hit & coverage & ((expected * camera_rays(scene, 48, 32)[1]).sum(-1) < 0)
        self.assertGreater(plain.sum(), 0.98 * hit.sum() - 4)
        self.assertLess(np.abs(found - expected)[plain].max(), 1e-4)

    def test_a_single_sided_triangle_lets_rays_through_from_behind(self):
        scene = tangle(self.folder)
        _, culled, _ = trace(scene, *camera_rays(scene, 48, 32))
        _, kept, _ = trace(scene, *camera_rays(scene, 48, 32), cull=False)
        self.assertGreater((np.abs(culled - kept).max(-1) > 1e-3).mean(), 0.02, "the scene does not show culling")


@needs_povray
class Light(Temporary):
    def pixels(self, builder, quantity="direct", size=(16, 16), depth=1):
        return witness.radiance(builder.scene(self.folder), quantity, *size, depth)

    def centres(self, size, half):
        return np.meshgrid(*[half * ((2 * np.arange(size) + 1) / size - 1)] * 2)

    def test_a_lambert_plane_under_a_point_light_is_the_formula_to_16_bits(self):
        b = Builder()
        b.mesh(*square(2), lambert(), rotation=[0, 0.38268343, 0, 0.92387953])
        b.light("point", 30, translation=[0.3, 1.5, -0.2])
        b.orthographic(1, translation=[0, 3, 0], rotation=DOWN)
        found, variance = self.pixels(b)
        # The same sub-pixel rays, averaged the same way: what is left is POV-Ray's 16 bits.
        x, z = self.centres(16 * witness.GRID, 1)
        e = 30 * 1.5 / ((x - 0.3)**2 + 1.5**2 + (z + 0.2)**2)**1.5 / np.pi
        e = e.reshape(16, witness.GRID, 16, witness.GRID).mean((1, 3))
        expected = e[..., None] * np.array([0.8, 0.4 * 0.5, 0.2 * 0.25])
        self.assertLess(np.abs(found - expected).max() / expected.max(), LSB)
        self.assertLess(variance.max(), (0.001 * expected.max())**2)

    def test_a_directional_light_is_irradiance_on_a_plane_facing_it(self):
        b = Builder()
        b.mesh(*square(2), lambert())
        b.light("directional", 2, rotation=[math.sin(-0.5), 0, 0, math.cos(-0.5)])  # -z turned down by 1 rad
        b.orthographic(1, translation=[0, 3, 0], rotation=DOWN)
        found, _ = self.pixels(b)
        expected = 2 * math.sin(1) / np.pi * np.array([0.8, 0.2, 0.05])
        self.assertLess(np.abs(found - expected).max() / expected.max(), 2 * LSB)

    def test_a_shadow_covers_what_the_light_does_not_see(self):
        b = Builder()
        b.mesh(*square(2), lambert((1, 1, 1)))
        b.mesh(*square(0.25, 1.0), lambert((1, 1, 1)))
        b.light("point", 10, translation=[0, 2, 0])
        b.orthographic(1, translation=[0, 0.9, 0], rotation=DOWN)  # from below the occluder
        found, _ = self.pixels(b)
        dark = found[..., 0] == 0
        self.assertEqual(dark.sum(), 64)  # half the width, exactly on pixel borders
        self.assertTrue(dark[4:12, 4:12].all())

    def test_contact_shadows_reach_the_foot_of_a_tiny_scene(self):
        b = Builder()
        s = 1e-3  # a millimetre: POV-Ray by itself ignores occluders nearer than 0.001
        b.mesh(*square(2 * s), lambert((1, 1, 1)))
        b.mesh([(0, 0, -2 * s), (0, 0, 2 * s), (0, s, 2 * s), (0, s, -2 * s)], [(0, 1, 2), (0, 2, 3)], lambert())
        b.light("directional", 1, rotation=[-0.5, -0.5, 0, math.sqrt(0.5)])  # along (1, -1, 0)
        b.orthographic(s / 50, translation=[0, 3 * s, 0], rotation=DOWN)  # the foot alone
        found, _ = self.pixels(b)
        self.assertGreater(found[:, :8].min(), 0)
        self.assertEqual(found[:, 8:].max(), 0)

    def test_a_texture_is_decoded_and_its_first_row_lies_at_v_0(self):
        b = Builder()
        texels = np.array([[[255, 0, 0], [0, 255, 0]], [[0, 0, 255], [188, 188, 188]]], np.uint8)
        path = os.path.join(self.folder, "t.png")
        out = pov.oiio.ImageOutput.create(path)
        out.open(path, pov.oiio.ImageSpec(2, 2, 3, pov.oiio.UINT8))
        out.write_image(texels)
        out.close()
        with open(path, "rb") as file:
            b.image(file.read())
        material = lambert((1, 1, 1))
        material["pbrMetallicRoughness"]["baseColorTexture"] = {"index": 0}
        positions, triangles = square(1)
        b.mesh(positions, triangles, material, texcoords=[(0, 1), (1, 1), (1, 0), (0, 0)])
        b.light("directional", np.pi, rotation=DOWN)
        b.orthographic(1, translation=[0, 3, 0], rotation=DOWN)
        found, _ = self.pixels(b)
        linear = np.where(texels <= 10, texels / 255 / 12.92, ((texels / 255 + 0.055) / 1.055)**2.4)
        x = 2 * (np.arange(16 * witness.GRID) + 0.5) / (16 * witness.GRID) - 0.5  # in texels from the first one's centre
        i, t = np.floor(x).astype(int), (x % 1)[:, None]
        rows = linear[i % 2] * (1 - t[..., None]) + linear[(i + 1) % 2] * t[..., None]
        fine = rows[:, i % 2] * (1 - t) + rows[:, (i + 1) % 2] * t
        expected = fine.reshape(16, witness.GRID, 16, witness.GRID, 3).mean((1, 3)) * (1, 0.5, 0.25)
        self.assertLess(np.abs(found - expected).max(), 2 * LSB)

    def test_a_mirror_shows_what_stands_behind_it_and_only_if_depth_allows(self):
        b = Builder()
        b.mesh(*square(2), mirror())
        b.mesh([(-0.5, 0.5, -1), (0.5, 0.5, -1), (0.5, 1.5, -1), (-0.5, 1.5, -1)], [(0, 1, 2), (0, 2, 3)], glowing((0.9, 0.6, 0.3)))
        quaternion = [math.sin(-0.25), 0, 0, math.cos(-0.25)]
        b.perspective(0.9, translation=[0, 1, 1.5], rotation=quaternion)
        scene = b.scene(self.folder)
        origins, directions = camera_rays(scene, 32, 32)
        hit, position, normal = trace(scene, origins, directions)
        on_mirror = hit & (np.abs(position[..., 1]) < 1e-6)
        reflected = directions * (1, -1, 1)
        second, position2, _ = trace(scene, position, reflected)
        expected = (hit & ~on_mirror) | (on_mirror & second)
        self.assertGreater((on_mirror & second).sum(), 20)
        for depth, shown in ((1, expected), (0, hit & ~on_mirror)):
            with unittest.mock.patch.object(witness, "GRID", 1):  # one ray per pixel, through its centre
                picture, _ = witness.radiance(scene, "mirror", 32, 32, depth)
            self.assertLess(((picture[..., 0] > 0) != shown).sum(), 3)
            self.assertLess(np.abs(picture[picture[..., 0] > 0] - (0.9, 0.6, 0.3)).max(), 2 * LSB)

    def test_what_the_witness_cannot_do_is_refused_in_one_line(self):
        b = Builder()
        b.mesh(*square(2), dict(lambert(), extras={"disney_specular": 0.5}, name="gloss"))
        b.light("point", 1)
        b.orthographic(1, translation=[0, 3, 0], rotation=DOWN)
        with self.assertRaisesRegex(pov.Failure, "'gloss': wanted Lambert"):
            self.pixels(b)


@needs_povray
class Brdf(unittest.TestCase):
    def test_every_configuration_is_what_numpy_computes_in_double(self):
        size, entries = brdf.listing()
        for entry in entries:
            with self.subTest(entry["name"]):
                expected = brdf_numpy.evaluate(entry["model"], disney_sdl.complete(entry["parameters"]), entry["light"],
                                               size, entry["lobe"])
                stored, _, _ = exr.read(brdf.path_of(entry, witness.RENDERS))
                self.assertLess(np.abs(stored - expected).max() / expected.max(), 1e-7)

    def test_a_lobe_that_is_wrong_by_a_thousandth_is_seen(self):
        p = disney_sdl.complete({"roughness": 0.4, "metallic": 1.0})
        povs = brdf.evaluate("disney", p, (0.5, 0.4, 0.8), 33, "specular")
        wrong = brdf_numpy.evaluate("disney", dict(p, roughness=0.4004), (0.5, 0.4, 0.8), 33, "specular")
        self.assertGreater(np.abs(povs - wrong).max() / wrong.max(), 1e-4)

    def test_unknown_parameters_are_refused(self):
        with self.assertRaisesRegex(pov.Failure, "unknown parameter 'rougness'"):
            brdf.parse(["rougness=1"])


@needs_povray
class Card(Temporary):
    """The quantity brdf: a card of quads with a sphere's normals."""

    def card(self, lean=0.0):
        size, positions, normals, triangles = 8, [], [], []
        for j in range(2, 6):
            for i in range(2, 6):
                x, y, h = (2 * i + 1) / size - 1, 1 - (2 * j + 1) / size, 1 / size
                first = len(positions)
                positions += [(x - h, y - h, 0), (x + h, y - h, 0), (x + h, y + h, 0), (x - h, y + h, 0)]
                normals += [(x, y + lean, math.sqrt(1 - x * x - (y + lean)**2))] * 4
                triangles += [(first, first + 1, first + 2), (first, first + 2, first + 3)]
        b = Builder()
        b.mesh(positions, triangles, {"pbrMetallicRoughness": {"metallicFactor": 1, "roughnessFactor": 0.4}}, normals)
        b.light("directional", 3, rotation=[0, 0.2, 0, math.sqrt(0.96)])
        b.orthographic(1, translation=[0, 0, 2])
        return b.scene(self.folder)

    case = {"name": "card", "shader": "disney", "size": [8, 8]}

    def test_a_card_is_the_brdf_of_its_normals_times_the_light(self):
        pixels, hit = witness.card(self.card(), self.case)
        light = (2 * 0.2 * math.sqrt(0.96), 0, 1 - 2 * 0.04)
        expected = brdf_numpy.evaluate("disney", disney_sdl.complete({"base": (1, 1, 1), "metallic": 1, "roughness": 0.4}), light, 8)
        self.assertEqual(hit.sum(), 16)
        self.assertLess(np.abs(pixels - 3 * expected * (1, 0.5, 0.25))[hit].max() / expected.max(), 1e-7)
        self.assertEqual(np.abs(pixels[~hit]).max(), 0)

    def test_normals_that_are_not_the_spheres_are_refused(self):
        with self.assertRaisesRegex(pov.Failure, "the normals of a sphere"):
            witness.card(self.card(0.001), self.case)

    def test_a_flat_triangle_with_oblique_normals_which_povray_would_forget_is_refused_elsewhere(self):
        with self.assertRaisesRegex(pov.Failure, "32 triangles with one oblique normal"):
            witness.normal(self.card(), 8, 8)


@needs_povray
class Stored(Temporary):
    """The pictures in renders/ are today's, and POV-Ray still says the same, bit for bit."""

    def test_no_stored_render_is_stale(self):
        self.assertEqual([(c["name"], q, why) for c, q, _, why in witness.pending(witness.load([]), witness.RENDERS)], [])
        self.assertEqual([(entry["name"], why) for entry, why in brdf.stale(witness.RENDERS)], [])

    def test_povray_still_makes_the_stored_renders_of_cases(self):
        for case in witness.load([]):
            for quantity in witness.quantities(case):
                path = os.path.join(self.folder, "now.exr")
                witness.make(case, quantity, path)
                now, stored = exr.read(path), exr.read(witness.path_of(case, quantity, witness.RENDERS))
                self.assertTrue(np.array_equal(now[0], stored[0]), (case["name"], quantity))

    def test_povray_still_makes_the_stored_brdfs(self):
        size, entries = brdf.listing()
        for entry in entries[::7]:
            now = brdf.evaluate(entry["model"], entry["parameters"], entry["light"], size, entry["lobe"])
            self.assertTrue(np.array_equal(np.float32(now), exr.read(brdf.path_of(entry, witness.RENDERS))[0]), entry["name"])


class Files(Temporary):
    def test_hashes_are_those_of_the_documented_bytes(self):
        case = {"name": "x", "why": "é", "scene": "s.glb", "shader": "path", "size": [4, 2], "spp": 8, "seed": 1, "depth": 3,
                "options": {"d-gamma": 1, "d-constant": 0.005}}
        text = '{"camera":0,"depth":3,"options":{"d-constant":0.005,"d-gamma":1},"scene_hash":"abc","shader":"path","size":[4,2]}'
        self.assertEqual(exr.picture_hash(case, "abc"), hashlib.sha256(text.encode()).hexdigest())
        digest = hashlib.sha256()
        for name in sorted(os.listdir(brdf.HERE)):
            if name.endswith(".py"):
                with open(os.path.join(brdf.HERE, name), "rb") as file:
                    digest.update(file.read())
        self.assertEqual(exr.script_hash(), digest.hexdigest())

    def test_a_file_comes_back_with_its_channels_and_header(self):
        pixels = np.float32(np.random.default_rng(1).uniform(0, 9, (3, 5, 3)))
        path = os.path.join(self.folder, "x.exr")
        exr.write(path, pixels, {"assay:witness": "POV-Ray 3.7", "assay:spp": 256}, variance=pixels * 1e-9, coverage=pixels[..., 0] > 4)
        read, names, header = exr.read(path)
        channel = {name: read[..., i] for i, name in enumerate(names)}
        self.assertTrue(np.array_equal(channel["G"], pixels[..., 1]))
        self.assertTrue(np.array_equal(channel["A"], pixels[..., 0] > 4))
        self.assertLess(np.abs(channel["variance.B"] * header["assay:variance_scale"] / (pixels[..., 2] * 1e-9) - 1).max(), 1e-3)
        self.assertEqual((header["assay:witness"], header["assay:spp"]), ("POV-Ray 3.7", 256))

    def test_two_words_hold_a_value_to_a_billionth(self):
        values = np.random.default_rng(2).uniform(0, 0.9999, 1000)
        high, low = np.floor(values * pov.FULL) / pov.FULL, np.rint((values * pov.FULL % 1) * pov.FULL) / pov.FULL
        self.assertLess(np.abs(pov.join(high, low) - values).max(), 2e-10)

    def test_without_povray_the_witness_says_so_in_one_line_and_exits_2(self):
        ran = subprocess.run([sys.executable, os.path.join(brdf.HERE, "brdf.py"), "disney", "-o", os.path.join(self.folder, "x.exr")],
                             env=dict(os.environ, POVRAY="no-such-povray"), capture_output=True, text=True)
        self.assertEqual(ran.returncode, 2)
        self.assertEqual(ran.stderr.count("\n"), 1)
        self.assertIn("povray: not found", ran.stderr)

    def test_an_unknown_case_is_named_and_exits_2(self):
        ran = subprocess.run([sys.executable, os.path.join(brdf.HERE, "witness.py"), "no_such_case"], capture_output=True, text=True)
        self.assertEqual(ran.returncode, 2)
        self.assertIn("wanted a case named 'no_such_case'", ran.stderr)


if __name__ == "__main__":
    if not pov.program() and sys.argv[1:] != ["Files"]:
        print("povray is not installed: skipped")
        sys.exit(77)
    unittest.main()
