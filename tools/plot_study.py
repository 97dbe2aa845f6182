"""Draws what machpoint study left in its output directory (plot.py study DIR).

work_precision.png: error against seconds, a line for each combination of the
settings that are not cells; the Pareto front is marked, and the legend says the
order and what half the error costs. cost.png: seconds against cells.
"""
import argparse
import json
import pathlib
import sys

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt

MARKERS = "osD^vP*X<>"
STYLES = ["-", "--", ":", "-."]


class Study:
    """study.json, its finished rows by lines."""

    def __init__(self, directory):
        self.json = json.loads((directory / "study.json").read_text())
        self.error = self.json["error"]
        self.laws = {law["line"]: law for law in self.json["laws"]}
        self.rows = [r for r in self.json["rows"] if r["status"] == "finished"]
        self.failed = [r for r in self.json["rows"] if r["status"] == "failed"]
        self.lines = {}
        for row in self.rows:
            self.lines.setdefault(row["line"], []).append(row)
        for rows in self.lines.values():
            rows.sort(key=cell_count)
        self.styles = self._styles()

    def _styles(self):
        """A colour for each value of the first setting that tells lines apart,
        a marker for each combination of the others."""
        values = {name: {key: json.dumps(value)
                         for key, value in rows[0]["settings"].items()
                         if key != "grid.cells"}
                  for name, rows in self.lines.items()}
        telling = [key for key in dict.fromkeys(k for v in values.values() for k in v)
                   if len({v.get(key) for v in values.values()}) > 1]
        first, others = telling[:1], telling[1:]
        colours, markers, styles = {}, {}, {}
        for name, settings in values.items():
            colour = tuple(settings.get(key) for key in first)
            marker = tuple(settings.get(key) for key in others)
            c = colours.setdefault(colour, len(colours))
            m = markers.setdefault(marker, len(markers))
            styles[name] = {"color": f"C{c % 10}", "marker": MARKERS[m % len(MARKERS)],
                            "linestyle": STYLES[m % len(STYLES)]}
        return styles

    def title(self):
        machine = self.json["machine"]["processor"] or "unknown processor"
        threads = sorted({row["threads"] for row in self.rows})
        return (f"{self.json['study']}: {machine}, "
                f"{'/'.join(map(str, threads))} thread(s), {self.json['revision']}")

    def error_of(self, row):
        return row.get("errors", {}).get(self.error)


def cell_count(row):
    count = 1
    for n in row["cells"]:
        count *= n
    return count


def law_text(law):
    """What the legend says of a line."""
    if law["order"] is None:
        return ""
    text = f"$h^{{{law['order']:.2f}}}$"
    if law["halving_takes"]:
        return f"{text}, half the error: {law['halving_takes']:.3g} x the time"
    return f"{text}, finer grids do not help"


def work_precision(study):
    figure, axis = plt.subplots(figsize=(9, 7.5), constrained_layout=True)
    for name, rows in study.lines.items():
        known = [r for r in rows if study.error_of(r)]
        if not known:
            continue
        law = law_text(study.laws[name]) if len(known) > 1 else ""
        axis.plot([r["seconds"] for r in known], [study.error_of(r) for r in known],
                  ms=5, lw=1.3, label=f"{name}: {law}" if law else name,
                  **study.styles[name])
    front = [r for r in study.rows if r["id"] in study.json["pareto"]]
    front.sort(key=lambda r: r["seconds"])
    axis.plot([r["seconds"] for r in front], [study.error_of(r) for r in front],
              "o", ms=12, mfc="none", mec="black", mew=1, label="Pareto front")
    proofs = [p for p in study.json["proofs"] if p["value"]]
    if proofs:
        axis.plot([p["predicted"]["seconds"] for p in proofs],
                  [p["predicted"]["error"] for p in proofs],
                  "+", ms=11, color="black", label="predicted by the fits")
        axis.plot([p["seconds"] for p in proofs], [p["value"] for p in proofs],
                  "x", ms=9, color="red", label="and run to prove it")
    against = {"exact": "the exact solution", "finer": "the next finer run",
               "run": "the reference run"}[study.json["reference"]]
    finish(axis, study, "seconds of a run", f"{study.error} against {against}")
    return figure


def cost(study):
    figure, axis = plt.subplots(figsize=(9, 7.5), constrained_layout=True)
    for name, rows in study.lines.items():
        exponent = study.laws[name]["time_exponent"]
        law = f": $cells^{{{exponent:.2f}}}$" if exponent is not None else ""
        axis.plot([cell_count(r) for r in rows], [r["seconds"] for r in rows], ms=5,
                  lw=1.3, label=name + law, **study.styles[name])
        for row in rows:  # the rounds show how quiet the machine was
            axis.plot([cell_count(row)] * len(row["rounds"]), row["rounds"], "_",
                      ms=5, color=study.styles[name]["color"], alpha=0.5)
    finish(axis, study, "cells", "seconds of a run")
    return figure


def finish(axis, study, x, y):
    axis.set_xscale("log")
    axis.set_yscale("log")
    axis.set_xlabel(x)
    axis.set_ylabel(y)
    axis.grid(which="both", alpha=0.25)
    axis.legend(fontsize=8, loc="upper center", bbox_to_anchor=(0.5, -0.1), ncols=2)
    axis.set_title(study.title(), fontsize=9)
    if study.failed:
        names = ", ".join(f"{r['line']} {'x'.join(map(str, r['cells']))}"
                          for r in study.failed)
        axis.annotate(f"failed: {names}", (0.01, 0.01), xycoords="axes fraction",
                      fontsize=7)


def main(arguments):
    parser = argparse.ArgumentParser(
        prog="plot.py study", description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter)
    add = parser.add_argument
    add("directory", type=pathlib.Path, help="output directory of a study")
    add("--output", type=pathlib.Path, metavar="DIR",
        help="where the pictures go (default: the study's directory)")
    options = parser.parse_args(arguments)
    try:
        study = Study(options.directory)
        if not study.rows:
            sys.exit(f"plot.py: {options.directory}: no run of the study has finished")
        folder = options.output or options.directory
        folder.mkdir(parents=True, exist_ok=True)
        for name, draw in [("work_precision.png", work_precision), ("cost.png", cost)]:
            draw(study).savefig(folder / name, dpi=130)
            print(folder / name)
    except (OSError, KeyError, ValueError) as error:
        sys.exit(f"plot.py: {options.directory}: cannot be drawn: {error}; give the "
                 "directory that machpoint study named with --output")
