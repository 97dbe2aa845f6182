"""Machpoint's speed beside yardsticks on the same work, in one session.

Usage: python3 benchmarks/speed [--build DIR] [--serial DIR] [--python PATH]
           [--rounds NUMBER] [--fast] [--output DIR] [--docs]

Runs `apic` and `conservative` with the gas's own step (ideal gas, energy, loss
return, retries), the plain loop, and Taichi and Warp where PATH has them (`pip
install taichi warp-lang` into an environment of its own), in turn, so that a
drift of the machine meets all alike; then the cylinder, Sod's tube and the memory
of a particle. Prints medians and what they are held against, says whether the
machine was quiet, and writes DIR/results.json. --docs writes docs/performance.md
too. What cannot run is left out, and named. Exit code: 0.
"""
import argparse
import functools
import json
import pathlib
import sys

HERE = pathlib.Path(__file__).resolve().parents[1]
sys.path += [str(HERE / "performance"), str(HERE / "kernels")]

import jobs
import machine
import page
import results
import targets
from jobs import Job

SOD_ERROR = 1.5e-3
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
                self.figures.setdefault(job.name, []).append(figure)
                print(f"{' '.join(map(str, job.name))}: {figure:.4g}",
                      flush=True)
        self.watch.probe(self.probe_seconds)


def make_jobs(arguments, directory):
    """All jobs. directory: for the runs' output."""
    build = pathlib.Path(arguments.build)
    serial = pathlib.Path(arguments.serial) / results.EXECUTABLE
    fast = arguments.fast
    cells = 32 if fast else 512
    particles = 4 * cells ** 2
    steps = 2 if fast else 20
    machpoint = build / "machpoint"
    ours = build / results.EXECUTABLE
    revision = jobs.revision(machpoint)
    partial = functools.partial
    updates = partial(jobs.updates, ours, revision)
    found = []

    def loop(name, command, threads, module=None, package=None):
        for order in ORDERS:
            def measure(order=order):
                if module:
                    jobs.require_module(arguments.python, module, package)
                return jobs.yardstick(command, cells, steps, order, threads)
            found.append(Job((name, order, threads), measure))

    for threads in (1, 2):
        for order in ORDERS:
            found.append(Job(("ours", "apic", 2, order, threads),
                             partial(updates, "apic", 2, order, particles,
                                     threads)))
        loop("plain", [build / "machpoint_plain_loop"], threads)
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
    found.append(Job(("ours", "apic", 2, "unsorted", 1),
                     partial(updates, "apic", 2, "unsorted", particles, 1)))
    for time in ("symplectic", "midpoint"):
        method = f"conservative_{time}"
        for order in ORDERS:
            found.append(Job(("ours", method, 2, order, 1),
                             partial(updates, method, 2, order, particles,
                                     1)))
    for dim in arguments.dimensions:
        found.append(Job(("serial", dim),
                         partial(jobs.updates, serial, revision, "apic", dim,
                                 "ordered", particles, 1)))
    found.append(Job(
        ("bytes",),
        lambda: jobs.kernels(ours, revision, "apic", 2, "ordered", 1000,
                             1)["particle_bytes"], 1))
    for method in ("apic", "conservative"):
        found.append(Job(("memory", method),
                         partial(jobs.peak_bytes, machpoint, method, cells,
                                 directory), 1))
        found.append(Job(("memory, no retries", method),
                         partial(jobs.peak_bytes, machpoint, method, cells,
                                 directory, retries=0), 1))
        found.append(Job(("held", method),
                         partial(jobs.held_bytes, machpoint, method, cells,
                                 directory), 1))
        found.append(Job(("held, no retries", method),
                         partial(jobs.held_bytes, machpoint, method, cells,
                                 directory, retries=0), 1))
    small = {"grid.cells": [40, 20]} if fast else {}
    for name, sets in ((("cylinder",), small),
                       (("cylinder", "cfl 1.2"), {"time.cfl": 1.2, **small})):
        found.append(Job(name, lambda sets=sets: jobs.scene(
            machpoint, "cylinder_mach3", sets, 2, directory,
            5 if fast else None)["wall_seconds"], 2))
    return found


def sod_job(machpoint, fast, directory):
    """Sod's tube at a given error: how to reach it is found first. \\raises
    Lacking"""
    error = 5e-2 if fast else SOD_ERROR
    cells = [50, 100] if fast else [100, 150, 200, 250, 300, 400, 500, 600,
                                    800, 1000, 1200]
    sets = jobs.sod_settings(machpoint, error, cells, directory)
    return sets, Job(("sod",), lambda: jobs.scene(
        machpoint, "sod", sets, 1, directory)["wall_seconds"])


def section(record):
    """Of docs/performance.md. record: what results.json holds."""
    text = (f"Written by `python3 benchmarks/speed --docs`; Machpoint "
            f"`{record['revision']}`, {record['processor']}, medians of "
            f"{record['rounds']} rounds. {machine.in_words(record['machine'])}"
            "\n\n")
    text += record["verdicts"] + "\n" + record["speeds"]
    if record["left_out"]:
        text += "\nLeft out:\n\n"
        text += "".join(f"- {name}: {reason}\n" for name, reason in
                        record["left_out"].items())
    return text


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--build", metavar="DIR",
                        default=page.ROOT / "build/openmp")
    parser.add_argument("--serial", metavar="DIR",
                        default=page.ROOT / "build/serial")
    parser.add_argument("--python", metavar="PATH", default=sys.executable,
                        help="interpreter that has taichi and warp")
    parser.add_argument("--rounds", type=int, metavar="NUMBER")
    parser.add_argument("--dimensions", type=int, nargs="+", default=[2, 3],
                        choices=[2, 3], metavar="DIM")
    parser.add_argument("--output", metavar="DIR", default="out/speed")
    parser.add_argument("--fast", action="store_true",
                        help="tiny sizes, one round: does it work?")
    parser.add_argument("--docs", action="store_true")
    arguments = parser.parse_args()
    if arguments.docs and arguments.fast:
        parser.error("--docs is of the full size")
    rounds = arguments.rounds or (1 if arguments.fast else 5)
    build = pathlib.Path(arguments.build)
    for name in ("machpoint", results.EXECUTABLE, "machpoint_plain_loop",
                 "machpoint_triad"):
        if not (build / name).exists():
            parser.error(f"{build / name} is missing: build it, or name its "
                         "folder with --build")
    output = pathlib.Path(arguments.output)
    output.mkdir(parents=True, exist_ok=True)

    watch = machine.Watch(build / "machpoint_triad")
    session = Session(watch, 0.1 if arguments.fast else 1)
    some = make_jobs(arguments, output / "run")
    sets = {}
    try:
        sets, job = sod_job(build / "machpoint", arguments.fast,
                            output / "run")
        some.append(job)
    except jobs.Lacking as reason:
        session.lacking["sod",] = str(reason)
    session.run(some, rounds)

    figures = session.figures
    note = ", ".join(f"{path} {value}" for path, value in sets.items())
    table = targets.rows(targets.medians(figures), note)
    if arguments.fast:
        table = targets.unjudged(table)
    record = {
        "revision": jobs.revision(build / "machpoint"),
        "processor": machine.processor(), "rounds": rounds,
        "machine": watch.report(targets.spreads(figures)),
        "figures": {" ".join(map(str, name)): values
                    for name, values in figures.items()},
        "rows": [dict(zip(["text", "measured", "asked", "verdict", "note"],
                          row.words())) for row in table],
        "verdicts": targets.verdicts(table),
        "speeds": targets.speeds(figures),
        "left_out": {" ".join(map(str, name)): reason
                     for name, reason in session.lacking.items()},
    }
    (output / "results.json").write_text(json.dumps(record, indent=2) + "\n")
    print("\n" + section(record))
    if arguments.docs:
        page.write("speed", section(record))
    return 0


if __name__ == "__main__":
    sys.exit(main())
