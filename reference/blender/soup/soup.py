#!/usr/bin/python3
"""The triangle soup: Blender's Principled BSDF at thousands of (material, to the eye, to the light), without noise.

  soup.py                    remake soup.exr beside this file
  soup.py --check            render live and compare with soup.exr
  soup.py --judge PROGRAM    render live and let PROGRAM (build/reference/reference_blender_test) compare with Assay
  soup.py --seed N --size M  other materials and directions; with -o FILE or --judge, and then --seeds COUNT of them

An orthographic camera looks along -z at a grid of small triangles, one in each pixel, each with a normal and a material
of its own, under a delta sun: a pixel is one value of BRDF times cosine, with one sample. The pictures for several
angles between eye and sun stand one under another. Exit codes: 0 fine, 1 --check differs, 2 could not run.

soup.exr: `R G B` (radiance under irradiance 1), and of each pixel, as Cycles' shader saw them: `wo.*`, `wi.*`, `normal.*`,
`geometric.*` (0 where equal to normal), `tangent.*` (not unit, not orthogonal), `base.*`, the parameters by name
(multiples of 1/1024, so that half holds them), and `subset`, an index into SUBSETS. Header: `assay:witness`,
`assay:script_hash` (of *.py in this folder), `assay:subsets`, `assay:seed`.
"""

import argparse
import hashlib
import os
import shutil
import subprocess
import sys
import tempfile

import numpy as np
import OpenImageIO as oiio

HERE = os.path.dirname(os.path.abspath(__file__))
STORED = os.path.join(HERE, "soup.exr")
ANGLES = (0, 20, 60, 100, 140, 172)  # degrees between eye and sun, one block each
# Cycles has a kernel for each instruction set, and they round differently. From roughness .3 on, and away from grazing
# angles, that is seen as less than this of a pixel (measured with CYCLES_CPU_NO_AVX2=1).
SAME = 1e-4

# name: (share of a block in 64ths, how the parameters are drawn)
NUMBERS = ("metallic", "roughness", "specular", "specular_tint", "anisotropic", "anisotropic_rotation", "sheen", "sheen_tint",
           "clearcoat", "clearcoat_roughness")
OFF = dict.fromkeys(NUMBERS, 0)
ANY = (0, 1)
ROUGH, NARROW = (.3, 1), (.02, .3)
LAYERS = dict(metallic=ANY, specular=ANY, specular_tint=ANY, anisotropic=ANY, anisotropic_rotation=ANY, sheen=ANY,
              sheen_tint=ANY, clearcoat=ANY)
SUBSETS = {
    "diffuse": (4, dict(roughness=ANY)),
    "sheen": (3, dict(roughness=ANY, sheen=ANY)),
    "sheen tinted": (3, dict(roughness=ANY, sheen=ANY, sheen_tint=ANY)),
    "specular": (4, dict(roughness=ROUGH, specular=ANY)),
    "specular tinted": (4, dict(roughness=ROUGH, specular=ANY, specular_tint=ANY)),
    "metal": (4, dict(metallic=1, roughness=ROUGH, specular=ANY)),
    "metallic share": (4, dict(metallic=ANY, roughness=ROUGH, specular=ANY, specular_tint=ANY)),
    "anisotropic": (6, dict(metallic=1, roughness=ROUGH, specular=ANY, anisotropic=ANY, anisotropic_rotation=ANY)),
    "clearcoat": (4, dict(clearcoat=ANY, clearcoat_roughness=ROUGH)),
    "everything": (6, dict(LAYERS, roughness=ROUGH, clearcoat_roughness=ROUGH)),
    "everything, grazing": (4, dict(LAYERS, roughness=ROUGH, clearcoat_roughness=ROUGH)),
    "everything, linked normal": (4, dict(LAYERS, roughness=ROUGH, clearcoat_roughness=ROUGH)),
    "metal, narrow": (4, dict(metallic=1, roughness=NARROW, specular=ANY)),
    "anisotropic, narrow": (4, dict(metallic=1, roughness=NARROW, specular=ANY, anisotropic=ANY, anisotropic_rotation=ANY)),
    "clearcoat, narrow": (3, dict(clearcoat=ANY, clearcoat_roughness=NARROW)),
    "everything, narrow": (2, dict(LAYERS, roughness=NARROW, clearcoat_roughness=NARROW)),
    "mirror threshold": (1, dict(metallic=1, roughness=(.015, .021), clearcoat=ANY, clearcoat_roughness=(.015, .021))),
}
BLACK = ("clearcoat", "clearcoat, narrow")  # subsets that show a lobe alone: no diffuse beneath it
WHITE = ("specular", "specular tinted")  # nor here, but the tint needs a hue: nearly black


class Failure(Exception):
    """One line for the user."""


def unit(v):
    return v / np.linalg.norm(v, axis=-1, keepdims=True)


def draw_parameters(random, subset, n):
    drawn = {}
    for name in NUMBERS:
        low, high = np.broadcast_to(SUBSETS[subset][1].get(name, 0), 2)
        # The ends of the range more often than chance would have them.
        u = np.clip(random.uniform(-.08, 1.08, n), 0, 1)
        drawn[name] = np.rint((low + (high - low) * u) * 1024) / 1024
    base = np.rint(random.uniform(0, 1, (n, 3)) * 1024) / 1024
    if subset in BLACK:
        base[:] = 0
    if subset in WHITE:
        base = np.rint(base * 8) / 1024
    return dict(drawn, base=base)


def around(random, axis, slope):
    """Unit vectors near `axis`, off by the given tangent in a random direction."""
    across = unit(np.cross(axis, random.normal(size=(len(slope), 3))))
    return unit(axis + across * slope[:, None])


def draw_normals(random, subset, parameters, light):
    """(normals, shading normals): half of them near the half vector, where narrow lobes are."""
    n = len(parameters["roughness"])
    eye = np.array([0., 0, 1])
    half = unit(eye + light)
    widths = np.where(random.random(n) < .5, parameters["roughness"], parameters["clearcoat_roughness"])
    alpha = np.maximum(.0003, np.where(widths > 0, widths, .5) ** 2)
    lowest = 1e-4 if "grazing" in subset else .02
    normals, shading, missing = np.zeros((n, 3)), np.zeros((n, 3)), np.arange(n)
    while len(missing):
        count = len(missing)
        near = around(random, half, alpha[missing] * np.tan(1.5 * random.random(count)))
        found = np.where((random.random(count) < .5)[:, None], near, unit(random.normal(size=(count, 3))))
        if "grazing" in subset:  # put it at a cosine of 1e-4 to 0.3 to the eye or the light
            to = np.where((random.random(count) < .5)[:, None], eye, light)
            across = unit(found - to * (found * to).sum(-1, keepdims=True))
            cosine = 10 ** random.uniform(-4, -.5, count)[:, None]
            found = to * cosine + across * np.sqrt(1 - cosine ** 2)
        tilted = found
        if "linked" in subset:
            found = around(random, found, random.uniform(0, 1, count))
            mirror = 2 * tilted * tilted[:, 2:] - eye
            # Where Cycles would bend the normal is not this witness's question.
            good = ((mirror * found).sum(-1) > .05) & (tilted[:, 2] > lowest) & (tilted @ light > lowest) & (found[:, 2] > .05)
        else:
            good = (found[:, 2] > lowest) & (found @ light > lowest)
        normals[missing[good]], shading[missing[good]] = found[good], tilted[good]
        missing = missing[~good]
    return normals, shading


def triangles(normals, size):
    """One around each pixel's centre, (n, 3, 3), within .25 pixels of it as seen and not too deep when seen from the side."""
    y, x = np.divmod(np.arange(size * size), size)
    centre = np.stack([x + .5 - size / 2, size / 2 - y - .5, np.zeros(size * size)], -1)
    across = np.cross([0., 0, 1], normals)
    short = np.linalg.norm(across, axis=-1) < 1e-6
    across[short] = (1, 0, 0)
    across = unit(across)
    along = np.cross(normals, across)
    reach = .25 / np.maximum(normals[:, 2:], .002)
    corners = [centre + .25 * np.cos(turn) * across + reach * np.sin(turn) * along for turn in 2 * np.pi / 3 * np.arange(3)]
    return np.stack(corners, 1).astype(np.float32)


def draw(seed, size):
    """The blocks: a list of dictionaries, as soup_in_blender.py wants them, with `subset` besides."""
    rows = np.repeat(np.arange(len(SUBSETS)), [share for share, _ in SUBSETS.values()])
    subset = rows[np.arange(size * size) * len(rows) // (size * size)]
    blocks = []
    for k, angle in enumerate(ANGLES):
        random = np.random.default_rng([seed, k])
        turn = random.uniform(0, 2 * np.pi)
        light = np.array([np.sin(np.radians(angle)) * np.cos(turn), np.sin(np.radians(angle)) * np.sin(turn), np.cos(np.radians(angle))])
        parts = []
        for index, name in enumerate(SUBSETS):
            parameters = draw_parameters(random, name, int((subset == index).sum()))
            normals, shading = draw_normals(random, name, parameters, light)
            parts.append(dict(parameters, geometry=normals, normal=shading))
        block = {name: np.concatenate([part[name] for part in parts]) for name in parts[0]}
        block["vertices"] = triangles(block.pop("geometry"), size)
        block["tangent"] = np.rint(random.uniform(-1, 1, (size * size, 3)) * 64) / 64
        block["linked_normal"] = np.char.find(np.array(list(SUBSETS)), "linked")[subset] >= 0
        blocks.append(dict(block, light=light, subset=subset))
    return blocks


def render(blocks, size, program):
    """(version, picture, channel names): the blocks one under another."""
    command = shutil.which(program)
    if command is None:
        raise Failure(f"no {program} found: install Blender 3.4 (apt-get install blender python3-numpy), or name it with --blender")
    version = subprocess.run([command, "--version"], capture_output=True, text=True).stdout.split()[1]
    with tempfile.TemporaryDirectory() as folder:
        arrays = {f"k{k}.{name}": values for k, block in enumerate(blocks) for name, values in block.items() if name != "subset"}
        np.savez(os.path.join(folder, "job.npz"), size=size, **arrays)
        ran = subprocess.run([command, "-b", "--factory-startup", "-P", os.path.join(HERE, "soup_in_blender.py"), "--", folder],
                             capture_output=True, text=True, errors="replace", env=dict(os.environ, PYTHONDONTWRITEBYTECODE="1"))
        suns = {int(words[1]): np.array(words[2:5], float) for words in map(str.split, ran.stdout.splitlines()) if words[:1] == ["sun:"]}
        pictures = []
        for k, block in enumerate(blocks):
            if not os.path.exists(os.path.join(folder, f"{k}.exr")):
                raise Failure(f"Blender: wanted {len(blocks)} pictures, found {k}: {(ran.stderr or ran.stdout).strip().splitlines()[-1]}")
            pictures.append(assemble(os.path.join(folder, f"{k}.exr"), suns[k], block, size))
    return version, np.concatenate([picture for picture, _ in pictures]), pictures[0][1]


def assemble(path, sun, block, size):
    """The stored channels of one block, and their names. Everything but `subset` and `wi` is what Cycles wrote."""
    image = oiio.ImageInput.open(path)
    names = image.spec().channelnames
    pixels = image.read_image(0, 0, 0, len(names), oiio.FLOAT)
    image.close()

    def layer(name):
        return np.stack([pixels[..., names.index(f"ViewLayer.{name}.{c}")] for c in "RGB"], -1)

    geometric, normal = layer("geometric"), layer("normal")
    geometric[(geometric == normal).all(-1)] = 0
    found = [(f"{channel}", layer("Combined")[..., i]) for i, channel in enumerate("RGB")]
    vectors = {"normal": normal, "geometric": geometric, "tangent": layer("tangent"), "wo": layer("incoming"),
               "wi": np.broadcast_to(sun.astype(np.float32), normal.shape), "base": layer("base")}
    found += [(f"{name}.{c}", values[..., i]) for name, values in vectors.items() for i, c in enumerate("XYZ")]
    for i, name in enumerate(NUMBERS):
        found.append((name, layer(f"numbers{i // 3 * 3}")[..., i % 3]))
        # Whatever Blender does to an attribute on the way, it must arrive.
        if not np.array_equal(found[-1][1].ravel(), block[name].astype(np.float32)):
            raise Failure(f"{name}: Cycles saw other values than the script gave, or a pixel missed its triangle")
    found.append(("subset", block["subset"].reshape(size, size)))
    return np.stack([values for _, values in found], -1).astype(np.float32), [name for name, _ in found]


def script_hash():
    digest = hashlib.sha256()
    for name in sorted(os.listdir(HERE)):
        if name.endswith(".py"):
            with open(os.path.join(HERE, name), "rb") as file:
                digest.update(file.read())
    return digest.hexdigest()


def write(path, pixels, names, header):
    spec = oiio.ImageSpec(pixels.shape[1], pixels.shape[0], len(names), oiio.FLOAT)
    spec.channelnames = names
    exact = ("R", "G", "B", "normal", "geometric", "wo", "wi")
    spec.channelformats = tuple(oiio.TypeDesc("float" if n.split(".")[0] in exact else "half") for n in names)
    spec.attribute("compression", "zip")
    for name, value in header.items():
        spec.attribute(name, value)
    output = oiio.ImageOutput.create(path)
    if output is None or not output.open(path, spec) or not output.write_image(pixels) or not output.close():
        raise Failure(f"{path}: cannot be written: {output.geterror() if output else oiio.geterror()}")


def read(path):
    image = oiio.ImageInput.open(path)
    if image is None:
        raise Failure(f"{path}: wanted an EXR, found: {oiio.geterror()}")
    spec = image.spec()
    pixels = image.read_image(0, 0, 0, spec.nchannels, oiio.FLOAT)
    image.close()
    return pixels, list(spec.channelnames), {a.name: a.value for a in spec.extra_attribs}


def check(version, live, names):
    """0 if the live picture is the stored one but for the machine's rounding, which narrow lobes amplify without bound."""
    stored, stored_names, header = read(STORED)
    stored = stored[..., [stored_names.index(name) for name in names]]
    narrow = [i for i, name in enumerate(SUBSETS) if "narrow" in name or "mirror" in name]
    wide = ~np.isin(live[..., names.index("subset")], narrow)
    difference = np.abs(live[..., :3] - stored[..., :3]).max(-1) / np.maximum(live[..., :3].max(-1), 1e-6)
    share, inputs = float((difference[wide] > SAME).mean()), np.abs(live[..., 3:] - stored[..., 3:]).max()
    print(f"{difference.size} configurations, live Blender {version} against stored {header['assay:witness']}: "
          + ("the same bits" if np.array_equal(live, stored) else
             f"{100 * share:.3g} % of the wide lobes differ by more than {SAME:g}, largest {difference[wide].max():.3g}"))
    return 1 if share > .001 or inputs > 1e-6 else 0


def judge(program, path):
    ran = subprocess.run([program, "--gtest_filter=Soup.*"], env=dict(os.environ, ASSAY_SOUP=path))
    return 1 if ran.returncode else 0


def run(arguments, seed):
    version, pixels, names = render(draw(seed, arguments.size), arguments.size, arguments.blender)
    header = {"assay:witness": f"Blender {version}", "assay:script_hash": script_hash(), "assay:subsets": ";".join(SUBSETS),
              "assay:seed": seed}
    status = check(version, pixels, names) if arguments.check else 0
    if arguments.judge:
        with tempfile.TemporaryDirectory() as folder:
            write(os.path.join(folder, "soup.exr"), pixels, names, header)
            status = max(status, judge(arguments.judge, os.path.join(folder, "soup.exr")))
    if arguments.o or not (arguments.check or arguments.judge):
        write(arguments.o or STORED, pixels, names, header)
        print(f"{arguments.o or STORED}: {pixels[..., 0].size} configurations")
    return status


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--check", action="store_true")
    parser.add_argument("--judge", metavar="PROGRAM")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--seeds", type=int, default=1, help="how many, one after another")
    parser.add_argument("--size", type=int, default=64, help="pixels each way of a block")
    parser.add_argument("-o", metavar="FILE", help="default: soup.exr beside this file, unless --check or --judge")
    parser.add_argument("--blender", default=os.environ.get("ASSAY_BLENDER", "blender"), metavar="PROGRAM")
    arguments = parser.parse_args()
    if arguments.check and (arguments.seed, arguments.seeds, arguments.size) != (1, 1, 64):
        parser.error("--check: the stored soup has seed 1 and size 64")
    try:
        if arguments.check and read(STORED)[2].get("assay:script_hash") != script_hash():
            print("soup.exr: stale: made by other scripts; remake it with reference/blender/soup/soup.py")
            return 1
        return max(run(arguments, seed) for seed in range(arguments.seed, arguments.seed + arguments.seeds))
    except Failure as error:
        print(f"soup.py: {error}", file=sys.stderr)
        return 2


if __name__ == "__main__":
    sys.exit(main())
