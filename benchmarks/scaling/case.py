"""What is measured: a scene on some ranks, or several copies of it at once."""
import dataclasses
import json
import math
import pathlib
import shlex
import shutil
import statistics
import subprocess
import tempfile

import launcher
import program
from page import ROOT


@dataclasses.dataclass(frozen=True)
class Case:
    """A scene at a size.

    cells: [Dim]; domains: how many times as long as the input's the domain is
    along each axis, if not the same; copies: runs on one rank each, started at
    once and without a word between them.
    """

    scene: str
    cells: tuple
    ranks: int
    steps: int
    copies: int = 1
    method: str = "conservative"
    basis: str = "quadratic"
    domains: tuple = ()

    @property
    def name(self):
        words = [self.scene, "x".join(map(str, self.cells)), self.method,
                 self.basis, f"{self.ranks}_ranks"]
        if self.copies > 1:
            words.append(f"{self.copies}_copies")
        if self.domains:
            words.append("x".join(map(str, self.domains)) + "_domains")
        return "-".join(words)

    @property
    def cells_of_rank(self):
        """Of the case that has them on one rank."""
        return tuple(n // times for n, times in
                     zip(self.cells, self.domains or (1,) * len(self.cells)))

    def settings(self):
        """Overrides of the input: size and method, and one output, at the
        end."""
        scene = json.loads((ROOT / "input" / f"{self.scene}.json").read_text())
        keys = {"grid.cells": list(self.cells), "method.name": self.method,
                "method.basis": self.basis,
                "output.every": scene["time"]["end"]}
        if self.domains:
            grid = scene["grid"]
            keys["grid.upper"] = [
                lower + times * (upper - lower) for lower, upper, times in
                zip(grid["lower"], grid["upper"], self.domains)]
        return keys


class Bench:
    """Runs cases in turn, and keeps what they tell of themselves."""

    def __init__(self, machpoint, mpiexec, output):
        """mpiexec: a list of words"""
        self.machpoint = pathlib.Path(machpoint).resolve()
        self.revision = program.revision(self.machpoint)
        self.mpiexec = mpiexec
        self.output = pathlib.Path(output)
        self.commands = {}
        self.lacking = {}

    def _start(self, case, number, scratch):
        directory = self.output / f"{case.name}-{number}"
        words = []
        for path, value in case.settings().items():
            words += ["--set", f"{path}={json.dumps(value)}"]
        command = [*self.mpiexec, "-n", str(case.ranks), str(self.machpoint),
                   "run", str(ROOT / "input" / f"{case.scene}.json"), *words,
                   "--max-steps", str(case.steps), "--quiet", "--overwrite",
                   "--output", str(directory)]
        self.commands[case.name] = shlex.join(
            [*self.mpiexec, "-n", str(case.ranks), "machpoint", "run",
             f"input/{case.scene}.json", *words, "--max-steps",
             str(case.steps), "--overwrite"])
        # Copies that start at once must not make one directory, also where the
        # caller's environment has named one for Open MPI.
        own = tempfile.mkdtemp(dir=scratch)
        environment = dict(
            launcher.ENVIRONMENT, OMPI_MCA_hwloc_base_binding_policy="none",
            TMPDIR=own, OMPI_MCA_orte_tmpdir_base=own)
        return directory, subprocess.Popen(
            command, env=environment, stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)

    def run(self, case):
        """Figures of one run, per step; None if the build lacks the case."""
        if case.name in self.lacking:
            return None
        with tempfile.TemporaryDirectory(prefix="scaling") as scratch:
            return self._measure(case, scratch)

    def _measure(self, case, scratch):
        started = [self._start(case, k, scratch) for k in range(case.copies)]
        try:
            figures = self._finish(case, started)
        finally:
            for _, process in started:
                if process.poll() is None:
                    process.terminate()
                    process.communicate()
        if case.name in self.lacking:
            return None
        # Copies share the machine: the last one ends the measurement.
        slowest = max(figures, key=lambda f: f["step"])
        slowest["updates"] = sum(f["updates"] for f in figures)
        return slowest

    def _finish(self, case, started):
        """Figures of each copy, once all have ended."""
        figures = []
        for directory, process in started:
            text = process.communicate()[0]
            lacks = "this build has no"
            if process.returncode == 2 and lacks in text:
                self.lacking[case.name] = next(
                    line[line.index(lacks):]
                    for line in text.splitlines() if lacks in line)
            elif process.returncode != 0:
                raise SystemExit(
                    f"exit code {process.returncode}: "
                    f"{self.commands[case.name]}\n{text}")
            else:
                figures.append(read(directory))
            shutil.rmtree(directory, ignore_errors=True)
        return figures


def read(directory):
    """What summary.json tells, per step: seconds of each activity are the mean
    over ranks, so that they sum to the step's. Not of the first step: memory is
    new then."""
    summary = json.loads((directory / "summary.json").read_text())
    steps, ranks = summary["steps"] - 1, summary["ranks"]
    told = summary["communication"]["after_first_step"]
    seconds = {name: told["seconds"][name]["sum"] / ranks / steps
               for name in program.ACTIVITIES}
    step = sum(seconds.values())
    counts = {name: told[name]["largest"] / steps
              for name in ["halo_bytes", "halo_messages",
                           "migrated_particles", "migrated_bytes"]}
    return {
        "step": step,
        "updates": summary["particles_initial"] / step,
        "seconds": seconds,
        "slowest_compute": told["seconds"]["compute"]["largest"] / steps,
        "output": told["seconds"]["output"]["largest"],
        "collectives": told["collectives"] / steps,
        "particles": summary["particles_initial"],
        **counts,
    }


def median(runs):
    """Median of every figure over runs of one case, and the extremes of the
    step."""
    if not runs or isinstance(runs[0], (int, float)):
        return statistics.median(runs) if runs else math.nan
    return {key: median([run[key] for run in runs]) for key in runs[0]}


def summarise(runs):
    found = median(runs)
    found["step_range"] = [min(r["step"] for r in runs),
                           max(r["step"] for r in runs)]
    found["runs"] = len(runs)
    return found


def shares_kept(cases, runs):
    """What two ranks keep of one rank's speed, and two runs that share nothing
    but the machine: median, least and largest of the ratios within each round,
    one row for each scene and size."""
    alone = {(c.scene, c.cells): runs[c] for c in cases
             if c.ranks == c.copies == 1}
    rows = {}
    for case in cases:
        key = case.scene, case.cells_of_rank
        if (case.ranks * case.copies != 2 or not alone.get(key)
                or not runs[case]):
            continue
        row = rows.setdefault(key, {
            "scene": case.scene, "cells": case.cells_of_rank,
            "particles": alone[key][0]["particles"],
            "2 ranks": None, "2 runs": None})
        ratios = [one["step"] / both["step"]
                  for one, both in zip(alone[key], runs[case])]
        row["2 ranks" if case.ranks == 2 else "2 runs"] = (
            statistics.median(ratios), min(ratios), max(ratios))
    return sorted(rows.values(), key=lambda r: (len(r["cells"]),
                                                r["particles"]))
