#!/usr/bin/python3
"""Draws what `assay speed` measured: plot.py results.json FOLDER writes error.svg and growth.svg there."""

import json
import math
import pathlib
import statistics
import sys

import matplotlib

matplotlib.use("svg")
import matplotlib.pyplot as plt  # noqa: E402
from matplotlib import ticker  # noqa: E402

COLORS = {"assay": "#c43b1d", "assay adaptive": "#e8973a", "cycles": "#1f5fa8", "cycles adaptive": "#6fb1e0"}
OTHERS = ("#4a9c4a", "#8a5cb8", "#777777")
# The same file for the same numbers, with text as text.
plt.rcParams.update({"svg.fonttype": "none", "svg.hashsalt": "assay", "font.size": 8, "axes.grid": True, "grid.color": "#dddddd",
                     "axes.spines.top": False, "axes.spines.right": False, "lines.markersize": 3, "lines.linewidth": 1.2})


def color(name, seen={}):
    return COLORS.get(name) or seen.setdefault(name, OTHERS[len(seen) % len(OTHERS)])


def panels(count):
    columns = min(count, 3)
    rows = -(-count // columns)
    figure, axes = plt.subplots(rows, columns, figsize=(3.3 * columns, 2.5 * rows), squeeze=False, constrained_layout=True)
    for axis in axes.ravel()[count:]:
        axis.remove()
    return figure, axes.ravel()[:count]


def save(figure, axes, path):
    handles = {}
    for axis in axes:
        handles.update({label: handle for handle, label in zip(*axis.get_legend_handles_labels())})
    figure.legend(handles.values(), handles.keys(), loc="outside lower center" if matplotlib.__version__ >= "3.7" else "lower center",
                  ncol=len(handles), frameon=False, bbox_to_anchor=None if matplotlib.__version__ >= "3.7" else (.5, -.1 if len(axes) <= 3 else -.04))
    figure.savefig(path, metadata={"Date": None, "Creator": None}, bbox_inches="tight")


def errors(scenes, path):
    figure, axes = panels(len(scenes))
    for axis, (name, scene) in zip(axes, scenes.items()):
        for contestant, result in scene["contestants"].items():
            seconds = [statistics.median(level["seconds"]) for level in result["levels"]]
            error = [[max(e, 1e-30) ** .5 / scene["references"][result["family"]]["mean"] for e in level["mse"]]
                     for level in result["levels"]]
            middle = [statistics.median(e) for e in error]
            axis.plot(seconds, middle, "o-", color=color(contestant), label=contestant)
            axis.fill_between(seconds, [min(e) for e in error], [max(e) for e in error], color=color(contestant), alpha=.2, lw=0)
        axis.set(xscale="log", yscale="log", title=name)
        axis.set_xlabel("render time in this run, s")
        axis.set_ylabel("RMSE / image mean")
    save(figure, axes, path)


def growth(series, path):
    figure, axes = panels(len(series) + ("lights" in series))
    wanted = [(s, "seconds", "time per sample") for s in series.values()]
    if "lights" in series:
        wanted.append((series["lights"], "cost", "cost of equal noise"))
    for axis, (one, key, label) in zip(axes, wanted):
        names = list(dict.fromkeys(n for point in one["points"] for n, v in point.items() if isinstance(v, dict)))
        base = next(v[key] for v in one["points"][0].values() if isinstance(v, dict))
        for name in names:
            points = [(point["x"], point[name][key] / base) for point in one["points"] if name in point]
            axis.plot(*zip(*points), "o-", color=color(name), label=name)
        axis.set(xscale="log", yscale="log", xlabel=one["axis"], ylabel=label + ", first = 1")
        # Ticks at what was measured; less than a decade needs plain numbers.
        places = [point["x"] for point in one["points"]]
        axis.set_xticks(places, ["%g" % x if x < 1e4 else "$10^{%d}$" % round(math.log10(x)) for x in places])
        axis.xaxis.set_minor_locator(ticker.NullLocator())
        axis.yaxis.set_major_locator(ticker.LogLocator(subs=(1, 1.5, 2, 3, 5, 7)))
        axis.yaxis.set_major_formatter(ticker.FormatStrFormatter("%g"))
        axis.yaxis.set_minor_formatter(ticker.NullFormatter())
    save(figure, axes, path)


def main():
    results = json.loads(pathlib.Path(sys.argv[1]).read_text())
    folder = pathlib.Path(sys.argv[2])
    folder.mkdir(parents=True, exist_ok=True)
    if results.get("scenes"):
        errors(results["scenes"], folder / "error.svg")
    if results.get("series"):
        growth(results["series"], folder / "growth.svg")


main()
