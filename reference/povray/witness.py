#!/usr/bin/python3
"""Makes the stored renders of the POV-Ray witness, reference/povray/renders/NAME.QUANTITY.exr.

    witness.py CASE...        render the named cases' povray witnesses
    witness.py --all-stale    render every stored picture that is missing or stale, those of brdf.json too
    witness.py --check        write nothing; exit 1 and name each missing or stale one

Positions and normals are those of the ray through each pixel's centre. Radiances are box-filtered: 16 x 16 rays per
pixel on a regular grid, averaged; `variance` is the spread of neighbouring rays, what the grid leaves undecided.
"""

import argparse
import json
import os
import sys
import time

import numpy as np

import brdf
import brdf_numpy
import disney_sdl
import exr
import pov
import scene_to_pov

HERE = os.path.dirname(os.path.abspath(__file__))
REGRESSION = os.path.join(os.path.dirname(os.path.dirname(HERE)), "regression")
RENDERS = os.path.join(HERE, "renders")
GRID = 16


def position(scene, width, height):
    functions, undo = scene.position_functions()
    pixels = pov.render_function(*functions, lambda texture: scene.one_texture(texture, width, height), width, height)
    hit = pixels.min(axis=2) > 0.005
    return np.where(hit[..., None], undo(pixels), 0), hit


def normal(scene, width, height):
    entries = " ".join(f"[1 slope {axis} color_map {{ [0 rgb 0] [1 rgb {c}] }}]"
                       for axis, c in (("x", "<3,0,0>"), ("y", "<0,3,0>"), ("z", "<0,0,3>")))
    texture = f"texture {{ pigment {{ average pigment_map {{ {entries} }} }} finish {{ ambient 0 diffuse 0 emission 1 }} }}\n"
    pixels = pov.render(scene.one_texture(texture, width, height), width, height)
    hit = pixels.max(axis=2) > 0
    vectors = np.cos(np.pi * (1 - pixels))
    return np.where(hit[..., None], vectors / np.linalg.norm(vectors, axis=2, keepdims=True), 0), hit


def radiance(scene, quantity, width, height, depth):
    """(pixels, variance): rendered at such an exposure that nothing reaches POV-Ray's clamp at 1."""
    def picture(size, exposure):
        sdl, files = scene.lit(quantity, width, height, exposure)
        levels = depth + 1 if quantity == "mirror" else 32
        # Rays are dropped by number alone, never because they count for little (adc_bailout).
        return pov.render(f"global_settings {{ max_trace_level {levels} adc_bailout 0 }}\n" + sdl,
                          size * width, size * height, files)

    exposure, top = 1.0, 1.0
    while not 0.01 < top < 1:  # a coarse picture finds the order of magnitude
        top = picture(2, exposure).max()
        exposure *= 2.0**-12 if top >= 1 else 2.0**6
        if not 1e-30 < exposure < 1e30:
            raise pov.Failure(f"{scene.path}: wanted some light, found a picture that is black or infinite")
    exposure *= 2.0**-6 * 0.8 / top
    fine = picture(GRID, exposure)
    while fine.max() >= 1:
        exposure /= 4
        fine = picture(GRID, exposure)
    fine /= exposure
    cells = fine.reshape(height, GRID, width, GRID, 3).transpose(0, 2, 1, 3, 4)
    # A ray stands for a cell 1/16 of a pixel wide. For a slope d between neighbours the cell's variance is d^2/12 per
    # axis, for an edge of height d somewhere in it d^2/6 on average.
    spread = ((np.diff(cells, axis=2)**2).sum((2, 3)) + (np.diff(cells, axis=3)**2).sum((2, 3))) / 6
    rounding = GRID**2 / 12 / (pov.FULL * exposure)**2
    return cells.mean((2, 3)), (spread + rounding) / GRID**4


def card(scene, case):
    """(pixels, hit): the BRDF of a scene that is a picture of a sphere's normals, one quad per pixel, facing an
    orthographic camera, under one directional light. No geometry enters but the normals, which are checked."""
    width, height = case["size"]
    materials = {m.material.where: m.material for m in scene.meshes}
    material, light = list(materials.values())[0], scene.lights[0] if scene.lights else None
    if (len(materials) > 1 or material.textured or material.emission.any() or scene.environment or width != height
            or scene.camera["type"] != "orthographic" or len(scene.lights) != 1 or light["kind"] != "directional"):
        raise pov.Failure(f"{scene.path}: wanted, for the quantity brdf, one plain material, one directional light and an "
                          "orthographic camera with a square image")
    # Into the camera's frame, which is brdf.py's: each triangle's normals are those of the pixel its centre lies in.
    eye = scene.camera_world[:3, :3]
    half = scene.camera["orthographic"]["ymag"]
    sphere, hit = brdf_numpy.sphere_normals(width)[0], position(scene, width, height)[1]
    for mesh in scene.meshes:
        centre = (mesh.world_positions[mesh.triangles].mean(1) - scene.camera_world[:3, 3]) @ eye / half
        i, j = ((centre[:, 0] + 1) / 2 * width).astype(int), ((1 - centre[:, 1]) / 2 * height).astype(int)
        if mesh.normals is None or ((i | j) < 0).any() or np.maximum(i, j).max() >= width or np.abs(
                mesh.normals[mesh.triangles] @ mesh.world[:3, :3].T @ eye - sphere[j, i][:, None]).max() > 1e-6:
            raise pov.Failure(f"{scene.path}: wanted, for the quantity brdf, the normals of a sphere that fills the image")
    options = case.get("options", {})
    constant = options.get("d-constant", "auto")
    parameters = disney_sdl.complete({**material.disney(), "d_gamma": options.get("d-gamma", 2.0),
                                      "d_constant": None if constant == "auto" else float(constant)})
    pixels = brdf.evaluate(case["shader"], parameters, eye.T @ light["matrix"][:3, 2], width)
    return np.where(hit[..., None], pixels * light["intensity"], 0), hit


def make(case, quantity, path):
    """Renders one witness of one case into `path`."""
    file = os.path.join(REGRESSION, "scenes", case["scene"])
    width, height = case["size"]
    units = case.get("options", {}).get("punctual-units", "auto")
    header = {"assay:witness": pov.version(), "assay:script_hash": exr.script_hash(),
              "assay:scene_hash": scene_hash(case), "assay:picture_hash": exr.picture_hash(case, scene_hash(case)),
              "assay:spp": 1, "assay:replicates": 1}
    scene = scene_to_pov.Scene(file, case.get("camera", 0), units)
    if quantity in ("position", "normal"):
        pixels, hit = (position if quantity == "position" else normal)(scene, width, height)
        header["assay:scene_size"] = scene.size
        exr.write(path, pixels, header, coverage=hit)
    elif quantity in ("direct", "mirror"):
        pixels, variance = radiance(scene, quantity, width, height, case["depth"])
        header["assay:spp"] = GRID**2
        exr.write(path, pixels, header, variance=variance)
    elif quantity == "brdf":
        pixels, hit = card(scene, case)
        exr.write(path, pixels, header, coverage=hit)
    else:
        raise pov.Failure(f"{case['name']}: unknown povray quantity '{quantity}'")


_scene_hashes = {}


def scene_hash(case):
    file = os.path.join(REGRESSION, "scenes", case["scene"])
    if file not in _scene_hashes:
        try:
            _scene_hashes[file] = scene_to_pov.gltf.scene_hash(file)
        except scene_to_pov.gltf.GltfError as error:
            raise pov.Failure(str(error)) from None
    return _scene_hashes[file]


def load(names):
    """The cases of that name, or all."""
    folder = os.path.join(REGRESSION, "cases")
    known = sorted(f[:-5] for f in os.listdir(folder) if f.endswith(".json") and f != "schema.json")
    for name in names:
        if name not in known:
            raise pov.Failure(f"{folder}: wanted a case named '{name}', found none")
    cases = []
    for name in names or known:
        with open(os.path.join(folder, name + ".json")) as file:
            try:
                cases.append(json.load(file))
            except ValueError as error:
                raise pov.Failure(f"{file.name}: not JSON: {error}") from None
    return cases


def stale(case, path):
    """Why the stored render is not today's, or None."""
    if not os.path.exists(path):
        return "missing"
    header = exr.read(path)[2]
    for key, now in (("assay:script_hash", exr.script_hash()), ("assay:scene_hash", scene_hash(case)),
                     ("assay:picture_hash", exr.picture_hash(case, scene_hash(case)))):
        if header.get(key) != now:
            return f"stale: {key[6:].replace('_', ' ')} differs"
    return None


def quantities(case):
    return list(dict.fromkeys(w["quantity"] for w in case.get("witnesses", []) if w["kind"] == "povray"))


def path_of(case, quantity, out):
    return os.path.join(out, f"{case['name']}.{quantity}.exr")


def pending(cases, out, all_of_them=False):
    """(case, quantity, path, why) of each witness to render."""
    work = []
    for case in cases:
        for quantity in quantities(case):
            path = path_of(case, quantity, out)
            why = "asked for" if all_of_them else stale(case, path)
            if why:
                work.append((case, quantity, path, why))
    return work


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("cases", nargs="*", metavar="CASE")
    parser.add_argument("--all-stale", action="store_true", help="render what is missing or stale")
    parser.add_argument("--check", action="store_true", help="render nothing; exit 1 if anything is missing or stale")
    parser.add_argument("--out", default=RENDERS, metavar="DIR")
    arguments = parser.parse_args()
    if not (arguments.cases or arguments.all_stale or arguments.check):
        parser.error("wanted case names, --all-stale or --check")

    cases = load(arguments.cases)
    for case in cases:
        if arguments.cases and not quantities(case):
            raise pov.Failure(f"{case['name']}: wanted a case with a povray witness, found none in it")
    work = pending(cases, arguments.out, bool(arguments.cases) and not (arguments.check or arguments.all_stale))
    lobes = brdf.stale(arguments.out) if not arguments.cases else []
    if arguments.check:
        for path, why in [(w[2], w[3]) for w in work] + [(brdf.path_of(entry, arguments.out), why) for entry, why in lobes]:
            print(f"{path}: {why}")
        print(f"povray: {len(work) + len(lobes)} renders to remake")
        return 1 if work or lobes else 0
    if work:
        os.makedirs(arguments.out, exist_ok=True)
        pov.version()
    failed = 0
    for number, (case, quantity, path, why) in enumerate(work, 1):
        start = time.monotonic()
        try:
            make(case, quantity, path)
            print(f"[{number}/{len(work)}] {case['name']}.{quantity}: {time.monotonic() - start:.1f} s ({why})", flush=True)
        except pov.Failure as failure:
            failed += 1
            print(f"[{number}/{len(work)}] {case['name']}.{quantity}: FAILED: {failure}", file=sys.stderr, flush=True)
    if lobes:
        brdf.remake([entry for entry, _ in lobes], arguments.out)
    print(f"povray: {len(work) - failed + len(lobes)} renders made" + (f", {failed} failed" if failed else ""))
    return 2 if failed else 0


if __name__ == "__main__":
    try:
        sys.exit(main())
    except pov.Failure as failure:
        print(failure, file=sys.stderr)
        sys.exit(2)
