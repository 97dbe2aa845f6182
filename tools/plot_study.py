"""Draws what machpoint study left in its output directory (plot.py study DIR).

work_precision.png: error against seconds, a line for each combination of the
settings that are not cells; the Pareto front is marked, and the legend says the
order and what half the error costs. cost.png: seconds against cells. report.html:
both, with all tables and the input, in one file that needs no other.

Of a study of effects: effects.png, what the run takes less, and how far its result
is off, when each effect is left out; report.html with that and its table.
"""
import argparse
import html
import io
import json
import pathlib
import statistics
import sys

import matplotlib

matplotlib.use("Agg")
import matplotlib.patches
import matplotlib.pyplot as plt
import matplotlib.ticker

from html_page import listing, number, page, table

MARKERS = "osD^vP*X<>"
STYLES = ["-", "--", ":", "-."]


class Study:
    """study.json, its finished rows by lines."""

    def __init__(self, directory):
        self.json = json.loads((directory / "study.json").read_text())
        self.error = self.json["error"]
        self.is_of_effects = self.json.get("kind") == "effects"
        is_wall = self.json["clock"] == "wall"
        self.rounds = "wall_rounds" if is_wall else "cpu_rounds"
        self.seconds = f"{'' if is_wall else 'processor '}seconds of a run"
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
                f"{'/'.join(map(str, threads))} thread(s), {self.revisions()}")

    def revisions(self):
        """Of the programs that made the rows."""
        return ", ".join(sorted({row["revision"] for row in self.rows}))

    def error_of(self, row):
        return row.get("errors", {}).get(self.error)


def cell_count(row):
    count = 1
    for n in row["cells"]:
        count *= n
    return count


def factor(value):
    return "> 1000" if value > 1000 else f"{value:.3g}"


def law_text(law):
    """What the legend says of a line."""
    if law["order"] is None:
        return ""
    text = f"$h^{{{law['order']:.2f}}}$"
    if law["halving_takes"]:
        return f"{text}, half the error: {factor(law['halving_takes'])} x the time"
    if law["order"] > 0:
        return f"{text}, too fast for a law"
    return f"{text}, finer grids do not help"


def log_axes():
    figure, axis = plt.subplots(figsize=(9, 7.5), constrained_layout=True)
    axis.set_xscale("log")
    axis.set_yscale("log")
    for side in (axis.xaxis, axis.yaxis):  # short axes need numbers between powers
        side.set_minor_formatter(
            matplotlib.ticker.LogFormatterSciNotation(minor_thresholds=(1.7, 0.5)))
        side.set_tick_params(which="minor", labelsize=7)
    return figure, axis


def work_precision(study):
    figure, axis = log_axes()
    for name, rows in study.lines.items():
        known = [r for r in rows if study.error_of(r)]
        if not known:
            continue
        law = law_text(study.laws[name]) if len(known) > 1 else ""
        axis.plot([r["seconds"] for r in known], [study.error_of(r) for r in known],
                  ms=5, lw=1.3, label=f"{name}: {law}" if law else name,
                  **study.styles[name])
    front = [r for r in study.rows
             if r["id"] in study.json["pareto"] and study.error_of(r)]
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
    # What has blown up may leave the picture, or there would be none.
    errors = [study.error_of(r) for r in front]
    if errors and axis.get_ylim()[1] > 100 * max(errors):
        axis.set_ylim(0.5 * min(errors), 100 * max(errors))
    against = {"exact": "the exact solution", "finer": "the next finer run",
               "run": "the reference run", "known": "the known value"}[study.json["reference"]]
    finish(axis, study, study.seconds, f"{study.error} against {against}")
    return figure


def cost(study):
    figure, axis = log_axes()
    for name, rows in study.lines.items():
        exponent = study.laws[name]["time_exponent"]
        law = f": $cells^{{{exponent:.2f}}}$" if exponent is not None else ""
        axis.plot([cell_count(r) for r in rows], [r["seconds"] for r in rows], ms=5,
                  lw=1.3, label=name + law, **study.styles[name])
        for row in rows:  # the rounds show how quiet the machine was
            rounds = row[study.rounds]
            axis.plot([cell_count(row)] * len(rounds), rounds, "_",
                      ms=5, color=study.styles[name]["color"], alpha=0.5)
    axis.plot([], [], "_", ms=5, color="0.5", label="each round of a run")
    finish(axis, study, "cells", study.seconds)
    return figure


def effects(study):
    """Bars for each effect: time, memory, and what its absence does."""
    table, whole = study.json["effects"], study.json["rows"][0]
    results = list(table[0]["result"])
    changes = [name for name in results if name.endswith(".change")]
    panels = 4 if study.error in results else 3
    figure, axes = plt.subplots(1, panels, sharey=True, constrained_layout=True,
                                figsize=(3.8 * panels, 2.2 + 0.42 * len(table)))
    places = range(len(table))
    time, memory, change = axes[:3]
    time.set_yticks(places, [entry["effect"] for entry in table])
    time.invert_yaxis()

    share = 100 / whole["seconds"]
    status = {row["id"]: row["status"] for row in study.json["rows"]}
    for place, entry in zip(places, table):
        if not entry["price"]:
            has_failed = status[entry["id"]] == "failed"
            time.annotate(" fails without it" if has_failed else " not run yet",
                          (0, place), va="center", fontsize=8, color="C3")
            continue
        time.barh(place, share * entry["price"]["seconds"], 0.7, color="C0")
        if entry["own"]:
            time.barh(place, share * entry["own"]["seconds"], 0.3, color="C1")
        memory.barh(place, entry["price"]["array_bytes"] / 1024, 0.7, color="C0")
    noise = share * study.json["time_noise"]
    time.axvspan(-noise, noise, color="0.85", zorder=0)
    time.set_xlabel(f"% of the run's {number(whole['seconds'])} s")
    memory.set_xlabel(f"KiB of {whole['array_bytes'] / 1024:.0f} KiB of arrays")
    for axis in (time, memory):
        axis.axvline(0, color="black", lw=0.6)
    time.legend(handles=[
        matplotlib.patches.Patch(color="C0", label="less without it"),
        matplotlib.patches.Patch(color="C1", label="its own passes"),
        matplotlib.patches.Patch(color="0.85", label="noise")],
        fontsize=7)

    height = 0.8 / len(changes)
    for k, name in enumerate(changes):
        change.barh([place - 0.4 + (k + 0.5) * height for place in places],
                    [entry["result"][name] or 0 for entry in table], height,
                    label=name.removesuffix(".change"), color=f"C{k + 2}")
    if any(entry["result"][name] for entry in table for name in changes):
        change.set_xscale("log")
    change.set_xlabel("relative change of the result without it")
    change.legend(fontsize=7)
    if panels == 4:
        axes[3].barh(places, [entry["result"][study.error] or 0 for entry in table],
                     0.7, color="C0", label="without it")
        axes[3].axvline(study.error_of(whole), color="black", label="as it is")
        axes[3].set_xlabel(f"{study.error} against the exact solution")
        axes[3].set_xscale("log")
        # What has blown up may leave the picture.
        axes[3].set_xlim(0.3 * study.error_of(whole), min(
            axes[3].get_xlim()[1], 100 * study.error_of(whole)))
        axes[3].legend(fontsize=7)
    for axis in axes:
        axis.grid(axis="x", alpha=0.25)
    figure.suptitle(study.title(), fontsize=9)
    return figure


def finish(axis, study, x, y):
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


# --------------------------------------------------------------------------
# report.html
# --------------------------------------------------------------------------

def accuracy_parts(study):
    """Laws, runs and predictions."""
    data = study.json
    rows = []
    for row in data["rows"]:
        cells = [row["line"], " x ".join(map(str, row["cells"]))]
        if row["status"] == "finished":
            cells += [number(statistics.median(row["wall_rounds"])),
                      number(statistics.median(row["cpu_rounds"])),
                      number(study.error_of(row), ".3e"), row["steps"],
                      number(row["particle_updates"] / 1e6),
                      number(row["memory_bytes"] / 2**20, ".1f")]
        else:
            cells += [row.get("message", row["status"])] + [""] * 5
        rows.append(("front" if row["id"] in data["pareto"] else "", cells))
    laws = [("", [law["line"], law["runs"], number(law["time_exponent"]),
                  number(law["order"]),
                  factor(law["halving_takes"]) if law["halving_takes"] else "-"])
            for law in data["laws"]]
    proofs = [("", [p["request"], p["row"]["line"],
                    " x ".join(map(str, p["row"]["cells"])),
                    number(p["predicted"]["seconds"]), number(p["seconds"]),
                    number(p["predicted"]["error"], ".3e"), number(p["value"], ".3e")])
              for p in data["proofs"]]
    parts = [
        "<h2>Laws</h2><p>Time ~ cells^a and error ~ h^p, of the finest runs; half the "
        "error takes so many times the time.</p>",
        table(["line", "runs", "a", "p", "half the error"], laws),
        "<h2>Runs</h2><p>Bold: the Pareto front, no other run is as fast and as "
        "accurate.</p>",
        table(["line", "cells", "wall seconds", "processor seconds", data["error"], "steps",
               "M updates", "MiB"], rows)]
    if proofs:
        parts += ["<h2>Predictions</h2>",
                  table(["asked", "line", "cells", "seconds, predicted", "real",
                         "error, predicted", "real"], proofs)]
    return parts


def effects_parts(study):
    """Prices and changes, and the runs that failed."""
    data, whole = study.json, study.json["rows"][0]
    names = list(data["effects"][0]["result"])
    rows = []
    for entry in data["effects"]:
        own, price = entry["own"], entry["price"]
        cells = [entry["effect"],
                 number(own and own["kernels"] / whole["steps"]),
                 number(own and own["seconds"]),
                 number(price and price["seconds"]),
                 number(price and 100 * price["seconds"] / whole["seconds"], ".1f"),
                 number(price and price["array_bytes"] / 1024),
                 number(price and price["steps"], ".0f")]
        rows.append(("", cells + [number(entry["result"][name], ".2e")
                                  for name in names]))
    error = study.error_of(whole)
    parts = [
        "<h2>Effects</h2>"
        f"<p>As it is: {' x '.join(map(str, whole['cells']))} cells, {whole['steps']} "
        f"steps, {number(whole['kernels'] / whole['steps'])} kernels a step, "
        f"{number(whole['seconds'])} s, {whole['array_bytes'] / 1024:.0f} KiB of "
        f"arrays{f', {html.escape(study.error)} {error:.3e}' if error else ''}.</p>"
        "<p>Its own: the passes that serve an effect alone (-: it works within other "
        "kernels). Less: what the run takes less without it. Then the result without "
        "it; a change is the L1 of the difference over that of the field as it is.</p>",
        table(["effect", "own kernels a step", "own seconds", "seconds less", "% less",
               "KiB less", "steps less", *names], rows)]
    if study.failed:
        parts += ["<h2>Failed</h2>",
                  table(["run", "why"], [("", [row["line"], row["message"]])
                                         for row in study.failed])]
    return parts


def report(study, pictures):
    """The text of report.html. pictures: SVG texts"""
    data = study.json
    title = f"Study {html.escape(data['study'])}"
    parts = [
        f"<h1>{title}</h1>",
        f"<p>Scene {html.escape(data['scene'])}, {data['dimension']}D, "
        f"{html.escape(data['error'])}; each run is the {'least' if study.is_of_effects else 'median'} of "
        f"{data['repeats']} by the {data['clock']} clock. "
        f"{html.escape(data['machine']['processor'])}, {data['machine']['cores']} cores; "
        f"revision {html.escape(study.revisions())}.</p>",
        *(f"<figure>{picture}</figure>" for picture in pictures),
        *(effects_parts if study.is_of_effects else accuracy_parts)(study),
        listing("Input", data["input"])]
    return page(title, parts)


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
        if study.is_of_effects and not study.json["effects"]:
            sys.exit(f"plot.py: {options.directory}: the scene has no effect that "
                     "could be left out, so there is nothing to draw")
        if study.is_of_effects and study.json["rows"][0]["status"] != "finished":
            sys.exit(f"plot.py: {options.directory}: the run with all effects has not "
                     "finished, and the others are held against it")
        if not study.rows:
            sys.exit(f"plot.py: {options.directory}: no run of the study has finished")
        folder = options.output or options.directory
        folder.mkdir(parents=True, exist_ok=True)
        pictures = []
        drawings = [("work_precision.png", work_precision), ("cost.png", cost)]
        if study.is_of_effects:
            drawings = [("effects.png", effects)]
        for name, draw in drawings:
            figure = draw(study)
            figure.savefig(folder / name, dpi=130)
            print(folder / name)
            text = io.StringIO()
            figure.savefig(text, format="svg")
            pictures.append(text.getvalue()[text.getvalue().index("<svg"):])
        (folder / "report.html").write_text(report(study, pictures))
        print(folder / "report.html")
    except (OSError, KeyError, ValueError) as error:
        sys.exit(f"plot.py: {options.directory}: cannot be drawn: {error}; give the "
                 "directory that machpoint study named with --output")
