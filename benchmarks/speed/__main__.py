"""Machpoint's speed beside yardsticks on the same work, in one session.

Usage: python3 benchmarks/speed [--build DIR] [--serial DIR] [--python PATH]
           [--rounds NUMBER] [--dimensions DIM...] [--fast] [--output DIR] [--docs]

Runs `apic` and `conservative` with the gas's own step (ideal gas, energy, loss
return, retries), both builds of the plain loop, of which the faster one counts, and
Taichi and Warp where PATH has them (`pip install taichi warp-lang` into an
environment of its own), in turn, so that a drift of the machine meets all alike;
then the cylinder (twice at most), Sod's tube and the memory of a particle (once).
Prints medians and what they are held against, says whether the machine was quiet,
and writes DIR/results.json. --docs, of at least three rounds, writes
docs/performance.md too. What cannot run is left out, and named. Exit code: 0; 2 for
options that cannot be met.
"""
import functools
import json
import pathlib
import sys
import tempfile

HERE = pathlib.Path(__file__).resolve().parents[1]
sys.path += [str(HERE / "performance"), str(HERE / "kernels")]

import jobs
import machine
import options
import page
import results
import targets
from jobs import Job
from sizes import FULL, TINY

ORDERS = ["ordered", "mixed"]


class Session:
    """Jobs, run in rounds; those that lack something are left out."""

    def __init__(self, watch, probe_seconds):
        self.watch = watch
        self.probe_seconds = probe_seconds
        self.figures = {}
        self.lacking = {}

    def run(self, some, rounds):
        for number in range(rounds):
            self.watch.probe(self.probe_seconds)
            for job in some:
                if job.name in self.lacking:
                    continue
                if job.rounds is not None and number >= job.rounds:
                    continue
                try:
                    figure = job.measure()
                except jobs.Lacking as reason:
                    self.lacking[job.name] = str(reason)
                    continue
                self.keep(figure if isinstance(figure, dict) else
                          {job.name: figure})
        self.watch.probe(self.probe_seconds)

    def keep(self, figures):
        for name, figure in figures.items():
            self.figures.setdefault(name, []).append(figure)
            print(f"{' '.join(map(str, name))}: {figure:.4g}", flush=True)


def make_jobs(arguments, sizes, directory):
    """All jobs. directory: for the runs' output."""
    build = arguments.build
    serial = arguments.serial / results.EXECUTABLE
    cells, particles, steps = sizes.cells, sizes.particles, sizes.steps
    machpoint = build / "machpoint"
    ours = build / results.EXECUTABLE
    revision = jobs.revision(machpoint)
    partial = functools.partial
    updates = partial(jobs.updates, ours, revision)
    methods = ["apic", "conservative_symplectic", "conservative_midpoint"]
    found = []

    def step(method, order, threads):
        """In 2D; with its parts where these are held against their bytes."""
        name = ("ours", method, 2, order, threads)
        of = method, 2, order, particles, threads
        return Job(name, partial(jobs.updates_and_parts, name, ours, revision, *of)
                   if (order, threads) == ("ordered", 1) else
                   partial(updates, *of))

    def loop(name, command, threads, module=None, package=None):
        for order in ORDERS:
            def measure(order=order):
                if module:
                    jobs.require_module(arguments.python, module, package)
                return jobs.yardstick(command, cells, steps, order, threads)
            found.append(Job((name, order, threads), measure))

    for threads in (1, 2):
        found += [step("apic", order, threads) for order in ORDERS]
        for name, program in jobs.PLAIN_LOOPS.items():
            loop(name, [build / program], threads)
        loop("taichi", [arguments.python,
                        HERE / "yardstick" / "taichi_loop.py"], threads,
             "taichi", "taichi")
        if threads == 1:
            loop("warp", [arguments.python, HERE / "yardstick" /
                          "warp_loop.py"], 1, "warp", "warp-lang")
        if 3 in arguments.dimensions:
            found.append(Job(("ours", "apic", 3, "ordered", threads),
                             partial(updates, "apic", 3, "ordered",
                                     particles, threads)))
    found.append(step("apic", "unsorted", 1))
    found += [step(method, order, 1) for method in methods[1:]
              for order in ORDERS]
    for dim in arguments.dimensions:
        found.append(Job(("serial", dim),
                         partial(jobs.updates, serial, revision, "apic", dim,
                                 "ordered", particles, 1)))
    found.append(Job(("bytes",), partial(jobs.counted_bytes, ours, revision,
                                         methods), 1))
    for method in ("apic", "conservative"):
        for words, retries in (("", {}), (", no retries", {"retries": 0})):
            for name, measure in (("memory", jobs.peak_bytes),
                                  ("held", jobs.held_bytes)):
                found.append(Job((name + words, method),
                                 partial(measure, machpoint, method, cells,
                                         directory, **retries), 1))
    for name, sets in ((("cylinder",), {}),
                       (("cylinder", "cfl 1.2"), {"time.cfl": 1.2})):
        sets = {"grid.cells": sizes.cylinder, **sets}
        found.append(Job(name, lambda sets=sets: jobs.scene(
            machpoint, "cylinder_mach3", sets, 2, directory,
            sizes.cylinder_steps)["wall_seconds"], 2))
    return found


def sod_job(machpoint, sizes, directory):
    """Sod's tube at a given error: how to reach it is found first. \\raises
    Lacking"""
    sets = jobs.sod_settings(machpoint, sizes.sod_error, sizes.sod_cells,
                             directory)
    return sets, Job(("sod",), lambda: jobs.scene(
        machpoint, "sod", sets, 1, directory)["wall_seconds"])


def section(record, docs):
    """Of docs/performance.md. record: what results.json holds."""
    text = (f"{page.written_by('speed', docs)}; Machpoint "
            f"`{record['revision']}`, {record['processor']}, medians; 2D on "
            f"{record['cells']} x {record['cells']} cells. "
            f"{machine.in_words(record['machine'])}\n\n")
    text += record["verdicts"] + "\n" + record["speeds"]
    if record["left_out"]:
        text += "\nLeft out:\n\n"
        text += "".join(f"- {name}: {reason}\n" for name, reason in
                        record["left_out"].items())
    return text


def parse():
    """The options, which can be met, and the rounds."""
    parser = options.parser(__doc__)
    parser.add_argument("--build", metavar="DIR", type=pathlib.Path,
                        default=page.ROOT / "build/openmp",
                        help="default: build/openmp")
    parser.add_argument("--serial", metavar="DIR", type=pathlib.Path,
                        default=page.ROOT / "build/serial",
                        help="default: build/serial")
    parser.add_argument("--python", metavar="PATH", type=options.program,
                        default=sys.executable,
                        help="interpreter that has taichi and warp")
    parser.add_argument("--rounds", type=options.whole(1), metavar="NUMBER",
                        help="5, or with --fast 1")
    parser.add_argument("--dimensions", type=int, nargs="+", default=[2, 3],
                        choices=[2, 3], metavar="DIM", help="default: 2 3")
    parser.add_argument("--output", metavar="DIR", type=options.folder,
                        default="out/speed", help="default: out/speed")
    parser.add_argument("--fast", action="store_true",
                        help="tiny sizes, one round: does it work?")
    parser.add_argument("--docs", action="store_true",
                        help="write docs/performance.md, too")
    arguments = parser.parse_args()
    rounds = arguments.rounds or (1 if arguments.fast else 5)
    options.require_full(parser, arguments, rounds, ["fast", "dimensions"])
    if arguments.docs:
        page.require("speed")
    missing = jobs.missing(arguments.build)
    if missing:
        parser.error(f"{missing} is missing: build it, or name its folder with "
                     "--build")
    if not (arguments.serial / "machpoint").is_file() and \
            arguments.serial != parser.get_default("serial"):
        parser.error(f"{arguments.serial} has no machpoint: name the folder of a "
                     "build with --serial")
    for folder, expected in ((arguments.build, "OpenMP"),
                             (arguments.serial, "Serial")):
        if (folder / "machpoint").is_file():
            backend = jobs.version(folder / "machpoint")["backend"]
            if backend != expected:
                parser.error(f"{folder} is a build for {backend}, not for "
                             f"{expected}")
    return arguments, rounds


def main():
    arguments, rounds = parse()
    sizes = TINY if arguments.fast else FULL
    machpoint = arguments.build / "machpoint"
    watch = machine.Watch(arguments.build / "machpoint_triad")
    session = Session(watch, sizes.probe_seconds)
    sets = {}
    with tempfile.TemporaryDirectory() as scratch:
        run = pathlib.Path(scratch)
        some = make_jobs(arguments, sizes, run)
        try:
            sets, job = sod_job(machpoint, sizes, run)
            some.append(job)
        except jobs.Lacking as reason:
            session.lacking["sod",] = str(reason)
        session.run(some, rounds)

    figures = session.figures
    note = ", ".join(f"{path} {value}" for path, value in sets.items())
    table = targets.rows(figures, sizes, note)
    if arguments.fast:
        table = targets.unjudged(table)
    record = {
        "revision": jobs.revision(machpoint), "processor": machine.processor(),
        "rounds": rounds, "cells": sizes.cells,
        "machine": watch.report(targets.spreads(figures)),
        "figures": {" ".join(map(str, name)): values
                    for name, values in figures.items()},
        "rows": [dict(zip(["text", "measured", "asked", "verdict", "runs", "note"],
                          row.words())) for row in table],
        "verdicts": targets.verdicts(table),
        "speeds": targets.speeds(figures),
        "left_out": {" ".join(map(str, name)): reason
                     for name, reason in session.lacking.items()},
    }
    (arguments.output / "results.json").write_text(
        json.dumps(record, indent=2) + "\n")
    text = section(record, arguments.docs)
    print("\n" + text)
    if arguments.docs:
        page.write("speed", text)
    return 0


if __name__ == "__main__":
    sys.exit(main())
