"""How the time grows with the number of cells: figure 2 of Baioni et al. 2023.

Usage: python3 benchmarks/sod_sweep [--build [NAME=]DIR]... [--rounds NUMBER]
           [--seconds NUMBER] [--largest NUMBER] [--cylinders NUMBER]
           [--threads NUMBER] [--output DIR] [--docs]

Runs Sod's tube at 100 * 2^k cells, k = 0 to 16, and the cylinder from 100x50 to
1600x800 with every preset that is built (serial, openmp, cuda), or those named.

What is timed is the same flow for all sizes. The cylinder's runs go to t = 0.1, with
as many steps as that takes: later ones take longer, as gas gathers ahead of it. The
tube cannot, with sixty thousand times as many cells and steps: it runs 41 steps, in
which its waves pass the same number of cells. Time per step is that of all but a
run's first, which touches memory for the first time. Sizes are run in turn, --rounds
times, but not again when their runs have taken --seconds together; one whose run
would take six times as long, or for which the memory is too small, is left out, and
named. Those that take less than --seconds to the end are run to it once; for the
others that is predicted: time per step x steps, which grow as the cells of an axis,
x how much longer a mean step took than a timed one at the finest size that was run
to the end. A backend takes some five minutes of two cores.

Prints time against cells, fits the slope of the time per step past the first decade,
tells how far the farthest size lies from that line, says whether the machine was
quiet, writes DIR/results.json and DIR/sod_sweep.png. --docs, of the full size and at
least three rounds, also writes docs/performance.md and docs/pictures/sod_sweep.png.
Exit code: 0; 2 for options that cannot be met.
"""
import json
import os
import pathlib
import shutil
import sys
import tempfile

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] /
                       "performance"))

import machine
import options
import page
import program
import sweep

PRESETS = ["serial", "openmp", "cuda"]
TITLES = ["", "cells", "particles", "ms of the first step", "ms a step", "steps",
          "runs", "apart", "to t =", "steps to the end", "seconds to the end",
          "a step of these over a timed one"]


def builds(parser, named):
    """{name: folder} of what is named, or of the presets that are built."""
    found = {}
    for text in named:
        name, _, folder = text.rpartition("=")
        folder = pathlib.Path(folder)
        name = name or folder.resolve().name
        if name in found:
            parser.error(f"{found[name]} and {folder} are both called {name}: say "
                         "--build NAME=DIR")
        if not (folder / "machpoint").is_file():
            parser.error(f"{folder / 'machpoint'} is not built: build it, or name "
                         "its folder with --build")
        found[name] = folder
    if not named:
        found = {name: page.ROOT / "build" / name for name in PRESETS
                 if (page.ROOT / "build" / name / "machpoint").is_file()}
    if not found:
        parser.error("no preset is built: build one, or name a folder with --build")
    return found


def row(name, point):
    predicted = "" if point["measured"] else " (predicted)"
    apart = f"{100 * point['spread']:.0f} %" if point["runs"] > 1 else "-"
    late = f"{point['late']:.2f}" if point["measured"] else "-"
    return [name, " x ".join(f"{n:,}" for n in point["cells"]),
            f"{point['particles']:,}", f"{1e3 * point['first_step']:.3g}",
            f"{1e3 * point['step']:.3g}", point["steps"], point["runs"], apart,
            f"{point['time']:.2g}", point["all_steps"],
            f"{point['seconds']:.3g}{predicted}", late]


def verdict(slope):
    return "met" if abs(slope - 1) <= 0.05 else "**missed**"


def section(record, docs):
    """Of docs/performance.md."""
    revisions = record["revisions"]
    of = f"`{next(iter(revisions.values()))}`" if len(set(revisions.values())) == 1 \
        else ", ".join(f"{name} `{own}`" for name, own in revisions.items())
    text = (f"{page.written_by('sod_sweep', docs)}; Machpoint {of}, "
            f"{record['processor']}, {record['threads']} thread(s) of OpenMP, inputs "
            f"as shipped, medians of at most {record['rounds']} runs. "
            f"{machine.in_words(record['machine'])}\n\n")
    if docs:
        text += "![Time against cells](pictures/sod_sweep.png)\n\n"
    slopes = {name: slope for name, slope in record["slopes"].items()
              if slope is not None}
    text += page.table(
        ["", "slope of the time per step past the first decade", "asked for", "",
         "farthest size from that line"],
        [[name, f"{slope:.3f}", "1.00 +- 0.05", verdict(slope),
          f"{100 * record['residuals'][name]:.1f} %"]
         for name, slope in slopes.items()])
    text += "\n" + page.table(TITLES, [
        row(name, point) for name, points in record["lines"].items()
        for point in points])
    if record["left_out"]:
        text += "\nLeft out:\n\n"
        text += "".join(f"- {reason}\n" for reason in record["left_out"])
    return text


def parse():
    parser = options.parser(__doc__)
    parser.add_argument("--build", action="append", default=[],
                        metavar="[NAME=]DIR",
                        help="may be repeated; default: every preset that is built")
    parser.add_argument("--rounds", type=options.whole(1), default=5,
                        metavar="NUMBER", help="how often a size is run, at most")
    parser.add_argument("--seconds", type=options.positive, default=30,
                        metavar="NUMBER",
                        help="after which a size is not run again")
    parser.add_argument("--largest", type=options.whole(0), default=16,
                        metavar="NUMBER", help="k of the finest tube")
    parser.add_argument("--cylinders", type=options.whole(0), default=5,
                        metavar="NUMBER", help="how many sizes of the cylinder")
    parser.add_argument("--threads", type=options.whole(1),
                        default=os.cpu_count(), metavar="NUMBER",
                        help="default: as many as cores")
    parser.add_argument("--output", type=options.folder, metavar="DIR",
                        default="out/sod_sweep", help="default: out/sod_sweep")
    parser.add_argument("--docs", action="store_true",
                        help="write docs/performance.md, too")
    arguments = parser.parse_args()
    options.require_full(parser, arguments, arguments.rounds,
                         ["largest", "cylinders", "seconds"])
    if arguments.docs:
        page.require("sod_sweep")
    return arguments, builds(parser, arguments.build)


def main():
    arguments, folders = parse()
    import picture # says what it lacks
    sizes = {"sod": [(100 * 2 ** k,) for k in range(arguments.largest + 1)],
             "cylinder_mach3": [(100 * 2 ** k, 50 * 2 ** k)
                                for k in range(arguments.cylinders)]}
    record = {"processor": machine.processor(), "threads": arguments.threads,
              "rounds": arguments.rounds,
              "revisions": {name: program.revision(folder / "machpoint")
                            for name, folder in folders.items()},
              "lines": {}, "slopes": {}, "residuals": {}, "left_out": []}
    triad = next(iter(folders.values())) / "machpoint_triad"
    watch = machine.Watch(triad if triad.is_file() else None)
    for name, folder in folders.items():
        for scene, cells in sizes.items():
            line = f"{scene}, {name}"
            with tempfile.TemporaryDirectory() as scratch:
                runner = sweep.Runner(folder / "machpoint", scene,
                                      arguments.threads, scratch)
                points, reason = sweep.measure(
                    runner, cells, arguments.rounds, arguments.seconds,
                    between=lambda: watch.probe(0.5))
            if points:
                record["lines"][line] = points
                record["slopes"][line], record["residuals"][line] = \
                    sweep.fit(points)
            if reason:
                record["left_out"].append(f"{line}: {reason}")
    if not record["lines"]:
        raise SystemExit("nothing could be run:\n" +
                         "\n".join(record["left_out"]))
    record["machine"] = watch.report(
        [point["spread"] for points in record["lines"].values()
         for point in points if point["runs"] > 1])
    text = section(record, arguments.docs)
    print(text)
    output = arguments.output
    (output / "results.json").write_text(json.dumps(record, indent=2) + "\n")
    picture.draw(record, output / "sod_sweep.png")
    if arguments.docs:
        shutil.copy(output / "sod_sweep.png",
                    page.ROOT / "docs" / "pictures" / "sod_sweep.png")
        page.write("sod_sweep", text)
    return 0


if __name__ == "__main__":
    sys.exit(main())
