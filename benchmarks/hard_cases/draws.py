"""Random Riemann problems: seeded, over six decades, up to Mach 20."""
import math
import random

import gas

SCENE = "input/sod.json"
CELLS = 200
SPAN = 0.8  # of the domain that the waves cover at the end


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
