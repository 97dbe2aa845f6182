#!/usr/bin/env python3
"""Runs the piston and compares it with the exact shock.

Usage: check.py PROGRAM INPUT OUTPUT
"""
import csv
import json
import math
import pathlib
import subprocess
import sys

import h5py
import numpy as np

program, source, output = sys.argv[1:]
output = pathlib.Path(output)
told = subprocess.run([program, "check", source], check=True, text=True,
                      stdout=subprocess.PIPE, stderr=subprocess.PIPE)
subprocess.run([program, "run", source, "--output", output, "--overwrite", "--quiet"],
               check=True)

# Exact: a shock at which the gas takes the velocity u of the piston
# (Rankine-Hugoniot; Toro 2009, section 3.1.3), p = rho = 1 before it.
piston = json.loads(pathlib.Path(source).read_text())["boundary"][0]
gamma, u = 1.4, piston["velocity"]
quarter = (gamma + 1) / 4 * u
speed = quarter + math.sqrt(quarter**2 + gamma)
density = speed / (speed - u)
pressure = 1 + speed * u

summary = json.loads((output / "summary.json").read_text())
balance = summary["conservation"]
with h5py.File(max((output / "particles").glob("*.h5"))) as file:
    time = float(file.attrs["time"])
    position = file["position"][:, 0]
    order = np.argsort(position)
    position, rho = position[order], file["density"][:][order]
with open(output / "series" / "piston.csv", newline="") as file:
    face = float(list(csv.DictReader(file))[-1]["position"])

# The shock is where the density passes the mean of both sides.
mean = (1 + density) / 2
k = np.flatnonzero(rho > mean)[-1]
shock = np.interp(mean, rho[[k + 1, k]], position[[k + 1, k]])
# A fifth of the shocked gas at both ends: wall heating, and the shock's width.
margin = (shock - face) / 5
plateau = rho[(position > face + margin) & (position < shock - margin)].mean()
work = balance["work_on_gas"]

failures = 0


def check(what, error, tolerance):
    global failures
    good = abs(error) <= tolerance
    failures += not good
    print(f"{what:<44} {error:>11.3e}  (at most {tolerance:g})"
          f"{'' if good else '  FAILED'}")


# The shock is captured over about four of the 230 cells that it has crossed.
check("shock speed, relative error", shock / time / speed - 1, 0.02)
# The volumes that particles carry are first order in time inside the shock.
check("density behind the shock, relative error", plateau / density - 1, 0.01)
# The gas takes the work p u t: this sees the force, not only the balance.
check("work of the piston, relative error", work / (pressure * u * time) - 1, 0.02)
# Round-off of some thousand steps, but no more.
single = summary["precision"] == "single"
check("mass, relative drift", balance["mass"], 1e-6 if single else 1e-13)
check("energy less work, relative drift", balance["total_energy"],
      1e-4 if single else 1e-11)
check("position of the face, error", face - u * time,
      1e-6 if single else 1e-12)
# A study knows the boundary's series, too.
study = output / "piston.json"
study.write_text(json.dumps({
    "study": "piston", "input": str(pathlib.Path(source).resolve()),
    "vary": [{"grid.cells": [[75], [150]]}], "error": "piston.force",
    "reference": {"type": "known", "values": {"piston.force": pressure}}}))
subprocess.run([program, "study", study, "--output", output / "study"],
               check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
rows = json.loads((output / "study" / "study.json").read_text())["rows"]
force = rows[-1]["values"]["piston.force"]
check("mean force of 150 cells, relative error", force / pressure - 1, 0.03)
check("warnings of the input", told.stderr.count("warning"), 0)
check("particles behind the face", np.count_nonzero(position < face), 0)
sys.exit(failures > 0)
