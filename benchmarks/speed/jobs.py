"""What is measured for the table of speeds: one function for each kind of run.

A job is called once in every round and returns a figure, or {name: figure}.
"""
import dataclasses
import json
import typing

import page
import results
from program import execute, revision, run, version

PER_CELL = {2: 4, 3: 8}
PLAIN_LOOPS = {"plain": "machpoint_plain_loop",
               "plain without SLP": "machpoint_plain_loop_no_slp"}
#: What a build has to have; a build of tests alone has none but the first.
PROGRAMS = ["machpoint", results.EXECUTABLE, *PLAIN_LOOPS.values(),
            "machpoint_triad"]


@dataclasses.dataclass(frozen=True)
class Job:
    """measure(): a figure, or some of them by name; rounds: in how many of the
    rounds, None for all."""

    name: tuple
    measure: typing.Callable
    rounds: int | None = None


class Lacking(Exception):
    """What a job needs is not here; the text says how to get it."""


def missing(build):
    """The first program that a build has not got, or None."""
    return next((build / name for name in PROGRAMS
                 if not (build / name).is_file()), None)


def kernels(executable, expected, method, dim, order, particles, threads):
    """{part: row} of machpoint_kernels, which has to be of the expected revision:
    a build of some targets alone may have left an older one. The parts are
    measured in the same steps as `step`."""
    if not executable.exists():
        raise Lacking(f"the build {executable.parent.name} has no "
                      f"{executable.name}")
    name = f"{method}/quadratic/{dim}D/{PER_CELL[dim]}/{order}"
    # No limits of the machine here: `small` measures them in no time.
    found = results.run(
        executable, [f"--benchmark_filter=^{name}/", "--particles",
                     str(particles), "--samples", "1", "--small"], threads)
    own = found["context"]["revision"]
    if own != expected:
        raise SystemExit(f"{executable} is of {own}, machpoint of {expected}: "
                         "build both anew")
    return {key[5]: row for key, row in results.rows(found).items()}


def updates(*of):
    return kernels(*of)["step"]["updates_per_second"]


def updates_and_parts(name, executable, expected, method, *of):
    """The step's, by a job's name, and ("part", method, part) of its parts."""
    rows = kernels(executable, expected, method, *of)
    rates = {("part", method, part): row["updates_per_second"]
             for part, row in rows.items()}
    return {name: rates.pop(("part", method, "step")), **rates}


def counted_bytes(executable, expected, methods):
    """("bytes",) of a particle, and ("bytes", method, part) that a particle step
    moves."""
    found = {}
    for method in methods:
        rows = kernels(executable, expected, method, 2, "ordered", 1000, 1)
        found["bytes",] = rows["step"]["particle_bytes"]
        for part, row in rows.items():
            found["bytes", method, part] = row["bytes"]
    return found


def yardstick(command, cells, steps, order, threads):
    """Updates per second of a loop that prints JSON."""
    words = [*command, cells, steps, 1] + \
        (["mixed"] if order == "mixed" else [])
    text = execute(words, threads).splitlines()[-1]
    return json.loads(text)["updates_per_second"][0]


def require_module(python, module, package):
    """\\raises Lacking"""
    if run([python, "-c", f"import {module}"], 1).returncode != 0:
        raise Lacking(f"pip install {package}, and name its interpreter with "
                      "--python")


def scene(machpoint, name, sets, threads, directory, steps=None):
    """summary.json of a run that writes no particles and no grid.
    directory: one that nobody else uses."""
    sets = {"output.particles": False, "output.grid": False, **sets}
    words = [machpoint, "run", page.ROOT / "input" / f"{name}.json", "--quiet",
             "--overwrite", "--output", directory]
    for path, value in sets.items():
        words += ["--set", f"{path}={json.dumps(value)}"]
    if steps:
        words += ["--max-steps", steps]
    execute(words, threads)
    return json.loads((directory / "summary.json").read_text())


def vortices(machpoint, method, cells, directory, retries=10):
    """summary.json of a short run that sorts, 4 particles a cell."""
    return scene(machpoint, "taylor_green",
                 {"grid.cells": [cells, cells], "time.retries": retries,
                  "method": {"name": method, "basis": "quadratic"}},
                 1, directory, 25)


def peak_bytes(machpoint, method, cells, directory, retries=10):
    """Bytes per particle that a run takes beyond what a tiny one takes."""
    runs = [vortices(machpoint, method, n, directory, retries)
            for n in (8, cells)]
    return (runs[1]["peak_memory_bytes"] - runs[0]["peak_memory_bytes"]) / \
        runs[1]["particles_initial"]


def held_bytes(machpoint, method, cells, directory, retries=10):
    """Bytes per particle of all AoSoAs."""
    return vortices(machpoint, method, cells, directory,
                    retries)["bytes_per_particle"]


def sod_settings(machpoint, error, cells, directory):
    """Overrides of Sod's tube by which the error of the density, L1, is met:
    those of the fastest run."""
    best = None
    for time in ("symplectic", "midpoint"):
        for per_cell in (2, 3):
            for n in cells:
                sets = {"grid.cells": [n], "particles.per_cell": per_cell,
                        "method.time": time}
                summary = scene(machpoint, "sod", sets, 1, directory)
                if summary["errors"]["density"]["L1"] > error:
                    continue
                if not best or summary["wall_seconds"] < best[0]:
                    best = summary["wall_seconds"], sets
                break  # more cells take longer
    if not best:
        raise Lacking(f"no run of Sod's tube with up to {cells[-1]} cells has "
                      f"L1(rho) <= {error:g}")
    return best[1]
