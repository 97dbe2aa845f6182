"""What tools and benchmarks answer before they do anything, and what they leave alone.

The executable comes from MACHPOINT_EXECUTABLE.
"""

import os
import pathlib
import subprocess
import sys
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parent.parent
TOOLS = ROOT / "tools"
BENCHMARKS = ROOT / "benchmarks"
PROGRAMS = [path.parent if path.name == "__main__.py" else path
            for path in sorted([*BENCHMARKS.rglob("__main__.py"),
                                *BENCHMARKS.rglob("cylinder_features.py"),
                                BENCHMARKS / "frozen_step.py",
                                BENCHMARKS / "price.py",
                                BENCHMARKS / "hard_cases/ablation.py",
                                BENCHMARKS / "kernels/pairs.py",
                                TOOLS / "gpu_stages/__main__.py"])]


class Help(unittest.TestCase):

    def test_it_is_the_comment_at_the_top(self):
        for name in ["setup", "run", "test", "gpu_check"]:
            source = (TOOLS / name).read_text().splitlines()
            comment = source[1:next(k for k, line in enumerate(source)
                                    if not line.startswith("#"))]
            for arguments in [["--help"], ["-h"], ["something", "--help"]]:
                with self.subTest(tool=name, arguments=arguments), \
                        tempfile.TemporaryDirectory() as empty:
                    # With no more on the PATH than that, nothing could be built.
                    for word in ["bash", "dirname", "nproc", "sed"]:
                        program = subprocess.run(["which", word], check=True, text=True,
                                                 capture_output=True).stdout.strip()
                        (pathlib.Path(empty) / word).symlink_to(program)
                    result = subprocess.run(
                        [pathlib.Path(empty) / "bash", TOOLS / name, *arguments],
                        env={"PATH": empty}, capture_output=True, text=True, timeout=20)
                    self.assertEqual(result.returncode, 0, result.stderr)
                    self.assertEqual(result.stderr, "")
                    self.assertEqual(
                        result.stdout.splitlines(),
                        [line.removeprefix("#").removeprefix(" ") for line in comment])


class WithoutPackages(unittest.TestCase):
    """Of an interpreter that has its own modules alone."""

    def run_program(self, program, *arguments):
        with tempfile.TemporaryDirectory() as folder:
            return subprocess.run(
                [sys.executable, "-B", "-E", "-s", "-S", program, *arguments],
                cwd=folder, capture_output=True, text=True, timeout=60)

    def test_help(self):
        for program in PROGRAMS:
            with self.subTest(program=program.relative_to(ROOT)):
                result = self.run_program(program, "--help")
                self.assertEqual(result.returncode, 0, result.stderr)
                self.assertTrue(result.stdout.startswith("usage: "), result.stdout)

    def test_an_unknown_option(self):
        for program in PROGRAMS:
            with self.subTest(program=program.relative_to(ROOT)):
                result = self.run_program(program, "--unknown-option")
                self.assertEqual(result.returncode, 2, result.stderr)
                self.assertIn("usage: ", result.stderr)
                self.assertNotIn("Traceback", result.stderr)

    def test_what_is_missing_is_named(self):
        result = self.run_program(BENCHMARKS / "frozen_step.py")
        self.assertEqual(result.returncode, 2, result.stderr)
        self.assertEqual(len(result.stderr.splitlines()), 1, result.stderr)
        self.assertIn("numpy", result.stderr)
        self.assertIn("run this with /usr/bin/python3", result.stderr)


class Documents(unittest.TestCase):

    def test_no_trial_is_written(self):
        for program in ["precision", "scaling"]:
            rounds = {"precision": "--rounds", "scaling": "--repeats"}[program]
            for words in [["--fast"], [rounds, "2"]]:
                with self.subTest(program=program, words=words), \
                        tempfile.TemporaryDirectory() as folder:
                    named = [] if program == "precision" else [
                        "--machpoint", os.environ["MACHPOINT_EXECUTABLE"]]
                    result = subprocess.run(
                        [sys.executable, BENCHMARKS / program, "--docs", *words,
                         *named], cwd=folder, capture_output=True, text=True,
                        timeout=60)
                    self.assertEqual(result.returncode, 2, result.stderr)
                    self.assertIn("leave out --docs", result.stderr)


class Checkpoint(unittest.TestCase):

    def test_files_of_others_stay(self):
        with tempfile.TemporaryDirectory() as folder:
            mine = [pathlib.Path(folder) / name for name in ("plain", "run/mine")]
            mine[1].parent.mkdir()
            for path in mine:
                path.write_text("mine")
            result = subprocess.run(
                [sys.executable, BENCHMARKS / "checkpoint", "--machpoint",
                 os.environ["MACHPOINT_EXECUTABLE"], "--cells", "16", "--ranks",
                 "1", "--repeats", "1", "--output", folder],
                capture_output=True, text=True, timeout=100)
            self.assertEqual(result.returncode, 0, result.stderr)
            self.assertEqual(sorted(path for path in pathlib.Path(folder).rglob("*")
                                    if path.is_file()), mine)


if __name__ == "__main__":
    unittest.main()
