#!/usr/bin/env python3
"""Stand-off distance and stagnation pressure of machpoint_reference's cylinder.

Usage: benchmarks/reference/cylinder_features.py DIR [first_time]

DIR holds a run of machpoint_reference on input/cylinder_mach3.json, with one
sphere as obstacle. Printed for every output with time >= first_time (default:
the last quarter), from the grid's fields:
- stand-off: where, along the stagnation line (the mean of the rows beside the
  body's centre), the density first passes the mean of the free stream's and
  that behind a normal shock, in radii from the body;
- stagnation pressure: at the body's front, by a straight line through the two
  gas cells before it, over the free stream's pressure.
Exact at Mach 3 with gamma 1.4: pressure 12.06 (Rayleigh's pitot formula).
"""
import pathlib
import sys

sys.path.append(str(pathlib.Path(__file__).resolve().parents[1] / "performance"))

import cylinder
import packages

h5py = packages.find("h5py")
np = packages.find("numpy")


def features(file, center, radius, middle):
    """Stand-off in radii and pressure at the front."""
    (x0, y0), (h, hy) = file.attrs["lower"], file.attrs["spacing"]
    density, pressure = file["density"][...], file["pressure"][...]
    y = y0 + np.arange(density.shape[0]) * hy
    rows = abs(y - center[1]) < 0.75 * hy
    x = x0 + np.arange(density.shape[1]) * h
    front = center[0] - radius
    line = (x < front) & (density[rows] > 0).all(axis=0)
    x, rho, p = x[line], density[rows].mean(0)[line], pressure[rows].mean(0)[line]
    stagnation = p[-1] + (p[-1] - p[-2]) / h * (front - x[-1])
    passes = np.flatnonzero((rho[:-1] < middle) & (rho[1:] >= middle))
    if not len(passes):
        return np.nan, stagnation
    i = passes[0]
    shock = x[i] + h * (middle - rho[i]) / (rho[i + 1] - rho[i])
    return (front - shock) / radius, stagnation


def main():
    run = cylinder.parse(__doc__)
    middle = (run.gas["density"] + run.behind) / 2
    for path in sorted(run.folder.glob("grid/*.h5")):
        with h5py.File(path) as file:
            if file.attrs["time"] < run.first - 1e-9:
                continue
            standoff, p = features(file, run.body["center"], run.body["radius"],
                                   middle)
            print(f"t = {file.attrs['time']:.3g}: stand-off {standoff:.3f} R, "
                  f"stagnation pressure {p / run.gas['pressure']:.2f}")


if __name__ == "__main__":
    main()
