"""docs/scaling.md from the results."""
import os

import machine
import model
from page import table, written_by
from program import ACTIVITIES

HEAD = """# Scaling

{written}; do not edit. Machpoint `{revision}`,
measured on one machine ({processor}, {cores} cores for the
operating system), whose cores ranks of one thread share, so that 4 ranks are
**oversubscribed** where there are fewer cores: they show what sharing a core costs,
not what a larger machine would do. Figures are medians over
{repeats} rounds of all runs; the range beside one is that over the rounds.
"""


def milliseconds(seconds):
    return f"{1e3 * seconds:.3g}"


def size(case):
    return " x ".join(map(str, case.cells))


def ranks(case):
    if case.copies > 1:
        return f"{case.copies} runs apart"
    over = " (oversubscribed)" if case.ranks > os.cpu_count() else ""
    return f"{case.ranks}{over}"


def split(figures):
    """Share of the step of each activity, in per cent."""
    return [f"{100 * figures['seconds'][part] / figures['step']:.1f}"
            for part in ACTIVITIES]


def scaling(topic, results, gain):
    """A table of one topic. gain(figures, those of one rank, case)."""
    rows = []
    for case in topic:
        if case not in results:
            continue
        figures = results[case]
        if case.ranks == 1:
            one = figures
        low, high = figures["step_range"]
        rows.append([
            case.scene, size(case), ranks(case),
            f"{milliseconds(figures['step'])} ({milliseconds(low)} to "
            f"{milliseconds(high)})",
            f"{gain(figures, one, case):.2f}",
            f"{figures['slowest_compute'] / figures['seconds']['compute']:.2f}",
            *split(figures)])
    return table(["scene", "cells", "ranks", "ms a step (range)", "efficiency",
                  "slowest/mean", *(f"{p} %" for p in ACTIVITIES)], rows)


def limits(topics, results, memory):
    rows = [["memory bandwidth (triad)", f"{memory[1] / 1e9:.2f} GB/s",
             f"{memory[2] / 1e9:.2f} GB/s", f"{memory[2] / memory[1]:.2f}"]]
    alone = {(c.scene, c.cells): results[c] for c in topics["strong"]
             if c.ranks == 1 and c in results}
    for case in topics["apart"]:
        one = alone.get((case.scene, case.cells))
        if case in results and one:
            both = results[case]["updates"]
            rows.append([f"{case.scene}, runs without MPI messages",
                         f"{one['updates'] / 1e6:.3g} M updates/s",
                         f"{both / 1e6:.3g} M updates/s",
                         f"{both / one['updates']:.2f}"])
    return table(["", "one process", "two at once", "gain"], rows)


def stencil(topics, results):
    rows = []
    for case in topics["stencil"]:
        if case not in results:
            continue
        f = results[case]
        rows.append([
            case.method, case.basis, f"{f['halo_messages']:.1f}",
            f"{f['halo_bytes'] / 1024:.1f}",
            milliseconds(f["seconds"]["halo"]),
            milliseconds(f["seconds"]["halo_wait"]), milliseconds(f["step"])])
    return table(["method", "basis", "messages", "KiB", "halo ms",
                  "waiting ms", "step ms"], rows)


def loads(kept):
    """A table of case.shares_kept."""
    def cell(shares):
        if not shares:
            return "-"
        median, low, high = shares
        return f"{median:.2f} ({low:.2f} to {high:.2f})"
    return table(["scene", "cells of a rank", "particles of a rank", "2 ranks",
                  "2 runs apart"],
                 [[row["scene"], " x ".join(map(str, row["cells"])),
                   f"{row['particles']:,}", cell(row["2 ranks"]),
                   cell(row["2 runs"])] for row in kept])


def output(topics, results):
    rows = [[case.scene, size(case), ranks(case),
             milliseconds(results[case]["output"])]
            for case in topics["strong"] if case in results]
    return table(["scene", "cells", "ranks", "ms an output"], rows)


def constants(fits):
    return table(
        ["", *(f"{dim}D" for dim in fits)],
        [["ns to compute a particle", *(f"{1e9 * f['seconds_per_particle']:.0f}"
                                        for f in fits.values())],
         ["bytes of halo for a cell of cut surface (worst deviation)",
          *(f"{f['halo_bytes']:.0f} ({100 * f['halo_worst']:.0f} %)"
            for f in fits.values())],
         ["bytes of particles for the same",
          *(f"{f['migrated_bytes']:.0f} ({100 * f['migrated_worst']:.0f} %)"
            for f in fits.values())],
         ["messages for a cut side (worst deviation)",
          *(f"{f['messages']:.1f} ({100 * f['messages_worst']:.0f} %)"
            for f in fits.values())],
         ["collective calls", *(f"{f['collectives']:.1f}"
                                for f in fits.values())]])


# Latency, bytes per second, speed of a rank over the core of the fit.
MACHINES = {"cluster of cores": (2e-6, 2e9, 1),
            "cluster of GPUs": (1e-5, 2e10, 100)}
SIDES = {2: [32, 128, 512, 2048], 3: [8, 16, 32, 64, 128]}
PER_CELL = {2: 4, 3: 8}


def prediction(fits):
    rows = []
    for name, figures in MACHINES.items():
        for dim, fitted in fits.items():
            for side in SIDES[dim]:
                efficiencies = [
                    model.efficiency(model.predict(
                        fitted, PER_CELL[dim], side, ranks, *figures))
                    for ranks in (64, 4096)]
                rows.append([name, f"{dim}D", " x ".join([str(side)] * dim),
                             f"{PER_CELL[dim] * side ** dim:,}",
                             *(f"{100 * e:.1f} %" for e in efficiencies)])
    return table(["machine", "", "cells of a rank", "particles of a rank",
                  "64 ranks", "4096 ranks"], rows)


def write(topics, results, kept, bench, memory, fits, repeats):
    """The whole page."""
    text = HEAD.format(written=written_by("scaling", True),
                       revision=bench.revision, processor=machine.processor(),
                       cores=os.cpu_count(), repeats=repeats)
    text += """
A step's time, the first step apart, is split into what a rank does
(`communication.after_first_step` of [summary.json](output.md#summaryjson), mean over
ranks): `compute`, `halo` (layers of nodes packed, handed to MPI and taken up),
`halo_wait` (until a neighbour's are here), `migration` of particles (with its own
wait) and `collectives` (sums over ranks, and the wait for the last of them). Where
loads differ the waits are those of the ranks with less to do: `slowest/mean` is the
largest compute time over the mean.

## What the machine allows

"""
    text += limits(topics, results, memory)
    text += """
Two ranks can hardly gain more than two runs that share nothing but the machine.

## Strong scaling: the same scene on more ranks

Efficiency: speed-up over one rank, divided by the ranks.

"""
    text += scaling(topics["strong"], results,
                    lambda f, one, case: one["step"] / f["step"] / case.ranks)
    text += """
`cylinder_mach3` has unequal loads: the gas gathers in front of the body.

## Weak scaling: as many cells for each rank

Efficiency: time of a step on one rank over that on all.

"""
    text += scaling(topics["weak"], results,
                    lambda f, one, case: one["step"] / f["step"])
    text += """
## How much work a rank needs

Efficiency of weak scaling on two ranks, and of two runs at once that share nothing
but the machine: medians of the ratios within each round, and their range.

"""
    text += loads(kept)
    first = next(c for c in topics["stencil"])
    text += f"""
## What wider B-splines cost

`{first.scene}`, {size(first)} cells on 2 ranks; messages and KiB are those that a
rank sends in a step.

"""
    text += stencil(topics, results)
    text += """
## One output

Particles and grid, forced to the disk. Files below 32 MiB are written by the root.

"""
    text += output(topics, results)
    text += """
## A model of the cost

On a box with a volume of cells and a surface S of cut sides (cells that touch
another rank's), a step computes in proportion to the volume, sends bytes in
proportion to S, messages in proportion to the number of cut sides, and takes part
in a fixed number of collective calls. Fitted to the runs above and to smaller
boxes, `conservative`, quadratic:

"""
    text += constants(fits)
    text += """
**What follows is a prediction, not a result.** No machine larger than the one above
was at hand. It assumes equal loads, nothing overlapped, sides cut all around,
collective calls in log2(ranks) stages of one latency each, no time to start a GPU's
kernels, particles that move as little as those of these short runs, and

"""
    text += table(
        ["machine", "latency", "bandwidth of a rank", "speed of a rank"],
        [[name, f"{1e6 * latency:g} us", f"{rate / 1e9:g} GB/s",
          f"{speed:g} x a core above"]
         for name, (latency, rate, speed) in MACHINES.items()])
    text += "\nPredicted efficiency of weak scaling:\n\n"
    text += prediction(fits)
    if bench.lacking:
        text += "\n## Left out\n\n"
        text += "".join(f"- `{name}`: {reason}\n"
                        for name, reason in bench.lacking.items())
    text += """
## Commands

Ranks have a thread each (`OMP_NUM_THREADS=1`). With fewer cores than ranks Open MPI asks for
`--oversubscribe`, which the benchmark says by `OMPI_MCA_rmaps_base_oversubscribe=1` in the
environment.

"""
    for case in results:
        if case.copies == 1:
            text += f"    {bench.commands[case.name]}\n"
    return text
