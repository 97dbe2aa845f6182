"""benchmarks/scaling: its model of the cost, and that it measures and reports.

The executable comes from MACHPOINT_EXECUTABLE, the launcher from
MACHPOINT_MPIEXEC.
"""

import os
import pathlib
import sys
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parent.parent / "benchmarks"
sys.path += [str(ROOT / name) for name in ("performance", "scaling")]

import case
import model
import report


class ModelTest(unittest.TestCase):

    def test_boxes_have_the_least_surface(self):
        self.assertEqual(model.boxes((400, 200), 2), (2, 1))
        self.assertEqual(model.boxes((64, 64), 2), (1, 2))
        self.assertEqual(model.boxes((24, 24, 24), 2), (1, 1, 2))

    def test_the_surface_of_cuts(self):
        self.assertEqual(model.cut_surface((64, 64), (1, 2), True), (128, 2))
        self.assertEqual(model.cut_surface((64, 64), (1, 2), False), (64, 1))
        self.assertEqual(model.cut_surface((8, 6, 9), (1, 2, 3), False),
                         (8 * 3 + 2 * 8 * 3, 3))

    def test_a_machine_without_latency_and_of_any_bandwidth_is_perfect(self):
        fitted = {"dimension": 2, "seconds_per_particle": 1e-6,
                  "halo_bytes": 600, "migrated_bytes": 100, "messages": 7,
                  "collectives": 6}

        def efficiency(side, latency, bandwidth):
            return model.efficiency(model.predict(
                fitted, 4, side, 64, latency, bandwidth))
        self.assertAlmostEqual(efficiency(32, 0, 1e30), 1)
        # The latency of a step: 28 messages, 4 of migration, 6 calls of 6
        # stages; half the step if the 4096 particles take as long.
        self.assertAlmostEqual(efficiency(32, 4096e-6 / 68, 1e30), 0.5)
        # Surface over volume: twice as large boxes need half the bandwidth.
        self.assertAlmostEqual(efficiency(32, 0, 2e9), efficiency(64, 0, 1e9))


class BenchTest(unittest.TestCase):

    def test_runs_are_measured_and_reported(self):
        scratch = tempfile.TemporaryDirectory()
        self.addCleanup(scratch.cleanup)
        bench = case.Bench(os.environ["MACHPOINT_EXECUTABLE"],
                           [os.environ["MACHPOINT_MPIEXEC"]], scratch.name)
        scene = "isentropic_vortex"
        cases = [case.Case(scene, cells, ranks, 3, copies)
                 for cells, ranks, copies in [
                     ((24, 24), 1, 1), ((24, 24), 2, 1), ((24, 24), 1, 2),
                     ((48, 24), 2, 1), ((24, 48), 2, 1)]]
        runs = {c: [bench.run(c)] for c in cases}
        results = {c: case.summarise(found) for c, found in runs.items()}
        one, two, apart, tall, wide = results.values()
        self.assertEqual(one["halo_bytes"], 0)
        self.assertEqual(apart["collectives"], 0)
        self.assertEqual(two["halo_messages"], 2)
        # Cuts run across the longer axis: equally long ones cost the same.
        self.assertEqual(tall["halo_messages"], wide["halo_messages"])
        self.assertEqual(tall["halo_bytes"], wide["halo_bytes"])
        self.assertEqual(tall["halo_bytes"], two["halo_bytes"])
        self.assertAlmostEqual(sum(two["seconds"].values()), two["step"])
        fitted = model.fit(results.items(), 2)
        self.assertLess(fitted["halo_worst"], 1e-12)
        self.assertEqual(fitted["messages"], 1)

        twice = case.Case(scene, (24, 48), 2, 3, domains=(1, 2))
        runs[twice] = [bench.run(twice)] * 2
        kept, = case.shares_kept([cases[0], cases[2], twice], runs)
        self.assertEqual(kept["particles"], 4 * 24 * 24)
        self.assertEqual(kept["2 ranks"],
                         (one["step"] / runs[twice][0]["step"],) * 3)
        self.assertEqual(kept["2 runs"],
                         (one["step"] / apart["step"],) * 3)
        topics = {"strong": cases[:2], "weak": cases[:1], "apart": [cases[2]],
                  "stencil": [cases[1]]}
        bench.lacking["a case"] = "no such basis"
        text = report.write(topics, results, [kept], bench, {1: 5e9, 2: 8e9},
                            {2: fitted}, 1)
        for part in ["1.60", "8.00 GB/s", "| 24 x 24 | 2,304 |",
                     "prediction", "no such basis",
                     bench.commands[cases[1].name]]:
            self.assertIn(part, text)

    def test_where_one_copy_fails_the_others_end(self):
        """A launcher whose second copy tells its id and sleeps; the first one fails
        then."""
        with tempfile.TemporaryDirectory() as scratch:
            told = pathlib.Path(scratch) / "id"
            launcher = pathlib.Path(scratch) / "launcher"
            launcher.write_text("\n".join([
                "#!/bin/sh", f"for word; do case $word in *-0) until [ -s {told} ]",
                "do sleep .01; done; exit 3;; esac; done",
                f"echo $$ > {told}", "exec sleep 60"]))
            launcher.chmod(0o700)
            bench = case.Bench(os.environ["MACHPOINT_EXECUTABLE"], [str(launcher)],
                               scratch)
            with self.assertRaisesRegex(SystemExit, "exit code 3"):
                bench.run(case.Case("isentropic_vortex", (24, 24), 1, 3, copies=2))
            with self.assertRaises(ProcessLookupError):
                os.kill(int(told.read_text()), 0)


if __name__ == "__main__":
    unittest.main()
