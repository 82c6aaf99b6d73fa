#!/usr/bin/python3
"""Ask Blender what the cases look like, and store the answer as reference/blender/renders/NAME.exr.

  witness.py CASE...           render these cases
  witness.py --all-stale       render every case whose stored render is missing, of another picture, of other
                               scripts, or of fewer samples than the case asks for (with CASE names: of these)
  witness.py --all             render every case that calls Blender as a witness
  witness.py --check CASE...   render live, with fewer samples and other seeds, and compare with the stored render

Exit codes: 0 fine, 1 --check found a difference or a stale render, 2 could not run (no Blender, bad case).
The mean and the variance of the mean come from independent seeds (default 8 of 1024 samples per pixel each).
"""

import argparse
import json
import math
import os
import shutil
import statistics
import subprocess
import sys
import tempfile

sys.dont_write_bytecode = True
sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))

import numpy as np  # noqa: E402

import suite  # noqa: E402

TESTED = "3.4."
CHECK_SEED = 1000  # --check renders with seeds no stored render has used
CHECK_SEEDS, CHECK_SHARE = 4, 4
FALSE_ALARMS = 1e-6  # of one --check of one case
ROUNDING = 1e-5  # relative, of a sum of equal samples in float


def fail(message):
    print(f"witness.py: {message}", file=sys.stderr)
    sys.exit(2)


class Blender:
    def __init__(self, command, threads):
        self.command = shutil.which(command)
        self.threads = threads
        if self.command is None:
            fail(f"no {command} found: install Blender 3.4 (apt-get install blender python3-numpy), or name it with --blender")
        try:
            answer = subprocess.run([self.command, "--version"], capture_output=True, text=True, timeout=60).stdout.split()
        except (OSError, subprocess.TimeoutExpired) as error:
            fail(f"{self.command} --version: {error}")
        if len(answer) < 2 or answer[0] != "Blender":
            fail(f"{self.command} --version: wanted Blender and a number, found: {' '.join(answer)[:60]}")
        self.version = answer[1]
        self.tested = self.version.startswith(TESTED)
        if not self.tested:
            print(f"witness.py: warning: Blender {self.version} is untested, its Principled BSDF may differ "
                  f"(tested: {TESTED}x)", file=sys.stderr)

    @property
    def name(self):
        return f"Blender {self.version}" + ("" if self.tested else " (untested)")

    def render(self, jobs, folder):
        """Runs the jobs in one Blender process; yields (name, error or None, seconds) as each one ends."""
        path = os.path.join(folder, "jobs.json")
        with open(path, "w") as file:
            json.dump({"threads": self.threads, "jobs": jobs}, file)
        command = [self.command, "-b", "--factory-startup", "-P", os.path.join(suite.HERE, "render_in_blender.py"), "--", path]
        environment = dict(os.environ, PYTHONDONTWRITEBYTECODE="1")
        last, finished = [], 0
        with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, errors="replace",
                              env=environment) as process:
            for line in process.stdout:
                if line.startswith("witness: "):
                    report = json.loads(line[9:])
                    finished += 1
                    yield report["name"], report.get("error"), report["seconds"]
                else:
                    last = (last + [line.rstrip()])[-20:]
        for job in jobs[finished:]:
            why = next((line for line in reversed(last) if "rror" in line), last[-1] if last else "no output")
            yield job["name"], f"{job['scene']}: Blender ended with exit code {process.returncode}: {why}", 0.0


def stale(case, folder):
    """Why the stored render cannot be used, or None."""
    path = os.path.join(folder, case.name + ".exr")
    if not os.path.exists(path):
        return "not there"
    scene, picture = case.hashes()
    _, _, header = suite.read_witness(path)
    if header.get("assay:picture_hash") != picture:
        return "of another picture"
    if header.get("assay:script_hash") != suite.script_hash():
        return "made by other scripts"
    if header.get("assay:spp", 0) < case.job()["spp"] * case.seeds():
        return "of fewer samples"
    return None


def render_cases(blender, work, handle):
    """`work`: (case, spp, seeds). Calls handle(case, mean, variance) and prints a line per case; counts failures."""
    failures = 0
    with tempfile.TemporaryDirectory() as folder:
        jobs, known = [], {}
        for case, spp, seeds in work:
            try:
                job = dict(case.job(), spp=spp, seeds=seeds, out=os.path.join(folder, case.name))
            except suite.CaseError as error:
                print(f"witness.py: {error}", file=sys.stderr)
                failures += 1
                continue
            jobs.append(job)
            known[case.name] = (case, job)
        for count, (name, error, seconds) in enumerate(blender.render(jobs, folder) if jobs else (), 1):
            case, job = known[name]
            label = f"[{count:{len(str(len(jobs)))}}/{len(jobs)}] {name:<34}"
            if error is None:
                try:
                    images = [suite.read_exr(f"{job['out']}.{seed}.exr")[0][..., :3] for seed in job["seeds"]]
                    mean, variance = suite.merge(images)
                    if not np.isfinite(mean).all():
                        raise suite.CaseError(f"{name}: Blender's render holds non-finite pixels")
                    note = handle(case, mean, variance, job)
                except (suite.CaseError, OSError) as problem:
                    error = str(problem)
            if error is not None:
                print(f"{label} FAILED", flush=True)
                print(f"witness.py: {error}", file=sys.stderr)
                failures += 1
            else:
                print(f"{label} {len(job['seeds'])} x {job['spp']} spp {seconds:6.1f} s  {note}", flush=True)
    return failures


def store(blender, out):
    def handle(case, mean, variance, job):
        scene, picture = case.hashes()
        path = os.path.join(out, case.name + ".exr")
        suite.write_witness(path, mean, variance, {
            "assay:witness": blender.name, "assay:script_hash": suite.script_hash(), "assay:picture_hash": picture,
            "assay:scene_hash": scene, "assay:spp": job["spp"] * len(job["seeds"]), "assay:replicates": len(job["seeds"]),
        })
        return path
    return handle


def worst_z(a, variance_a, replicates_a, b, variance_b, replicates_b, tile=8):
    """Largest |z| over tiles and the whole image, per channel, by Welch's t with Satterthwaite's degrees of freedom;
    and the z that a pair of equal pictures exceeds with probability FALSE_ALARMS. Pixels are independent."""
    parts = (a - b, variance_a + variance_b,
             variance_a ** 2 / (replicates_a - 1) + variance_b ** 2 / (replicates_b - 1), np.maximum(a, b))
    height, width, _ = a.shape
    regions = [(0, height, 0, width)] + [(y, min(y + tile, height), x, min(x + tile, width))
                                         for y in range(0, height, tile) for x in range(0, width, tile)]
    worst = 0.0
    for y0, y1, x0, x1 in regions:
        difference, variance, spread, value = (p[y0:y1, x0:x1].sum(axis=(0, 1)) for p in parts)
        # Sums of other numbers of samples differ by float rounding, in all pixels alike.
        t2 = difference ** 2 / (variance + (ROUNDING * value) ** 2 + 1e-30)
        freedom = np.maximum(variance ** 2 / np.maximum(spread, 1e-300), 1)
        freedom = np.where(variance > 0, freedom, 1e9)
        # Wallace's normal deviate of Student's t.
        z = (8 * freedom + 1) / (8 * freedom + 3) * np.sqrt(freedom * np.log1p(t2 / freedom))
        worst = max(worst, float(z.max()))
    tests = len(regions) * 3
    return worst, statistics.NormalDist().inv_cdf(1 - FALSE_ALARMS / tests / 2)


def check(out, differing):
    def handle(case, mean, variance, job):
        stored, stored_variance, header = suite.read_witness(os.path.join(out, case.name + ".exr"))
        if stored.shape != mean.shape:
            differing.append(case.name)
            return f"DIFFERS: stored {stored.shape[1]} x {stored.shape[0]}, live {mean.shape[1]} x {mean.shape[0]}"
        z, limit = worst_z(mean, variance, len(job["seeds"]), stored, stored_variance, header["assay:replicates"])
        error = math.sqrt((variance.sum() + stored_variance.sum()) / mean.size ** 2)
        visible = f"sees a bias of {100 * limit * error / max(stored.mean(), 1e-12):.2g} % of the image"
        if z > limit:
            differing.append(case.name)
        return f"{'DIFFERS' if z > limit else 'AGREES'}: worst z {z:.2f}, limit {limit:.2f}; {visible}"
    return handle


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("cases", nargs="*", metavar="CASE")
    parser.add_argument("--all", action="store_true", help="every case that calls Blender")
    parser.add_argument("--all-stale", action="store_true", help="only those whose stored render is stale")
    parser.add_argument("--check", action="store_true", help="compare a live render with the stored one")
    parser.add_argument("--out", default=os.path.join(suite.HERE, "renders"), metavar="DIR", help="folder of the renders")
    parser.add_argument("--suite", default=os.path.join(suite.ROOT, "regression"), metavar="DIR", help="holds cases/, scenes/")
    parser.add_argument("--blender", default=os.environ.get("ASSAY_BLENDER", "blender"), metavar="PROGRAM")
    parser.add_argument("--threads", type=int, default=os.cpu_count(), metavar="N")
    arguments = parser.parse_args()
    if not (arguments.cases or arguments.all or arguments.all_stale):
        fail("wanted CASE names, --all or --all-stale; see --help")
    try:
        cases = [suite.Case(name, arguments.suite) for name in arguments.cases or suite.case_names(arguments.suite)]
        if arguments.all_stale:
            reasons = {case.name: stale(case, arguments.out) for case in cases}
            cases = [case for case in cases if reasons[case.name]]
            for case in cases:
                print(f"stale: {case.name}: {reasons[case.name]}")
            if not cases:
                print("no stale Blender renders")
                return 0
        if arguments.check:
            return run_check(arguments, cases)
    except suite.CaseError as error:
        fail(error)
    blender = Blender(arguments.blender, arguments.threads)
    os.makedirs(arguments.out, exist_ok=True)
    work = [(case, (case.witness or {}).get("spp", 1024), list(range(1, case.seeds() + 1))) for case in cases]
    return 2 if render_cases(blender, work, store(blender, arguments.out)) else 0


def run_check(arguments, cases):
    blender, differing = Blender(arguments.blender, arguments.threads), []
    work = []
    for case in cases:
        reason = stale(case, arguments.out)
        if reason:
            differing.append(case.name)
            print(f"{case.name}: stored render {reason}; remake it with scripts/update-references --blender {case.name}")
        else:
            spp = max(1, (case.witness or {}).get("spp", 1024) // CHECK_SHARE)
            work.append((case, spp, list(range(CHECK_SEED, CHECK_SEED + CHECK_SEEDS))))
    if render_cases(blender, work, check(arguments.out, differing)):
        return 2
    return 1 if differing else 0


if __name__ == "__main__":
    sys.exit(main())
