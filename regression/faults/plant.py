#!/usr/bin/python3
"""Plants the faults of faults.toml in a copy of the renderer, each behind a switch.

A suite that has never failed proves nothing. Each fault is a mistake somebody could make in one line of renderer/;
the copy is built as one program, in which the environment variable ASSAY_FAULT=NAME switches one of them on (none:
the renderer as it is). So one build serves all faults, and the shipped sources know nothing of them.

  plant.py RENDERER_DIR OUTPUT_DIR   write the copy to OUTPUT_DIR/renderer, and OUTPUT_DIR/faults.cmake with one
                                     ctest per fault

In faults.toml, `at` is a piece of the source that occurs once, in which ⟦…⟧ marks what the fault replaces by `plant`:
an expression, or statements if the marked text ends in a semicolon.
"""
import re
import sys
import tomllib
from pathlib import Path

HERE = Path(__file__).resolve().parent
HEADER = """// Which planted fault is on: its number, -1 for none. Written by regression/faults/plant.py.
#pragma once
int assay_fault();
"""
SWITCH = """#include "fault.h"

#include <cstdio>
#include <cstdlib>
#include <cstring>

int assay_fault() {
  static const int number = [] {
    const char* wanted = std::getenv("ASSAY_FAULT");
    if (!wanted || !*wanted) return -1;
    const char* names[] = {%s};
    for (int i = 0; i < %d; ++i)
      if (std::strcmp(names[i], wanted) == 0) return i;
    std::fprintf(stderr, "error: ASSAY_FAULT: wanted a name in faults.toml, found %%s\\n", wanted);
    std::exit(2);
  }();
  return number;
}
"""


class Misplaced(Exception):
    pass


def read_faults():
    faults = tomllib.loads((HERE / "faults.toml").read_text())["fault"]
    names = [f["name"] for f in faults]
    if len(set(names)) != len(names):
        raise Misplaced("faults.toml: two faults have one name")
    return faults


def switched(good, bad, number):
    if good.rstrip().endswith(";"):
        return "if (assay_fault() == %d) { %s } else { %s }" % (number, bad, good)
    return "(assay_fault() == %d ? (%s) : (%s))" % (number, bad, good)


def plant(source, fault, number):
    """The source with the fault behind its switch."""
    before, good, after = re.fullmatch(r"(.*)⟦(.*)⟧(.*)", fault["at"], re.S).groups()
    where = "faults.toml: %s: %s" % (fault["name"], fault["file"])
    found = source.count(before + good + after)
    if found != 1:
        raise Misplaced("%s: wanted the text of `at` once, found it %d times: the code has moved, move the fault"
                        % (where, found))
    return source.replace(before + good + after, before + switched(good, fault["plant"], number) + after)


def write(path, text):
    """Leaves an unchanged file alone, so that nothing is compiled anew."""
    path.parent.mkdir(parents=True, exist_ok=True)
    if not path.exists() or path.read_text() != text:
        path.write_text(text)


def main():
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    renderer, output = Path(sys.argv[1]), Path(sys.argv[2])
    faults = read_faults()
    misplaced, written = [], set()
    for path in sorted(renderer.glob("*/*")):
        # Not the tests, and of the programs only assay-render.
        if (path.suffix not in (".h", ".cpp") or path.name.endswith(("_test.cpp", "_main.cpp"))
                or path.parent.name == "view"):
            continue
        text = path.read_text()
        name = "renderer/%s/%s" % (path.parent.name, path.name)
        planted = False
        for number, fault in enumerate(faults):
            if fault["file"] != name:
                continue
            try:
                text, planted = plant(text, fault, number), True
            except Misplaced as error:
                misplaced.append(str(error))
        if planted:
            text = '#include "fault.h"\n' + text
        write(output / name, text)
        written.add(output / name)
    for old in set(output.glob("renderer/*/*")) - written:
        old.unlink()
    for fault in faults:
        if not (output / fault["file"]).exists():
            misplaced.append("faults.toml: %s: no file %s" % (fault["name"], fault["file"]))
    write(output / "renderer/fault.h", HEADER)
    names = ", ".join('"%s"' % f["name"] for f in faults)
    write(output / "renderer/fault.cpp", SWITCH % (names, len(faults)))
    write(output / "misplaced.txt", "".join(m + "\n" for m in misplaced))
    write(output / "faults.cmake", "".join(
        'planted_fault("%s" "%s")\n' % (f["name"], f["case"]) for f in faults))
    for line in misplaced:
        print(line, file=sys.stderr)


if __name__ == "__main__":
    main()
