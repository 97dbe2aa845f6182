"""What a run says it costs: --estimate before it, --estimate-error after it.

The executable comes from MACHPOINT_EXECUTABLE. Seconds are never under test.
"""

import json
import os
import pathlib
import re
import subprocess
import tempfile
import unittest

from running import FINISHED, NUMERICAL_FAILURE, ONE_THREAD, WRONG_INPUT

EXECUTABLE = os.path.abspath(os.environ["MACHPOINT_EXECUTABLE"])
INPUTS = pathlib.Path(__file__).resolve().parent.parent / "input"
SINGLE = os.environ.get("MACHPOINT_PRECISION") == "single"
FIELDS = ["density", "velocity", "pressure", "specific_internal_energy"]
NO_FIELDS = ["output.particles=false", "output.grid=false"]


class PriceTest(unittest.TestCase):

    def setUp(self):
        scratch = tempfile.TemporaryDirectory()
        self.addCleanup(scratch.cleanup)
        self.directory = pathlib.Path(scratch.name)
        self.output = self.directory / "out"

    def machpoint(self, scene, sets, *options, ranks=1, code=FINISHED):
        """A run, in an empty directory."""
        words = [EXECUTABLE, "run", str(INPUTS / f"{scene}.json"),
                 *map(str, options)]
        for text in [*NO_FIELDS, *sets]:
            words += ["--set", text]
        if ranks > 1:
            launcher = os.environ.get("MACHPOINT_MPIEXEC")
            if not launcher:
                self.skipTest("this build has no MPI")
            words = [launcher, "-n", str(ranks), *words]
        result = subprocess.run(words, capture_output=True, text=True,
                                stdin=subprocess.DEVNULL, timeout=100,
                                cwd=self.directory, env=ONE_THREAD)
        if "this build has no" in result.stderr:
            self.skipTest(result.stderr.strip())
        self.assertEqual(result.returncode, code,
                         result.stdout + result.stderr)
        return result

    def run_scene(self, scene, *sets, options=(), ranks=1, code=FINISHED):
        """The end table and the summary of a run."""
        shown = self.machpoint(scene, sets, "--output", self.output,
                               "--overwrite", *options, ranks=ranks,
                               code=code).stdout
        return shown, json.loads((self.output / "summary.json").read_text())

    def judge(self, scene, *sets, **keywords):
        return self.run_scene(scene, *sets, options=["--estimate-error"],
                              **keywords)


class Price(PriceTest):

    def test_against_the_exact_solution(self):
        shown, summary = self.run_scene("sod", "grid.cells=[40]")
        price = summary["price"]
        self.assertIsNone(summary["error_estimate"])
        self.assertEqual(price["error"], summary["errors"]["density"]["L1"])
        # Half of the tube at density 1, the other half at 1/8.
        self.assertAlmostEqual(price["relative_error"],
                               price["error"] / 0.5625,
                               places=6 if SINGLE else 12)
        self.assertEqual(price["error_source"], "exact")
        self.assertEqual((price["order"], price["order_source"]),
                         (1, "assumed"))
        output = summary["communication"]["seconds"]["output"]["largest"]
        self.assertAlmostEqual(
            price["half_error_seconds"],
            output + 4 * (summary["wall_seconds"] - output))
        self.assertRegex(shown, r"  price: .* s for a density error of .* % "
                         r"\(L1, against exact\); half of it takes some .* s "
                         r"\(assumed order 1\)\n")

    def test_outputs_before_a_restart_count(self):
        # A run that little but writes costs little more on a finer grid.
        sets = ["grid.cells=[20]", "output.every=0.005", "output.particles=true",
                'checkpoint={"every_steps":10000}']
        _, summary = self.run_scene("sod", *sets, options=["--max-steps", 36])
        self.assertLess(summary["final_time"], summary["input"]["time"]["end"])
        result = self.machpoint("sod", sets, "--output", self.output,
                                "--restart", "latest")
        summary = json.loads((self.output / "summary.json").read_text())
        self.assertIn("goes on from", result.stderr)
        self.assertLess(summary["price"]["half_error_seconds"],
                        2 * summary["wall_seconds"])

    def test_what_is_not_known_is_not_told(self):
        shown, summary = self.run_scene("two_blasts", "grid.cells=[20]")
        price = summary["price"]
        self.assertEqual(price.pop("seconds"), summary["wall_seconds"])
        self.assertEqual(set(price.values()), {None})
        self.assertRegex(shown, r"  price: .* s; its error is not known: "
                         r"--estimate-error estimates it\n")

    def test_round_off_is_not_halved(self):
        shown, summary = self.judge("gas_at_rest_2d", "grid.cells=[16,16]",
                                    "time.end=0.2")
        self.assertIsNone(summary["price"]["half_error_seconds"])
        self.assertNotIn("half of it", shown)
        fields = summary["error_estimate"]["fields"]
        for field in FIELDS:
            self.assertLess(fields[field]["L1"], 1e-5 if SINGLE else 1e-13)
            self.assertIsNone(fields[field]["order"])
        self.assertIsNone(fields["velocity"]["relative"])


class EstimatedError(PriceTest):

    def test_it_is_that_of_sods_tube(self):
        shown, summary = self.judge("sod")
        estimate = summary["error_estimate"]
        self.assertEqual([run["cells"] for run in estimate["companions"]],
                         [[50], [25]])
        for field in FIELDS:
            with self.subTest(field=field):
                ratio = (estimate["fields"][field]["L1"] /
                         summary["errors"][field]["L1"])
                self.assertGreater(ratio, 0.5)
                self.assertLess(ratio, 2)
        density = estimate["fields"]["density"]
        # Shock and contact: first order, less a contact's loss.
        self.assertGreater(density["observed_order"], 0.6)
        self.assertLess(density["observed_order"], 1.2)
        price = summary["price"]
        self.assertEqual(price["error_source"], "exact")
        self.assertEqual((price["order"], price["order_source"]),
                         (density["observed_order"], "observed"))
        self.assertIn("(from 50 and 25 cells, in ", shown)
        # Nothing is left of the companions.
        self.assertEqual(sorted(path.name for path in
                                self.directory.rglob("*")),
                         ["out", "summary.json"])

    def test_without_an_exact_solution(self):
        _, summary = self.judge("two_blasts", "grid.cells=[80]",
                                "time.end=0.02")
        density = summary["error_estimate"]["fields"]["density"]
        self.assertEqual(summary["price"]["error"], density["L1"])
        self.assertEqual(summary["price"]["relative_error"],
                         density["relative"])
        self.assertEqual(summary["price"]["error_source"], "estimated")

    def test_two_grids_show_no_order(self):
        # The quarter has too few cells, for the estimate or for the ranks.
        for cells, ranks, reason in [
                (24, 1, "a grid of a quarter has too few cells"),
                (40, 4, "--estimate-error runs the scene with 10 cells")]:
            with self.subTest(cells=cells):
                shown, summary = self.judge("sod", f"grid.cells=[{cells}]",
                                            ranks=ranks)
                estimate = summary["error_estimate"]
                self.assertEqual(
                    [run["cells"] for run in estimate["companions"]],
                    [[cells // 2]])
                density = estimate["fields"]["density"]
                self.assertEqual(density["order"], 1)
                self.assertIsNone(density["observed_order"])
                self.assertIn(reason, estimate["order_message"])
                self.assertIn(f"no observed order: {estimate['order_message']}\n",
                              shown)
                self.assertEqual(summary["price"]["order_source"], "assumed")

    def test_of_a_run_that_ends_early(self):
        _, whole = self.judge("sod", "grid.cells=[64]")
        _, early = self.run_scene(
            "sod", "grid.cells=[64]",
            options=["--estimate-error", "--max-steps", 40])
        # Companions end where it did: the error is that of this time.
        for runs in zip(*(s["error_estimate"]["companions"]
                          for s in (early, whole))):
            self.assertLess(runs[0]["steps"], runs[1]["steps"])
        for field in ["density", "pressure"]:
            ratio = (early["error_estimate"]["fields"][field]["L1"] /
                     early["errors"][field]["L1"])
            self.assertGreater(ratio, 0.4)
            self.assertLess(ratio, 2.5)

    def test_of_a_run_that_fails(self):
        shown, summary = self.judge("sod", "grid.cells=[20]", "time.cfl=50",
                                    "time.retries=1", "output.every=1", code=NUMERICAL_FAILURE)
        self.assertIsNone(summary["error_estimate"])
        self.assertNotIn("half of it", shown)

    def test_too_few_cells(self):
        for cells, ranks, text in [
                (6, 1, "take 7 or more along an axis"),
                (20, 4, "--estimate-error runs the scene with 10 cells")]:
            with self.subTest(cells=cells):
                result = self.machpoint(
                    "sod", [f"grid.cells=[{cells}]"], "--output", self.output,
                    "--estimate-error", ranks=ranks, code=WRONG_INPUT)
                self.assertIn(text, result.stderr)
                self.assertFalse(self.output.exists())

    def test_on_several_ranks(self):
        sets = ["grid.cells=[40,40]", "time.end=0.2"]
        told = [self.judge("kelvin_helmholtz", *sets, ranks=ranks)[1]
                ["error_estimate"]["fields"] for ranks in (1, 4)]
        for field in FIELDS:
            self.assertAlmostEqual(told[1][field]["L1"] /
                                   told[0][field]["L1"], 1,
                                   places=4 if SINGLE else 9)


class DryRun(PriceTest):

    def estimate(self, scene, *sets, ranks=1):
        """What is told, and that nothing is left."""
        shown = self.machpoint(scene, sets, "--estimate", ranks=ranks).stdout
        self.assertEqual(list(self.directory.iterdir()), [])
        seconds = re.search(
            r"^  time +(\S+) s \((\S+) s to (\S+) s\), without outputs$", shown,
            re.M)
        likely, least, most = map(float, seconds.groups())
        self.assertLess(0, least)
        self.assertLess(least, likely)
        self.assertLess(likely, most)
        return {key: float(re.search(pattern, shown, re.M)[1])
                for key, pattern in [
                    ("steps", r"^  steps +(\d+)$"),
                    ("particles_initial", r"^  particles +(\d+) at the start"),
                    ("particles_final", r"(\d+) at the end$"),
                    ("mebibytes", r"^  memory +(\S+) MiB")]}

    def compare(self, scene, *sets, ranks=1):
        told = self.estimate(scene, *sets, ranks=ranks)
        _, real = self.run_scene(scene, *sets, ranks=ranks)
        self.assertEqual(told["particles_initial"], real["particles_initial"])
        # Which particles merge depends on the grid more than waves do.
        for key, delta in [("steps", 0.05), ("particles_final", 0.1)]:
            self.assertAlmostEqual(told[key] / real[key], 1, delta=delta,
                                   msg=key)
        self.assertAlmostEqual(
            told["mebibytes"] * 2**20 / real["peak_memory_bytes"], 1,
            delta=0.25)

    def test_on_a_line(self):
        self.compare("sod", "grid.cells=[200]")

    def test_of_a_run_that_is_over_at_once(self):
        # Nothing to foretell: its first steps are all of them.
        told = self.estimate("sod", "grid.cells=[20]")
        shown, real = self.run_scene("sod", "grid.cells=[20]")
        self.assertEqual(told["steps"], real["steps"])
        self.assertEqual(told["particles_final"], real["particles_final"])
        shown = self.machpoint("sod", ["grid.cells=[20]"], "--estimate").stdout
        self.assertIn(f"and all {real['steps']} steps with 20\n", shown)

    def test_in_a_plane_that_empties(self):
        # 0.9 of the particles on average, 0.65 of them at the end.
        self.compare("noh_2d", "grid.cells=[48,48]")

    def test_on_several_ranks(self):
        # One coarser grid, on however busy a machine, and waves as fast on it.
        self.compare("kelvin_helmholtz", "grid.cells=[40,40]", "time.end=0.6",
                     "output.every=1", ranks=2)

    def test_where_most_of_the_gas_is_to_come(self):
        told = self.estimate("filling", "grid.cells=[48,48]", "time.end=0.5")
        self.assertGreater(told["particles_final"],
                           1.5 * told["particles_initial"])

    def test_what_cannot_be_asked(self):
        for options in (["--estimate", "--estimate-error"],
                        ["--estimate", "--restart", "latest"]):
            result = self.machpoint("sod", [], *options, code=WRONG_INPUT)
            self.assertIn("--estimate", result.stderr)
        result = self.machpoint("sod", ["grid.cells=[20]"], "--estimate",
                                ranks=4, code=WRONG_INPUT)
        self.assertIn("--estimate runs the scene with 10 cells", result.stderr)


if __name__ == "__main__":
    unittest.main()
