"""Random Riemann problems: seeded, over six decades, up to Mach 20."""
import concurrent.futures
import json
import math
import random
import shutil
import statistics

import gas
import suite
from run import ROOT, broken_invariants, execute, settings

SCENE = "input/sod.json"
CELLS = 200
SPAN = 0.8  # of the domain that the waves cover at the end
MOST_STEPS = 100000  # the time step of a cold gas beside a hot one is short


def draw(number):
    """Problem `number`: gamma, left and right (density, velocity, pressure).

    Densities and pressures are log-uniform over six decades, Mach numbers
    uniform between -20 and 20, gamma between 1.1 and 1.67.
    """
    r = random.Random(number)
    gamma = r.uniform(1.1, 1.67)
    sides = []
    for _ in range(2):
        density, pressure = 10**r.uniform(-3, 3), 10**r.uniform(-3, 3)
        speed = r.uniform(-20, 20) * math.sqrt(gamma * pressure / density)
        sides.append((density, speed, pressure))
    return gamma, *sides


def is_vacuum_forming(gamma, left, right):
    c = sum(math.sqrt(gamma * p / rho) for rho, _, p in (left, right))
    return right[1] - left[1] >= 2 * c / (gamma - 1)


def overrides(number, cells=CELLS):
    """The problem as overrides of SCENE.

    The domain has length 1 and holds all waves up to the end, with a margin on
    both sides; gas that moves inwards is let in, gas that moves outwards is
    let go.
    """
    gamma, left, right = draw(number)
    slowest, fastest = gas.riemann_speeds(left, right, gamma)
    slowest, fastest = min(slowest, 0), max(fastest, 0)
    end = SPAN / (fastest - slowest)
    lower = slowest * end - (1 - SPAN) / 2

    def state(side):
        return {"density": side[0], "velocity": [side[1]], "pressure": side[2]}

    def boundary(name, side, inwards):
        if inwards > 0:
            return dict(type="inflow", side=name, **state(side))
        return dict(type="outflow", side=name)

    return {
        "scene": f"riemann_{number}",
        "grid": {"lower": [lower], "upper": [lower + 1], "cells": [cells]},
        "physics": [{"type": "ideal_gas", "gamma": gamma},
                    {"type": "artificial_viscosity"}],
        "initial": [{"type": "riemann", "position": 0, "left": state(left),
                     "right": state(right)}],
        "boundary": [boundary("x_lower", left, left[1]),
                     boundary("x_upper", right, -right[1])],
        "time.end": end,
        "output": {"every": end, "grid": False},
    }


def solve(work, method, number):
    """One problem by one method: what broke, and L1 of the density over the
    mass in the domain."""
    directory = work.output / "runs" / f"draws-{method}" / str(number)
    scene = json.loads((ROOT / SCENE).read_text())
    run = execute(work.machpoint, SCENE,
                  settings(scene, method, overrides(number)), directory, 600)
    result = {"number": number, "code": run.code, "command": run.command,
              "vacuum": is_vacuum_forming(*draw(number)), "error": None,
              "retries": None, "broken": broken_invariants(run, MOST_STEPS)}
    if run.summary:
        result["retries"] = run.summary["retries"]
        if run.summary["errors"]:  # none of a run that failed
            result["error"] = run.error() / float(run.read()["mass"].sum())
    shutil.rmtree(directory, ignore_errors=True)
    return result


def solve_all(work, method, numbers, workers=2):
    """Results of many problems, kept by the hundred."""
    scene = suite.digest(json.loads((ROOT / SCENE).read_text()))
    results = []
    with concurrent.futures.ThreadPoolExecutor(workers) as pool:
        for first in range(0, len(numbers), 100):
            block = numbers[first:first + 100]
            key = (f"draws-{method}-{block[0]}-{block[-1]}-{CELLS}-{scene}-"
                   f"{work.identity}")
            results += work.remembered(key, lambda: list(
                pool.map(lambda n: solve(work, method, n), block))) or []
    return results


def digest(results):
    """Counts and errors of many results."""
    intact = [r for r in results if not r["broken"]]
    errors = sorted(r["error"] for r in intact if r["error"] is not None)
    return {"drawn": len(results), "intact": len(intact),
            "vacuum": sum(r["vacuum"] for r in results),
            "vacuum_intact": sum(r["vacuum"] for r in intact),
            "retried": sum(bool(r["retries"]) for r in intact),
            "median": statistics.median(errors) if errors else None,
            "90 % below": errors[int(0.9 * len(errors))] if errors else None,
            "worst": errors[-1] if errors else None}
