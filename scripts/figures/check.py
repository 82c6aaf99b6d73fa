"""Whether docs/disney.md is still true: its links, commands, plots, numbers and pictures."""

import json
import pathlib
import re
import subprocess
import sys
import tempfile

import page
import plots
import sweep
from page import ROOT

# What the captions of the 2018 report say, or where they are wrong, what the picture was made with.
PUBLISHED = {
    "figure_4": ("path", {}),
    "figure_5": ("path_disney", {"d-gamma": 1, "d-constant": 0.005}),
    "figure_6_caption": ("path_disney", {"d-gamma": 1, "d-constant": 0.03}),
    "figure_6": ("path_disney", {"d-gamma": 1, "d-constant": 0.3}),
    "figure_7": ("path_disney", {"d-gamma": 2, "d-constant": 0.005}),
    "gamma_1_auto": ("path_disney", {"d-gamma": 1, "d-constant": "auto"}),
    "gamma_2_auto": ("path_disney", {"d-gamma": 2, "d-constant": "auto"}),
}
CLAMP = 10  # of the report's program
MOST_BYTES = 3_000_000
# Mean over pixels and channels, linear, cut at 1. Figure 7 rendered small has 0.027 of noise, the others a few thousandths.
LARGEST_DIFFERENCE = 0.04


def run(command, **keys):
    return subprocess.run(command, cwd=ROOT, stdout=subprocess.PIPE, stderr=subprocess.PIPE, check=False, **keys)


def files():
    for path in (page.PAGE, page.README):
        for file in page.pictures(path) + page.links(path):
            if not file.exists():
                yield "%s: wanted %s, found no such file" % (path.relative_to(ROOT), file.relative_to(ROOT))
    for file, name in page.symbols(page.PAGE):
        if file.exists() and not re.search(r"\b%s\b" % name, file.read_text()):
            yield "docs/disney.md: wanted %s in %s, found nothing of that name" % (name, file.relative_to(ROOT))
    shown = set(page.pictures(page.PAGE) + page.pictures(page.README))
    stored = sorted(page.IMAGES.iterdir())
    for file in stored:
        if file not in shown:
            yield "%s: no page shows it" % file.relative_to(ROOT)
    made = {name + ".svg" for name in plots.PLOTS} | {name + ".jpg" for name in page.commands()}
    for name in sorted({file.name for file in stored} - made):
        yield "docs/images/disney/%s: no command of the page makes it" % name
    size = sum(file.stat().st_size for file in stored)
    if size > MOST_BYTES:
        yield "docs/images/disney: wanted at most %d bytes, found %d" % (MOST_BYTES, size)


def drawings(build):
    curves = plots.parse(run([str(build / "renderer" / "bsdf-curves")], text=True).stdout)
    for name, content in plots.files(curves).items():
        file = page.IMAGES / name
        if not file.is_file() or file.read_bytes() != content:
            yield "%s: not what the renderer's code gives; scripts/make-figures --plots" % file.relative_to(ROOT)
    if page.with_numbers(page.text(), curves) != page.text():
        yield "docs/disney.md: its numbers are not what the renderer's code gives; scripts/make-figures --plots"


def replaced(command, **options):
    """The command with the values of some options changed or added; out: another file."""
    words = list(command)
    for key, value in options.items():
        flag = "-o" if key == "out" else "--" + key
        if flag in words:
            words[words.index(flag) + 1] = str(value)
        else:
            words += [flag, str(value)]
    return words


def small(name, command, folder, width=188, height=80, spp=64):
    """Renders the picture small into an .exr, which knows no display gamma; with everything else as in the page."""
    out = folder / (name + ".exr")
    if "--gamma" in command:
        i = command.index("--gamma")
        command = command[:i] + command[i + 2:]
    done = run(replaced(command, out=out, width=width, height=height, spp=spp) + ["--quiet"], text=True)
    return out, done


def renders(folder, build):
    """Runs every command small: it parses, its header has the published settings, its picture is the stored one."""
    import OpenImageIO as oiio
    import numpy

    commands = page.commands()
    for name, content in sweep.files().items():
        (folder / name).write_bytes(content)
    for name in set(PUBLISHED) - set(commands):
        yield "docs/disney.md: wanted a command for %s, found none" % name
    pictures = {}
    for name, command in commands.items():
        report = name in PUBLISHED
        command = [str(build / "bin" / "assay-render")] + command[1:]
        if not report:
            command = [str(folder / "sweep.glb") if word.endswith("/sweep.glb") else word for word in command]
        size = {} if report else {"width": 110, "height": 11, "spp": 8}
        out, done = small(name, command, folder, **size)
        if done.returncode:
            yield "docs/disney.md: %s: %s" % (name, done.stderr.strip())
            continue
        file = oiio.ImageInput.open(str(out))
        header = {a.name: a.value for a in file.spec().extra_attribs}
        options = json.loads(header["assay:options"])
        if not report:
            if options["camera"] == 0 and name != next(iter(sweep.ROWS)):
                yield "docs/disney.md: %s: wanted its own camera, found the first" % name
            continue
        shader, published = PUBLISHED[name]
        if header["assay:shader"] != shader:
            yield "docs/disney.md: %s: wanted shader %s, found %s" % (name, shader, header["assay:shader"])
        for key, value in {**published, "clamp": CLAMP}.items():
            if options.get(key) != value:
                yield "docs/disney.md: %s: wanted %s %s, found %s" % (name, key, value, options.get(key))
        given = dict(zip(command, command[1:]))
        if (given.get("--width"), given.get("--height"), given.get("--gamma")) != ("1269", "540", "2.2"):
            yield "docs/disney.md: %s: wanted 1269 x 540 and gamma 2.2 as published" % name
        pixels = oiio.ImageBuf(str(out)).get_pixels(oiio.FLOAT)[:, :, :3]
        pictures[name] = numpy.clip(pixels, 0, 1)

    # Each small render resembles its own stored picture more than any other's.
    stored = {}
    for name in pictures:
        picture = oiio.ImageBuf(str(page.IMAGES / (name + ".jpg")))
        linear = oiio.ImageBufAlgo.pow(picture, 2.2)
        height, width = pictures[name].shape[:2]
        stored[name] = oiio.ImageBufAlgo.resize(linear, filtername="box", roi=oiio.ROI(0, width, 0, height)).get_pixels(
            oiio.FLOAT)[:, :, :3]
    for name, pixels in pictures.items():
        apart = {other: float(numpy.abs(pixels - picture).mean()) for other, picture in stored.items()}
        nearest = min(apart, key=apart.get)
        if nearest != name:
            yield "docs/images/disney/%s.jpg: looks less like its command's picture than %s.jpg" % (name, nearest)
        if apart[name] > LARGEST_DIFFERENCE:
            yield "docs/images/disney/%s.jpg: wanted at most %g mean difference from its command's picture, found %.4f" % (
                name, LARGEST_DIFFERENCE, apart[name])


def everything(build):
    """0: all is true; 1: printed what is not; 77: the pictures cannot be looked at here."""
    try:
        import OpenImageIO, numpy  # noqa: F401
    except ImportError as error:
        print("make-figures: %s; install python3-openimageio and python3-numpy" % error)
        return 77
    wrong = list(files()) + list(drawings(build))
    with tempfile.TemporaryDirectory() as folder:
        wrong += list(renders(pathlib.Path(folder), build))
    for line in wrong:
        print(line)
    return 1 if wrong else 0


def print_luminance(commands):
    """Linear Rec.709 luminance, mean over the picture, with the clamp and, where the sum converges, without it."""
    import OpenImageIO as oiio

    def mean(file):
        r, g, b = oiio.ImageBufAlgo.computePixelStats(oiio.ImageBuf(str(file))).avg[:3]
        return 0.2126 * r + 0.7152 * g + 0.0722 * b

    with tempfile.TemporaryDirectory() as folder:
        for name in PUBLISHED:
            out, done = small(name, commands[name], pathlib.Path(folder), 235, 100, 256)
            if done.returncode:
                sys.exit("make-figures: %s: %s" % (name, done.stderr.strip()))
            clamped = mean(out)
            free, _ = small(name, replaced(commands[name], clamp=0), pathlib.Path(folder), 235, 100, 256)
            print("%-18s clamp %d: %.4f   no clamp: %.4g" % (name, CLAMP, clamped, mean(free)), flush=True)
