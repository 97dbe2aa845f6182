"""Hard cases in three dimensions."""
import math

import gas
import packages
from case import Bound, Case, about, at_least, at_most
from planes import bow_shock, outermost, particles, radial, size

np = packages.find("numpy")


def sedov(runs):
    """As in two dimensions, shells of a fiftieth of the exact radius, 1."""
    values = {}
    for run in runs:
        _, middles, density = radial(particles(run), np.zeros(3),
                                     np.linspace(0, 1.2, 61))
        level = 1 + 0.5 * (density.max() - 1)
        values[f"shock radius, {size(run)}"] = outermost(middles, density,
                                                         level)
        values[f"peak density, {size(run)}"] = density.max()
    return {k: float(v) for k, v in values.items()}


def noh(runs):
    """Shells of a sixtieth: largest density of a shell, and where the density
    falls through 20 (exact: 64 within a third of the time)."""
    values = {}
    for run in runs:
        _, middles, density = radial(particles(run), np.zeros(3),
                                     np.linspace(0, 0.4, 25))
        values[f"plateau, {size(run)}"] = density.max()
        values[f"shock radius / exact, {size(run)}"] = outermost(
            middles, density, 20) / (run.summary["final_time"] / 3)
    return {k: float(v) for k, v in values.items()}


def cubes(*numbers):
    return [{"grid.cells": [n, n, n]} for n in numbers]


def blasts(*numbers):
    return [{"grid.cells": [n, n, n], "initial.0.radius": 1.2 / n}
            for n in numbers]


# A quarter of the sphere, between planes of symmetry.
QUARTER = {"grid": {"lower": [0, 0, 0], "upper": [0.9, 0.6, 0.6],
                    "cells": [54, 36, 36]},
           "boundary.6.shape.center": [0.6, 0, 0], "time.end": 1,
           "output.every": 0.1}

CASES = [
    Case("sedov_3d", "3D", "sedov_3d", "spherical blast", sedov, blasts(40),
         blasts(16), {"shock radius, 40x40x40": about(1, 0.02, "theory")}),
    Case("noh_3d", "3D", "noh_3d", "spherical implosion", noh, cubes(36),
         cubes(12)),
    Case("sphere_mach3", "3D", "sphere_mach3", "Mach 3 sphere", bow_shock,
         [QUARTER],
         [{"grid.cells": [24, 18, 18], "time.end": 0.3, "output.every": 0.1}],
         {"stand-off, 54x36x36": about(gas.billig_sphere(3), 0.25, "Billig"),
          "pitot, 54x36x36": about(gas.pitot_ratio(3, 1.4), 0.05,
                                   "Rayleigh")}),
]
