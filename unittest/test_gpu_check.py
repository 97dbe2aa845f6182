"""tools/gpu_check, less what only a GPU can show."""

import argparse
import json
import os
import pathlib
import subprocess
import sys
import tempfile
import unittest
import unittest.mock

TOOL = pathlib.Path(__file__).resolve().parent.parent / "tools" / "gpu_check"
sys.path.insert(0, str(TOOL.parent / "gpu_stages"))

from check import STAGES, Check
from comparisons import SUMMARY
from measurements import METRICS


class Scratch(unittest.TestCase):

    def setUp(self):
        scratch = tempfile.TemporaryDirectory()
        self.addCleanup(scratch.cleanup)
        self.folder = pathlib.Path(scratch.name)


class CommandLine(Scratch):

    def program(self, name, text):
        """Puts one first on the PATH, which prints a text."""
        path = self.folder / "bin" / name
        path.parent.mkdir(exist_ok=True)
        path.write_text(f"#!/bin/sh\necho '{text}'\n")
        path.chmod(0o755)

    def run_tool(self, *arguments, gpus=None, python=sys.executable):
        """gpus: what nvidia-smi prints; None: there is none."""
        if gpus is not None:
            self.program("nvidia-smi", gpus)
        return subprocess.run(
            [TOOL, "--output", self.folder / "out", *arguments],
            capture_output=True, text=True, timeout=60,
            env=dict(os.environ, PATH=f"{self.folder / 'bin'}:/bin",
                     MACHPOINT_PYTHON=python))

    @unittest.skipIf(pathlib.Path("/bin/nvidia-smi").exists(),
                     "this machine has a GPU")
    def test_no_gpu(self):
        for gpus in [None, "No devices were found"]:
            result = self.run_tool(gpus=gpus)
            self.assertEqual(result.returncode, 2, result.stderr)
            self.assertIn("no GPU", result.stderr)
            self.assertFalse((self.folder / "out").exists())

    def test_wrong_usage(self):
        for arguments in [["--stage", "everything"],
                          ["--preset", "openmp", "--reference", "openmp"]]:
            self.assertEqual(self.run_tool(*arguments).returncode, 2)

    def test_one_stage(self):
        result = self.run_tool("--stage", "device", gpus="GPU 0: of this test")
        self.assertEqual(result.returncode, 0, result.stdout + result.stderr)
        text = (self.folder / "out/report.md").read_text()
        self.assertIn("GPU 0: of this test", text)
        self.assertIn("| device | passed | cuda against openmp |", text)
        self.assertIn("| build | not run: `tools/gpu_check --output "
                      f"{self.folder}/out --stage build`", text)

    def test_the_call_to_repeat_has_the_options_of_this_one(self):
        options = ["--preset", "openmp", "--reference=serial", "--quick", "--set",
                   "Machpoint_DIMENSIONS=1;2"]
        result = self.run_tool("--stage", "device", *options)
        self.assertEqual(result.returncode, 0, result.stderr)
        text = (self.folder / "out/report.md").read_text()
        self.assertIn("| device | passed | openmp against serial |", text)
        self.assertIn("--preset openmp --reference=serial --quick --set "
                      "'Machpoint_DIMENSIONS=1;2' --stage sweep`", text)

    def test_the_python_that_is_named_and_not_the_first(self):
        self.program("python3", "the first")
        self.assertIn("gpu_check: device", self.run_tool("--dry-run").stdout)
        # None is named: Debian's own, where there is one.
        own = pathlib.Path("/usr/bin/python3").exists()
        self.assertIn("gpu_check: device" if own else "the first",
                      self.run_tool("--dry-run", python="").stdout)

    def test_dry_run(self):
        result = self.run_tool("--dry-run")
        self.assertEqual(result.returncode, 0, result.stderr)
        for stage in STAGES:
            self.assertIn(f"gpu_check: {stage}\n", result.stdout)
        self.assertIn("--preset cuda", result.stdout)
        self.assertIn("build/gpu_check/cuda", result.stdout)
        self.assertFalse((self.folder / "out").exists())

    def test_a_dry_run_keeps_what_is_there(self):
        out = self.folder / "out"
        out.mkdir()
        names = [*(f"{stage}.log" for stage in STAGES), "ctest.xml",
                 "kernels.json", "ncu.csv"]
        for name in names:
            (out / name).write_text("of an earlier call")
        self.assertEqual(self.run_tool("--dry-run").returncode, 0)
        self.assertEqual({path.name: path.read_text() for path in out.iterdir()},
                         dict.fromkeys(names, "of an earlier call"))


class Stages(Scratch):

    def check(self, **options):
        return Check(argparse.Namespace(**dict(
            dict(preset="cuda", reference="openmp", output=self.folder,
                 limit=60, quick=True, dry_run=False, set=[], others=[]),
            **options)))

    def test_a_failure_is_recorded(self):
        check = self.check()
        check.device = lambda: check.require("false")
        self.assertFalse(check.perform("device"))
        check.kernels = lambda: sys.exit("a benchmark ends itself")
        self.assertFalse(check.perform("kernels"))
        check.setup = lambda: {"text": ["all is well"]}
        self.assertTrue(check.perform("setup"))
        check.report()
        records = json.loads((self.folder / "report.json").read_text())
        self.assertEqual([(r["stage"], r["passed"]) for r in records],
                         [("device", False), ("setup", True),
                          ("kernels", False)])
        text = (self.folder / "report.md").read_text()
        self.assertIn("- failed: exit code 1 of false", text)
        self.assertIn("all is well", text)

    def test_the_time_limit_ends_a_command(self):
        check = self.check(limit=0.1)
        check.device = lambda: check.require("sleep", "30")
        self.assertFalse(check.perform("device"))
        record = json.loads((self.folder / "device.json").read_text())
        self.assertLess(record["seconds"], 20)
        self.assertIn("time limit", record["failed"][0])

    def test_a_scene_that_was_not_compiled(self):
        found = {"verdict": "not compiled", "difference": "", "speed": ["", ""]}

        def failed(**options):
            check = self.check(**options)
            check.hides_particles = lambda: ""
            check.remembered = lambda key, make: found
            return check.scenes()["failed"]

        self.assertIn("sod: not compiled", failed())
        self.assertEqual(failed(set=["Machpoint_DIMENSIONS=2"]), [])
        # The call that built them had it.
        (self.folder / "build.json").write_text(
            json.dumps({"set": ["Machpoint_DIMENSIONS=2"]}))
        self.assertEqual(failed(), [])

    def test_summaries_alone_are_no_particles(self):
        bare = {"precision": "double", "particle_updates_per_second": 1,
                **dict.fromkeys(SUMMARY, {"same": 1})}
        check = self.check()
        check.has_hdf5 = lambda: True
        check.summary_of = lambda *_: bare
        check.remembered = lambda key, make: make()
        import compare_backends
        with unittest.mock.patch.object(compare_backends, "h5py", None):
            self.assertTrue(check.perform("scenes"))
        check.report()
        text = (self.folder / "report.md").read_text()
        self.assertIn("| scenes | passed, but by summaries alone, not particle by "
                      f"particle: {sys.executable} lacks numpy or h5py", text)
        self.assertIn("| sod | summaries agree |", text)
        self.assertNotIn("| ok |", text)

    def test_summaries_differ(self):
        a = {"steps": 50, "particles_final": 10, "final_time": 0.1,
             "errors": {"density": {"L1": 1e-3}},
             "extrema": {"min_density": 0.5}}
        b = json.loads(json.dumps(a))
        difference = Check.difference_of_summaries
        self.assertEqual(difference(a, b)[0], 0)
        b["errors"]["density"]["L1"] *= 1 + 1e-6
        worst, where = difference(a, b)
        self.assertAlmostEqual(worst, 1e-6, delta=1e-9)
        self.assertEqual(where, "errors/density/L1")

    def test_a_kernel_counts_as_it_was_run_last(self):
        head = ["ID", "Kernel Name", *METRICS.values()]
        lines = ["==PROF== Connected", *[
            ",".join(f'"{cell}"' for cell in row) for row in [
                head, ["", "", *["unit"] * len(METRICS)],
                ["0", "step", *["1"] * len(METRICS)],
                ["1", "other", *["1"] * len(METRICS)],
                ["2", "step", "2,500", *["7.5"] * 8]]]]
        names = {"step": "void run<Kokkos::ParallelFor<Machpoint::Impl::Turns<"
                         "void Machpoint::Impl::gatherParticles<"
                         "Machpoint::Quadratic, 2>(int)::{lambda(int)#1}> > >",
                 "other": "void Kokkos::Impl::fill()"}
        text = "\n".join(lines)
        for short, name in names.items():
            text = text.replace(f'"{short}"', f'"{name}"')
        found = Check.kernels_of(text)
        self.assertEqual(len(found), 1, found)
        (kernel, numbers), = found.items()
        self.assertIn("gatherParticles<Quadratic, 2>", kernel)
        self.assertEqual(numbers["ns"], 2500)
        self.assertEqual(numbers["registers"], 7.5)


if __name__ == "__main__":
    unittest.main()
