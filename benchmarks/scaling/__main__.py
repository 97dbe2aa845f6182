"""Strong and weak scaling over ranks, and what limits it.

Usage: python3 benchmarks/scaling [--machpoint PATH] [--fast] [--docs]
           [--topic NAME]... [--repeats NUMBER] [--steps NUMBER]
           [--mpiexec COMMAND] [--triad PATH] [--output DIR]

Runs scenes on 1, 2 and 4 ranks of one thread each, in turn, so that a drift of the
machine meets all alike; prints medians and writes DIR/results.json. Beside them
stand what the machine itself allows in the same session (memory bandwidth of one
process and of two, two runs that know nothing of each other), how much work a rank
needs (load), what wider B-splines cost in messages, and a model of the costs. --docs
writes docs/scaling.md too. A case that the build lacks (dimension, basis) is left
out, and named. On a machine with other work going on, figures mean little. Exit
code: 0.
"""
import json
import os
import pathlib
import statistics
import subprocess
import sys

sys.path.append(str(pathlib.Path(__file__).resolve().parents[1] / "performance"))

import executable
import launcher
import model
import options
import packages
import report
from case import Bench, Case, shares_kept, summarise
from page import ROOT


def cases(fast, steps=None):
    """{topic: [cases]}; a case may serve several topics."""
    flat, solid = ((32, 12) if fast else (128, 16))
    steps = steps or (3 if fast else 30)
    vortex, sedov, cylinder = ("isentropic_vortex", "sedov_3d",
                               "cylinder_mach3")
    wide = 60 if fast else 200
    cube = 16 if fast else 24
    sides = {vortex: (16, 24) if fast else (32, 64, 256, 512),
             sedov: (12,) if fast else (12, 48)}

    def made(scene, cells, ranks, **more):
        return Case(scene, tuple(cells), ranks, steps, **more)

    def grown(cells, times):
        return tuple(n * k for n, k in zip(cells, times))

    def pair(scene, cells):
        """One rank, two with as many cells each, two runs apart."""
        times = (1,) * (len(cells) - 1) + (2,)
        return [made(scene, cells, 1),
                made(scene, grown(cells, times), 2, domains=times),
                made(scene, cells, 1, copies=2)]

    box = (flat, flat)
    block = (cube, cube, cube)
    topics = {
        "strong": [made(vortex, box, r) for r in (1, 2, 4)] +
                  [made(cylinder, (wide, wide // 2), r) for r in (1, 2, 4)] +
                  [made(sedov, block, r) for r in (1, 2, 4)],
        "weak": [made(vortex, box, 1)] +
                [made(vortex, grown(box, times), r, domains=times)
                 for r, times in ((2, (1, 2)), (4, (2, 2)))] +
                [made(sedov, block, 1)] +
                [made(sedov, grown(block, times), r, domains=times)
                 for r, times in ((2, (1, 1, 2)), (4, (1, 2, 2)))],
        "apart": [made(vortex, box, 1, copies=2),
                  made(sedov, block, 1, copies=2)],
        "load": [c for scene, lengths in sides.items() for n in lengths
                 for c in pair(scene, (n,) * (2 if scene == vortex else 3))],
        "stencil": [made(vortex, box, 2, method=method, basis=basis)
                    for method in ("apic", "conservative")
                    for basis in ("linear", "quadratic", "cubic")],
    }
    # For the model alone: other ratios of surface to volume.
    half = flat // 2
    topics["surface"] = [
        made(vortex, (half, half), 2), made(vortex, (half, flat), 2),
        made(vortex, (half, half), 4), made(vortex, (flat, half), 4),
        made(sedov, (solid, solid, solid), 2),
        made(sedov, (solid, solid, cube), 2),
        made(sedov, (solid, solid, solid), 4)]
    return topics


def bandwidth(triad, copies, seconds):
    """Bytes per second of each of some processes at once."""
    started = [subprocess.Popen([str(triad), str(seconds)],
                                stdout=subprocess.PIPE, text=True)
               for _ in range(copies)]
    return [float(process.communicate()[0]) for process in started]


def show(name, f):
    parts = ", ".join(f"{key} {1e3 * value:.2f}"
                      for key, value in f["seconds"].items())
    low, high = f["step_range"]
    print(f"{name:<62} {1e3 * f['step']:8.2f} ms/step "
          f"({1e3 * low:.2f} to {1e3 * high:.2f}): {parts}", flush=True)


def show_kept(kept):
    for row in kept:
        for what in ("2 ranks", "2 runs"):
            if row[what]:
                median, low, high = row[what]
                print(f"{row['scene']}, {row['particles']:,} particles a rank, "
                      f"{what}: efficiency {median:.3f} ({low:.2f} to "
                      f"{high:.2f})")


def main():
    parser = options.parser(__doc__)
    executable.add_option(parser)
    parser.add_argument("--triad", metavar="PATH", type=options.program,
                        help="machpoint_triad; default: beside machpoint")
    parser.add_argument("--mpiexec", metavar="COMMAND", default="mpirun",
                        help="starts several ranks; default: mpirun")
    parser.add_argument("--output", metavar="DIR", type=options.folder,
                        default="out/scaling", help="default: out/scaling")
    parser.add_argument("--repeats", type=options.whole(1), metavar="NUMBER",
                        help="how often each scene is run; default: 5, with --fast 2")
    # The first one is not counted.
    parser.add_argument("--steps", type=options.whole(2), metavar="NUMBER",
                        help="of a run; long ones overlap better")
    parser.add_argument("--topic", action="append", choices=list(cases(True)),
                        help="may be repeated; default: all")
    parser.add_argument("--fast", action="store_true",
                        help="small scenes, two repeats: does it work?")
    parser.add_argument("--docs", action="store_true",
                        help="write docs/scaling.md, too")
    arguments = packages.parse(parser)
    repeats = arguments.repeats or (2 if arguments.fast else 5)
    options.require_full(parser, arguments, repeats, ["fast", "topic", "steps"])
    triad = pathlib.Path(arguments.triad or
                         pathlib.Path(arguments.machpoint).parent /
                         "machpoint_triad")
    if not triad.exists():
        parser.error(f"{triad} is missing: build the target machpoint_triad, "
                     "or name it with --triad")

    bench = Bench(arguments.machpoint, launcher.find(parser, arguments.mpiexec),
                  arguments.output)
    topics = {topic: found if topic in (arguments.topic or [topic]) else []
              for topic, found
              in cases(arguments.fast, arguments.steps).items()}
    every = list(dict.fromkeys(c for some in topics.values() for c in some))
    runs = {case: [] for case in every}
    rates = {1: [], 2: []}
    for _ in range(repeats):
        for copies, found in rates.items():
            found.append(bandwidth(triad, copies,
                                   0.2 if arguments.fast else 1.5))
        for case in every:
            figures = bench.run(case)
            if figures:
                runs[case].append(figures)
    results = {case: summarise(found) for case, found in runs.items() if found}
    for case, figures in results.items():
        show(case.name, figures)
    kept = shares_kept([c for topic in ("weak", "apart", "load")
                        for c in topics[topic]], runs)
    show_kept(kept)
    for name, reason in bench.lacking.items():
        print(f"{name}: left out: {reason}")
    fits = {}
    for dim in (2, 3):
        of_model = [(case, results[case]) for topic in ("strong", "weak",
                                                        "surface")
                    for case in topics[topic]
                    if case in results and len(case.cells) == dim
                    and case.scene != "cylinder_mach3"]
        if any(case.ranks > 1 for case, _ in of_model):
            fits[dim] = model.fit(dict(of_model).items(), dim)
    memory = {copies: statistics.median(sum(rate) for rate in found)
              for copies, found in rates.items()}
    for copies, rate in memory.items():
        print(f"memory bandwidth, {copies} at once: {rate / 1e9:.2f} GB/s")
    for dim, fitted in fits.items():
        print(f"model, {dim}D: {fitted}")

    (arguments.output / "results.json").write_text(json.dumps({
        "cores": os.cpu_count(), "repeats": repeats,
        "cases": {case.name: figures for case, figures in results.items()},
        "commands": bench.commands, "left_out": bench.lacking,
        "efficiency_of_two": kept,
        "memory_bandwidth": memory, "model": fits}, indent=2) + "\n")
    if arguments.docs:
        (ROOT / "docs" / "scaling.md").write_text(report.write(
            topics, results, kept, bench, memory, fits, repeats))
    return 0


if __name__ == "__main__":
    sys.exit(main())
