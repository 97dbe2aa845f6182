"""One scene at growing sizes: what is run, and the slope."""
import json
import math
import os
import pathlib
import shutil
import subprocess

import page

ACTIVITIES = ["compute", "halo", "halo_wait", "migration", "collectives"]
SORT_EVERY = 20  # steps; whole cycles of them are timed
MEMORY = 0.8     # of what is free may be taken


class Runner:
    """Runs a scene without output and without its exact solution, which would
    cost more than the steps."""

    def __init__(self, executable, scene, threads, directory):
        self.executable, self.threads = executable, threads
        self.directory = pathlib.Path(directory)
        self.scene = json.loads(
            (page.ROOT / "input" / f"{scene}.json").read_text())
        self.scene.pop("exact", None)
        self.scene["output"] = {"particles": False, "grid": False}
        version = subprocess.run([executable, "--version"], check=True,
                                 capture_output=True, text=True).stdout
        self.revision = version.split("revision ")[1].split()[0]

    def run(self, cells, steps):
        """summary.json after some steps, or at the end of the scene; None and
        a reason where the build lacks the scene's dimension."""
        self.directory.mkdir(parents=True, exist_ok=True)
        path = self.directory / "input.json"
        self.scene["grid"]["cells"] = list(cells)
        path.write_text(json.dumps(self.scene))
        result = subprocess.run(
            [self.executable, "run", path, "--quiet", "--overwrite",
             "--output", self.directory / "out", "--max-steps", str(steps)],
            env=dict(os.environ, OMP_NUM_THREADS=str(self.threads),
                     OMP_PROC_BIND="false"),
            stdin=subprocess.DEVNULL, capture_output=True, text=True)
        if result.returncode == 2 and "this build" in result.stderr:
            return None
        if result.returncode != 0:
            raise SystemExit(f"{self.scene['scene']} at {cells}: exit code "
                             f"{result.returncode}\n{result.stderr}")
        summary = json.loads((self.directory / "out" /
                              "summary.json").read_text())
        shutil.rmtree(self.directory)
        return summary


def seconds_of_steps(summary):
    """Of the first step and the mean of the others, of the time loop alone: without
    set-up and output. A run's first step touches much of its memory for the first
    time, and takes up to ten times as long as any other."""
    told = summary["communication"]["seconds"]
    whole = sum(told[name]["sum"] for name in ACTIVITIES)
    first = summary["first_step_seconds"]
    return first, (whole - first) / (summary["steps"] - 1)


def free_memory():
    for line in pathlib.Path("/proc/meminfo").read_text().splitlines():
        if line.startswith("MemAvailable:"):
            return 1024 * int(line.split()[1])
    return math.inf


def measure(runner, sizes, limit, memory=free_memory):
    """Points of growing sizes, and why the last ones are left out, if they are.

    limit: seconds for a size. A point: cells, particles, first_step and step
    (seconds, this the mean of the others), steps (run), all_steps (to the end),
    seconds (to the end), measured (was it run to the end?).
    """
    points = []
    for cells in sizes:
        steps = whole = None
        if points:
            last = points[-1]
            ratio = math.prod(cells) / math.prod(last["cells"])
            # The time step is that of a cell's width.
            whole = round(last["all_steps"] * cells[0] / last["cells"][0])
            need = ratio * last["memory"]
            if need > MEMORY * memory():
                return points, (f"{' x '.join(map(str, cells))} cells and more "
                                f"need some {need / 1e9:.1f} GB of memory")
            cycles = round(limit / (ratio * last["step"] * SORT_EVERY))
            steps = 1 + SORT_EVERY * max(1, cycles)
            if steps >= whole:
                steps = None
        summary = runner.run(cells, steps or 10 ** 9)
        if summary is None:
            return points, "the build lacks its dimension, basis or method"
        if steps is None:
            whole = summary["steps"]
        first, step = seconds_of_steps(summary)
        points.append({
            "cells": list(cells), "particles": summary["particles_initial"],
            "first_step": first, "step": step, "steps": summary["steps"],
            "all_steps": whole, "seconds": first + step * (whole - 1),
            "measured": steps is None,
            "memory": summary["peak_memory_bytes"]})
        print(f"{runner.scene['scene']} {cells}: {1e3 * step:.4g} ms a step, "
              f"{summary['steps']} of {whole} steps", flush=True)
    return points, None


def slope(points):
    """Of log(time per step) over log(cells), least squares, of the sizes beyond
    ten times the smallest; None of fewer than two."""
    counts = [math.prod(point["cells"]) for point in points]
    pairs = [(math.log(n), math.log(point["step"]))
             for n, point in zip(counts, points) if n > 10 * counts[0]]
    if len(pairs) < 2:
        return None
    x = sum(a for a, _ in pairs) / len(pairs)
    y = sum(b for _, b in pairs) / len(pairs)
    return (sum((a - x) * (b - y) for a, b in pairs) /
            sum((a - x) ** 2 for a, _ in pairs))
