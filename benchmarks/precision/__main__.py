"""What mixed and single precision cost in accuracy and give in time and memory.

Usage: python3 benchmarks/precision [--double DIR] [--mixed DIR] [--single DIR]
           [--rounds NUMBER] [--fast] [--docs]

Runs the same scenes on builds of the same backend in double, mixed and single
precision, in turn and on one thread:

    cmake --preset serial && cmake --build --preset serial
    for p in mixed single; do
        cmake --preset serial -B build/$p -D Machpoint_PRECISION=$p
        cmake --build build/$p --target machpoint
    done

--docs writes docs/performance.md, of all scenes and at least three rounds. Exit code:
0; 2 without three such builds.
"""
import pathlib
import statistics
import sys
import tempfile

sys.path += [str(pathlib.Path(__file__).resolve().parents[1] / name)
             for name in ("performance", "kernels", "speed")]

import jobs
import machine
import options
import page

PRECISIONS = ["double", "mixed", "single"]
CONSERVATIVE = {"method": {"name": "conservative", "basis": "quadratic"}}
APIC = {"method": {"name": "apic", "basis": "quadratic"}}
# Scene, what is changed, steps.
ERRORS = [("sod", CONSERVATIVE, None),
          ("sod", {**CONSERVATIVE, "grid.cells": [3200]}, None),
          *((name, CONSERVATIVE, None) for name in
            ["leblanc", "toro2", "toro3", "toro4", "toro5", "vacuum", "noh_1d",
             "mach100_shock", "slow_shock", "acoustic_wave", "gravity_column",
             "translation", "isentropic_vortex"])]
GRIDS = [64, 128, 256, 512]
# So many steps that the first, which touches memory anew, does not show.
SPEEDS = [
    ("`apic`, 2D, 512x512", "taylor_green",
     {**APIC, "grid.cells": [512, 512]}, 100),
    ("`conservative`, 2D, 512x512", "taylor_green",
     {**CONSERVATIVE, "grid.cells": [512, 512]}, 100),
    ("Mach 3 cylinder, 400x200", "cylinder_mach3",
     {**CONSERVATIVE, "grid.cells": [400, 200]}, 100),
    ("`apic`, 3D, Sedov, 48^3", "sedov_3d",
     {**APIC, "grid.cells": [48, 48, 48]}, 50),
    ("`conservative`, 1D, Sod, 3200", "sod",
     {**CONSERVATIVE, "grid.cells": [3200]}, 1000)]


def nanoseconds(summary):
    """Of a particle step."""
    return 1e9 / summary["particle_updates_per_second"]


def heads(text):
    """Of a column for each precision."""
    return [f"{text}, {PRECISIONS[0]}", *PRECISIONS[1:]]


def error_rows(run, some):
    rows = []
    for scene, sets, steps in some:
        found = [run(which, scene, sets, steps) for which in PRECISIONS]
        cells = found[0]["cells"]
        drift = [summary["conservation"]["total_energy"] for summary in found]
        rows.append([f"`{scene}`, {'x'.join(map(str, cells))}",
                     *(f"{s['errors']['density']['L1']:.4g}" for s in found),
                     *("" if d is None else f"{abs(d):.1e}" for d in drift),
                     " \\| ".join(str(s["retries"]) for s in found)])
    return page.table(["scene", *heads("error"), *heads("energy drift"),
                       "steps repeated"], rows)


def grid_rows(run, grids):
    rows = []
    for cells in grids:
        row = [f"{cells}x{cells}"]
        for method in (APIC, CONSERVATIVE):
            sets = {**method, "grid.cells": [cells, cells], "time.end": 0.1}
            for which in PRECISIONS:
                summary = run(which, "isentropic_vortex", sets)
                row.append(f"{summary['errors']['density']['L1']:.3g}")
        rows.append(row)
    return page.table(["vortex, t = 0.1", *heads("`apic`"),
                       *heads("`conservative`")], rows)


def speed_rows(run, some, rounds):
    """The table, and how far repeated runs lie apart."""
    found = {}
    for _ in range(rounds):
        for text, scene, sets, steps in some:
            for which in PRECISIONS:
                found.setdefault((text, which), []).append(
                    run(which, scene, sets, steps))
    rows, spreads = [], []
    for text, *_ in some:
        times = [[nanoseconds(s) for s in found[text, which]]
                 for which in PRECISIONS]
        spreads += map(machine.spread, times)
        gains = [statistics.median(a / b for a, b in zip(times[0], others))
                 for others in times[1:]]
        held = [found[text, which][0]["bytes_per_particle"]
                for which in PRECISIONS]
        rows.append([text, *(f"{statistics.median(t):.1f}" for t in times),
                     *(f"{gain:.2f}" for gain in gains),
                     *(f"{b:.0f}" for b in held)])
    return page.table(["", *heads("ns a particle step"),
                       *(f"double over {name}" for name in PRECISIONS[1:]),
                       *heads("bytes of a particle")], rows), spreads


def main():
    parser = options.parser(__doc__)
    for name, folder in zip(PRECISIONS, ("serial", "mixed", "single")):
        parser.add_argument(f"--{name}", type=pathlib.Path, metavar="DIR",
                            default=page.ROOT / "build" / folder,
                            help=f"build in {name} precision; default: build/{folder}")
    parser.add_argument("--rounds", type=options.whole(1), metavar="NUMBER",
                        help="how often each scene is run; default: 5")
    parser.add_argument("--fast", action="store_true",
                        help="three scenes in 2D, by default one round: a trial")
    parser.add_argument("--docs", action="store_true",
                        help="write docs/performance.md, too")
    arguments = parser.parse_args()
    fast = arguments.fast
    rounds = arguments.rounds or (1 if fast else 5)
    options.require_full(parser, arguments, rounds, ["fast"])
    if arguments.docs:
        page.require("precision")
    builds = {name: getattr(arguments, name) / "machpoint"
              for name in PRECISIONS}
    for build in builds.values():
        if not build.exists():
            parser.error(f"{build} is missing; see the top of "
                         "benchmarks/precision/__main__.py")
    watch = machine.Watch()
    with tempfile.TemporaryDirectory() as scratch:
        revisions = {jobs.revision(path) for path in builds.values()}
        if len(revisions) > 1:
            parser.error(f"the builds are of {' and '.join(sorted(revisions))}"
                         ": build all anew")

        def run(which, scene, sets, steps=None):
            summary = jobs.scene(builds[which], scene, sets, 1,
                                 pathlib.Path(scratch) / "run", steps)
            if summary["precision"] != which:
                parser.error(f"{builds[which]} computes in "
                             f"{summary['precision']} precision; see --{which}")
            return summary
        errors = error_rows(run, [("translation", CONSERVATIVE, None)]
                            if fast else ERRORS)
        grids = grid_rows(run, GRIDS[:1] if fast else GRIDS)
        speeds, spreads = speed_rows(
            run, [(*SPEEDS[2][:3], 10)] if fast else SPEEDS,
            rounds)
    text = (f"{page.written_by('precision', arguments.docs)} "
            f"({rounds} rounds, one thread) on {machine.processor()}; "
            f"revision `{jobs.revision(builds['single'])}`. "
            f"{machine.in_words(watch.report(spreads))}\n\n"
            f"{speeds}\nErrors of the density (L1) at the end, all with "
            f"`conservative`:\n\n{errors}\n"
            f"Errors on finer and finer grids:\n\n{grids}")
    print(text)
    if arguments.docs:
        page.write("precision", text)
    return 0


if __name__ == "__main__":
    sys.exit(main())
