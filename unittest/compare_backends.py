#!/usr/bin/env python3
"""The same scenes on two builds: particle by particle equal to round-off.

Usage: unittest/compare_backends.py MACHPOINT_A MACHPOINT_B

Backends add in different orders, so 50 steps may amplify 1e-16 a little; they
may not change a digit that anyone would see.
"""
import glob
import os
import subprocess
import sys
import tempfile
import unittest

import h5py
import numpy as np

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
SCENES = {
    "sod": [],
    "sod_2d": ["particles.placement=random", "particles.sort_every=3"],
    "cylinder_mach3": ["grid.cells=[80,40]"],
    "cylinder_mach3_recycle": ["grid.cells=[80,40]"],
    "sphere_mach3": ["grid.cells=[16,12,12]"],
}
FIELDS = ("position", "velocity", "density", "pressure",
          "specific_internal_energy", "mass")


def last_particles(machpoint, scene, overrides, threads):
    with tempfile.TemporaryDirectory() as folder:
        out = os.path.join(folder, "out")
        command = [machpoint, "run", f"{ROOT}/input/{scene}.json", "--quiet",
                   "--max-steps", "50", "--output", out]
        for override in overrides:
            command += ["--set", override]
        subprocess.run(command, check=True, stdout=subprocess.DEVNULL,
                       env=dict(os.environ, OMP_NUM_THREADS=str(threads)))
        path = sorted(glob.glob(out + "/particles/*.h5"))[-1]
        with h5py.File(path) as f:
            order = np.argsort(f["id"][:])
            return {"id": f["id"][:][order],
                    **{name: f[name][:][order] for name in FIELDS}}


class Backends(unittest.TestCase):
    def compare(self, a, b, scene):
        np.testing.assert_array_equal(a["id"], b["id"], err_msg=scene)
        for name in FIELDS:
            scale = np.abs(a[name]).max() + 1e-300
            np.testing.assert_allclose(a[name] / scale, b[name] / scale,
                                       atol=1e-9, rtol=0,
                                       err_msg=f"{scene}: {name}")

    def test_builds_agree(self):
        for scene, overrides in SCENES.items():
            self.compare(last_particles(BUILDS[0], scene, overrides, 1),
                         last_particles(BUILDS[1], scene, overrides, 2), scene)

    def test_one_thread_is_reproducible(self):
        for scene, overrides in SCENES.items():
            a = last_particles(BUILDS[0], scene, overrides, 1)
            b = last_particles(BUILDS[0], scene, overrides, 1)
            for name in FIELDS:
                np.testing.assert_array_equal(a[name], b[name], err_msg=scene)


if __name__ == "__main__":
    BUILDS = sys.argv[1:3]
    unittest.main(argv=sys.argv[:1])
