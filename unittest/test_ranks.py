"""What machpoint answers when mpirun starts it on several ranks.

The executable comes from MACHPOINT_EXECUTABLE, the launcher from
MACHPOINT_MPIEXEC.
"""

import json
import os
import pathlib
import signal
import subprocess
import sys
import tempfile
import unittest

import h5py

import running
from running import FINISHED, IO_FAILURE, STOPPED_EARLY, WRONG_INPUT

sys.path.append(str(pathlib.Path(__file__).resolve().parents[1] /
                    "benchmarks" / "kills"))
import ranks as launched

EXECUTABLE = os.path.abspath(os.environ["MACHPOINT_EXECUTABLE"])
LAUNCHER = os.environ["MACHPOINT_MPIEXEC"]
SOD = pathlib.Path(__file__).resolve().parent.parent / "input" / "sod.json"


def is_rank(process, number):
    """Is this process of the executable the given rank?"""
    try:
        return (os.readlink(f"/proc/{process}/exe") == EXECUTABLE
                and f"OMPI_COMM_WORLD_RANK={number}\0".encode()
                in pathlib.Path(f"/proc/{process}/environ").read_bytes())
    except OSError:
        return False


class RanksTest(unittest.TestCase):

    def setUp(self):
        scratch = tempfile.TemporaryDirectory()
        self.addCleanup(scratch.cleanup)
        self.output = pathlib.Path(scratch.name) / "out"

    def start(self, *arguments, ranks=2):
        return running.start(self, [LAUNCHER, "-n", ranks, EXECUTABLE, *arguments],
                             running.ONE_THREAD)

    def assertAnswer(self, process, code, message):
        """It ends with the code, and one rank says the message. Returns all that
        was said."""
        stdout, stderr = process.communicate(timeout=60)
        self.assertEqual(process.returncode, code, stdout + stderr)
        self.assertEqual((stdout + stderr).count(message), 1, stdout + stderr)
        return stdout + stderr

    def wait_for(self, process, count, pattern):
        running.wait_for(self, process, count, self.output, pattern)

    def rank(self, process, number):
        """The process of a rank."""
        found = [child for child in launched.children(process.pid)
                 if is_rank(child, number)]
        if not found:
            self.skipTest("this launcher hides where its ranks are")
        return found[0]

    def test_the_root_speaks(self):
        run = ["run", SOD, "--max-steps", 2, "--output", self.output]
        self.assertAnswer(self.start(*run), FINISHED, "output: ")
        summary = json.loads((self.output / "summary.json").read_text())
        self.assertEqual(summary["ranks"], 2)
        self.assertEqual(list(self.output.rglob("*.tmp")), [])
        for kind in ["particles", "grid"]:
            self.assertEqual(len(list((self.output / kind).glob("*.h5"))), 2)

        self.assertAnswer(self.start(*run), IO_FAILURE, "holds another run")

    def test_messages_are_counted(self):
        # One exchange a step (docs/ranks.md) over the one cut, each way.
        told = []
        for steps in (2, 5):
            self.assertAnswer(
                self.start("run", SOD, "--max-steps", steps, "--set",
                           "method.pressure_relaxation=0", "--set",
                           "method.heat_mixing=0", "--output", self.output,
                           "--overwrite"), FINISHED, "output: ")
            summary = json.loads((self.output / "summary.json").read_text())
            told.append(summary["communication"])
        few, many = [t["halo_messages"] for t in told]
        self.assertEqual(many["sum"] - few["sum"], 2 * 3)
        self.assertEqual(many["sum"], 2 * many["largest"])
        few, many = [t["halo_bytes"] for t in told]
        self.assertGreater(many["sum"], few["sum"])
        self.assertEqual(told[1]["gpu_aware"], False)
        for seconds in told[1]["seconds"].values():
            self.assertLessEqual(seconds["largest"], seconds["sum"])
            self.assertLessEqual(seconds["sum"], 2 * seconds["largest"])

    def test_wrong_input(self):
        # A rank that cannot reach the others would say which one it is.
        for arguments, message in [
                (["run", self.output], "cannot be read"),
                (["run", SOD, "--set", "method.basi=1"], "did you mean"),
                (["check", self.output], "cannot be read"),
                (["check", SOD, "--set", "method.basi=1"], "did you mean"),
                (["describe", "slip_wal"], "did you mean"),
                (["nonsense"], 'unknown command "nonsense"')]:
            with self.subTest(arguments=arguments):
                said = self.assertAnswer(self.start(*arguments), WRONG_INPUT,
                                         message)
                self.assertNotIn("rank 0: ", said)

    def test_a_signal_to_one_rank_stops_all(self):
        process = self.start("run", SOD, "--output", self.output,
                             "--set", "grid.cells=[20000]",
                             "--set", "output.every=1e-6")
        self.wait_for(process, 2, "particles/*.h5")
        os.kill(self.rank(process, 1), signal.SIGTERM)
        self.assertAnswer(process, STOPPED_EARLY, "stopped by signal 15")
        summary = json.loads((self.output / "summary.json").read_text())
        last = max((self.output / "particles").glob("*.h5"))
        self.assertEqual(int(last.stem), summary["steps"])

    def test_one_rank_of_four_is_killed(self):
        run = ["run", SOD, "--set", "grid.cells=[400]", "--set",
               "output.every=0.05", "--set", 'checkpoint={"every_steps":20}',
               "--set", "reproducible=true"]
        whole = self.output.with_name("whole")
        process = self.start(*run, "--output", whole, ranks=4)
        self.assertAnswer(process, FINISHED, "output: ")
        run += ["--output", self.output]
        for victim, until, how in [(3, "*0060.h5", []),
                                   (0, "*0120.h5", ["--restart", "latest"])]:
            process = self.start(*run, *how, ranks=4)
            self.wait_for(process, 1, "checkpoints/" + until)
            os.kill(self.rank(process, victim), signal.SIGKILL)
            launched.end(process)  # the others end, too
            self.assertNotEqual(process.returncode, FINISHED)
        self.assertAnswer(self.start(*run, "--restart", "latest", ranks=4),
                          FINISHED, "output: ")
        names = sorted(path.name for path in (whole / "particles").iterdir())
        self.assertEqual(len(names), 5)
        for name in names:
            with h5py.File(whole / "particles" / name) as expected, h5py.File(
                    self.output / "particles" / name) as found:
                for key in expected:
                    if key != "xdmf":
                        self.assertEqual(found[key][()].tobytes(),
                                         expected[key][()].tobytes(),
                                         f"{name}/{key}")

    def test_a_full_disk_ends_all(self):
        disk = self.output.with_name("disk")
        disk.mkdir()
        mount = subprocess.run(["mount", "-t", "tmpfs", "-o", "size=200k",
                                "tmpfs", str(disk)], capture_output=True)
        if mount.returncode != 0:
            self.skipTest("mounting a small tmpfs is not permitted")
        self.addCleanup(subprocess.run, ["umount", str(disk)], check=True)
        self.output = disk / "out"
        self.assertAnswer(
            self.start("run", SOD, "--set", "grid.cells=[2000]", "--output",
                       self.output), IO_FAILURE, "No space left")
        self.assertEqual(list(self.output.rglob("*.tmp")), [])
        for path in self.output.rglob("*.h5"):  # what is there is whole
            with h5py.File(path) as file:
                self.assertIn("time", file.attrs)


if __name__ == "__main__":
    unittest.main()
