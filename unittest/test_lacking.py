"""What a build without MPI or HDF5 does, and that it says what it lacks.

The executable comes from MACHPOINT_EXECUTABLE, what it lacks from
MACHPOINT_LACKS.
"""

import json
import os
import pathlib
import signal
import subprocess
import tempfile
import time
import unittest

import running
from running import ENVIRONMENT, FINISHED, IO_FAILURE, STOPPED_EARLY, WRONG_INPUT

EXECUTABLE = os.path.abspath(os.environ["MACHPOINT_EXECUTABLE"])
LACKS = os.environ["MACHPOINT_LACKS"].split()
SOD = pathlib.Path(__file__).resolve().parent.parent / "input" / "sod.json"

NO_FIELDS = ["--set", "output={\"particles\": false, \"grid\": false}"]
WITHOUT_MPI = unittest.skipUnless("MPI" in LACKS, "this build has MPI")
WITHOUT_HDF5 = unittest.skipUnless("HDF5" in LACKS, "this build has HDF5")


class Lacking(unittest.TestCase):

    def setUp(self):
        scratch = tempfile.TemporaryDirectory()
        self.addCleanup(scratch.cleanup)
        self.output = pathlib.Path(scratch.name) / "out"

    def command(self, *arguments):
        return [EXECUTABLE, "run", str(SOD), "--quiet", "--output",
                str(self.output), *arguments]

    def run_sod(self, *arguments, **environment):
        return subprocess.run(
            self.command(*arguments), stdin=subprocess.DEVNULL,
            capture_output=True, text=True, timeout=60,
            env={**ENVIRONMENT, **environment})

    def assertRefused(self, result, code, lack):
        self.assertEqual(result.returncode, code, result.stderr)
        self.assertEqual(len(result.stderr.splitlines()), 1, result.stderr)
        self.assertIn(f"-DMachpoint_ENABLE_{lack}=ON", result.stderr)
        self.assertFalse(self.output.exists())

    def test_the_tube(self):
        """Finishes, with the accuracy of any other build."""
        result = self.run_sod(*NO_FIELDS)
        self.assertEqual(result.returncode, FINISHED, result.stderr)
        self.assertEqual([path.name for path in self.output.iterdir()],
                         ["summary.json"])
        summary = json.loads((self.output / "summary.json").read_text())
        self.assertEqual(summary["ranks"], 1)
        self.assertEqual(summary["final_time"], 0.2)
        # The bound of benchmarks/hard_cases.
        self.assertLess(summary["errors"]["density"]["L1"], 7.2e-3)

    @WITHOUT_HDF5
    def test_fields(self):
        for key in ["particles", "grid"]:
            self.assertRefused(
                self.run_sod("--set", f"output={{\"{key}\": false}}"),
                IO_FAILURE, "HDF5")

    @WITHOUT_HDF5
    def test_checkpoints(self):
        self.assertRefused(
            self.run_sod(*NO_FIELDS, "--set",
                         "checkpoint={\"every_steps\": 5}"),
            IO_FAILURE, "HDF5")

    @WITHOUT_HDF5
    def test_restart(self):
        self.assertRefused(self.run_sod(*NO_FIELDS, "--restart", str(SOD)),
                           IO_FAILURE, "HDF5")

    @WITHOUT_HDF5
    def test_stop(self):
        process = running.start(
            self, self.command(*NO_FIELDS, "--set", "grid.cells=[100000]"),
            ENVIRONMENT)
        while process.poll() is None and not self.output.exists():
            time.sleep(0.01)
        process.send_signal(signal.SIGTERM)
        message = process.communicate(timeout=60)[1]
        self.assertEqual(process.returncode, STOPPED_EARLY, message)
        self.assertIn("lacks HDF5", message)

    @WITHOUT_MPI
    def test_ranks(self):
        """Processes that know nothing of each other refuse to start."""
        for variable in ["OMPI_COMM_WORLD_SIZE", "PMI_SIZE"]:
            self.assertRefused(self.run_sod(*NO_FIELDS, **{variable: "2"}),
                               WRONG_INPUT, "MPI")
        one = self.run_sod(*NO_FIELDS, "--max-steps", "1",
                           OMPI_COMM_WORLD_SIZE="1")
        self.assertEqual(one.returncode, FINISHED, one.stderr)

    @WITHOUT_MPI
    def test_boxes(self):
        result = self.run_sod(*NO_FIELDS, "--set",
                              "decomposition={\"ranks\": [2]}")
        self.assertEqual(result.returncode, WRONG_INPUT, result.stderr)
        self.assertIn("/decomposition/ranks", result.stderr)


if __name__ == "__main__":
    unittest.main()
