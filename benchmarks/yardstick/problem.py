"""The problem of plain_loop.cpp, for the loops in Python."""
import json
import sys
import time

import numpy as np

STIFFNESS = 400
GRAVITY = 9.8
LOWER, UPPER = 0.1, 0.9  # of the block
WARM_UP = 5  # steps


def arguments(usage):
    """CELLS STEPS SAMPLES [mixed] of the command line."""
    words = sys.argv[1:]
    mixed = words[3:] == ["mixed"]
    if len(words) not in (3, 4) or len(words) == 4 and not mixed:
        sys.exit(usage)
    return (*map(int, words[:3]), mixed)


def time_step(cells):
    return 2e-4 * 128 / cells


def block(cells, mixed):
    """Places [particles][2], 4 in a cell, and the mass of one."""
    side = 2 * round((UPPER - LOWER) * cells)
    spacing = (UPPER - LOWER) / side
    k = np.arange(side)
    cell = np.stack(np.meshgrid(k, k, indexing="ij"), -1).reshape(-1, 2)
    if not mixed:
        return LOWER + (cell + 0.5) * spacing, spacing ** 2
    random = np.random.default_rng(1)
    places = LOWER + (cell + random.random(cell.shape)) * spacing
    random.shuffle(places)
    return places, spacing ** 2


def measure(run, places, count, steps, samples):
    """Prints what plain_loop.cpp prints. run(number) of steps; places() of the
    particles [particles][2]."""
    run(WARM_UP)
    rates = []
    for _ in range(samples):
        start = time.perf_counter()
        run(steps)
        rates.append(count * steps / (time.perf_counter() - start))
    print(json.dumps({"particles": count, "updates_per_second": rates,
                      "mean": places().mean(axis=0).tolist()}))
