#!/usr/bin/env python3
"""The same scenes in double, single and mixed precision, and what a build in
single precision refuses.

Usage: unittest/compare_precisions.py DOUBLE SINGLE MIXED

Errors against exact solutions must be those of the scheme in all. SINGLE and MIXED
need no more than 2D and quadratic B-splines.
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

    def summary(self, build, *arguments, **options):
        folder, _ = self.machpoint(build, *arguments, **options)
        return json.loads((folder / "summary.json").read_text())

    def summaries(self, *arguments):
        return [self.summary(build, *arguments)
                for build in (DOUBLE, SINGLE, MIXED)]

    def test_errors_are_those_of_the_scheme(self):
        for method in "apic", "conservative":
            with self.subTest(method=method):
                sets = [*SMALL_VORTEX, f"method.name={method}",
                        "method.basis=quadratic"]
                found = self.summaries("isentropic_vortex", *sets)
                self.assertEqual([s["precision"] for s in found],
                                 ["double", "single", "mixed"])
                double, *others = found
                for other, near, exact in zip(others, (1e-2, 1e-6),
                                              (2e-6, 1e-14)):
                    self.assertEqual(double["steps"], other["steps"])
                    for field, error in double["errors"].items():
                        self.assertLess(
                            abs(other["errors"][field]["L1"] / error["L1"] -
                                1), near, field)
                    for balance in "mass", "momentum", "total_energy":
                        self.assertLess(abs(other["conservation"][balance]),
                                        exact, balance)

    def test_a_bow_shock_stands_where_it_stands(self):
        double, *others = self.summaries(
            "cylinder_mach3", "grid.cells=[80,40]", "time.end=1")
        # The time step is that of the fastest particle, a light piece of one halved
        # in the wake; round-off moves when that happens (without halving the steps
        # are equal: method.split_volume 0).
        for other in others:
            self.assertEqual(other["retries"], 0)
            for key, bound in ("particles_final", 1e-2), ("steps", 3e-2):
                self.assertLess(abs(other[key] / double[key] - 1), bound, key)
        # A step that an output cuts short has a large force for a short time.
        drag = []
        for build in (DOUBLE, SINGLE, MIXED):
            time, force = numpy.loadtxt(
                self.folder / pathlib.Path(build).parent.name /
                "series/cylinder.csv", delimiter=",", skiprows=1,
                usecols=(0, 1), unpack=True)
            late = time > 0.6
            drag.append(numpy.average(force[late],
                                      weights=numpy.diff(time, prepend=0)[late]))
        for other in drag[1:]:
            self.assertLess(abs(other / drag[0] - 1), 1e-2)

    # Beside a blast gradients are steep, and particles are halved.
    def test_mixed_precision_keeps_energy_in_a_blast(self):
        blast = self.summary(
            MIXED, "sedov_2d", "method.name=conservative",
            "method.basis=quadratic", "grid.cells=[40,40]")
        self.assertGreater(blast["particles_final"],
                           blast["particles_initial"] + 100)
        self.assertLess(abs(blast["conservation"]["total_energy"]), 1e-14)

    @unittest.skipUnless(shutil.which("mpirun"), "there is no mpirun")
    def test_ranks_exchange_floats(self):
        for build, near in (SINGLE, 1e-3), (MIXED, 1e-6):
            one, two = [self.summary(build, "isentropic_vortex",
                                     *SMALL_VORTEX, ranks=ranks)
                        for ranks in (1, 2)]
            self.assertEqual(two["ranks"], 2)
            self.assertGreater(two["communication"]["migrated_particles"]
                               ["sum"], 0)
            self.assertEqual(one["steps"], two["steps"])
            self.assertLess(abs(two["conservation"]["mass"]), 1e-12)
            for field, error in one["errors"].items():
                self.assertLess(
                    abs(two["errors"][field]["L1"] / error["L1"] - 1), near,
                    field)

    def test_files_have_floats(self):
        for build, dtype in (SINGLE, numpy.float32), (MIXED, numpy.float64):
            output, _ = self.machpoint(build, "isentropic_vortex",
                                       *SMALL_VORTEX,
                                       options=["--max-steps", "2"])
            for kind in "particles", "grid":
                with h5py.File(max((output / kind).glob("*.h5"))) as file:
                    self.assertEqual(file["density"].dtype, dtype)
                    self.assertEqual(file.attrs["time"].dtype, numpy.float64)
                self.assertIn(f'Precision="{numpy.dtype(dtype).itemsize}"',
                              (output / f"{kind}.xdmf").read_text())

    def test_a_checkpoint_belongs_to_its_precision(self):
        stop = ["--max-steps", "4"]
        checkpoint = 'checkpoint={"every_steps":2}'
        for build, name in (SINGLE, "single"), (MIXED, "mixed"):
            output, _ = self.machpoint(build, "isentropic_vortex",
                                       *SMALL_VORTEX, checkpoint, options=stop)
            self.machpoint(build, "isentropic_vortex", *SMALL_VORTEX,
                           checkpoint,
                           options=["--restart", "latest", "--max-steps", "6"])
            latest = max((output / "checkpoints").glob("*.h5"))
            _, said = self.machpoint(
                DOUBLE, "isentropic_vortex", *SMALL_VORTEX, checkpoint,
                options=["--restart", latest], code=BAD_INPUT)
            self.assertIn(f"has particles in {name} precision, and this "
                          "program computes in double; restart with a build "
                          f"whose Machpoint_PRECISION is {name}", said)

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
        def benchmark(*builds):
            words = [sys.executable, ROOT / "benchmarks/precision", "--fast"]
            for name, build in zip(("double", "mixed", "single"), builds):
                words += [f"--{name}", pathlib.Path(build).parent]
            return subprocess.run(words, capture_output=True, text=True)

        result = benchmark(DOUBLE, MIXED, SINGLE)
        self.assertEqual(result.returncode, 0, result.stderr)
        rows = {cells[1]: cells[2:-1] for cells in
                ([cell.strip() for cell in line.split("|")]
                 for line in result.stdout.splitlines() if line[:2] == "| ")}
        found = [float(cell) for cell in rows["Mach 3 cylinder, 400x200"]]
        times, ratios, held = found[:3], found[3:5], found[5:]
        for ratio, time in zip(ratios, times[1:]):
            self.assertAlmostEqual(ratio, times[0] / time, delta=0.02 * ratio)
        self.assertLess(held[1], 0.9 * held[0])
        self.assertLess(held[2], 0.6 * held[0])
        *exact, rounded = map(float, rows["`translation`, 40x40"][:3])
        self.assertLess(max(exact), 1e-13)
        self.assertTrue(1e-13 < rounded < 1e-5, rounded)
        self.assertEqual(len(rows["64x64"]), 6)

        swapped = benchmark(SINGLE, MIXED, DOUBLE)
        self.assertEqual(swapped.returncode, BAD_INPUT)
        self.assertIn("computes in single precision; see --double",
                      swapped.stderr)


if __name__ == "__main__":
    DOUBLE, SINGLE, MIXED = sys.argv[1:4]
    unittest.main(argv=sys.argv[:1])
