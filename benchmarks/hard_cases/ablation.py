"""What each part of `conservative` costs and buys: it alone off, or, where it
is off by default, it alone on.

Usage: python3 benchmarks/hard_cases/ablation.py [--machpoint PATH]
           [--output DIR] [--docs]

Prints a table; --docs writes docs/ablation.md. Cost is the time of a particle
step of the cylindrical blast over the default's in the same round: the median of
five rounds, and how far they lie apart.
"""
import json
import pathlib
import statistics
import sys

sys.path.append(str(pathlib.Path(__file__).resolve().parents[1] / "performance"))

import executable
import options
import packages
import planes
import program
import report
from run import ROOT, execute, relative, settings

# Key of the input: its other value in 1D, and in 2D; None: not varied there.
PARTS = {
    "method.time": ("symplectic", "symplectic"),
    "method.least_filling": (0.5, 0.5),
    "method.volume_relaxation": (1, 0),
    "method.particle_shifting": (0.2, 0),
    "method.viscosity_limiter": (False, False),
    "method.blend": (1, 1),
    "method.blend_in_compression": (20, 0),
    "method.loss_return": (False, False),
    "method.pressure_relaxation": (0, 0.05),
    "method.heat_mixing": (0, 2),
    "method.heat_conduction": (None, 0),
    "method.split_volume": (0, 0),
    "method.merge_volume": (0.125, 0),
    "treatment": (None, "projection"),
    "time.retries": (0, 0),
}

ROUNDS = 5  # of timing


def density_error(runs):
    return {"": runs[0].error()}


def blast(runs):
    found = planes.sedov(runs)
    return {label.split(",")[0]: value for label, value in found.items()}


def shock(runs):
    found = planes.bow_shock(runs)
    return {label.split(",")[0]: value for label, value in found.items()}


# Column: scene, overrides, what is measured, labels shown.
COLUMNS = {
    "Sod": ("sod", {}, density_error, [""]),
    "Toro 3": ("toro3", {}, density_error, [""]),
    "LeBlanc": ("leblanc", {}, density_error, [""]),
    "Noh": ("noh_1d", {}, density_error, [""]),
    "wave 64": ("acoustic_wave", {"grid.cells": [64]}, density_error, [""]),
    "blast 100²": ("sedov_2d", planes.blasts((100, 4))[0], blast,
                   ["shock radius", "peak density", "scatter"]),
    "cylinder": ("cylinder_mach3", dict(planes.CYLINDER, **{
        "grid.cells": [100, 50]}), shock,
                 ["stand-off", "pitot", "pitot's std"]),
}


def measure(machpoint, output, column, part):
    """({label: value}, particle updates/s), (None, None) where the part is not
    varied; speed None if the run failed."""
    scene, sets, figures, labels = COLUMNS[column]
    document = json.loads((ROOT / "input" / f"{scene}.json").read_text())
    dimension = document["dimension"]
    keys = settings(document, "conservative", dict(
        sets, **{"method.time": "midpoint", "time.cfl": 0.8}))
    keys.setdefault("output.every", 1e9)
    if part:
        value = PARTS[part][0 if dimension == 1 else 1]
        if value is None:
            return None, None
        if part == "treatment":
            body = [k for k, entry in enumerate(document["boundary"])
                    if entry["type"] == "obstacle"]
            if not body:
                return None, None
            keys[f"boundary.{body[0]}.treatment"] = value
        elif part == "method.time":
            keys["method.time"] = value
            keys["time.cfl"] = 0.4
        else:
            keys[part] = value
    run = execute(machpoint, f"input/{scene}.json", keys,
                  output / f"{scene}-{part or 'default'}", 1800)
    if run.code != 0:
        return {"": f"exit {run.code}"}, None
    found = figures([run])
    return ({label: found.get(label) for label in labels},
            run.summary["particle_updates_per_second"])


def show(values):
    if values is None:
        return "-"
    return " / ".join(value if isinstance(value, str) else relative(value)
                      for value in values.values())


def main():
    parser = options.parser(__doc__)
    executable.add_option(parser)
    parser.add_argument("--output", metavar="DIR", default="out/ablation",
                        help="default: out/ablation")
    parser.add_argument("--docs", action="store_true",
                        help="write docs/ablation.md, too")
    arguments = packages.parse(parser)
    machpoint = str(pathlib.Path(arguments.machpoint).resolve())
    revision = program.revision(machpoint)
    output = pathlib.Path(arguments.output)

    rows, speeds = {}, {}
    for part in [None, *PARTS]:
        rows[part] = {}
        for column in COLUMNS:
            rows[part][column], speed = measure(machpoint, output, column, part)
            if column == "blast 100²" and speed:
                speeds[part] = [speed]
        print(part or "default", {c: show(v) for c, v in rows[part].items()},
              flush=True)
    # Turn by turn, so that a noisy machine harms all alike.
    for _ in range(ROUNDS - 1):
        for part, found in speeds.items():
            found.append(measure(machpoint, output, "blast 100²", part)[1])

    def cost(part):
        ratios = sorted(base / own
                        for base, own in zip(speeds[None], speeds[part])
                        if base and own)
        if not ratios:
            return "-"
        return (f"{statistics.median(ratios):.2f} "
                f"({ratios[0]:.2f} to {ratios[-1]:.2f})")

    text = [
        "# What each part costs and buys", "",
        "Generated by `python3 benchmarks/hard_cases/ablation.py --docs`; do not "
        f"edit. Machpoint `{revision}`, measured on {report.computer()}. The "
        "method `conservative` on quadratic splines, `midpoint` at CFL 0.8 "
        "(`symplectic` at 0.4); in each "
        "row one key has the value shown, for 1D and for 2D. L1 of the density "
        "in 1D; the cylindrical blast's shock radius (exact .75), peak density "
        "(6) and scatter; the Mach 3 cylinder's (100x50) stand-off, pitot "
        "pressure (12.06) and its deviation in time. *Cost*: time of a particle "
        "step of the blast over the default's in the same round: median and "
        f"range of {ROUNDS} rounds.", "",
        "| key | 1D, 2D | " + " | ".join(COLUMNS) + " | cost |",
        "|---|---|" + "---|" * (len(COLUMNS) + 1)]
    for part, row in rows.items():
        values = "default" if part is None else ", ".join(
            "-" if v is None else json.dumps(v) for v in PARTS[part])
        text.append(f"| {(part or '').split('.')[-1]} | {values} | " +
                    " | ".join(show(v) for v in row.values()) +
                    f" | {cost(part) if part in speeds else '-'} |")
    print("\n".join(text))
    if arguments.docs:
        (ROOT / "docs/ablation.md").write_text("\n".join(text) + "\n")


if __name__ == "__main__":
    main()
