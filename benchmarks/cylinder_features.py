#!/usr/bin/env python3
"""Stand-off distance and stagnation (pitot) pressure of a Mach 3 cylinder.

Usage: benchmarks/cylinder_features.py DIR [first_time]

DIR holds a run of a scene with one sphere as obstacle (input/cylinder_mach3).
From every particle output with time >= first_time (default: the last quarter):
- stand-off: along the stagnation line (|y - y_c| < h) the first place where
  the density (mass over volume, in slabs of h) passes the mean of the free
  stream's and that behind a normal shock, in radii from the body;
- pitot: volume-weighted pressure within 1.5 h of the body's front, over the free
  stream's.
Exact values (gamma 1.4, Mach 3): density ratio 3.857, pitot 12.06; the
stand-off of a finite-volume reference at this blockage is 0.70 R.
"""
import pathlib
import sys

HERE = pathlib.Path(__file__).resolve().parent
sys.path += [str(HERE / name) for name in ("performance", "reference", "hard_cases")]

import cylinder
import packages
import planes
from run import Run

np = packages.find("numpy")


def main():
    flow = cylinder.parse(__doc__)
    if not (flow.folder / "particles").is_dir():
        sys.exit(f"{flow.folder}: this run has no particles; take "
                 "benchmarks/reference/cylinder_features.py")
    run = Run(flow.folder, 0, "", "", 0)
    middle = (flow.gas["density"] + flow.behind) / 2
    rows = [(data["time"], *planes.ahead_of_body(run, data, flow.body, middle))
            for data in run.later(flow.first)]
    if not rows:
        sys.exit(f"{flow.folder}: no output of particles from t = {flow.first:g} on; "
                 "give an earlier time as second argument")
    t, standoff, pitot = np.array(rows).T
    print(f"{len(t)} outputs, t = {t[0]:.3g} to {t[-1]:.3g}")
    print(f"stand-off {np.nanmean(standoff):.3f} R "
          f"(std {np.nanstd(standoff):.3f})")
    print(f"pitot {np.nanmean(pitot):.2f} (std {np.nanstd(pitot):.2f})")


if __name__ == "__main__":
    main()
