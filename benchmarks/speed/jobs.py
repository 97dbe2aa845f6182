"""What is measured for the table of speeds: one function for each kind of run.

A job is called once in every round and returns a figure, or a dictionary of
them.
"""
import dataclasses
import json
import os
import pathlib
import shutil
import subprocess
import typing

import page
import results

PER_CELL = {2: 4, 3: 8}


@dataclasses.dataclass(frozen=True)
class Job:
    """measure(): a figure; rounds: in how many of the rounds, None for all."""

    name: tuple
    measure: typing.Callable
    rounds: int | None = None


class Lacking(Exception):
    """What a job needs is not here; the text says how to get it."""


def execute(words, threads):
    """stdout of a command; OpenMP's threads are not tied to cores, which a
    virtual machine hands out as it likes."""
    environment = dict(os.environ, OMP_NUM_THREADS=str(threads),
                       OMP_PROC_BIND="false")
    result = subprocess.run([str(word) for word in words], env=environment,
                            stdin=subprocess.DEVNULL, capture_output=True,
                            text=True)
    if result.returncode != 0:
        raise SystemExit(f"{' '.join(map(str, words))}: exit code "
                         f"{result.returncode}\n{result.stderr}")
    return result.stdout


def revision(machpoint):
    """What a program says that it was built of."""
    return execute([machpoint, "--version"], 1).split("revision ")[1].split()[0]


def kernels(executable, expected, method, dim, order, particles, threads):
    """The step's row of machpoint_kernels, which has to be of the expected
    revision: a build of some targets alone may have left an older one."""
    if not pathlib.Path(executable).exists():
        raise Lacking(f"{executable} is not built")
    name = f"{method}/quadratic/{dim}D/{PER_CELL[dim]}/{order}/step"
    # No limits of the machine here: `small` measures them in no time.
    found = results.run(
        executable, [f"--benchmark_filter=^{name}/", "--particles",
                     str(particles), "--samples", "1", "--small"], threads)
    own = found["context"]["revision"]
    if own != expected:
        raise SystemExit(f"{executable} is of {own}, machpoint of {expected}: "
                         "build both anew")
    return next(iter(results.rows(found).values()))


def updates(*of):
    return kernels(*of)["updates_per_second"]


def yardstick(command, cells, steps, order, threads):
    """Updates per second of a loop that prints JSON."""
    words = [*command, cells, steps, 1] + \
        (["mixed"] if order == "mixed" else [])
    text = execute(words, threads).splitlines()[-1]
    return json.loads(text)["updates_per_second"][0]


def require_module(python, module, package):
    """\\raises Lacking"""
    if subprocess.run([python, "-c", f"import {module}"], capture_output=True,
                      check=False).returncode != 0:
        raise Lacking(f"pip install {package}, and name its interpreter with "
                      "--python")


def scene(machpoint, name, sets, threads, directory, steps=None):
    """summary.json of a run that writes nothing else."""
    sets = {"output.particles": False, "output.grid": False, **sets}
    words = [machpoint, "run", page.ROOT / "input" / f"{name}.json", "--quiet",
             "--overwrite", "--output", directory]
    for path, value in sets.items():
        words += ["--set", f"{path}={json.dumps(value)}"]
    if steps:
        words += ["--max-steps", steps]
    execute(words, threads)
    summary = json.loads((directory / "summary.json").read_text())
    shutil.rmtree(directory)
    return summary


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
