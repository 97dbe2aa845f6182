"""tools/gpu_check, less what only a GPU can show."""

import argparse
import importlib.machinery
import importlib.util
import json
import os
import pathlib
import subprocess
import sys
import tempfile
import unittest

TOOL = pathlib.Path(__file__).resolve().parent.parent / "tools" / "gpu_check"
sys.dont_write_bytecode = True
loader = importlib.machinery.SourceFileLoader("gpu_check", str(TOOL))
gpu_check = importlib.util.module_from_spec(
    importlib.util.spec_from_loader("gpu_check", loader))
loader.exec_module(gpu_check)


class Scratch(unittest.TestCase):

    def setUp(self):
        scratch = tempfile.TemporaryDirectory()
        self.addCleanup(scratch.cleanup)
        self.folder = pathlib.Path(scratch.name)


class CommandLine(Scratch):

    def run_tool(self, *arguments, gpus=None):
        """gpus: what nvidia-smi prints; None: there is none."""
        path = self.folder / "bin"
        path.mkdir(exist_ok=True)
        if gpus is not None:
            (path / "nvidia-smi").write_text(f"#!/bin/sh\necho '{gpus}'\n")
            (path / "nvidia-smi").chmod(0o755)
        return subprocess.run(
            [sys.executable, TOOL, "--output", self.folder / "out", *arguments],
            capture_output=True, text=True, timeout=60,
            env=dict(os.environ, PATH=f"{path}:/bin"))

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
        self.assertIn("| build | not run: `tools/gpu_check --stage build`",
                      text)

    def test_dry_run(self):
        result = self.run_tool("--dry-run")
        self.assertEqual(result.returncode, 0, result.stderr)
        for stage in gpu_check.STAGES:
            self.assertIn(f"gpu_check: {stage}\n", result.stdout)
        self.assertIn("--preset cuda", result.stdout)
        self.assertIn("build/gpu_check/cuda", result.stdout)
        self.assertFalse(list((self.folder / "out").glob("*.json")))


class Stages(Scratch):

    def check(self, **options):
        return gpu_check.Check(argparse.Namespace(**dict(
            dict(preset="cuda", reference="openmp", output=self.folder,
                 limit=60, quick=True, dry_run=False, set=[]), **options)))

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
            check.remembered = lambda key, make: found
            return check.scenes()["failed"]

        self.assertIn("sod: not compiled", failed())
        self.assertEqual(failed(set=["Machpoint_DIMENSIONS=2"]), [])
        # The call that built them had it.
        (self.folder / "build.json").write_text(
            json.dumps({"set": ["Machpoint_DIMENSIONS=2"]}))
        self.assertEqual(failed(), [])

    def test_summaries_differ(self):
        a = {"steps": 50, "particles_final": 10, "final_time": 0.1,
             "errors": {"density": {"L1": 1e-3}},
             "extrema": {"min_density": 0.5}}
        b = json.loads(json.dumps(a))
        difference = gpu_check.Check.difference_of_summaries
        self.assertEqual(difference(a, b)[0], 0)
        b["errors"]["density"]["L1"] *= 1 + 1e-6
        worst, where = difference(a, b)
        self.assertAlmostEqual(worst, 1e-6, delta=1e-9)
        self.assertEqual(where, "errors/density/L1")

    def test_a_kernel_counts_as_it_was_run_last(self):
        head = ["ID", "Kernel Name", *gpu_check.METRICS.values()]
        lines = ["==PROF== Connected", *[
            ",".join(f'"{cell}"' for cell in row) for row in [
                head, ["", "", *["unit"] * len(gpu_check.METRICS)],
                ["0", "step", *["1"] * len(gpu_check.METRICS)],
                ["1", "other", *["1"] * len(gpu_check.METRICS)],
                ["2", "step", "2,500", *["7.5"] * 8]]]]
        names = {"step": "void run<Kokkos::ParallelFor<Machpoint::Impl::Turns<"
                         "void Machpoint::Impl::gatherParticles<"
                         "Machpoint::Quadratic, 2>(int)::{lambda(int)#1}> > >",
                 "other": "void Kokkos::Impl::fill()"}
        text = "\n".join(lines)
        for short, name in names.items():
            text = text.replace(f'"{short}"', f'"{name}"')
        found = gpu_check.Check.kernels_of(text)
        self.assertEqual(len(found), 1, found)
        (kernel, numbers), = found.items()
        self.assertIn("gatherParticles<Quadratic, 2>", kernel)
        self.assertEqual(numbers["ns"], 2500)
        self.assertEqual(numbers["registers"], 7.5)


if __name__ == "__main__":
    unittest.main()
