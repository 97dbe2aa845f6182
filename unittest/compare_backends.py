#!/usr/bin/env python3
"""The same scenes on several builds: particle by particle equal to round-off.

Usage: unittest/compare_backends.py MACHPOINT OTHER...

Each OTHER is held against the first, which also has to repeat itself. Backends add
in different orders, so 50 steps may amplify 1e-16 a little; they may not change a
digit that anyone would see.
"""
import glob
import json
import os
import subprocess
import sys
import tempfile
import unittest

try:
    import h5py
    import numpy as np
except ModuleNotFoundError: # tools/gpu_check then compares summaries
    h5py = None

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
SCENES = {
    "sod": [],
    "sod_2d": ["particles.placement=random", "particles.sort_every=3"],
    "cylinder_mach3": ["grid.cells=[80,40]"],
    "cylinder_mach3_recycle": ["grid.cells=[80,40]"],
    "sphere_mach3": ["grid.cells=[16,12,12]"],
    "isentropic_vortex": ["grid.cells=[32,32]", "method.name=apic"],
    "sod_3d": ["grid.cells=[40,4,4]", "method.name=paper"],
}
FIELDS = ("position", "velocity", "density", "pressure",
          "specific_internal_energy", "mass")
STEPS = 50
TOLERANCE = 1e-9  # of a field's largest magnitude, or of the speed of sound


def run(machpoint, scene, overrides, threads=None, timeout=None):
    """Particles after STEPS steps in the order of their ids, {field: values},
    and the summary. threads: of OpenMP; None: as the environment says.
    timeout: in seconds."""
    with tempfile.TemporaryDirectory() as folder:
        out = os.path.join(folder, "out")
        command = [machpoint, "run", f"{ROOT}/input/{scene}.json", "--quiet",
                   "--max-steps", str(STEPS), "--output", out]
        for override in overrides:
            command += ["--set", override]
        environment = dict(os.environ)
        if threads is not None:
            environment["OMP_NUM_THREADS"] = str(threads)
        subprocess.run(command, check=True, stdout=subprocess.DEVNULL,
                       stderr=subprocess.PIPE, text=True, env=environment,
                       timeout=timeout)
        with open(out + "/summary.json") as f:
            summary = json.load(f)
        path = sorted(glob.glob(out + "/particles/*.h5"))[-1]
        with h5py.File(path) as f:
            order = np.argsort(f["id"][:])
            return {"id": f["id"][:][order],
                    **{name: f[name][:][order] for name in FIELDS}}, summary


def difference(a, b):
    """Largest difference of two runs' particles, relative to the field's
    largest magnitude, and that field; infinite where the particles are not the
    same ones. A velocity is held against sqrt(p / rho), too, where that is larger:
    that of gas at rest is round-off."""
    if not np.array_equal(a["id"], b["id"]):
        return np.inf, "id"
    parts = {}
    for name in FIELDS:
        scale = np.abs(a[name]).max() + 1e-300
        if name == "velocity":
            scale = max(scale, np.sqrt(
                np.abs(a["pressure"] / a["density"]).max()))
        parts[name] = float(np.abs(a[name] - b[name]).max() / scale)
    # What is not a number is no small difference.
    worst = max(parts, key=lambda name: np.nan_to_num(parts[name], nan=np.inf))
    return parts[worst], worst


class Backends(unittest.TestCase):

    def test_builds_agree(self):
        for scene, overrides in SCENES.items():
            first = run(BUILDS[0], scene, overrides, 1)[0]
            for other in BUILDS[1:]:
                with self.subTest(scene=scene, build=other):
                    found, field = difference(
                        first, run(other, scene, overrides, 2)[0])
                    self.assertLessEqual(found, TOLERANCE, field)

    def test_one_thread_is_reproducible(self):
        for scene, overrides in SCENES.items():
            a = run(BUILDS[0], scene, overrides, 1)[0]
            b = run(BUILDS[0], scene, overrides, 1)[0]
            for name in FIELDS:
                np.testing.assert_array_equal(a[name], b[name], err_msg=scene)


if __name__ == "__main__":
    BUILDS = sys.argv[1:]
    if len(BUILDS) < 2:
        sys.exit("name two builds or more")
    unittest.main(argv=sys.argv[:1])
