#!/usr/bin/python3
"""Lets the suite find the planted faults: the proof that it can fail.

  judge.py find NAME      run the case that faults.toml names for this fault: exit 0 if the suite finds it, and
                          names the lobe that faults.toml names
  judge.py control        with no fault on, the planted renderer must draw the first samples of all goldens
  judge.py places         every fault still has its place in the source
  judge.py table          every fault against its own case: the table of docs/faults.md
  judge.py matrix [NAME…] every fault against every case, to BUILD/faulty/matrix.json and into docs/faults.md
                          (nightly): its own case in full, the others at an eighth of their samples and
                          by the statistics alone; with names, only these faults are run anew (the page
                          is written if matrix.json has all the others)

A fault is found when a picture is CHANGED, NOISIER or BROKEN. UNDECIDED and ERROR do not count.
Exit codes: 0 found, 1 not found, 2 could not run.
"""
import argparse
import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE))
import plant  # noqa: E402

BEGIN, END = "<!-- matrix -->", "<!-- /matrix -->"
FOUND = ("CHANGED", "NOISIER", "BROKEN")


def fail(message):
    print("faults: error: " + message, file=sys.stderr)
    sys.exit(2)


def run_suite(build, name, pattern=None, options=(), suite=HERE.parent):
    """Verdicts of the cases, {case: results}, with the fault `name` on (None: no fault)."""
    folder = build / "faulty" / "runs" / (name or "control")
    folder.mkdir(parents=True, exist_ok=True)
    for old in [*(folder / "results").glob("*.json"), *folder.glob("run.json")]:
        old.unlink()
    command = [str(build / "faulty/bin/assay"), "run", "--suite", str(suite), "--build", str(folder)]
    command += options
    if pattern:
        command += ["-k", pattern]
    environment = dict(os.environ, ASSAY_FAULT=name or "")
    done = subprocess.run(command, env=environment, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    results = {p.stem: json.loads(p.read_text()) for p in (folder / "results").glob("*.json")}
    if not (folder / "run.json").exists():
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
    if result["verdict"] not in FOUND:
        return 1
    moved = result["reason"].partition("by lobe: ")[2].partition(" ")[0]  # the one that moved most
    if fault.get("lobe", "") not in moved:
        print("%s: wanted by lobe: %s, found %s" % (name, fault["lobe"], moved or "none"))
        return 1
    return 0


def control(build):
    wrong = run_suite(build, None, options=["--quick"])
    print("of all cases' first samples %d are not the golden's%s" % (len(wrong), "".join("\n  " + w for w in sorted(wrong))))
    return 1 if wrong else 0


def places(build):
    misplaced = (build / "faulty/misplaced.txt").read_text()
    print(misplaced or "%d faults, all in place" % len(plant.read_faults()))
    return 1 if misplaced else 0


def verdict_and_change(result):
    return [result["verdict"], change(result)]


def table(build):
    """Every fault against its own case, as Markdown."""
    faults, verdicts = plant.read_faults(), {}
    for number, fault in enumerate(faults, 1):
        print("[%d/%d] %s" % (number, len(faults), fault["name"]), file=sys.stderr, flush=True)
        result = run_suite(build, fault["name"], exactly(fault["case"]))[fault["case"]]
        verdicts[fault["name"]] = {fault["case"]: verdict_and_change(result)}
    print(own_cases(faults, verdicts))
    return 0 if all(found_by(row) for row in verdicts.values()) else 1


def small_suite(build):
    """All cases at an eighth of their samples (two for each replicate at least), without witnesses and without limits
    of FLIP and RMSE, which are for the full samples: so the statistics alone must find a fault. Goldens are drawn
    by the planted renderer with no fault on."""
    suite = build / "faulty/suite"
    shutil.rmtree(suite, ignore_errors=True)
    (suite / "cases").mkdir(parents=True)
    (suite / "scenes").symlink_to(HERE.parent / "scenes")
    for path in (HERE.parent / "cases").glob("*.json"):
        case = json.loads(path.read_text())
        if path.stem != "schema":
            case["spp"] = max(2, case["spp"] // case["replicates"] // 8) * case["replicates"]
            case["limits"] = {"flip": 1, "rmse": 1e6}
            case.pop("witnesses", None)
        (suite / "cases" / path.name).write_text(json.dumps(case))
    cases = sorted(run_suite(build, None, suite=suite))
    command = [str(build / "faulty/bin/assay"), "accept", *cases, "--because", "sound", "--suite", str(suite),
               "--build", str(build / "faulty/runs/control")]
    environment = {k: v for k, v in os.environ.items() if k != "CI"}
    done = subprocess.run(command, env=environment, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    if done.returncode:
        fail("%s: %s" % (" ".join(command), done.stdout))
    return suite, cases


def matrix(build, names):
    store = build / "faulty/matrix.json"
    verdicts = json.loads(store.read_text()) if names and store.exists() else {}
    faults = plant.read_faults()
    suite, cases = small_suite(build)
    for number, fault in enumerate(faults, 1):
        if names and fault["name"] not in names:
            continue
        print("[%d/%d] %s" % (number, len(faults), fault["name"]), file=sys.stderr, flush=True)
        results = run_suite(build, fault["name"], options=["--judge-only"], suite=suite)
        results.update(run_suite(build, fault["name"], exactly(fault["case"]), ["--judge-only"]))
        verdicts[fault["name"]] = {case: verdict_and_change(r) for case, r in results.items()}
        store.write_text(json.dumps(verdicts, indent=1))
    judged = [f for f in faults if f["name"] in verdicts]
    text = own_cases(judged, verdicts) + "\n\n" + grid(judged, verdicts, cases)
    print(text)
    if len(judged) == len(faults):
        page = HERE.parent.parent / "docs/faults.md"
        before, _, rest = page.read_text().partition(BEGIN)
        page.write_text(before + BEGIN + "\n\n" + text + "\n\n" + END + rest.partition(END)[2])
    else:  # a page of some would lose the others' rows
        print("docs/faults.md stays: %s has %d of %d faults" % (store, len(judged), len(faults)), file=sys.stderr)
    return 0 if all(found_by(verdicts[f["name"]]) for f in judged) else 1


def found_by(row):
    return sorted(case for case, (verdict, _) in row.items() if verdict in FOUND)


def own_cases(faults, verdicts):
    lines = ["| fault | what is wrong | in | found by | verdict | the picture's mean |", "|---|---|---|---|---|--:|"]
    subtle, rooms = 0, {}
    for fault in faults:
        room = fault["file"].split("/")[1]
        rooms[room] = rooms.get(room, 0) + 1
        verdict, moved = verdicts[fault["name"]][fault["case"]]
        subtle += moved is not None and abs(moved) < .01
        lines.append("| %s | %s | %s | %s | %s | %s |" % (
            fault["name"], fault["why"], room, fault["case"], verdict,
            "" if moved is None else "%+.2f %%" % (100 * moved)))
    found = sum(bool(found_by({f["case"]: verdicts[f["name"]][f["case"]]})) for f in faults)
    return "%d faults (%s), %d found. %d move the mean of their picture by less than 1 %%.\n\n" % (
        len(faults), ", ".join("%s %d" % r for r in sorted(rooms.items())), found, subtle) + "\n".join(lines)


def grid(faults, verdicts, cases):
    """Faults by cases, a letter each, and what follows for the cases."""
    letter = {"CHANGED": "C", "NOISIER": "N", "BROKEN": "B", "ERROR": "E", "UNDECIDED": "?", "QUIETER": "q",
              "EQUIVALENT": "=", "IDENTICAL": "."}
    width = max(len(f["name"]) for f in faults)
    lines = ["```text"]
    for row in range(max(len(c) for c in cases)):
        lines.append(" " * (width + 2) + "".join(c.rjust(max(len(c) for c in cases))[row] for c in cases).rstrip())
    alone = {}
    for fault in faults:
        verdict = verdicts[fault["name"]]
        found = found_by(verdict)
        if len(found) == 1:
            alone.setdefault(found[0], []).append(fault["name"])
        lines.append("%-*s  %s %d" % (width, fault["name"], "".join(
            letter[verdict[c][0]] for c in cases), len(found)))
    idle = [c for c in cases if not any(c in found_by(verdicts[f["name"]]) for f in faults)]
    return "\n".join(lines + ["```", "", "Found by one case only: " + "; ".join(
        "`%s` (%s)" % (c, ", ".join(names)) for c, names in sorted(alone.items())) + ".", "",
        "Cases that found none of these: " + (", ".join("`%s`" % c for c in idle) or "none") + "."])


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
