#!/usr/bin/python3
"""Lets the suite find the planted faults: the proof that it can fail.

  judge.py find NAME      run the case that faults.toml names for this fault: exit 0 if the suite finds it
  judge.py control        run every case with no fault on: the planted renderer must draw the goldens, bit for bit
  judge.py places         every fault still has its place in the source
  judge.py table          every fault against its own case: the table of docs/faults.md
  judge.py matrix [NAME…] every fault against every case, to BUILD/faulty/matrix.json and a table on standard
                          output (nightly, an hour and a half); with names, only these faults are run anew

A fault is found when a picture is CHANGED, NOISIER or BROKEN. UNDECIDED and ERROR do not count.
Exit codes: 0 found, 1 not found, 2 could not run.
"""
import argparse
import json
import os
import subprocess
import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE))
import plant  # noqa: E402

FOUND = ("CHANGED", "NOISIER", "BROKEN")


def fail(message):
    print("faults: error: " + message, file=sys.stderr)
    sys.exit(2)


def run_suite(build, name, pattern=None):
    """Verdicts of the cases, {case: results}, with the fault `name` on."""
    folder = build / "faulty" / "runs" / (name or "control")
    folder.mkdir(parents=True, exist_ok=True)
    for old in (folder / "results").glob("*.json"):
        old.unlink()
    command = [str(build / "faulty/bin/assay"), "run", "--suite", str(HERE.parent), "--build", str(folder)]
    if pattern:
        command += ["-k", pattern]
    environment = dict(os.environ, ASSAY_FAULT=name or "")
    done = subprocess.run(command, env=environment, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    results = {p.stem: json.loads(p.read_text()) for p in (folder / "results").glob("*.json")}
    if not results:
        fail("%s: no results:\n%s" % (" ".join(command), done.stdout))
    return results


def exactly(case):
    """A pattern of `assay run -k` that fits this name only."""
    return "?" + case[1:]


def change(result):
    """Relative change of the image's mean luminance; None where the judge had nothing to compare."""
    for stage in ("paired", "welch"):
        image = ((result["golden"].get(stage) or {}).get("image") or {}).get("luminance")
        if image and image["relative"] is not None:
            return image["relative"]
    return None


def find(build, name):
    fault = next((f for f in plant.read_faults() if f["name"] == name), None)
    if not fault:
        fail("%s: wanted a name in faults.toml" % name)
    result = run_suite(build, name, exactly(fault["case"]))[fault["case"]]
    print("%s: %s: %s: %s" % (name, fault["case"], result["verdict"], result["reason"]))
    return 0 if result["verdict"] in FOUND else 1


def control(build):
    results = run_suite(build, None)
    wrong = [case for case, result in sorted(results.items()) if result["verdict"] != "IDENTICAL"]
    print("%d cases, %d IDENTICAL%s" % (len(results), len(results) - len(wrong), "".join("\n  " + w for w in wrong)))
    return 1 if wrong else 0


def places(build):
    misplaced = (build / "faulty/misplaced.txt").read_text()
    print(misplaced or "%d faults, all in place" % len(plant.read_faults()))
    return 1 if misplaced else 0


def matrix(build, names):
    store = build / "faulty/matrix.json"
    table = json.loads(store.read_text()) if names and store.exists() else {}
    faults = plant.read_faults()
    for number, fault in enumerate(faults, 1):
        if names and fault["name"] not in names:
            continue
        print("[%d/%d] %s" % (number, len(faults), fault["name"]), file=sys.stderr, flush=True)
        table[fault["name"]] = {case: [r["verdict"], change(r)] for case, r in run_suite(build, fault["name"]).items()}
        store.write_text(json.dumps(table, indent=1))
    print(report(faults, table))
    return 0 if all(found_by(table[f["name"]]) for f in faults if f["name"] in table) else 1


def table(build):
    """Every fault against its own case, as Markdown."""
    faults = plant.read_faults()
    lines = ["| fault | what is wrong | in | found by | verdict | the picture's mean |", "|---|---|---|---|---|---|"]
    subtle = missed = 0
    for number, fault in enumerate(faults, 1):
        print("[%d/%d] %s" % (number, len(faults), fault["name"]), file=sys.stderr, flush=True)
        result = run_suite(build, fault["name"], exactly(fault["case"]))[fault["case"]]
        moved = change(result)
        subtle += moved is not None and abs(moved) < .01
        missed += result["verdict"] not in FOUND
        lines.append("| %s | %s | %s | %s | %s | %s |" % (
            fault["name"], fault["why"], fault["file"].split("/")[1], fault["case"], result["verdict"],
            "" if moved is None else "%+.2f %%" % (100 * moved)))
    rooms = {}
    for fault in faults:
        room = fault["file"].split("/")[1]
        rooms[room] = rooms.get(room, 0) + 1
    print("%d faults (%s), %d found. %d move the mean of their picture by less than 1 %%.\n" % (
        len(faults), ", ".join("%s %d" % r for r in sorted(rooms.items())), len(faults) - missed, subtle))
    print("\n".join(lines))
    return 1 if missed else 0


def found_by(row):
    return sorted(case for case, (verdict, _) in row.items() if verdict in FOUND)


def report(faults, table):
    lines = ["| fault | in | what | found by | its case | change of that picture's mean |", "|---|---|---|---|---|---|"]
    alone = {}
    subtle = 0
    for fault in faults:
        row = table.get(fault["name"])
        if row is None:
            continue
        found = found_by(row)
        for case in found if len(found) == 1 else ():
            alone.setdefault(case, []).append(fault["name"])
        verdict, moved = row[fault["case"]]
        subtle += moved is not None and abs(moved) < .01
        lines.append("| %s | %s | %s | %d of %d | %s: %s | %s |" % (
            fault["name"], fault["file"].split("/")[1], fault["why"], len(found), len(row), fault["case"], verdict,
            "" if moved is None else "%+.2g %%" % (100 * moved)))
    cases = sorted({case for row in table.values() for case in row})
    idle = [c for c in cases if not any(c in found_by(row) for row in table.values())]
    lines += ["", "%d faults, %d found, %d of them move their picture's mean by less than 1 %%." % (
        len(table), sum(bool(found_by(row)) for row in table.values()), subtle),
        "", "Only one case finds: " + "; ".join("%s (%s)" % (n, c) for c, ns in sorted(alone.items()) for n in ns),
        "", "Cases that found none of these: " + (", ".join(idle) or "none")]
    return "\n".join(lines)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--build", type=Path, default=HERE.parent.parent / "build", help="the build folder")
    parser.add_argument("command", choices=["find", "control", "places", "table", "matrix"])
    parser.add_argument("name", nargs="*")
    a = parser.parse_args()
    if not (a.build / "faulty/bin/assay").exists():
        fail("%s: not built: wanted the target assay-render-faulty" % (a.build / "faulty/bin/assay"))
    if a.command == "find":
        if len(a.name) != 1:
            parser.error("find: wanted one NAME")
        sys.exit(find(a.build, a.name[0]))
    sys.exit({"control": control, "places": places, "table": table}[a.command](a.build) if a.command != "matrix"
             else matrix(a.build, a.name))


if __name__ == "__main__":
    main()
