"""The number of ranks and how they are arranged change results by round-off, and
with `reproducible` not at all.

The executable comes from MACHPOINT_EXECUTABLE, the launcher from
MACHPOINT_MPIEXEC.
"""

import json
import os
import pathlib
import subprocess
import tempfile
import unittest

import h5py
import numpy as np

from running import ENVIRONMENT, NUMERICAL_FAILURE, WRONG_INPUT

EXECUTABLE = os.path.abspath(os.environ["MACHPOINT_EXECUTABLE"])
LAUNCHER = os.environ["MACHPOINT_MPIEXEC"]
INPUT = pathlib.Path(__file__).resolve().parent.parent / "input"

TOLERANCE = 1e-12  # relative to the largest value


def method(name, basis):
    return {"method": {"name": name, "basis": basis}}


UPPER_HALF, LOWER_HALF = [
    {"type": "half_space", "point": [0, 5], "normal": [0, direction]}
    for direction in (-1, 1)]

DIFFUSION = [{"type": "ideal_gas"}, {"type": "artificial_viscosity"},
             {"type": "viscosity", "shear": 0.02},
             {"type": "heat_conduction", "conductivity": 0.03}]

# Scene, what differs from the shipped input, steps. All kinds of sides,
# obstacles, and everything that makes, moves or removes particles.
SCENES = {
    "sod": ("sod", {}, 40),
    "sod, cubic, random": ("sod", {
        "particles.placement": "random", "method.basis": "cubic"}, 40),
    "vortex": ("isentropic_vortex", {"grid.cells": [32, 32]}, 20),
    "vortex, linear": ("isentropic_vortex", {
        "grid.cells": [32, 32], **method("conservative", "linear")}, 20),
    "blast with halves": ("sedov_2d", {"grid.cells": [40, 40]}, 40),
    "cylinder": ("cylinder_mach3", {"grid.cells": [100, 50]}, 40),
    "cylinder, merging": ("cylinder_mach3", {
        "grid.cells": [100, 50], "method.merge_volume": 0.4}, 12),
    "cylinder, apic": ("cylinder_mach3", {
        "grid.cells": [60, 30], **method("apic", "quadratic")}, 30),
    "recycled stream": ("cylinder_mach3_recycle", {
        "grid.cells": [60, 30], **method("paper", "quadratic")}, 30),
    "gravity": ("gravity_column", {}, 20),
    # Halves of what is longer than its cell is wide.
    "halves in narrow cells": ("filling", {
        "grid.cells": [128, 4], "initial": [
            {"type": "uniform", "density": 1, "velocity": [speed, 0],
             "pressure": 1, "region": {"type": "box", "lower": [lower, -1],
                                       "upper": [lower + 0.2, 2]}}
            for speed, lower in ((-3, 0.3), (3, 0.5))]}, 50),
    "heavy gas at a body": ("cylinder_mach3", {
        "grid.cells": [60, 30], "physics": [
            {"type": "ideal_gas"}, {"type": "artificial_viscosity"},
            {"type": "gravity", "acceleration": [0.2, -0.5]}]}, 30),
    "viscous gas at a body": ("cylinder_mach3", {
        "grid.cells": [60, 30], "physics": DIFFUSION}, 30),
    "blast in 3D": ("sedov_3d", {"grid.cells": [16, 18, 20]}, 12),
    # The kind of a side changes, at a corner of periodic sides too.
    "side of two kinds": ("isentropic_vortex", {
        "grid.cells": [32, 36], "boundary": [
            {"type": "periodic", "side": "y_lower"},
            {"type": "periodic", "side": "y_upper"},
            {"type": "slip_wall", "side": "x_lower"},
            {"type": "outflow", "side": "x_upper", "region": UPPER_HALF},
            {"type": "no_slip_wall", "side": "x_upper",
             "region": LOWER_HALF}]}, 25),
}
# Gas in a part of the domain, so that boxes move: every module and method that
# keeps something on nodes must follow.
FOLLOWED = {
    # Round-off soon grows at the front to vacuum.
    "filling": ("filling", {"grid.cells": [32, 32]}, 15),
    "cylinder": ("cylinder_mach3", {
        "grid.cells": [60, 30], "initial.0.region": {
            "type": "box", "lower": [-1, -1], "upper": [1.2, 3]}}, 25),
    "cylinder, apic": ("cylinder_mach3", {
        "grid.cells": [60, 30], **method("apic", "quadratic"),
        "initial.0.region": {
            "type": "box", "lower": [-1, -1], "upper": [1.2, 3]}}, 25),
    "viscous stream": ("cylinder_mach3", {
        "grid.cells": [60, 30], "physics": DIFFUSION, "initial.0.region": {
            "type": "box", "lower": [-1, -1], "upper": [1.2, 3]}}, 25),
    "stream, paper": ("cylinder_mach3_recycle", {
        "grid.cells": [60, 30], **method("paper", "quadratic"),
        "initial.0.region": {
            "type": "box", "lower": [-1, -1], "upper": [1.2, 3]}}, 25),
    "gravity, linear": ("gravity_column", {
        **method("conservative", "linear"), "initial.0.region": {
            "type": "box", "lower": [-1], "upper": [0.3]}}, 40),
}
OFTEN = {"every": 5, "threshold": 1.05}
# The same to the last bit: every kind of sum. Scene, changes, steps, ranks.
REPRODUCIBLE = {
    "sod": ("sod", {"particles.placement": "random"}, 30, (2, 3, 4)),
    "vortex": ("isentropic_vortex", {"grid.cells": [24, 24]}, 10, (2, 4)),
    "blast with halves": ("sedov_2d", {"grid.cells": [24, 24]}, 30, (3, 4)),
    "cylinder": ("cylinder_mach3", {
        "grid.cells": [80, 40], "method.merge_volume": 0.4}, 15,
                 (2, 3, [2, 2], [4, 1], [1, 4])),
    # Nodes that stand for the wall, in more than one box.
    "ball on the floor": ("cylinder_mach3", {
        "grid.cells": [60, 30], "boundary.4.shape.center": [0.6, 0.25]}, 30,
                          (2, 3, [4, 1])),
    "cylinder, apic": ("cylinder_mach3", {
        "grid.cells": [60, 30], **method("apic", "quadratic")}, 10, (3,)),
    "recycled stream": ("cylinder_mach3_recycle", {
        "grid.cells": [60, 30], **method("paper", "quadratic")}, 10, (3,)),
    "gravity": ("gravity_column", {}, 10, (3,)),
    "viscous gas at a body": ("cylinder_mach3", {
        "grid.cells": [60, 30], "physics": DIFFUSION}, 10, (2, [2, 2])),
    "blast in 3D": ("sedov_3d", {"grid.cells": [10, 11, 15]}, 6, (3, 4)),
}
ARRANGED = {"cylinder": ([4, 1], [2, 2], [1, 4]),
            "side of two kinds": ([4, 1], [2, 2]),
            "blast in 3D": ([2, 2, 1], [1, 2, 2])}


class DecompositionTest(unittest.TestCase):

    def setUp(self):
        scratch = tempfile.TemporaryDirectory()
        self.addCleanup(scratch.cleanup)
        self.scratch = pathlib.Path(scratch.name)

    def execute(self, ranks, scene, sets, steps, *options, threads=1):
        words = [LAUNCHER, "-n", str(ranks), EXECUTABLE, "run",
                 str(INPUT / f"{scene}.json"), "--quiet",
                 *(options or ["--overwrite"]),
                 "--output", str(self.scratch / "out"),
                 "--max-steps", str(steps), "--set", "output.every=1e9"]
        for path, value in sets.items():
            words += ["--set", f"{path}={json.dumps(value)}"]
        return subprocess.run(words, stdin=subprocess.DEVNULL, text=True,
                              capture_output=True,
                              env={**ENVIRONMENT,
                                   "OMP_NUM_THREADS": str(threads)},
                              timeout=120)

    def run_scene(self, ranks, *scene, threads=1):
        """Particles ordered by id, node fields, and the summary."""
        result = self.execute(ranks, *scene, threads=threads)
        self.assertEqual(result.returncode, 0, result.stderr)
        fields = {}
        for kind in ("particles", "grid"):
            last = sorted((self.scratch / "out" / kind).glob("*.h5"))[-1]
            with h5py.File(last) as file:
                data = {f"{kind} {name}": file[name][...] for name in file
                        if isinstance(file[name], h5py.Dataset)}
            if kind == "particles":
                order = np.argsort(data["particles id"])
                data = {name: values[order] for name, values in data.items()}
            fields.update(data)
        summary = json.loads(
            (self.scratch / "out" / "summary.json").read_text())
        self.assertEqual(summary["ranks"], ranks)
        self.assertGreaterEqual(summary["imbalance"]["start"], 1)
        summary["series"] = {
            file.name: file.read_text()
            for file in (self.scratch / "out" / "series").glob("*.csv")}
        return fields, summary

    def assert_same(self, one, many):
        fields, summary = one
        others, other_summary = many
        np.testing.assert_array_equal(fields["particles id"],
                                      others["particles id"])
        for name, values in fields.items():
            scale = max(abs(values).max(), 1e-300)
            # Of domains and sound speeds, about 1 in these scenes: a gas at
            # rest has no speed of its own.
            if name.endswith(("position", "velocity")):
                scale = max(scale, 1.0)
            self.assertLess(abs(values - others[name]).max() / scale,
                            TOLERANCE, name)
        for key in ("particles_initial", "particles_final", "steps", "cells",
                    "retries"):
            self.assertEqual(summary[key], other_summary[key], key)
        drifts = [s["conservation"] for s in (summary, other_summary)]
        self.assertLess(abs(drifts[1]["mass"]), 1e-13)
        for key in ("mass_in", "mass_out", "work_on_gas"):
            self.assertAlmostEqual(drifts[0][key], drifts[1][key], delta=1e-12)

    def test_any_number_of_ranks(self):
        for label, scene in SCENES.items():
            one = self.run_scene(1, *scene)
            self.assertGreater(len(one[0]["particles id"]), 100)
            for ranks in (2, 3, 4):
                with self.subTest(scene=label, ranks=ranks):
                    self.assert_same(one, self.run_scene(ranks, *scene))

    def test_any_arrangement(self):
        for label, arrangements in ARRANGED.items():
            scene, sets, steps = SCENES[label]
            one = self.run_scene(1, scene, sets, steps)
            for arrangement in arrangements:
                with self.subTest(scene=label, ranks=arrangement):
                    given = dict(sets, decomposition={"ranks": arrangement})
                    self.assert_same(
                        one, self.run_scene(4, scene, given, steps))

    def test_boxes_that_follow_the_gas(self):
        for label, (scene, sets, steps) in FOLLOWED.items():
            one = self.run_scene(1, scene, sets, steps)
            self.assertGreater(len(one[0]["particles id"]), 100)
            for ranks in (2, 4):
                with self.subTest(scene=label, ranks=ranks):
                    arrangement = {"balance": OFTEN}
                    if ranks == 4 and scene != "gravity_column":
                        arrangement["ranks"] = [2, 2]
                    many = self.run_scene(
                        ranks, scene, {**sets, "decomposition": arrangement},
                        steps)
                    self.assert_same(one, many)
                    seen = many[1]["imbalance"]
                    self.assertGreaterEqual(seen["cuts_moved"], 1)
                    self.assertGreater(seen["start"], 1.3)
                    self.assertLess(seen["end"] - 1, (seen["start"] - 1) / 2)
                    self.assertGreaterEqual(seen["largest"], seen["start"])

    def test_cells_of_unequal_sides(self):
        # Images reach more cells along y, whose boxes have to be wider.
        sets = {"grid.cells": [20, 26], "grid.upper": [40, 26],
                "boundary.4.shape": {"type": "box", "lower": [18, 3],
                                     "upper": [40, 23]}}
        self.assert_same(
            self.run_scene(1, "cylinder_mach3", sets, 10),
            self.run_scene(4, "cylinder_mach3", {
                **sets, "decomposition": {
                    "ranks": [2, 2], "balance": OFTEN}}, 10))

    def test_memory_where_the_root_has_no_gas(self):
        _, summary = self.run_scene(4, "filling", {
            "grid.cells": [32, 32], "initial.0.region": {
                "type": "box", "lower": [0.8, 0.8], "upper": [2, 2]},
            "decomposition": {"ranks": [2, 2], "balance": {"every": 0}}}, 1)
        self.assertGreater(summary["bytes_per_particle"], 100)

    def test_boxes_that_stay(self):
        scene, sets, steps = FOLLOWED["filling"]
        for balance in {"every": 0}, {"threshold": 4}:
            _, summary = self.run_scene(
                4, scene, {**sets, "decomposition": {"balance": balance}},
                steps)
            self.assertEqual(summary["imbalance"]["cuts_moved"], 0)
            self.assertGreater(summary["imbalance"]["end"], 1.3)
        _, summary = self.run_scene(1, scene, {"grid.cells": [32, 32]}, 1)
        self.assertEqual(summary["imbalance"], {
            "start": 1, "largest": 1, "end": 1, "cuts_moved": 0})

    def assert_identical(self, one, many):
        for name, values in one[0].items():
            np.testing.assert_array_equal(values, many[0][name], name)
        for key in ("conservation", "extrema", "errors", "final_time",
                    "retries", "particles_final", "series"):
            self.assertEqual(one[1][key], many[1][key], key)

    def test_reproducible(self):
        for label, (scene, sets, steps, several) in REPRODUCIBLE.items():
            sets = {**sets, "reproducible": True}
            one = self.run_scene(1, scene, sets, steps)
            for ranks in several:
                given = dict(sets)
                if isinstance(ranks, list):
                    given["decomposition"] = {"ranks": ranks}
                with self.subTest(scene=label, ranks=ranks):
                    many = self.run_scene(int(np.prod(ranks)), scene, given,
                                          steps)
                    self.assert_identical(one, many)

    def test_reproducible_with_threads_and_after_a_restart(self):
        sets = {"grid.cells": [60, 40], "reproducible": True}
        scene = "cylinder_mach3", {**sets, "checkpoint": {"every_steps": 8}}
        whole = self.run_scene(1, *scene, 16)
        self.run_scene(2, *scene, 8)
        rest = self.run_scene(3, *scene, 16, "--restart", "latest", threads=2)
        for name, values in whole[0].items():
            np.testing.assert_array_equal(values, rest[0][name], name)

    def test_reproducible_sums_do_not_overflow(self):
        sets = {"grid.cells": [4, 4], "particles.per_cell": 64 ** 2}
        result = self.execute(1, "sedov_2d", {**sets, "reproducible": True}, 1)
        self.assertEqual(result.returncode, NUMERICAL_FAILURE, result.stderr)
        self.assertIn("share a cell", result.stderr)
        self.assertEqual(self.execute(1, "sedov_2d", sets, 1).returncode, 0)

    def test_restart_on_any_number_of_ranks(self):
        keep = {"checkpoint": {"every_steps": 15}}
        for scene in [
                ("cylinder_mach3", {"grid.cells": [60, 30], **keep}),
                ("filling", {"grid.cells": [32, 32], **keep,
                             "decomposition": {"balance": OFTEN}})]:
            with self.subTest(scene[0]):
                self.restart_on_any_number_of_ranks(scene)

    def restart_on_any_number_of_ranks(self, scene):
        whole = self.run_scene(4, *scene, 30)
        for ranks in (4, 3, 1):
            with self.subTest(ranks=ranks):
                self.run_scene(4, *scene, 15)
                rest = self.run_scene(ranks, *scene, 30, "--restart", "latest")
                self.assert_same(whole, rest)
                # The same to the last bit.
                if ranks == 4 and whole[1]["backend"] in ("Serial", "OpenMP"):
                    for name, values in whole[0].items():
                        np.testing.assert_array_equal(values, rest[0][name],
                                                      name)
                    self.assertEqual(whole[1]["imbalance"],
                                     rest[1]["imbalance"])

    def test_ranks_that_do_not_fit(self):
        for ranks, scene, sets, words in [
                (3, "sod", {"grid.cells": [6]}, "cut into boxes of 2 cells"),
                (4, "sod", {"grid.cells": [3]}, "3 cells for 4 ranks"),
                (2, "sod", {"decomposition": {"ranks": [3]}},
                 "3 boxes on 2 ranks"),
                (4, "cylinder_mach3",
                 {"grid.cells": [100, 20], "decomposition": {"ranks": [1, 4]}},
                 "cut into boxes of 5 cells")]:
            with self.subTest(words):
                result = self.execute(ranks, scene, sets, 1)
                self.assertEqual(result.returncode, WRONG_INPUT)
                self.assertIn(words, result.stderr)
                self.assertEqual(result.stderr.count(words), 1)
                self.assertFalse((self.scratch / "out").exists())


if __name__ == "__main__":
    unittest.main()
