"""How the time grows with the number of cells: figure 2 of Baioni et al. 2023.

Usage: python3 benchmarks/sod_sweep [--build [NAME=]DIR]... [--seconds NUMBER]
           [--largest NUMBER] [--threads NUMBER] [--output DIR] [--docs]

Runs Sod's tube at 100 * 2^k cells, k = 0 to 16, and the cylinder from 100x50 to
1600x800 with every preset that is built (serial, openmp, cuda), or those named. A
size that would take longer than --seconds is run for as many steps as fit (21 at
least), and its time to the end is predicted: time per step x steps, which grow as
the cells of an axis. Time per step is that of all but a run's first, which touches
memory for the first time. Prints time against cells, fits the slope of the time per
step past the first decade, writes DIR/results.json and DIR/sod_sweep.png. --docs also
writes docs/performance.md and docs/pictures/sod_sweep.png. A size for which the
memory is too small is left out, and named. Exit code: 0.
"""
import argparse
import json
import os
import pathlib
import shutil
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] /
                       "performance"))

import machine
import page
import picture
import sweep

PRESETS = ["serial", "openmp", "cuda"]


def builds(named):
    """{name: executable} of what is named, or of the presets that are built."""
    found = {}
    for text in named:
        name, _, folder = text.rpartition("=")
        folder = pathlib.Path(folder)
        found[name or folder.name] = folder / "machpoint"
    if not named:
        found = {name: page.ROOT / "build" / name / "machpoint"
                 for name in PRESETS}
        found = {name: path for name, path in found.items() if path.exists()}
    missing = [str(path) for path in found.values() if not path.exists()]
    if missing or not found:
        raise SystemExit(f"{' and '.join(missing) or 'no preset'} is not "
                         "built: build it, or name its folder with --build")
    return found


def section(record):
    """Of docs/performance.md."""
    text = (f"Written by `python3 benchmarks/sod_sweep --docs`; Machpoint "
            f"`{record['revision']}`, {record['processor']}, "
            f"{record['threads']} thread(s) of OpenMP, inputs as shipped.\n\n"
            "![Time against cells](pictures/sod_sweep.png)\n\n")
    text += page.table(
        ["", "slope of the time per step past the first decade", "asked for",
         ""],
        [[name, f"{slope:.3f}", "1.00 +- 0.05",
          "met" if abs(slope - 1) <= 0.05 else "**missed**"]
         for name, slope in record["slopes"].items() if slope is not None])
    lines = []
    for name, points in record["lines"].items():
        for point in points:
            predicted = "" if point["measured"] else " (predicted)"
            lines.append([
                name, " x ".join(f"{n:,}" for n in point["cells"]),
                f"{point['particles']:,}", f"{1e3 * point['first_step']:.3g}",
                f"{1e3 * point['step']:.3g}",
                f"{point['steps']}", f"{point['all_steps']}",
                f"{point['seconds']:.3g}{predicted}"])
    text += "\n" + page.table(["", "cells", "particles", "ms of the first step",
                               "ms a step", "steps run", "steps to the end",
                               "seconds to the end"], lines)
    if record["left_out"]:
        text += "\nLeft out:\n\n"
        text += "".join(f"- {reason}\n" for reason in record["left_out"])
    return text


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--build", action="append", default=[],
                        metavar="[NAME=]DIR")
    parser.add_argument("--seconds", type=float, default=20, metavar="NUMBER",
                        help="that a size may take, about")
    parser.add_argument("--largest", type=int, default=16, metavar="NUMBER",
                        help="k of the finest tube")
    parser.add_argument("--cylinders", type=int, default=5, metavar="NUMBER",
                        help="how many sizes of the cylinder")
    parser.add_argument("--threads", type=int, default=os.cpu_count(),
                        metavar="NUMBER")
    parser.add_argument("--output", metavar="DIR", default="out/sod_sweep")
    parser.add_argument("--docs", action="store_true")
    arguments = parser.parse_args()
    output = pathlib.Path(arguments.output)
    output.mkdir(parents=True, exist_ok=True)
    executables = builds(arguments.build)
    sizes = {"sod": [(100 * 2 ** k,) for k in range(arguments.largest + 1)],
             "cylinder_mach3": [(100 * 2 ** k, 50 * 2 ** k)
                                for k in range(arguments.cylinders)]}
    record = {"processor": machine.processor(), "threads": arguments.threads,
              "lines": {}, "slopes": {}, "left_out": []}
    for name, executable in executables.items():
        for scene, cells in sizes.items():
            line = f"{scene}, {name}"
            runner = sweep.Runner(executable, scene, arguments.threads,
                                  output / "run")
            points, reason = sweep.measure(runner, cells, arguments.seconds)
            if points:
                record["revision"] = runner.revision
                record["lines"][line] = points
                record["slopes"][line] = sweep.slope(points)
            if reason:
                record["left_out"].append(f"{line}: {reason}")
    if not record["lines"]:
        raise SystemExit("nothing could be run:\n" +
                         "\n".join(record["left_out"]))
    print(section(record))
    (output / "results.json").write_text(json.dumps(record, indent=2) + "\n")
    picture.draw(record, output / "sod_sweep.png")
    if arguments.docs:
        shutil.copy(output / "sod_sweep.png",
                    page.ROOT / "docs" / "pictures" / "sod_sweep.png")
        page.write("sod_sweep", section(record))
    return 0


if __name__ == "__main__":
    sys.exit(main())
