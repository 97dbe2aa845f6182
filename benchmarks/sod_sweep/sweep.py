"""One scene at growing sizes: what is run, and the slope."""
import json
import math
import pathlib
import statistics
import time

import machine
import page
import program

#: What is timed: so many steps, two cycles of sorts, in which waves of the tube pass
#: the same number of cells; or until a time of the flow.
TIMED = {"sod": {"steps": 41}, "cylinder_mach3": {"end": 0.1}}
LONGEST = 6   # times as long as its runs may take together, a size's one run
MEMORY = 0.8  # of what is free may be taken


class Runner:
    """Runs a scene without output and without its exact solution, which would
    cost more than the steps."""

    def __init__(self, executable, scene, threads, directory):
        self.executable, self.name, self.threads = executable, scene, threads
        self.directory = pathlib.Path(directory)
        self.scene = json.loads(
            (page.ROOT / "input" / f"{scene}.json").read_text())
        self.scene.pop("exact", None)
        self.scene["output"] = {"particles": False, "grid": False}
        self.end = self.scene["time"]["end"]

    def run(self, cells, steps=10 ** 9, end=None):
        """summary.json after some steps, or at a time or the scene's end, and the
        seconds that the program took; None where the build lacks the scene's
        dimension, basis or method."""
        path = self.directory / "input.json"
        self.scene["grid"]["cells"] = list(cells)
        self.scene["time"]["end"] = end or self.end
        path.write_text(json.dumps(self.scene))
        start = time.perf_counter()
        result = program.run(
            [self.executable, "run", path, "--quiet", "--overwrite", "--output",
             self.directory / "out", "--max-steps", steps], self.threads)
        seconds = time.perf_counter() - start
        if result.returncode == 2 and "this build has no" in result.stderr:
            return None
        if result.returncode != 0:
            raise program.failure(result)
        text = (self.directory / "out" / "summary.json").read_text()
        return json.loads(text), seconds


def seconds_of_steps(summary):
    """Of the first step and the mean of the others, of the time loop alone: without
    set-up and output. A run's first step touches much of its memory for the first
    time, and takes up to ten times as long as any other."""
    told = summary["communication"]["seconds"]
    whole = sum(told[name]["sum"] for name in program.ACTIVITIES)
    first = summary["first_step_seconds"]
    return first, (whole - first) / (summary["steps"] - 1)


def free_memory():
    for line in pathlib.Path("/proc/meminfo").read_text().splitlines():
        if line.startswith("MemAvailable:"):
            return 1024 * int(line.split()[1])
    return math.inf


class Size:
    """What is known of one size. coarser: the next coarser one, or None."""

    def __init__(self, cells, coarser):
        self.cells, self.coarser = cells, coarser
        self.firsts, self.means = [], []  # seconds, of each run
        self.spent = 0  # seconds, of all runs
        self.to_end = None  # seconds of the loop, where it was run to the end
        self.all_steps = self.late_mean = None  # of a run to the end

    def time(self, runner):
        """Another run; False where the build cannot."""
        found = runner.run(self.cells, **TIMED[runner.name])
        if found is None:
            return False
        summary, seconds = found
        first, mean = seconds_of_steps(summary)
        self.firsts.append(first)
        self.means.append(mean)
        self.spent += seconds
        self.steps, self.reached = summary["steps"], summary["final_time"]
        self.particles = summary["particles_initial"]
        self.memory = summary["peak_memory_bytes"]
        print(f"{runner.name} {self.cells}: {1e3 * mean:.4g} ms a step, "
              f"{self.steps} steps", flush=True)
        return True

    def end(self, runner, limit):
        """Runs it to the end if that takes less than limit (seconds), as far as
        the coarser size tells; else predicts how many steps that needs: the time
        step is that of a cell's width."""
        coarser = self.coarser
        if coarser:
            finer = self.cells[0] / coarser.cells[0]
            self.all_steps = round(coarser.all_steps * finer)
            if coarser.to_end is None or \
                    coarser.to_end * self.growth * finer > limit:
                return
        summary, _ = runner.run(self.cells)
        first, self.late_mean = seconds_of_steps(summary)
        self.all_steps = summary["steps"]
        self.to_end = first + self.late_mean * (self.all_steps - 1)

    @property
    def growth(self):
        """How many times the coarser one's cells it has."""
        return math.prod(self.cells) / math.prod(self.coarser.cells)

    @property
    def late(self):
        """A mean step to the end over a timed one; if it was not run so far, that
        of the finest size that was."""
        return self.coarser.late if self.to_end is None else \
            self.late_mean / statistics.median(self.means)

    def point(self):
        first, step = map(statistics.median, (self.firsts, self.means))
        return {"cells": list(self.cells), "particles": self.particles,
                "first_step": first, "step": step, "steps": self.steps,
                "time": self.reached, "runs": len(self.means),
                "spread": machine.spread(self.means),
                "all_steps": self.all_steps, "measured": self.to_end is not None,
                "late": self.late,
                "seconds": self.to_end or
                first + step * self.late * (self.all_steps - 1)}


def too_much(size, runner, limit, memory):
    """Why it is not run, if it is not: what it needs, as the coarser one tells."""
    last = size.coarser
    if last is None:
        return None
    what = f"{' x '.join(map(str, size.cells))} cells and more need some "
    need = size.growth * last.memory
    if need > MEMORY * memory():
        return what + f"{need / 1e9:.1f} GB of memory"
    seconds = size.growth * last.spent
    if "end" in TIMED[runner.name]:
        seconds *= size.cells[0] / last.cells[0]
    if seconds > LONGEST * limit:
        return what + f"{seconds:.0f} s a run"
    return None


def first_round(runner, sizes, limit, memory):
    """Sizes that have been run once, and why the last ones are left out, if they
    are."""
    done = []
    for cells in sizes:
        size = Size(cells, done[-1] if done else None)
        reason = too_much(size, runner, limit, memory)
        if reason:
            return done, reason
        if not size.time(runner):
            return done, "the build lacks its dimension, basis or method"
        size.end(runner, limit)
        done.append(size)
    return done, None


def measure(runner, sizes, rounds, limit, memory=free_memory,
            between=lambda: None):
    """Points of growing sizes, and why the last ones are left out, if they are.

    rounds: how often a size is run, in turn with the others, but not again when its
    runs have taken limit (seconds) together; between(): called after each round. A
    point: cells, particles, first_step and step (seconds, medians, this of the mean
    of the others), steps (timed), time (of the flow, that they reach), runs, spread
    (of step, relative), all_steps and seconds (to the end), measured (was it run to
    the end?), late (a mean step to the end over a timed one).
    """
    done, reason = first_round(runner, sizes, limit, memory)
    for _ in range(rounds - 1):
        between()
        for size in done:
            if size.spent < limit:
                size.time(runner)
    between()
    return [size.point() for size in done], reason


def fit(points):
    """Slope of log(time per step) over log(cells), least squares, of the sizes
    beyond ten times the smallest, and how far the farthest lies from that line,
    relative; None of fewer than two."""
    counts = [math.prod(point["cells"]) for point in points]
    pairs = [(math.log(n), math.log(point["step"]))
             for n, point in zip(counts, points) if n > 10 * counts[0]]
    if len(pairs) < 2:
        return None, None
    slope, start = statistics.linear_regression(*zip(*pairs))
    return slope, max(abs(math.expm1(b - start - slope * a)) for a, b in pairs)
