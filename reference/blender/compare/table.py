#!/usr/bin/python3
"""Compare the example scenes and Blender's own files, and write the table of docs/compare-blend.md.

    reference/blender/compare/table.py [--update] [--out DIR] [--threads N] [NAME...]

Without --update the table is only printed; with NAMEs only their rows are made anew. Every page stays in DIR
(build/compare) to be looked at.
"""

import argparse
import json
import os
import subprocess
import sys
import tempfile

sys.dont_write_bytecode = True
HERE = os.path.dirname(os.path.abspath(__file__))
sys.path[:0] = [HERE, os.path.dirname(HERE)]

import suite  # noqa: E402

DOCS = os.path.join(suite.ROOT, "docs", "compare-blend.md")
BEGIN, END = "<!-- table.py begins -->", "<!-- table.py ends -->"
SCENES = ("diffuse", "specular", "sheen", "anisotropic", "brushed", "clearcoat_lamp", "clearcoat_sky", "glow", "textured", "alpha",
          "lamps", "sky_nodes", "geometry", "not_carried", *("studio_" + name for name in (
              "city", "courtyard", "forest", "interior", "night", "studio", "sunrise", "sunset")))
SIZE = "120x80"
HEAD = ("| scene | verdict | bias of the worst channel, % [99 % interval] | FLIP / limit | what happened to it |", "|---|---|---|---|---|")
CUBE = "import bpy; bpy.ops.wm.save_as_mainfile(filepath={!r})"


def blender(*arguments):
    program = os.environ.get("ASSAY_BLENDER", "blender")
    return subprocess.run([program, "-b", "--factory-startup", *arguments], check=True, capture_output=True, text=True).stdout


def bundled(folder):
    """{name: path}: what comes with Blender, and what our make_asset.py builds."""
    files = {"default cube": os.path.join(folder, "cube.blend"), "make_asset.py, .blend": os.path.join(folder, "asset.blend"),
             "make_asset.py, .glb": os.path.join(folder, "asset.glb")}
    blender("--python-expr", CUBE.format(files["default cube"]))
    blender("-P", os.path.join(os.path.dirname(HERE), "make_asset.py"), "--python-expr", CUBE.format(files["make_asset.py, .blend"]),
            "--", files["make_asset.py, .glb"])
    answer = blender("--python-expr", "import bpy; print('scripts:', bpy.utils.system_resource('SCRIPTS'))")
    scripts = next(line[9:] for line in answer.splitlines() if line.startswith("scripts: "))
    templates = os.path.join(scripts, "startup", "bl_app_templates_system")
    for name in sorted(os.listdir(templates)) if os.path.isdir(templates) else ():
        if os.path.exists(os.path.join(templates, name, "startup.blend")):
            files["template " + name] = os.path.join(templates, name, "startup.blend")
    library = os.path.join(scripts, "addons", "materials_library_vx")
    for name in sorted(os.listdir(library)) if os.path.isdir(library) else ():
        if name.endswith(".blend"):
            files["materials_library_vx/" + name] = os.path.join(library, name)
    return files


def compare(name, path, arguments):
    out = os.path.join(arguments.out, name.replace(" ", "_").replace(",", ""))
    ran = subprocess.run([os.path.join(suite.ROOT, "scripts", "compare-blend"), path, "--size", SIZE, "--out", out, "--keep", "--quiet",
                          "--json", "--threads", str(arguments.threads)], capture_output=True, text=True)
    if ran.returncode == 2:
        return f"| {name} | – | | | {ran.stderr.strip().split(': ', 2)[-1]} |"
    result = json.loads(ran.stdout)
    worst = max(result["bias"].values(), key=lambda d: abs(d["relative"] or 0))
    bias = f"{100 * worst['relative']:+.2f} [{100 * worst['low']:+.2f}, {100 * worst['high']:+.2f}]"
    flip = result["flip"]
    remarks = result["too_noisy"] and ["too noisy to tell"] or []
    remarks += [f"*lost:* {line}" for line in result["notes"]["lost"]] + [f"*alike:* {line}" for line in result["notes"]["changed"]]
    remarks += ["*known:* Blender's clearcoat" for line in result["notes"]["known"] if "clearcoat" in line]
    return f"| {name} | {result['verdict']} | {bias} | {flip['mean']:.4f} / {flip['limit']:.4f} | {'; '.join(remarks)} |"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("names", nargs="*", metavar="NAME")
    parser.add_argument("--update", action="store_true")
    parser.add_argument("--out", default=os.path.join(suite.ROOT, "build", "compare"), metavar="DIR")
    parser.add_argument("--threads", type=int, default=os.cpu_count())
    arguments = parser.parse_args()
    rows = kept_rows() if arguments.names else {}
    with tempfile.TemporaryDirectory() as folder:
        everything = {name: os.path.join(folder, name + ".blend") for name in SCENES}
        everything.update(bundled(folder))
        wanted = [name for name in everything if not arguments.names or name in arguments.names]
        if any(name in SCENES for name in wanted):
            blender("-P", os.path.join(HERE, "examples.py"), "--", folder, *(name for name in wanted if name in SCENES))
        for name in wanted:
            rows[name] = compare(name, everything[name], arguments)
            print(rows[name], flush=True)
            if arguments.update:
                update([rows[name] for name in everything if name in rows])


def kept_rows():
    with open(DOCS, encoding="utf-8") as file:
        table = file.read().split(BEGIN)[1].split(END)[0]
    return {line.split("|")[1].strip(): line for line in table.splitlines()[3:]}


def update(rows):
    with open(DOCS, encoding="utf-8") as file:
        text = file.read()
    before, after = text.split(BEGIN)[0], text.split(END)[1]
    with open(DOCS, "w", encoding="utf-8") as file:
        file.write(before + BEGIN + "\n" + "\n".join([*HEAD, *rows]) + "\n" + END + after)


if __name__ == "__main__":
    main()
