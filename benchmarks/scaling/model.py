"""What a step costs on a box of cells, and what that means for other machines.

A rank with a box of n_1 x ... cells and q particles per cell
- computes for  a q n_1 n_2 ...                       seconds,
- sends         s S and m q S                         bytes of halo and particles,
- in            k                                     messages and
                c                                     collective calls,
where S is the surface of its cuts: cells along all sides that other ranks share.
a, s, m, k and c are fitted to runs; latency and bandwidth are those of the machine
that is asked about.
"""
import math

import packages

np = packages.find("numpy")


def cut_surface(cells, boxes, periodic):
    """Cells along the cut sides of the box that has most of them, with the
    number of these sides. cells: [Dim] of the domain; boxes: [Dim] along each
    axis."""
    surface = sides = 0
    for axis, count in enumerate(boxes):
        if count == 1:
            continue
        face = math.prod(math.ceil(n / b) for d, (n, b) in
                         enumerate(zip(cells, boxes)) if d != axis)
        shared = 2 if periodic or count > 2 else 1
        surface += shared * face
        sides += shared
    return surface, sides


def boxes(cells, ranks):
    """Boxes along each axis: those of the least surface, as the program
    chooses them; of equals the one that cuts the last axis."""
    best = None

    def search(chosen, left):
        nonlocal best
        if len(chosen) == len(cells) - 1:
            chosen = (*chosen, left)
            surface = sum(
                math.prod(n / b for d, (n, b) in enumerate(zip(cells, chosen))
                          if d != axis)
                for axis in range(len(cells)) if chosen[axis] > 1)
            if best is None or surface < best[0]:
                best = surface, chosen
            return
        for r in range(1, left + 1):
            if left % r == 0:
                search((*chosen, r), left // r)

    search((), ranks)
    return best[1]


def slope(x, y):
    """Least squares y = slope x, and the largest deviation over the largest
    y."""
    x, y = np.asarray(x, float), np.asarray(y, float)
    value = float((x * y).sum() / (x * x).sum())
    largest = np.max(np.abs(y)) or 1.0
    return value, float(np.max(np.abs(value * x - y)) / largest)


def fit(runs, dimension):
    """The constants of the model from [(case, figures)] of one dimension.

    The program's layers of nodes include the halos of the other axes, which is
    why bytes grow a little faster than the surface.
    """
    fitted = {"dimension": dimension}
    whole = [f for case, f in runs if case.ranks == 1 and case.copies == 1]
    if whole:  # a topic may look at several ranks alone
        fitted["seconds_per_particle"] = float(np.median(
            [f["seconds"]["compute"] / f["particles"] for f in whole]))
    surfaces, counts, bytes_, moved, messages, calls = [], [], [], [], [], []
    for case, figures in runs:
        if case.ranks == 1:
            continue
        periodic = case.scene == "isentropic_vortex"
        cuts = boxes(case.cells, case.ranks)
        surface, sides = cut_surface(case.cells, cuts, periodic)
        surfaces.append(surface)
        counts.append(sides)
        bytes_.append(figures["halo_bytes"])
        moved.append(figures["migrated_bytes"])
        messages.append(figures["halo_messages"])
        calls.append(figures["collectives"])
    fitted["halo_bytes"], fitted["halo_worst"] = slope(surfaces, bytes_)
    fitted["migrated_bytes"], fitted["migrated_worst"] = slope(surfaces, moved)
    fitted["messages"], fitted["messages_worst"] = slope(counts, messages)
    fitted["collectives"] = float(np.median(calls))
    fitted["runs"] = len(surfaces)
    return fitted


def predict(fitted, per_cell, side, ranks, latency, bandwidth,
            speedup=1.0):
    """Seconds of a step on boxes of side^Dim cells, by part.

    latency: seconds of a message, and of each stage of a collective call;
    bandwidth: bytes per second that a rank sends; speedup: of a rank's
    computing over the core that the fit was taken on.
    """
    dim = fitted["dimension"]
    sides = 2 * dim
    surface = sides * side ** (dim - 1)
    stages = math.ceil(math.log2(ranks))
    return {
        "compute": fitted["seconds_per_particle"] * per_cell * side ** dim /
                   speedup,
        "halo": fitted["messages"] * sides * latency +
                fitted["halo_bytes"] * surface / bandwidth,
        "migration": sides * latency +
                     fitted["migrated_bytes"] * surface / bandwidth,
        "collectives": fitted["collectives"] * stages * latency,
    }


def efficiency(parts):
    """Share of a step that computes: that of weak scaling, with equal loads and
    nothing overlapped."""
    return parts["compute"] / sum(parts.values())
