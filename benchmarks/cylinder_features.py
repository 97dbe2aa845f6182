#!/usr/bin/env python3
"""Stand-off distance and stagnation (pitot) pressure of a Mach 3 cylinder.

Usage: benchmarks/cylinder_features.py DIR [first_time]

DIR holds a run of a scene with one sphere as obstacle (input/cylinder_mach3).
From every particle output with time >= first_time (default: the last quarter):
- stand-off: along the stagnation line (|y - y_c| < h) the first place where
  the density (mass over volume, in slabs of h) passes the mean of the free
  stream's and that behind a normal shock, in radii from the body;
- pitot: volume-weighted pressure within 1.5 h of the body's front.
Exact values (gamma 1.4, Mach 3): density ratio 3.857, pitot 12.06 p_inf; the
stand-off of a finite-volume reference at this blockage is 0.70 R.
"""
import pathlib
import sys

HERE = pathlib.Path(__file__).resolve().parent
sys.path += [str(HERE / name) for name in ("performance", "reference")]

import cylinder
import packages

h5py = packages.find("h5py")
np = packages.find("numpy")


def features(path, lower, h, center, radius, free, behind):
    with h5py.File(path) as f:
        x, y = f["position"][:].T
        mass = f["mass"][:]
        volume = mass / f["density"][:]
        pressure = f["pressure"][:]
    xc, yc = center
    line = (abs(y - yc) < h) & (x < xc - radius)
    slab = ((x[line] - lower) / h).astype(int)
    v = np.bincount(slab, volume[line])
    rho = np.bincount(slab, mass[line]) / np.maximum(v, 1e-300)
    place = lower + (np.arange(len(v)) + 0.5) * h
    rho, place = rho[v > 0], place[v > 0]
    middle = 0.5 * (free + behind)
    passes = np.where((rho[:-1] < middle) & (rho[1:] >= middle))[0]
    standoff = np.nan
    if len(passes):
        i = passes[0]
        part = (middle - rho[i]) / (rho[i + 1] - rho[i])
        shock = place[i] + part * (place[i + 1] - place[i])
        standoff = (xc - radius - shock) / radius
    front = (np.hypot(x - xc, y - yc) < radius + 1.5 * h) & \
        (abs(y - yc) < 2 * h) & (x < xc)
    pitot = (pressure * volume)[front].sum() / volume[front].sum() \
        if front.any() else np.nan
    return standoff, pitot


def main():
    run = cylinder.parse(__doc__)
    grid = run.scene["grid"]
    h = (grid["upper"][0] - grid["lower"][0]) / grid["cells"][0]
    rows = []
    for path in sorted(run.folder.glob("particles/*.h5")):
        with h5py.File(path) as f:
            time = f.attrs["time"]
        if time >= run.first - 1e-9:
            rows.append((time,) + features(path, grid["lower"][0], h,
                                           run.body["center"], run.body["radius"],
                                           run.gas["density"], run.behind))
    if not rows:
        sys.exit(f"{run.folder}: no output of particles from t = {run.first:g} on; "
                 "give an earlier time as second argument")
    t, standoff, pitot = np.array(rows).T
    print(f"{len(t)} outputs, t = {t[0]:.3g} to {t[-1]:.3g}")
    print(f"stand-off {np.nanmean(standoff):.3f} R "
          f"(std {np.nanstd(standoff):.3f})")
    print(f"pitot {np.nanmean(pitot):.2f} (std {np.nanstd(pitot):.2f})")


if __name__ == "__main__":
    main()
