"""docs/disney.md as data: its commands, its pictures, and the block of numbers computed by the renderer's code."""

import pathlib
import re
import shlex

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
PAGE = ROOT / "docs" / "disney.md"
README = ROOT / "README.md"
IMAGES = ROOT / "docs" / "images" / "disney"
RENDERER = "build/bin/assay-render"
BEGIN, END = "<!-- numbers: scripts/make-figures -->", "<!-- end of numbers -->"


def text():
    return PAGE.read_text()


def commands():
    """Picture's name -> words of the command that makes it."""
    found = {}
    for block in re.findall(r"^```sh\n(.*?)^```", text(), re.M | re.S):
        for line in block.replace("\\\n", " ").split("\n"):
            words = shlex.split(line, comments=True)
            if words[:1] == [RENDERER] and "-o" in words:
                out = pathlib.PurePosixPath(words[words.index("-o") + 1])
                if out.parent.as_posix() == "build/figures":
                    found[out.stem] = words
    return found


def pictures(path):
    """Paths of the pictures that a Markdown page shows."""
    links = re.findall(r"!\[[^\]]*\]\(([^)\s]+)\)", path.read_text())
    return [(path.parent / link).resolve() for link in links if "://" not in link]


def links(path):
    """Paths of the local files that a Markdown page links to, pictures apart."""
    found = re.findall(r"(?<!!)\[[^\]]*\]\(([^)\s#]+)[^)]*\)", path.read_text())
    return [(path.parent / link).resolve() for link in found if "://" not in link]


def symbols(path):
    """(file, name) of each name in backquotes after a link to source code."""
    for link, names in re.findall(r"\]\(([^)\s]+\.(?:h|cpp))\)((?:,? `\w+`)+)", path.read_text()):
        for name in re.findall(r"\w+", names):
            yield (path.parent / link).resolve(), name


def at(curve, x):
    return min(curve, key=lambda point: abs(point[0] - x))[1]


def numbers(curves):
    """The tables of the page that hold values of the shipped code."""
    lines = ["| c for which D is normalised | red, α = 0.0625 | green, α = 0.01 | blue, α = 0.0025 |", "|---|---|---|---|"]
    shapes = ("red", "green", "blue")
    for gamma in ("1", "2"):
        lines.append("| γ = %s | " % gamma + " | ".join(
            "%.3e" % curves["constant/%s/%s" % (gamma, shape)][0][1] for shape in shapes) + " |")
    lines += ["", "| share of light reflected | at 0° | at 60° | at 80° | at 89° |", "|---|---|---|---|---|"]
    rows = [("disney, white metal of roughness %s" % r, "albedo/disney/" + r) for r in ("0.1", "0.5", "1")]
    rows += [("path_disney, the same of roughness 0.25, γ = %s, D normalised" % g, "albedo/path_disney/" + g)
             for g in ("0.5", "1", "2", "10")]
    for label, key in rows:
        lines.append("| %s | " % label + " | ".join("%.2f" % at(curves[key], x) for x in (0, 60, 80, 89)) + " |")
    return "\n".join(lines)


def with_numbers(content, curves):
    head, _, rest = content.partition(BEGIN)
    _, _, tail = rest.partition(END)
    return head + BEGIN + "\n" + numbers(curves) + "\n\n" + END + tail
