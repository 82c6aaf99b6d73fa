#!/usr/bin/python3
"""Cycles as a contestant of `assay speed`: Blender stays alive between jobs and keeps the scene.

Reads one job per line of standard input,
  {"scene", "out", "width", "height", "spp", "seed", "depth", "threads", "adaptive"}
and answers each with one line of JSON,
  {"out", "ok", "error", "render_seconds", "build_seconds", "load_seconds", "rss_mb", "version"}.

`render_seconds` is Cycles' own "Render time (without synchronization)", the wall time of its render loop;
`build_seconds` what it spends on synchronisation and the BVH before its first render of a scene (its "Total render time"
less that); `load_seconds` the making of the Blender scene from the glTF. Blender's start-up is in none of them.
"""

import json
import os
import subprocess
import sys

HERE = os.path.dirname(os.path.abspath(__file__))
MARK = "speed: "


def main():
    # Debian's Blender takes the modules of the first python3 in PATH: with a virtual environment's it would find no numpy.
    environment = dict(os.environ, PATH="/usr/bin:" + os.environ.get("PATH", ""), PYTHONDONTWRITEBYTECODE="1")
    command = [os.environ.get("ASSAY_BLENDER", "blender"), "-b", "--factory-startup", "--debug-cycles", "--verbose", "2",
               "-P", os.path.join(HERE, "inside.py")]
    try:
        blender = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, errors="replace",
                                   env=environment)  # standard input is ours
    except OSError as error:
        print(f"worker.py: cannot start {command[0]}: {error.strerror} (apt-get install blender python3-numpy)", file=sys.stderr)
        return 2
    total = render = 0.0
    last = ""
    for line in blender.stdout:
        if "Total render time: " in line:
            total = float(line.rsplit(" ", 1)[1])
        elif "Render time (without synchronization): " in line:
            render = float(line.rsplit(" ", 1)[1])
        elif MARK in line:
            answer = json.loads(line[line.index(MARK) + len(MARK):])
            if answer["ok"] and render == 0:
                answer.update(ok=False, error="Cycles did not say how long it took (wanted Blender 3.4's log)")
            print(json.dumps(dict(answer, render_seconds=render, build_seconds=max(total - render, 0.0))), flush=True)
            total = render = 0.0
        elif "rror" in line:
            last = line.strip()
    code = blender.wait()
    if code:
        print(f"worker.py: Blender ended with exit code {code}: {last}", file=sys.stderr)
    return 2 if code else 0


if __name__ == "__main__":
    sys.exit(main())
