"""Hard cases in one dimension."""
import math

import gas
import packages
from case import Case, about, at_least, at_most

np = packages.find("numpy")

TABLE = "project's bound"
EQUILIBRIUM = "uniform pressure is an equilibrium"


def cells(*numbers):
    return [{"grid.cells": [n]} for n in numbers]


def errors(runs, norm="L1"):
    """L1 of the density for each run, labelled with its cells."""
    return {f"L1(rho), {r.summary['cells'][0]} cells": r.error("density", norm)
            for r in runs}


def errors_and_order(runs):
    """The same, with the slope from the coarsest to the finest."""
    values = errors(runs)
    first, last = runs[0], runs[-1]
    values["order"] = math.log(first.error() / last.error()) / math.log(
        last.summary["cells"][0] / first.summary["cells"][0])
    return values


def worst(runs):
    return {f"worst L1(rho) of {len(runs)}": max(r.error() for r in runs)}


def by(path, label):
    """Measures L1 of the density for each value of one key."""
    def measure(runs):
        values = {}
        for run in runs:
            node = run.input
            for key in path.split("."):
                node = node[int(key) if key.isdigit() else key]
            shown = f"{node:.3g}" if isinstance(node, float) else node
            values[f"L1(rho), {label} {shown}"] = run.error()
        return values
    return measure


def velocity_error(runs):
    return {f"max |v - v0|, {r.input['particles']['placement']}":
            r.error("velocity", "Linf") for r in runs}


def profile(run):
    """Sorted places and densities, and the length each stands for."""
    data = run.read()
    x, rho = data["position"][:, 0], data["density"]
    order = np.argsort(x)
    x, rho = x[order], rho[order]
    lower, upper = run.input["grid"]["lower"][0], run.input["grid"]["upper"][0]
    edges = np.r_[lower, 0.5 * (x[1:] + x[:-1]), upper]
    return x, rho, np.diff(edges)


def peak(runs):
    x, rho, _ = profile(runs[-1])
    return {"peak density": float(rho.max()),
            "place of the peak": float(x[rho.argmax()])}


def against(runs, reference):
    """L1 of the density against a finite-volume run on a fine grid."""
    fine = reference.read("grid")
    places = fine["lower"][0] + fine["spacing"][0] * np.arange(
        len(fine["density"]))
    values = {}
    for run in runs:
        x, rho, length = profile(run)
        difference = abs(rho - np.interp(x, places, fine["density"]))
        values[f"L1(rho), {run.summary['cells'][0]} cells"] = float(
            (difference * length).sum())
    return values


def tube(gamma=1.4, left=(1, 0, 1), right=(0.125, 0, 0.1), number=100):
    """A shock tube on [0, 1] with its diaphragm at 0.5, whose waves stay
    inside, as overrides of input/sod.json."""
    slowest, fastest = gas.riemann_speeds(left, right, gamma)

    def state(side):
        return {"density": side[0], "velocity": [side[1]], "pressure": side[2]}

    return {"grid.cells": [number],
            "physics": [{"type": "ideal_gas", "gamma": gamma},
                        {"type": "artificial_viscosity"}],
            "initial": [{"type": "riemann", "position": 0.5,
                         "left": state(left), "right": state(right)}],
            "time.end": 0.4 / max(-slowest, fastest)}


def yardstick(number, error):
    """Twice the error of finite volumes (MUSCL, HLLC, van Leer) on the same
    grid, as machpoint_reference measures it."""
    return {f"L1(rho), {number} cells": at_most(
        2 * error, "2 x finite volumes on the same grid")}


def three_cells(number, h, jump):
    """The error of a shock that is smeared over three cells."""
    return {f"L1(rho), {number} cells": at_most(3 * h * jump,
                                                "shock within 3 cells")}


def streams(number, end, *seeds):
    """Gas that passes at Mach .3 from an inflow to an outflow, at random
    places, as overrides of input/translation.json."""
    stream = {"density": 1.4, "velocity": [0.3], "pressure": 1}
    return [{"dimension": 1, "particles.placement": "random",
             "particles.seed": seed, "particles.per_cell": 3, "time.end": end,
             "grid": {"lower": [0], "upper": [1], "cells": [number]},
             "initial": [dict(type="uniform", **stream)],
             "boundary": [dict(type="inflow", side="x_lower", **stream),
                          {"type": "outflow", "side": "x_upper"}]}
            for seed in seeds]


def worst_density(runs):
    return {f"max |rho/rho0 - 1|, seed {r.input['particles']['seed']}":
            r.error("density", "Linf") / r.input["initial"][0]["density"]
            for r in runs}


RATIOS = [10.0**k for k in (2, 4, 6, 8, 10)]
GAMMAS = [1.01, 1.1, 1.2, 1.4, 5 / 3]

CASES = [
    Case("sod", "1D", "sod", "Sod's shock tube", errors_and_order,
         cells(100, 200, 400, 800, 1600), cells(100, 200),
         {"L1(rho), 100 cells": at_most(7.2e-3, TABLE, 6.0e-3),
          "L1(rho), 400 cells": at_most(1.9e-3, TABLE, 1.48e-3),
          "L1(rho), 1600 cells": at_most(5.5e-4, TABLE, 3.9e-4),
          "order": at_least(0.9, TABLE, 0.99)}),
    Case("sod_random", "1D", "sod", "Sod, random placement, 10 seeds", worst,
         [{"particles.placement": "random", "particles.seed": k}
          for k in range(1, 11)], None,
         {"worst L1(rho) of 10": at_most(1.0e-2, TABLE, 7.2e-3)}),
    Case("sod_per_cell", "1D", "sod", "Sod, 1 to 16 particles per cell",
         by("particles.per_cell", "per cell"),
         [{"particles.per_cell": k} for k in (1, 2, 4, 8, 16)],
         [{"particles.per_cell": k} for k in (1, 16)],
         {"L1(rho), per cell 2": at_most(1.0e-2, "as random placement")}),
    Case("sod_gamma", "1D", "sod", "Sod at gamma 1.01 to 5/3",
         by("physics.0.gamma", "gamma"), [tube(gamma=g) for g in GAMMAS],
         [tube(gamma=g) for g in (1.01, 5 / 3)]),
    Case("pressure_ratio", "1D", "sod", "Sod, pressure ratio 1e2 to 1e10",
         by("initial.0.right.pressure", "p2/p1"),
         [tube(right=(0.125, 0, 1 / r), number=200) for r in RATIOS],
         [tube(right=(0.125, 0, 1 / r), number=100) for r in (1e6, 1e10)]),
    Case("toro1", "1D", "toro1", "Toro 1, transonic rarefaction", errors,
         bounds=yardstick(100, 6.25e-3)),
    Case("toro2", "1D", "toro2", "Toro 2, double rarefaction", errors,
         bounds={"L1(rho), 100 cells": at_most(1.0e-2, TABLE, 8.6e-3)}),
    Case("toro3", "1D", "toro3", "Toro 3, pressure ratio 1e5", errors,
         bounds={"L1(rho), 200 cells": at_most(3.3e-2, TABLE, 2.84e-2)}),
    Case("toro4", "1D", "toro4", "Toro 4, colliding shocks", errors,
         bounds=yardstick(200, 0.254)),
    Case("toro5", "1D", "toro5", "Toro 5, slow contact", errors,
         bounds={"L1(rho), 200 cells": at_most(3.6e-2, TABLE, 3.05e-2)}),
    Case("leblanc", "1D", "leblanc", "LeBlanc's tube", errors,
         cells(360), None,
         {"L1(rho), 360 cells": at_most(2.0e-2, TABLE, 1.79e-2)}),
    Case("einfeldt_1203", "1D", "einfeldt_1203", "Einfeldt's 1-2-0-3", errors,
         bounds=yardstick(100, 6.42e-3)),
    Case("vacuum", "1D", "vacuum", "expansion into vacuum", errors),
    Case("receding", "1D", "receding", "gases that part: vacuum forms",
         errors, bounds=yardstick(100, 1.10e-2)),
    Case("noh_1d", "1D", "noh_1d", "Noh, planar", errors, cells(100), None,
         {"L1(rho), 100 cells": at_most(5.6e-2, TABLE, 4.47e-2)}),
    Case("two_blasts", "1D", "two_blasts", "Woodward-Colella blasts", peak,
         cells(400), None,
         {"L1(rho), 400 cells": at_most(5.2e-2, TABLE, 4.51e-2),
          "place of the peak": about(0.78, 0.03, "Woodward and Colella")},
         reference=lambda runs, finer: against(
             runs, finer({"grid.cells": [12800]}))),
    Case("shu_osher", "1D", "shu_osher", "Shu-Osher", peak,
         cells(300), None,
         {"L1(rho), 300 cells": at_most(0.26, TABLE, 0.247)},
         reference=lambda runs, finer: against(
             runs, finer({"grid.cells": [9000]}))),
    Case("stationary_contact", "1D", "stationary_contact",
         "contact at rest", errors,
         bounds={"L1(rho), 100 cells": at_most(1e-6, EQUILIBRIUM)}),
    Case("moving_contact", "1D", "moving_contact", "contact in a stream",
         errors, bounds={"L1(rho), 100 cells": at_most(1e-6, EQUILIBRIUM)}),
    Case("stationary_shock", "1D", "stationary_shock", "shock at rest",
         errors, bounds=three_cells(100, 1 / 100, 5 / 3)),
    Case("slow_shock", "1D", "slow_shock", "slowly moving shock", errors,
         bounds=three_cells(200, 1 / 100, 2.857)),
    Case("mach100_shock", "1D", "mach100_shock", "Mach 100 shock", errors,
         bounds=three_cells(100, 1 / 100, 4.997)),
    Case("wave", "1D", "acoustic_wave", "smooth wave, midpoint",
         errors_and_order,
         [{"grid.cells": [n], "method.time": "midpoint"}
          for n in (32, 64, 128, 256)],
         [{"grid.cells": [n], "method.time": "midpoint"} for n in (32, 64)],
         {"L1(rho), 64 cells": at_most(7e-4, TABLE, 6.1e-4),
          "order": at_least(1.8, TABLE, 1.77)}),
    # Noise of the particles' places must not grow in ten sound times.
    Case("wave_random", "1D", "acoustic_wave", "wave, random places", errors,
         [{"method.time": "midpoint", "particles.placement": "random",
           "initial.0.amplitude": 0.005, "time.end": 10}], None,
         {"L1(rho), 64 cells": at_most(1e-3, "a fifth of the amplitude")}),
    # Hats keep nothing of a short wave whose particles cross nodes.
    Case("wave_linear", "1D", "acoustic_wave", "on hats, CFL 0.5 to 1.2",
         worst,
         [{"method.basis": "linear", "grid.cells": [512], "time.cfl": cfl}
          for cfl in (0.5, 0.7, 0.8, 1.0, 1.2)],
         [{"method.basis": "linear", "grid.cells": [128], "time.cfl": cfl}
          for cfl in (0.5, 0.8)],
         {"worst L1(rho) of 5": at_most(6e-4, "1.5 times that at CFL 0.4")},
         methods=("conservative",)),
    Case("translation", "1D", "translation", "uniform stream at Mach 3",
         velocity_error,
         [{"dimension": 1, "particles.placement": p, "time.end": 2,
           "particles.per_cell": 3,
           "grid": {"lower": [0], "upper": [1], "cells": [100]},
           "initial.0.velocity": [3],
           "boundary": [{"type": "periodic", "side": side}
                        for side in ("x_lower", "x_upper")]}
          for p in ("lattice", "random")], None,
         {"max |v - v0|, lattice": at_most(1e-11, TABLE),
          "max |v - v0|, random": at_most(1e-4, TABLE)}),
    # A gap behind gas that leaves must not choke what follows.
    Case("open_stream", "1D", "translation", "Mach .3 through open sides",
         worst_density, streams(100, 20, 1, 2, 3), streams(50, 10, 1),
         {f"max |rho/rho0 - 1|, seed {seed}": at_most(0.05, EQUILIBRIUM)
          for seed in (1, 2, 3)}),
]
