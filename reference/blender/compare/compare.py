#!/usr/bin/python3
"""Compare your own scene, rendered by Blender (Cycles) and by Assay.

  scripts/compare-blend my.blend        what Blender shows of the file, against what Assay shows of its export
  scripts/compare-blend my.glb          the same glTF file in both

Both render the same triangles, lamps, camera and size with every approximation of Cycles switched off (shader
`principled` of assay-render, which is Blender 3.4's Principled BSDF term by term). What glTF cannot say is either made
alike in both pictures (a lamp's radius becomes 0, an area lamp a shining surface) or stays in Blender's picture only
(glass, subsurface, procedural textures); each is named. A .blend is not changed, and its scripts are not run.

The verdict is AGREES if the mean of each channel agrees within --margin, errors included, FLIP shows no more than the
noise does, and no tile of the picture stands out; DIFFERS, with the reasons, if one of these is shown not to hold; UNDECIDED
if it is only too noisy to tell.
"""

EPILOG = """
Written to --out: index.html (the comparison: look at this), result.json (its numbers), blender.exr and assay.exr
(linear, with variances). With --keep also scene.glb and prepared.blend, the scene as both saw it, to look into:
  scripts/compare-blend OUT/scene.glb             does a difference stay when Blender reads the export, too?
  build/bin/assay-render OUT/scene.glb --info     what Assay made of it

Exit codes: 0 agrees, 1 differs or undecided, 2 could not run (one line says why).

Examples
  scripts/compare-blend my.blend
  scripts/compare-blend my.blend --camera Closeup --frame 12 --size 640x360 --spp 2048
  scripts/compare-blend my.glb --margin 0.2% --out /tmp/comparison --keep
"""

import argparse
import json
import os
import shlex
import shutil
import signal
import subprocess
import sys
import tempfile
import time

sys.dont_write_bytecode = True
HERE = os.path.dirname(os.path.abspath(__file__))
sys.path[:0] = [HERE, os.path.dirname(HERE)]

import numpy as np  # noqa: E402

import gltf  # noqa: E402
import judge  # noqa: E402
import materials  # noqa: E402
import page  # noqa: E402
import suite  # noqa: E402
import witness  # noqa: E402
from notes import Failure, Notes  # noqa: E402

REPLICATES = 8
LONGEST = 320
SPP, MORE = 512, 4


class Progress:
    def __init__(self, quiet):
        self.quiet, self.start = quiet, time.time()

    def __call__(self, text):
        if not self.quiet:
            print(f"{time.time() - self.start:6.1f} s  {text}", file=sys.stderr, flush=True)


def run_inside(blender, job, on_answer=lambda answer: None):
    """One step of inside.py; its answers put together."""
    handle, path = tempfile.mkstemp(suffix=".json")
    with os.fdopen(handle, "w") as file:
        json.dump(job, file)
    command = [blender.command, "-b", "--factory-startup", "-P", os.path.join(HERE, "inside.py"), "--", path]
    answers, last = {}, []
    try:
        with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, errors="replace",
                              env=dict(os.environ, PYTHONDONTWRITEBYTECODE="1")) as process:
            try:
                for line in process.stdout:
                    if line.startswith("compare: "):
                        answer = json.loads(line[9:])
                        answers.update(answer)
                        on_answer(answer)
                    else:
                        last = (last + [line.rstrip()])[-40:]
            except BaseException:  # stopped: Blender must not go on alone
                process.kill()
                raise
    finally:
        os.remove(path)
    if "error" in answers:
        raise Failure(answers["error"] if job.get("blend", "") in answers["error"] else f"{job['blend']}: {answers['error']}")
    if not answers.get("done"):
        why = next((line for line in reversed(last) if "rror" in line), last[-1] if last else "no output")
        raise Failure(f"{job.get('blend', job['out'])}: Blender ended with exit code {process.returncode}: {why}")
    return answers


class Blend:
    """A .blend file: prepared once, then rendered as often as needed."""

    def __init__(self, arguments, blender, out):
        self.blender, self.out, self.arguments = blender, out, arguments
        with open(arguments.scene, "rb") as file:
            head = file.read(7)
        if head != b"BLENDER" and head[:2] != b"\x1f\x8b" and head[:4] != b"\x28\xb5\x2f\xfd":
            raise Failure(f"{arguments.scene}: wanted a .blend (or .glb, .gltf) file, found other bytes")

    def prepare(self):
        width, height = self.arguments.size or (None, None)
        answer = run_inside(self.blender, {
            "step": "prepare", "blend": os.path.abspath(self.arguments.scene), "out": self.out, "longest": LONGEST,
            "width": width, "height": height, "camera": self.arguments.camera, "frame": self.arguments.frame,
            "depth": self.arguments.depth})
        self.scene, self.camera = os.path.join(self.out, "scene.glb"), 0
        self.width, self.height, self.hide_environment = answer["width"], answer["height"], answer["hide_environment"]
        return answer["notes"]

    def render(self, spp, seeds, progress):
        def on_answer(answer):
            if "rendered" in answer:
                progress(f"Blender: seed {seeds.index(answer['rendered']) + 1} of {len(seeds)}, {spp} samples per pixel")
        run_inside(self.blender, {"step": "render", "blend": self.arguments.scene, "out": self.out, "spp": spp, "seeds": seeds,
                                  "depth": self.arguments.depth, "threads": self.blender.threads}, on_answer)


class Glb:
    """A glTF file: Blender reads it by the witness's own scripts."""

    def __init__(self, arguments, blender, out):
        self.blender, self.out, self.arguments = blender, out, arguments
        self.scene, self.hide_environment = arguments.scene, False

    def prepare(self):
        notes, scene = Notes(), gltf.Gltf(self.scene)
        if self.arguments.frame is not None:
            raise Failure(f"{self.scene}: --frame: wanted a .blend, found a glTF file: only its base pose is read")
        self.camera = self._camera(scene)
        aspect = scene.cameras()[self.camera][0].get("perspective", {}).get("aspectRatio", 16 / 9)
        self.width, self.height = self.arguments.size or (
            (LONGEST, max(1, round(LONGEST / aspect))) if aspect >= 1 else (max(1, round(LONGEST * aspect)), LONGEST))
        for index, material in enumerate(scene.list("materials")):
            made = materials.read_material(scene, index)
            if made["clearcoat"] > 0:
                notes.know(f"material '{made['name']}': clearcoat; Blender 3.4.1 gets it wrong wherever a bounced ray finds the light")
        self._quantise(notes)
        return notes.json()

    def _camera(self, scene):
        nodes = [node for node, _ in scene.nodes() if "camera" in node]
        if not nodes:
            raise Failure(f"{self.scene}: wanted a camera, found none")
        wanted = self.arguments.camera
        if wanted is None:
            return 0
        names = [node.get("name", scene.list("cameras")[node["camera"]].get("name", "")) for node in nodes]
        if wanted.isdigit() and int(wanted) < len(nodes):
            return int(wanted)
        if wanted not in names:
            raise Failure(f"{self.scene}: camera: wanted one of {', '.join(map(repr, names))}, found {wanted}")
        return names.index(wanted)

    def _quantise(self, notes):
        """Blender's importer keeps normals in 16 bits: both see those, where it can be done."""
        if not self.scene.endswith(".glb") or any("uri" in buffer for buffer in gltf.Gltf(self.scene).list("buffers")):
            return
        beside = os.path.join(self.out, "scene.glb")
        environment = gltf.Gltf(self.scene).environment()
        command = ["/usr/bin/python3", os.path.join(os.path.dirname(HERE), "quantise_normals.py"), self.scene, beside]
        ran = subprocess.run(command, capture_output=True, text=True, env=dict(os.environ, ASSAY_BLENDER=self.blender.command))
        if ran.returncode:
            notes.lose("normals: Blender's importer rounds them to 16 bits, and splits some; Assay has the file's own")
            return
        if environment and "file" in environment:
            shutil.copyfile(environment["file"], os.path.join(self.out, os.path.basename(environment["file"])))
        notes.change("normals: rounded in both as Blender's importer does")
        self.scene = beside

    def render(self, spp, seeds, progress):
        job = {"name": "scene", "scene": self.scene, "width": self.width, "height": self.height, "camera": self.camera,
               "depth": self.arguments.depth, "spp": spp, "seeds": seeds, "hide_environment": False, "punctual_units": "auto",
               "out": os.path.join(self.out, "blender")}
        progress(f"Blender: {len(seeds)} seeds of {spp} samples per pixel")
        with tempfile.TemporaryDirectory() as folder:
            for _, error, _ in self.blender.render([job], folder):
                if error:
                    raise Failure(error)


def render_blender(scene, spp, look, progress):
    seeds = list(range(1 + 100 * look, 1 + 100 * look + REPLICATES))
    scene.render(max(1, spp // REPLICATES), seeds, progress)
    files = [os.path.join(scene.out, f"blender.{seed}.exr") for seed in seeds]
    mean, variance = suite.merge([suite.read_exr(path)[0][..., :3] for path in files])
    for path in files:
        os.remove(path)
    out = os.path.join(scene.out, "blender.exr")
    if not np.isfinite(mean).all():
        raise Failure(f"{out}: wanted finite pixels from Blender, found some that are not")
    suite.write_witness(out, mean, variance, {"assay:witness": scene.blender.name, "assay:replicates": REPLICATES,
                                              "assay:spp": max(1, spp // REPLICATES) * REPLICATES})
    return out


def render_assay(program, scene, spp, look, depth, threads):
    out = os.path.join(scene.out, "assay.exr")
    command = [program, scene.scene, "-o", out, "--shader", "principled", "--width", str(scene.width), "--height",
               str(scene.height), "--spp", str(max(1, spp // REPLICATES) * REPLICATES), "--replicates", str(REPLICATES), "--depth", str(depth),
               "--seed", str(1 + look), "--camera", str(scene.camera), "--layers", "replicates", "--threads", str(threads), "--quiet"]
    ran = subprocess.run(command + (["--hide-environment"] if scene.hide_environment else []), capture_output=True, text=True)
    if ran.returncode:
        raise Failure((ran.stderr.strip() or f"assay-render: exit code {ran.returncode}").splitlines()[-1])
    return out


def share(text):
    """.005 or 0.5%."""
    value = float(text[:-1]) / 100 if text.endswith("%") else float(text)
    if not 0 < value < 1:
        raise argparse.ArgumentTypeError(f"wanted more than 0 and less than 1 (or 0.5%), found {text}")
    return value


def size(text):
    parts = text.lower().split("x")
    if len(parts) != 2 or not all(p.isdigit() and 0 < int(p) <= 16384 for p in parts):
        raise argparse.ArgumentTypeError(f"wanted WIDTHxHEIGHT such as 320x180, found {text}")
    return int(parts[0]), int(parts[1])


def count(least):
    def parse(text):
        if not text.isdigit() or int(text) < least:
            raise argparse.ArgumentTypeError(f"wanted a whole number of at least {least}, found {text}")
        return int(text)
    return parse


def arguments_of(argv):
    parser = argparse.ArgumentParser(prog="compare-blend", description=__doc__, epilog=EPILOG,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.error = lambda message: fail(f"{message} (--help says more)")
    parser.add_argument("scene", metavar="SCENE", help=".blend, .glb or .gltf")
    parser.add_argument("--out", metavar="DIR", help="folder of the comparison (build/compare/NAME)")
    parser.add_argument("--size", type=size, metavar="WxH", help=f"pixels (the scene's shape, {LONGEST} along its longer side)")
    parser.add_argument("--spp", type=count(2 * REPLICATES), metavar="N",
                        help=f"samples per pixel of each picture; left out: {SPP}, and {MORE} times that if noise alone is in the way")
    parser.add_argument("--depth", type=count(1), default=8, metavar="N", help="scattering events; 1 is direct light (8)")
    parser.add_argument("--camera", metavar="NAME", help="a camera of the file (the active one; of a glTF file the first)")
    parser.add_argument("--frame", type=int, metavar="N", help="of a .blend's animation (the one it was saved at)")
    parser.add_argument("--margin", type=share, default=.005, metavar="SHARE", help="largest bias of a channel's mean (0.5%%)")
    parser.add_argument("--keep", action="store_true", help="keep the scene as both saw it")
    parser.add_argument("--json", action="store_true", help="print result.json instead of a summary")
    parser.add_argument("--quiet", action="store_true", help="no progress")
    parser.add_argument("--threads", type=count(1), default=os.cpu_count(), metavar="N")
    parser.add_argument("--blender", default=os.environ.get("ASSAY_BLENDER", "blender"), metavar="PROGRAM")
    parser.add_argument("--bin", default=os.path.join(suite.ROOT, "build", "bin"), metavar="DIR", help="where assay and assay-render are")
    return parser.parse_args(argv)


def fail(message):
    print(f"compare-blend: {message}", file=sys.stderr)
    sys.exit(2)


def compare(arguments, progress):
    """The result, written to its folder."""
    if not os.path.isfile(arguments.scene):
        raise Failure(f"{arguments.scene}: wanted a .blend, .glb or .gltf file, found none")
    programs = [os.path.join(arguments.bin, name) for name in ("assay", "assay-render")]
    for program in programs:
        if not os.access(program, os.X_OK):
            raise Failure(f"{program}: wanted the program, found none (scripts/setup builds it)")
    name = os.path.splitext(os.path.basename(arguments.scene))[0]
    out = os.path.abspath(arguments.out or os.path.join(suite.ROOT, "build", "compare", name))
    os.makedirs(out, exist_ok=True)
    blender = witness.Blender(arguments.blender, arguments.threads)
    # Debian's Blender takes the modules of the first python3 in PATH: with a virtual environment's it would find no numpy.
    os.environ["PATH"] = "/usr/bin:" + os.environ.get("PATH", "")
    kind = Glb if arguments.scene.lower().endswith((".glb", ".gltf")) else Blend
    scene = kind(arguments, blender, out)
    progress(f"{arguments.scene}: reading it in {blender.name}")
    notes = scene.prepare()
    spp = arguments.spp or SPP
    for look in range(1 if arguments.spp else 2):
        reference = render_blender(scene, spp, look, progress)
        progress(f"Assay: {spp} samples per pixel")
        test = render_assay(programs[1], scene, spp, look, arguments.depth, arguments.threads)
        result = judge.judge(programs[0], reference, test, arguments.margin, out)
        if result["shown"] or not result["too_noisy"]:
            break
        if not arguments.spp and look == 0:
            spp *= MORE
            progress(f"too noisy to tell ({result['too_noisy'][0]}): again with {spp} samples per pixel")
    result.update(scene=os.path.basename(arguments.scene), blender=blender.version, width=scene.width, height=scene.height, spp=spp,
                  depth=arguments.depth, notes=notes, page=os.path.join(out, "index.html"))
    write(arguments, result, reference, test, out)
    return result


def write(arguments, result, reference, test, out):
    with open(os.path.join(out, "result.json"), "w") as file:
        json.dump(result, file, indent=1)
        file.write("\n")
    facts = [("size", f"{result['width']} × {result['height']}"), ("samples per pixel", f"{result['spp']} in {REPLICATES} independent parts"),
             ("scattering events", result["depth"]), ("Blender", result["blender"])]
    command = ["scripts/compare-blend " + " ".join(shlex.quote(word) for word in sys.argv[1:])]
    page.write(result["page"], result["scene"], result, result["notes"], reference, test, facts, command)
    kept = ("index.html", "result.json", "blender.exr", "assay.exr", *(("scene.glb", "prepared.blend") if arguments.keep else ()))
    for name in ("scene.glb", "prepared.blend", "prepared.blend1", "flip.exr", "environment.exr", "environment.hdr"):
        path = os.path.join(out, name)
        if name not in kept and os.path.exists(path) and not (arguments.keep and name.startswith("environment")) and \
                os.path.realpath(path) != os.path.realpath(arguments.scene):
            os.remove(path)


def summary(result):
    lines = [f"{result['verdict']}: {result['scene']}, Assay against Blender {result['blender']}, margin {100 * result['margin']:.3g} %"]
    for name, d in result["bias"].items():
        lines.append(f"  {name:<10} {page.percent(d['relative'])}  [{page.percent(d['low'])}, {page.percent(d['high'])}]")
    flip = result["flip"]
    if flip["mean"] is not None:
        lines.append(f"  FLIP {flip['mean']:.4f} (noise alone {flip['noise_alone']:.4f}, limit {flip['limit']:.4f}), RMSE {result['rmse']:.3g}")
    lines += [f"  differs: {text}" for text in result["reasons"]]
    lines += [f"  too noisy to tell: {text}; try --spp {4 * result['spp']}" for text in result["too_noisy"]]
    for kind, heading in (("lost", "not carried over"), ("changed", "made alike"), ("known", "known")):
        lines += [f"  {heading}: {text}" for text in result["notes"][kind]]
    return "\n".join(lines + [f"  {result['page']}"])


def main(argv):
    arguments = arguments_of(argv)
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    try:
        result = compare(arguments, Progress(arguments.quiet))
    except (Failure, suite.CaseError, gltf.GltfError, OSError) as error:
        fail(error)
    except KeyboardInterrupt:
        fail("stopped")
    print(json.dumps(result, indent=1) if arguments.json else summary(result))
    return 0 if result["verdict"] == "AGREES" else 1


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
