"""The hard cases of benchmarks/hard_cases in seconds instead of hours.

Every case runs at its small size with the method `conservative`: it has to
finish, to keep all invariants (run.broken_invariants) and the bounds that hold
at that size, which are those of the full size where that is small. With them
100 random Riemann problems. The executable comes from MACHPOINT_EXECUTABLE. A
case that cannot run is a failure.
"""

import concurrent.futures
import fcntl
import os
import pathlib
import subprocess
import sys
import tempfile
import types
import unittest

import numpy

ROOT = pathlib.Path(__file__).resolve().parent.parent / "benchmarks"
sys.path += [str(ROOT / name) for name in ("performance", "hard_cases")]

import draws
import gas
import planes
import report
import stable_cfl
import suite

METHOD = "conservative"
DRAWS = 100
# Two runs at a time with one thread each are faster than one with two.
os.environ["OMP_NUM_THREADS"] = "1"


class HardCases(unittest.TestCase):
    """Runs everything first, two at a time; one test for each case is made
    below."""

    @classmethod
    def setUpClass(cls):
        scratch = tempfile.TemporaryDirectory()
        cls.addClassCleanup(scratch.cleanup)
        work = suite.Suite(os.environ["MACHPOINT_EXECUTABLE"], scratch.name,
                           fast=True)
        with concurrent.futures.ThreadPoolExecutor(2) as pool:
            cls.results = {
                case.name: pool.submit(work.measure, case, METHOD)
                for case in suite.CASES}
        cls.draws = draws.solve_all(work, METHOD, range(DRAWS))

    def check_case(self, case):
        result = self.results[case.name].result()
        self.assertEqual(result["broken"], [], result["commands"])
        self.assertEqual(suite.misses(case, result), [], result["commands"])
        self.assertEqual(len(result["codes"]), len(case.variants(True)))

    def test_random_riemann_problems(self):
        self.assertEqual(len(self.draws), DRAWS)
        self.assertTrue(any(r["vacuum"] for r in self.draws))
        for result in self.draws:
            self.assertEqual(result["broken"], [], result["command"])


for _case in suite.CASES:
    def _test(self, case=_case):
        self.check_case(case)
    setattr(HardCases, f"test_{_case.name}", _test)


class Suite(unittest.TestCase):
    """What the verdicts rest on, and their pictures."""

    def test_a_body_is_no_gas_of_a_scale(self):
        low, high = report.limits(numpy.array([[0, 1.4], [1.4 + 1e-15, 1.4]]))
        self.assertAlmostEqual((low + high) / 2, 1.4)
        self.assertEqual(report.limits(numpy.arange(3)), (None, None))

    def test_a_bound_can_be_missed(self):
        case = next(c for c in suite.CASES if c.name == "toro2")
        label, bound = next(iter(case.bounds.items()))
        for value, missed in [(bound.high, 0), (1.01 * bound.high, 1),
                              (None, 1), (float("nan"), 1)]:
            result = {"values": {label: value}, "fast": False}
            self.assertEqual(len(suite.misses(case, result)), missed)

    def test_settings_reach_every_run(self):
        case = next(c for c in suite.CASES if c.name == "toro2")
        found = {}
        with tempfile.TemporaryDirectory() as scratch:
            for sets in {}, {"time.cfl": 0.1}:
                work = suite.Suite(os.environ["MACHPOINT_EXECUTABLE"], scratch,
                                   fast=True, sets=sets)
                found[len(sets)] = work.measure(case, METHOD)
        for command in found[1]["commands"]:
            self.assertIn("--set time.cfl=0.1", command)
        self.assertEqual(found[1]["broken"], [])
        self.assertGreater(found[1]["particle_steps"],
                           2 * found[0]["particle_steps"])

    def test_two_do_not_share_an_output(self):
        with tempfile.TemporaryDirectory() as scratch:
            command = [sys.executable, str(ROOT / "hard_cases"), "--kept",
                       "--case", "toro2", "--machpoint",
                       os.environ["MACHPOINT_EXECUTABLE"], "--output", scratch]
            with open(pathlib.Path(scratch) / "lock", "w") as lock:
                fcntl.flock(lock, fcntl.LOCK_EX)
                second = subprocess.run(command, capture_output=True, text=True)
            self.assertIn(f"{scratch}: another process", second.stderr)
            self.assertEqual(second.returncode, 1)
            self.assertFalse((pathlib.Path(scratch) / "results.json").exists())
            alone = subprocess.run(command, capture_output=True, text=True)
            self.assertEqual(alone.stderr, "")
            self.assertTrue((pathlib.Path(scratch) / "results.json").exists())

    def test_a_bound_of_nothing_is_missed(self):
        case = next(c for c in suite.CASES if c.name == "toro2")
        self.assertEqual(len(suite.misses(case, {"values": {}, "fast": False})),
                         len(case.bounds))

    def test_scenes_are_there(self):
        for case in suite.CASES:
            self.assertTrue((pathlib.Path(suite.ROOT) / "input" /
                             f"{case.scene}.json").exists(), case.name)
        for name, (scene, _) in stable_cfl.SCENES.items():
            self.assertIn("exact", suite.Suite.scene(scene), name)

    def test_draws_are_repeatable_and_wide(self):
        problems = [draws.draw(n) for n in range(1000)]
        self.assertEqual(problems[7], draws.draw(7))
        densities = [side[0] for _, *sides in problems for side in sides]
        self.assertGreater(max(densities) / min(densities), 10**5.8)
        vacuum = sum(draws.is_vacuum_forming(*p) for p in problems)
        self.assertTrue(100 < vacuum < 900, vacuum)

    def test_a_blast_is_held_against_its_diagonals(self):
        """A shock at .75 + .01 cos 4 phi reaches as far along x as along y."""
        r, phi = numpy.meshgrid(numpy.arange(0.0005, 1, 0.001),
                                numpy.linspace(0, 2 * numpy.pi, 800, False))
        r, phi = r.ravel(), phi.ravel()
        inside = r < 0.75 + 0.01 * numpy.cos(4 * phi)
        data = {"position": numpy.transpose([r * numpy.cos(phi),
                                             r * numpy.sin(phi)]),
                "density": numpy.where(inside & (r > 0.6), 6.0, 1.0),
                "mass": numpy.ones(r.size)}
        run = types.SimpleNamespace(
            input={"initial": [{"type": "blast", "center": [0, 0]}],
                   "particles": {"per_cell": 4}},
            summary={"cells": [100, 100]}, read=lambda *_: dict(data))
        found = planes.sedov([run])["anisotropy, 100², 4 per cell"]
        self.assertAlmostEqual(found, 0.02, delta=2e-3)

    def test_a_bow_shock_is_found_wherever_the_grid_begins(self):
        """One .1 before the front of a ball of radius .2, in a stream of pressure 2."""
        x, y = numpy.meshgrid(numpy.arange(0.005, 0.4, 0.01),
                              numpy.arange(0.305, 0.7, 0.01))
        places = numpy.transpose([x.ravel(), y.ravel()])
        density = numpy.where(places[:, 0] < 0.3, 1.0, 4.0)
        for lower in 0, -3:
            run = types.SimpleNamespace(spacing=0.02, input={
                "grid": {"lower": [lower, 0]}, "initial": [{"pressure": 2}]})
            found = planes.ahead_of_body(
                run, {"position": places + [lower, 0], "density": density,
                      "mass": density, "pressure": 3 * density},
                {"center": [lower + 0.6, 0.5], "radius": 0.2}, 2.5)
            numpy.testing.assert_allclose(found, (0.5, 6), rtol=1e-12)

    def test_theory(self):
        """Tabulated values: NACA report 1135; Toro 2009, table 4.1."""
        self.assertAlmostEqual(gas.pitot_ratio(3, 1.4), 12.06, delta=5e-3)
        self.assertAlmostEqual(gas.expansion(2, 0.174533, 1.4)[0], 2.385,
                               delta=1e-3)
        density, pressure = gas.shock_ratio(2, 1.4)
        self.assertAlmostEqual(density, 2.6667, delta=1e-4)
        self.assertAlmostEqual(pressure, 4.5, delta=1e-12)
        slow, fast = gas.riemann_speeds((1, 0, 1), (0.125, 0, 0.1), 1.4)
        self.assertAlmostEqual(slow, -1.18322, delta=1e-5)
        self.assertAlmostEqual(fast, 1.75216, delta=1e-5)


if __name__ == "__main__":
    unittest.main()
