"""The largest stable CFL number of each method and basis, by bisection."""
import math

from run import broken_invariants, execute, settings
from suite import digest

FIRST = 0.1
LIMIT = 100.0  # the input's largest
PRECISION = 1.1  # of the answer, as a factor

# Scene, overrides: all have an exact solution.
SCENES = {
    "sod": ("sod", {}),
    "toro3": ("toro3", {"grid.cells": [100]}),
    "noh_1d": ("noh_1d", {}),
    "noh_2d": ("noh_2d", {"grid.cells": [40, 40]}),
    "vortex": ("isentropic_vortex", {"grid.cells": [32, 32]}),
}
# Label: `method` of the input.
INTEGRATORS = {
    "paper linear": {"name": "paper", "basis": "linear"},
    **{f"apic {basis}": {"name": "apic", "basis": basis}
       for basis in ("linear", "quadratic", "cubic")},
    **{f"conservative {basis} {time}":
       {"name": "conservative", "basis": basis, "time": time}
       for basis in ("linear", "quadratic", "cubic")
       for time in ("symplectic", "midpoint")},
}


def attempt(work, name, integrator, cfl):
    """(whether all went well, L1 of the density) at one CFL number."""
    scene, sets = SCENES[name]
    method = INTEGRATORS[integrator]
    keys = settings(work.scene(scene), method["name"],
                    dict(sets, **{"method": method, "time.cfl": cfl,
                                  "output.every": 1e9, "output.grid": False}))
    directory = work.output / "runs" / f"cfl-{name}-{integrator}".replace(
        " ", "-")
    run = execute(work.machpoint, f"input/{scene}.json", keys, directory, 300)
    # paper loses energy at any time step: that is not about stability.
    broken = [text for text in broken_invariants(run, 100000)
              if "total energy" not in text]
    good = not broken and run.summary["retries"] == 0
    # A run that broke down has a summary, but no errors.
    return good, run.error() if run.summary.get("errors") else math.inf


def largest(work, name, integrator):
    """The largest CFL number, to 10 %, up to which every one tried finishes,
    repeats no step, keeps the invariants and has at most twice the error of
    CFL 0.1; None if that one fails itself."""
    good, error = attempt(work, name, integrator, FIRST)
    if not good:
        return None

    def stable(cfl):
        fine, found = attempt(work, name, integrator, cfl)
        return fine and found <= 2 * error

    low = high = FIRST
    while high < LIMIT:
        high = min(1.5 * low, LIMIT)
        if not stable(high):
            break
        low = high
    if low >= LIMIT:
        return LIMIT
    while high / low > PRECISION:
        middle = math.sqrt(low * high)
        low, high = (middle, high) if stable(middle) else (low, middle)
    return low


def key(work, name, integrator):
    scene = digest(work.scene(SCENES[name][0]))
    return f"cfl-{name}-{integrator.replace(' ', '-')}-{scene}-{work.identity}"


def is_kept(work):
    """Is the whole table there already?"""
    return all((work.output / "results" / f"{key(work, name, i)}.json").exists()
               for name in SCENES for i in INTEGRATORS)


def table(work):
    """{integrator: {scene: largest CFL or None}}."""
    return {integrator: {name: work.remembered(
        key(work, name, integrator),
        lambda: largest(work, name, integrator)) for name in SCENES}
        for integrator in INTEGRATORS}
