#!/usr/bin/env python3
"""The same scenes in double and in single precision, and what a build in
single precision refuses.

Usage: unittest/compare_precisions.py DOUBLE SINGLE

Errors against exact solutions must be those of the scheme in both. SINGLE needs
no more than 2D and quadratic B-splines.
"""
import json
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest

import h5py
import numpy

ROOT = pathlib.Path(__file__).resolve().parents[1]
BAD_INPUT = 2
SMALL_VORTEX = ["grid.cells=[32,32]", "time.end=1"]


class Precisions(unittest.TestCase):

    def setUp(self):
        scratch = tempfile.TemporaryDirectory()
        self.addCleanup(scratch.cleanup)
        self.folder = pathlib.Path(scratch.name)

    def machpoint(self, build, scene, *sets, options=(), code=0, ranks=1):
        """A run on one thread a rank; its folder and what it said."""
        output = self.folder / pathlib.Path(build).parent.name
        words = [build, "run", ROOT / f"input/{scene}.json", "--quiet",
                 "--output", output, *options]
        if "--restart" not in options:
            words.append("--overwrite")
        if ranks > 1:
            words = ["mpirun", "--oversubscribe", "-n", str(ranks), *words]
        for text in sets:
            words += ["--set", text]
        result = subprocess.run(words, capture_output=True, text=True,
                                env=dict(os.environ, OMP_NUM_THREADS="1",
                                         OMPI_ALLOW_RUN_AS_ROOT="1",
                                         OMPI_ALLOW_RUN_AS_ROOT_CONFIRM="1"))
        self.assertEqual(result.returncode, code, result.stderr)
        return output, result.stderr

    def summaries(self, *arguments):
        return [json.loads((self.machpoint(build, *arguments)[0] /
                            "summary.json").read_text())
                for build in (DOUBLE, SINGLE)]

    def test_errors_are_those_of_the_scheme(self):
        for method in "apic", "conservative":
            with self.subTest(method=method):
                sets = [*SMALL_VORTEX, f"method.name={method}",
                        "method.basis=quadratic"]
                double, single = self.summaries("isentropic_vortex", *sets)
                self.assertEqual(double["precision"], "double")
                self.assertEqual(single["precision"], "single")
                self.assertEqual(double["steps"], single["steps"])
                for field, error in double["errors"].items():
                    self.assertLess(
                        abs(single["errors"][field]["L1"] / error["L1"] - 1),
                        1e-2, field)
                for balance in "mass", "momentum", "total_energy":
                    self.assertLess(abs(single["conservation"][balance]),
                                    2e-6, balance)

    def test_a_bow_shock_stands_where_it_stands(self):
        double, single = self.summaries(
            "cylinder_mach3", "grid.cells=[80,40]", "time.end=1")
        self.assertEqual(single["retries"], 0)
        # The time step is that of the fastest particle, a light piece of one halved
        # in the wake; round-off moves when that happens (without halving the steps
        # are equal: method.split_volume 0).
        for key, bound in ("particles_final", 1e-2), ("steps", 3e-2):
            self.assertLess(abs(single[key] / double[key] - 1), bound, key)
        drag = [numpy.loadtxt(self.folder / pathlib.Path(build).parent.name /
                              "series/cylinder.csv", delimiter=",",
                              skiprows=1)[-50:, 1].mean()
                for build in (DOUBLE, SINGLE)]
        self.assertLess(abs(drag[1] / drag[0] - 1), 1e-2)

    @unittest.skipUnless(shutil.which("mpirun"), "there is no mpirun")
    def test_ranks_exchange_floats(self):
        found = []
        for ranks in 1, 2:
            output, _ = self.machpoint(SINGLE, "isentropic_vortex",
                                       *SMALL_VORTEX, ranks=ranks)
            found.append(json.loads((output / "summary.json").read_text()))
        self.assertEqual(found[1]["ranks"], 2)
        self.assertGreater(found[1]["communication"]["migrated_particles"]
                           ["sum"], 0)
        self.assertEqual(found[0]["steps"], found[1]["steps"])
        self.assertLess(abs(found[1]["conservation"]["mass"]), 1e-12)
        for field, error in found[0]["errors"].items():
            self.assertLess(
                abs(found[1]["errors"][field]["L1"] / error["L1"] - 1), 1e-3,
                field)

    def test_files_have_floats(self):
        output, _ = self.machpoint(SINGLE, "isentropic_vortex", *SMALL_VORTEX,
                                   options=["--max-steps", "2"])
        for kind in "particles", "grid":
            with h5py.File(max((output / kind).glob("*.h5"))) as file:
                self.assertEqual(file["density"].dtype, numpy.float32)
                self.assertEqual(file.attrs["time"].dtype, numpy.float64)
            self.assertIn('Precision="4"',
                          (output / f"{kind}.xdmf").read_text())

    def test_a_checkpoint_belongs_to_its_precision(self):
        stop = ["--max-steps", "4"]
        checkpoint = 'checkpoint={"every_steps":2}'
        output, _ = self.machpoint(SINGLE, "isentropic_vortex", *SMALL_VORTEX,
                                   checkpoint, options=stop)
        self.machpoint(SINGLE, "isentropic_vortex", *SMALL_VORTEX, checkpoint,
                       options=["--restart", "latest", "--max-steps", "6"])
        _, said = self.machpoint(
            DOUBLE, "isentropic_vortex", *SMALL_VORTEX, checkpoint,
            options=["--restart", max((output / "checkpoints").glob("*.h5"))],
            code=BAD_INPUT)
        self.assertIn("has particles in single precision, and this program "
                      "computes in double; restart with a build whose "
                      "Machpoint_PRECISION is single", said)

    def test_what_floats_cannot_do_is_refused(self):
        for setting, text in [
                ("grid.cells=[80000,4]",
                 "/grid/cells/0: 80000 cells are too many for positions in "
                 "single precision"),
                ("reproducible=true", "/reproducible: such sums are of "
                                      "doubles")]:
            _, said = self.machpoint(SINGLE, "isentropic_vortex", setting,
                                     code=BAD_INPUT)
            self.assertIn(text, said)
            self.assertIn("Machpoint_PRECISION=double", said)

    def test_the_benchmark_compares_them(self):
        def benchmark(double, single):
            return subprocess.run(
                [sys.executable, ROOT / "benchmarks/precision", "--fast",
                 "--double", pathlib.Path(double).parent,
                 "--single", pathlib.Path(single).parent],
                capture_output=True, text=True)

        result = benchmark(DOUBLE, SINGLE)
        self.assertEqual(result.returncode, 0, result.stderr)
        rows = {cells[1]: cells[2:-1] for cells in
                ([cell.strip() for cell in line.split("|")]
                 for line in result.stdout.splitlines() if line[:2] == "| ")}
        double, single, ratio, *held = map(float,
                                           rows["Mach 3 cylinder, 400x200"])
        self.assertAlmostEqual(ratio, double / single, delta=0.02 * ratio)
        self.assertLess(held[1], 0.6 * held[0])
        exact, rounded = map(float, rows["`translation`, 40x40"][:2])
        self.assertLess(exact, 1e-13)
        self.assertTrue(1e-13 < rounded < 1e-5, rounded)
        self.assertEqual(len(rows["64x64"]), 4)

        swapped = benchmark(SINGLE, DOUBLE)
        self.assertEqual(swapped.returncode, BAD_INPUT)
        self.assertIn("computes in single precision; see --double",
                      swapped.stderr)


if __name__ == "__main__":
    DOUBLE, SINGLE = sys.argv[1:3]
    unittest.main(argv=sys.argv[:1])
