#!/usr/bin/python3
"""What the suite exposes in Blender 3.4.1, measured: each line by a render of its own against a closed form or quadrature.

  exposures.py [NAME...]     print what is measured (all of them: about a minute and a half)
  exposures.py coat_in_float --pictures docs/images    also write blender_*.png there

Exit codes: 0 every exposure is still there, 1 one is not (another Blender?), 2 could not run.
"""

import argparse
import math
import os
import shutil
import subprocess
import sys
import tempfile

sys.dont_write_bytecode = True
HERE = os.path.dirname(os.path.abspath(__file__))
ROOT = os.path.dirname(os.path.dirname(os.path.dirname(HERE)))
sys.path[:0] = [os.path.join(os.path.dirname(HERE), "soup"), os.path.join(os.path.dirname(HERE), "tests")]

import numpy as np  # noqa: E402
import OpenImageIO as oiio  # noqa: E402

import principled_model as model  # noqa: E402
import soup  # noqa: E402

NOTHING = {"base_color": [0, 0, 0], "metallic": 0, "roughness": .5, "specular": 0, "specular_tint": 0, "anisotropic": 0,
           "anisotropic_rotation": 0, "sheen": 0, "sheen_tint": 0, "clearcoat": 0, "clearcoat_roughness": .03}


def at(degrees, azimuth=0.):
    t, p = math.radians(degrees), math.radians(azimuth)
    return np.array([math.sin(t) * math.cos(p), math.sin(t) * math.sin(p), math.cos(t)])


def hemisphere(n=2000):
    """Directions and their weights: the midpoint rule in cosine and azimuth."""
    z, phi = np.meshgrid((np.arange(n) + .5) / n, 2 * np.pi * (np.arange(n // 2) + .5) / (n // 2))
    r = np.sqrt(1 - z * z)
    return np.stack([r * np.cos(phi), r * np.sin(phi), z], -1).reshape(-1, 3), 2 * np.pi / z.size


def reflectance(parameters, v, seen=None):
    """The integral of BRDF times cosine over the hemisphere, or over its part where `seen` faces."""
    directions, weight = hemisphere()
    values = model.eval_cos(dict(NOTHING, **parameters), directions, np.broadcast_to(v, directions.shape))[:, 0]
    return (values if seen is None else values[directions @ seen >= 0]).sum() * weight


def visible_normals(roughness, v):
    """Half vectors, the mirror directions of v at them, and the density of GGX's visible normals times the weight of the
    midpoint rule."""
    h, weight = hemisphere()
    a2, vh = roughness ** 4, np.maximum(h @ v, 0)
    density = model.smith(v[2], a2) * vh / v[2] * a2 / (np.pi * (1 + (a2 - 1) * h[:, 2] ** 2) ** 2)
    return vh, 2 * vh[:, None] * h - v, density * weight


def coat_as_sampled(roughness, v):
    """What a lone coat comes out as if h is drawn by GGX visible normals and its density is reported as GTR1's: the mean
    of F G1(l) / 4 over the visible normals."""
    vh, l, density = visible_normals(roughness, v)
    up = (l[:, 2] > 0) & (vh > 0)
    fresnel = model.fresnel(np.array([.04]), vh, 1.5)[:, 0]
    return (.25 * fresnel * model.smith(np.where(up, l[:, 2], 1), .0625) * density)[up].sum()


def metal_as_sampled(roughness, v, smooth):
    """What a white metal comes out as if its visible normals' mirror directions are kept wherever the smooth normal faces
    them, though the shading normal may not: the mean of G1(|n.l|) over these."""
    vh, l, density = visible_normals(roughness, v)
    kept = (l @ smooth > 0) & (vh > 0)
    return (model.smith(l[:, 2], roughness ** 4) * density)[kept].sum()


class Exposures:
    """Each method: what was measured, as (text, value, what it should be, whether the fault is still seen)."""

    def __init__(self, folder):
        self.folder = folder

    def pixels(self, exposure, key):
        image = oiio.ImageInput.open(os.path.join(self.folder, f"{exposure}.{key}.exr"))
        if image is None:
            raise soup.Failure(f"Blender made no picture {exposure}.{key}")
        return image.read_image(0, 0, 0, 3, oiio.FLOAT).reshape(image.spec().height, -1, 3)

    def mean(self, exposure, key):
        return float(self.pixels(exposure, key)[..., 0].mean(dtype=np.float64))

    def clearcoat(self):
        """The coat's directions are drawn by one density and weighted with another."""
        for roughness, angle in ((.3, 30), (.3, 75), (1, 75)):
            measured = self.mean("clearcoat", f"furnace {roughness} {angle}")
            coat = {"clearcoat": 1, "clearcoat_roughness": min(roughness, .9999)}
            truth, biased = reflectance(coat, at(angle)), coat_as_sampled(roughness, at(angle))
            yield (f"coat of roughness {roughness} in a white furnace, seen at {angle} degrees (the formula of the mistake: "
                   f"{biased:.5f})", measured, truth, abs(measured / biased - 1) < .005 and abs(measured / truth - 1) > .05)
        # The lamp's disk: radius 1, 2 m along the mirror direction, radiance P / (4 pi r^2).
        r, phi = np.meshgrid(np.sqrt((np.arange(1000) + .5) / 1000), 2 * np.pi * (np.arange(500) + .5) / 500)
        centre, across = at(30, 180), np.array([0., 1, 0])
        along = np.cross(across, centre)
        points = (2 * centre + (r * np.cos(phi))[..., None] * across + (r * np.sin(phi))[..., None] * along).reshape(-1, 3)
        distance = np.linalg.norm(points, axis=-1)
        l = points / distance[:, None]
        f = model.eval_cos(dict(NOTHING, clearcoat=1, clearcoat_roughness=.2), l, np.broadcast_to(at(30), l.shape))[:, 0]
        truth = float((40 / (4 * np.pi) * f * (l @ centre) / distance ** 2).mean() * np.pi)
        for key, wrong in (("with", True), ("without", False)):
            measured = self.mean("clearcoat", f"lamp {key}")
            yield (f"coat of roughness 0.2 under a disk lamp, multiple importance sampling {'on' if wrong else 'off'}", measured,
                   truth, (abs(measured / truth - 1) > .5) == wrong and (wrong or abs(measured / truth - 1) < .005))

    def coat_in_float(self):
        """Near its peak a smooth coat is a quotient of rounding errors."""
        # Rows: roughness .018 to .035; columns: angle of the half vector, 0 to 3 alphas.
        size = 256
        y, x = np.divmod(np.arange(size * size), size)
        roughness = np.float32(.018 + .017 * y / (size - 1)).astype(np.float64)
        light = at(40, 30)
        half = soup.unit(np.array([0., 0, 1]) + light)
        across = soup.unit(np.cross(half, [.3, 1., .2]))
        normals = soup.unit(half + across * (3 * roughness ** 2 * x / (size - 1))[:, None])
        block = {name: np.zeros(size * size) for name in soup.NUMBERS}
        block.update(clearcoat=np.ones(size * size), clearcoat_roughness=roughness, base=np.zeros((size * size, 3)), light=light,
                     vertices=soup.triangles(normals, size), tangent=np.ones((size * size, 3)) * (1, 0, .5), normal=normals,
                     linked_normal=np.zeros(size * size), subset=np.zeros(size * size))
        _, pixels, names = soup.render([block], size, self.program)
        channel = {name: pixels[..., i].astype(np.float64) for i, name in enumerate(names)}
        n, l = (soup.unit(np.stack([channel[f"{w}.{c}"] for c in "XYZ"], -1)) for w in ("normal", "wi"))
        h = soup.unit(l + np.array([0., 0, 1]))
        sin2, a2 = (np.cross(n, h) ** 2).sum(-1), roughness.reshape(size, size) ** 4
        nl, nv = (n * l).sum(-1), n[..., 2]
        d = (a2 - 1) / (np.pi * np.log(a2) * (sin2 + a2 * (1 - sin2)))
        fresnel = model.fresnel(np.full(1, .04), np.array([float(h[0, 0] @ l[0, 0])]), 1.5)[0, 0]
        truth = .25 * fresnel * d * model.smith(nl, .0625) * model.smith(nv, .0625) / (4 * nv)
        self.coat_ratio = channel["R"] / truth
        low = roughness.reshape(size, size) < .03
        yield ("coat of roughness .018 to .03, half vector within 3 alpha: largest value over the right one",
               self.coat_ratio[low].max(), 1, self.coat_ratio[low].max() > 3)
        yield "  smallest value over the right one (light is negative)", self.coat_ratio[low].min(), 1, self.coat_ratio.min() < 0
        wrong = float((np.abs(self.coat_ratio[low] - 1) > .5).mean())
        yield "  share of these that are wrong by more than a half", wrong, 0, wrong > .01
        right = ~low & (np.abs(self.coat_ratio - 1) > .5)
        yield "  the same from .03 to .035", float(right.sum() / (~low).sum()), 0, True

    def normal_incidence(self):
        """G1 of an anisotropic lobe is 0/0 for a direction along the normal."""
        for anisotropic, wrong in ((.8, True), (0, False)):
            ratio = self.mean("normal_incidence", f"along {anisotropic}") / self.mean("normal_incidence", f"beside {anisotropic}")
            yield (f"metal of anisotropy {anisotropic} seen along its normal over a thousandth of a degree beside", ratio, 1,
                   abs(ratio - (2 if wrong else 1)) < .001)

    def lamps(self):
        """Units that Blender 4 has changed (area, spot) or kept (point)."""
        area = self.mean("lamps", "area") * 2
        yield "area lamp: radiance x area / power; Blender 4: 1/pi", area, 1 / math.pi, abs(area - .25) < 1e-5
        for kind in ("point", "spot"):
            falloff = self.mean("lamps", f"{kind} 40") / self.mean("lamps", f"{kind} 0") / math.cos(math.radians(40)) ** 3
            below = self.mean("lamps", f"{kind} 0") * math.pi
            yield (f"{kind} lamp of 4 pi W, irradiance 1 m below", below, 1, abs(below - 1) < 1e-5)
            yield (f"{kind} lamp: intensity 40 degrees off its axis (inside the cone) over that along it", falloff, 1,
                   abs(falloff - (math.cos(math.radians(40)) if kind == "spot" else 1)) < 1e-4)

    def emitters(self):
        """Light triangles are sampled by their solid angle, with an approximate arc cosine."""
        corners = np.array([(-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0)], float)
        for height in (.001, .003, .01, .03, .1):
            to = soup.unit(corners - np.array([1.5, 0, height]))
            following = np.roll(to, -1, axis=0)
            turns = soup.unit(np.cross(to, following)) * np.arccos(np.clip((to * following).sum(-1), -1, 1))[:, None]
            truth = abs(turns.sum(axis=0)[0]) / 2 / np.pi
            for key, triangles in (("large", 2), ("small", 512)):
                measured = self.mean("emitters", f"{key} {height}")
                off = abs(measured / truth - 1)
                yield (f"wall {height} m above the plane of a 2 x 2 m emitter of {triangles} triangles, .5 m beside it", measured,
                       truth, off > .004 if key == "large" else off < .002 or height < .01)

    def first_sample(self):
        """Sample 0 of every pixel and seed lies at the pixel's centre."""
        for spp in (1, 4):
            for offset in (0, spp):
                # Of eight columns four are black, three white, one is three quarters white.
                columns = np.array([8 * self.mean("first_sample", f"{spp} {offset} {seed}") - 3 for seed in range(1, 33)])
                mean, error = columns.mean(), columns.std(ddof=1) / math.sqrt(len(columns))
                expected = .75 if offset else .75 + .25 / spp
                yield (f"pixels that are three quarters white, {spp} samples from number {offset} on, 32 seeds (standard error "
                       f"{error:.4f})", mean, .75, abs(mean - expected) < .01 + 4 * error)

    def poles(self):
        """Environment maps repeat in v as well."""
        for key, text, seen in (("up", "straight up, at the pole", .5), ("quarter", "a quarter of a texel below it", .75),
                                ("centre", "the centre of the top row", 1)):
            measured = self.mean("poles", key)
            yield f"environment whose top row is 1 and all others 0: {text}", measured, 1, abs(measured - seen) < 1e-3
        measured = self.mean("poles", "down")
        yield "  straight down, in the black", measured, 0, abs(measured - .5) < 1e-3

    def normal_map(self):
        """Directions drawn from a glossy lobe are kept below its own normal's horizon, where its evaluation is zero."""
        for tilt in (0, 20, 35):
            c, s = math.cos(math.radians(tilt)), math.sin(math.radians(tilt))
            v, smooth = at(10 + tilt), np.array([s, 0, c])  # in the frame of the shading normal
            truth = reflectance({"base_color": [1, 1, 1], "metallic": 1, "roughness": .6}, v, smooth if tilt else None)
            biased = metal_as_sampled(.6, v, smooth)
            what = f"white metal of roughness .6 in a furnace, normal tilted by {tilt} degrees"
            measured = self.mean("normal_map", f"bsdf {tilt}")
            yield (f"{what}, BSDF samples alone (the formula of the mistake: {biased:.5f})", measured, truth,
                   abs(measured / biased - 1) < .001 and (not tilt or abs(measured / truth - 1) > .003))
            measured = self.mean("normal_map", f"both {tilt}")
            yield f"{what}, light samples too", measured, truth, abs(measured / truth - 1) < .002


def png(path, pixels):
    """`pixels`: (height, width, 3), display-referred, 0 to 1."""
    output = oiio.ImageOutput.create(path)
    output.open(path, oiio.ImageSpec(pixels.shape[1], pixels.shape[0], 3, oiio.UINT8))
    output.write_image(np.rint(np.clip(pixels, 0, 1) * 255).astype(np.uint8))
    output.close()
    print(path)


def diverging(t):
    """-1 blue, 0 white, 1 red."""
    t = np.clip(t, -1, 1)[..., None]
    return np.where(t > 0, 1 - t * (1 - np.array([.8, .1, .05])), 1 + t * (1 - np.array([.05, .25, .75])))


def picture_of_coat(exposures, path):
    """log2 of Blender's over the right value, -2 (blue) to 2 (red); black where light is negative."""
    ratio = exposures.coat_ratio
    pixels = diverging(np.log2(np.maximum(ratio, 1e-9)) / 2)
    pixels[ratio <= 0] = 0
    png(path, pixels.repeat(2, 0).repeat(2, 1))


def picture_of_models(path):
    """For three scenes one below another: Blender's render, Assay's golden with the model `disney`, and how much brighter
    (red) or darker (blue) `disney` is, full colour at 20 % of the scene's brightest tenth."""
    strips = []
    for name in ("specular", "clearcoat", "sheen"):
        files = (os.path.join(ROOT, "reference/blender/renders", f"principled_{name}.exr"),
                 os.path.join(ROOT, "regression/goldens", f"disney_{name}.exr"))
        blender, disney = map(rgb, files)
        scale = np.quantile(blender, .9)
        shown = [np.clip(image / scale * .7, 0, 1) ** (1 / 2.2) for image in (blender, disney)]
        strips.append(np.concatenate([*shown, diverging((disney - blender).mean(-1) / scale / .2)], 1).repeat(3, 0).repeat(3, 1))
    width = max(strip.shape[1] for strip in strips)
    png(path, np.concatenate([np.pad(strip, ((0, 6), (0, width - strip.shape[1]), (0, 0)), constant_values=1) for strip in strips]))


def rgb(path):
    pixels, names, _ = soup.read(path)
    return pixels[..., [names.index(c) for c in "RGB"]].astype(np.float64)


NAMES = ("clearcoat", "coat_in_float", "normal_incidence", "lamps", "emitters", "first_sample", "poles", "normal_map")


def run(names, program, folder):
    command = shutil.which(program)
    if command is None:
        raise soup.Failure(f"no {program} found: install Blender 3.4 (apt-get install blender python3-numpy), or name it with --blender")
    version = subprocess.run([command, "--version"], capture_output=True, text=True).stdout.split()[1]
    scenes = [name for name in names if name != "coat_in_float"]
    if scenes:
        subprocess.run([command, "-b", "--factory-startup", "-P", os.path.join(HERE, "scenes_in_blender.py"), "--", folder, *scenes],
                       stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, env=dict(os.environ, PYTHONDONTWRITEBYTECODE="1"))
    exposures, gone = Exposures(folder), []
    exposures.program = program
    print(f"Blender {version}\n\n| what is looked at | Blender | right | |\n|---|---|---|---|")
    for name in names:
        for text, value, truth, seen in getattr(exposures, name)():
            off = f"{100 * (value / truth - 1):+.2f} %".replace("-0.00", "+0.00") if truth and abs(value / truth) < 100 else ""
            print(f"| {text} | {value:.5g} | {truth:.5g} | {off if seen else 'GONE ' + off} |", flush=True)
            gone += [] if seen else [text]
    for text in gone:
        print(f"exposures.py: no longer so: {text}", file=sys.stderr)
    return exposures, 1 if gone else 0


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("names", nargs="*", metavar="NAME", help=", ".join(NAMES))
    parser.add_argument("--pictures", metavar="DIR")
    parser.add_argument("--blender", default=os.environ.get("ASSAY_BLENDER", "blender"), metavar="PROGRAM")
    arguments = parser.parse_args()
    for name in arguments.names:
        if name not in NAMES:
            parser.error(f"wanted one of {', '.join(NAMES)}, found {name}")
    try:
        with tempfile.TemporaryDirectory() as folder:
            exposures, status = run(arguments.names or NAMES, arguments.blender, folder)
        if arguments.pictures and hasattr(exposures, "coat_ratio"):
            picture_of_coat(exposures, os.path.join(arguments.pictures, "blender_coat_in_float.png"))
        if arguments.pictures:
            picture_of_models(os.path.join(arguments.pictures, "blender_and_disney.png"))
    except soup.Failure as error:
        print(f"exposures.py: {error}", file=sys.stderr)
        return 2
    return status


if __name__ == "__main__":
    sys.exit(main())
