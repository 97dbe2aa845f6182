"""What a run does that is stopped, killed or starved, and then restarted.

The executable comes from MACHPOINT_EXECUTABLE. A run that went through any of
this must end with the same bytes as one that did not: sums repeat exactly on one
thread.
"""

import csv
import fcntl
import json
import os
import pathlib
import random
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import unittest

import h5py
import numpy

import running
from running import ALARMING, FINISHED, IO_FAILURE, STOPPED_EARLY, WRONG_INPUT

EXECUTABLE = os.path.abspath(os.environ["MACHPOINT_EXECUTABLE"])

# A stream around a body: particles enter, leave, are halved and merged. It takes
# a fraction of a second.
SCENE = {
    "scene": "restart",
    "dimension": 2,
    "grid": {"lower": [0, 0], "upper": [1, 1], "cells": [32, 32]},
    "method": {"basis": "quadratic", "split_volume": 0.4, "merge_volume": 0.4},
    "particles": {"per_cell": 4, "placement": "random"},
    "physics": [{"type": "ideal_gas"}, {"type": "artificial_viscosity"}],
    "initial": [{"type": "uniform", "density": 1.4, "velocity": [4, 0],
                 "pressure": 1}],
    "boundary": [
        {"type": "inflow", "side": "x_lower", "density": 1.4,
         "velocity": [4, 0], "pressure": 1},
        {"type": "outflow", "side": "x_upper"},
        {"type": "slip_wall", "side": "y_lower"},
        {"type": "slip_wall", "side": "y_upper"},
        {"type": "obstacle", "name": "body",
         "shape": {"type": "sphere", "center": [0.5, 0.5], "radius": 0.12}}],
    "time": {"end": 0.6},
    "output": {"every": 0.1},
    "checkpoint": {"every_steps": 20}
}
# Keys of a summary that tell of time, or of this process alone.
TIMINGS = {"wall_seconds", "first_step_seconds", "particle_updates_per_second",
           "peak_memory_bytes", "peak_array_bytes", "kernels", "effects", "phases",
           "communication", "price"}


def outputs(directory):
    """Every dataset and attribute of a run's outputs, and its other files."""
    found = {}
    for kind in ["particles", "grid", "exact"]:
        for path in sorted((directory / kind).glob("*")):
            with h5py.File(path) as file:
                name = f"{kind}/{path.name}"
                found[name] = {key: value.tobytes()
                               for key, value in file.attrs.items()}
                for key in file:
                    if key != "xdmf":
                        found[name + "/" + key] = (file[key].shape,
                                                   file[key][()].tobytes())
    for path in [*directory.glob("*.xdmf"), *directory.glob("series/*")]:
        found[str(path.relative_to(directory))] = path.read_text()
    return found


def summary(directory):
    """A run's summary without what differs between equal runs."""
    whole = json.loads((directory / "summary.json").read_text())
    return {key: value for key, value in whole.items() if key not in TIMINGS}


def checkpoints(directory):
    return sorted((directory / "checkpoints").glob("*.h5"))


class RestartTest(unittest.TestCase):
    """Gives each test an empty directory and the run that nothing disturbed."""

    @classmethod
    def setUpClass(cls):
        scratch = tempfile.TemporaryDirectory()
        cls.addClassCleanup(scratch.cleanup)
        cls.scratch = pathlib.Path(scratch.name)
        cls.input = cls.scratch / "restart.json"
        cls.input.write_text(json.dumps(SCENE))
        cls.whole = cls.scratch / "whole"
        begin = time.monotonic()
        done = subprocess.run(
            [EXECUTABLE, "run", cls.input, "--output", cls.whole],
            stdin=subprocess.DEVNULL, capture_output=True, text=True, timeout=120,
            env=running.ONE_THREAD)
        cls.seconds = time.monotonic() - begin
        assert done.returncode == FINISHED, done.stdout + done.stderr
        cls.backend = json.loads(
            (cls.whole / "summary.json").read_text())["backend"]

    def setUp(self):
        scratch = tempfile.TemporaryDirectory()
        self.addCleanup(scratch.cleanup)
        self.directory = pathlib.Path(scratch.name)
        self.output = self.directory / "out"

    def start(self, *arguments):
        return running.start(self, [EXECUTABLE, "run", self.input, "--output",
                                    self.output, *arguments], running.ONE_THREAD)

    def run_code(self, code, *arguments):
        """Runs to an end of this exit code. Returns what stderr said."""
        process = self.start(*arguments)
        stdout, stderr = process.communicate(timeout=120)
        self.assertEqual(process.returncode, code, stdout + stderr)
        self.assertNotRegex(stdout + stderr, ALARMING)
        return stderr

    def wait_for(self, process, count, pattern):
        running.wait_for(self, process, count, self.output, pattern)

    def require_repeats(self):
        if self.backend not in ["Serial", "OpenMP"]:
            self.skipTest(f"sums do not repeat exactly on {self.backend}")

    def assertSameRun(self):
        """This run left what the undisturbed one did."""
        self.require_repeats()
        expected, found = outputs(self.whole), outputs(self.output)
        self.assertGreater(len(expected), 7 * 13)  # seven times
        self.assertEqual(sorted(found), sorted(expected))
        self.assertEqual([name for name in expected
                          if found[name] != expected[name]], [])
        expected, found = summary(self.whole), summary(self.output)
        expected["input"]["checkpoint"] = found["input"]["checkpoint"]
        self.assertEqual(found, expected)

    def assert_stopped(self, process):
        stdout, stderr = process.communicate(timeout=60)
        self.assertEqual(process.returncode, STOPPED_EARLY, stdout + stderr)
        self.assertIn("--restart latest", stderr)
        self.assertLess(summary(self.output)["final_time"], 0.6)
        # The state of the stop is written, and kept to go on from.
        self.assertEqual(int(checkpoints(self.output)[-1].stem),
                         summary(self.output)["steps"])
        return stderr


class Stopped(RestartTest):
    def test_signals(self):
        for number in [signal.SIGINT, signal.SIGTERM]:
            with self.subTest(signal=number):
                self.output = self.directory / number.name
                # Without a word of checkpoints in the input.
                free = ["--set", "checkpoint={}"]
                process = self.start(*free)
                self.wait_for(process, 3, "particles/*.h5")
                process.send_signal(number)
                self.assert_stopped(process)
                stderr = self.run_code(FINISHED, *free, "--restart", "latest")
                self.assertIn("goes on from", stderr)
                self.assertSameRun()
                self.assertEqual(len(checkpoints(self.output)), 1)

    def test_stop_file(self):
        process = self.start()
        self.wait_for(process, 2, "particles/*.h5")
        (self.output / "stop").touch()
        stderr = self.assert_stopped(process)
        self.assertIn(str(self.output / "stop"), stderr)
        self.assertFalse((self.output / "stop").exists())
        self.run_code(FINISHED, "--restart", "latest")
        self.assertSameRun()

    def test_stop_file_during_the_last_step(self):
        self.output.mkdir()
        (self.output / "stop").touch()
        self.run_code(FINISHED, "--set", "time.end=1e-6", "--set", "checkpoint={}")
        self.assertEqual(summary(self.output)["final_time"], 1e-6)
        self.assertFalse((self.output / "stop").exists())
        self.assertFalse((self.output / "checkpoints").exists())

    def test_max_steps(self):
        self.run_code(FINISHED, "--max-steps", 33)
        self.assertEqual([int(path.stem) for path in checkpoints(self.output)],
                         [20, 33])
        self.run_code(FINISHED, "--max-steps", 34, "--restart", "latest")
        self.run_code(FINISHED, "--restart", "latest")
        self.assertSameRun()

    def test_user_signal_keeps_the_state_and_goes_on(self):
        process = self.start("--set", "checkpoint={}")
        self.wait_for(process, 2, "particles/*.h5")
        self.assertEqual(checkpoints(self.output), [])
        process.send_signal(signal.SIGUSR1)
        self.wait_for(process, 1, "checkpoints/*.h5")
        process.communicate(timeout=60)
        self.assertEqual(process.returncode, FINISHED)
        self.assertEqual(len(checkpoints(self.output)), 1)
        self.assertSameRun()

    def test_killed_at_any_moment(self):
        rng = random.Random(7)
        kills = 0
        while kills < 5:
            known = checkpoints(self.output)
            process = self.start(*(["--restart", "latest"] if known
                                   else ["--overwrite"]))
            try:
                process.communicate(timeout=rng.uniform(0.2, 0.8)
                                    * self.seconds)
                self.assertEqual(process.returncode, FINISHED)
                # It was too fast: again from the last checkpoint but one.
                checkpoints(self.output)[-1].unlink()
            except subprocess.TimeoutExpired:
                process.kill()
                process.communicate(timeout=60)
                kills += 1
        self.run_code(FINISHED, *(["--restart", "latest"]
                                  if checkpoints(self.output)
                                  else ["--overwrite"]))
        self.assertSameRun()


class Kept(RestartTest):
    def test_last_ones_are_kept(self):
        self.run_code(FINISHED, "--max-steps", 50, "--set",
                      'checkpoint={"every_steps":10,"keep":3}')
        self.assertEqual([int(path.stem) for path in checkpoints(self.output)],
                         [30, 40, 50])
        self.assertEqual(list(self.output.rglob("*.tmp")), [])

    def test_what_one_costs_is_measured(self):
        script = pathlib.Path(__file__).parents[1] / "benchmarks/checkpoint"
        done = subprocess.run(
            [sys.executable, script, "--machpoint", EXECUTABLE, "--cells", "32",
             "--ranks", "1", "--repeats", "1", "--output",
             self.output / "price"], capture_output=True, text=True,
            timeout=60, check=False)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertRegex(done.stdout, r"1 ranks, 4096 particles, .*\n"
                                      r" +checkpoint .*\n +plain write ")

    def test_every_time(self):
        self.run_code(FINISHED, "--set",
                      'checkpoint={"every_time":0.15,"keep":9}')
        times = []
        for path in checkpoints(self.output):
            with h5py.File(path) as file:
                times.append(file.attrs["time"])
        self.assertEqual(len(times), 4)
        for number, at in enumerate(times, 1):
            self.assertGreaterEqual(at, 0.15 * number - 1e-12)
            self.assertLess(at, 0.15 * number + 0.02)
        self.assertSameRun()  # steps are not cut for checkpoints

    def test_every_time_that_steps_end_at(self):
        # 3 * 0.1 is behind 0.3, the end of that step and of the run.
        self.run_code(FINISHED, "--set", "time.end=0.3", "--set",
                      'checkpoint={"every_time":0.1,"keep":9}')
        times = []
        for path in checkpoints(self.output):
            with h5py.File(path) as file:
                times.append(file.attrs["time"])
        self.assertEqual(times, [0.1, 0.2, 0.3])
        # It goes on with a whole step.
        self.run_code(FINISHED, "--restart", "latest", "--set", "time.end=0.35")
        with open(self.output / "series/body.csv") as file:
            times = [float(row["time"]) for row in csv.DictReader(file)]
        self.assertGreater(min(b - a for a, b in zip(times, times[1:])), 1e-4)

    def test_every_wall_seconds(self):
        self.run_code(FINISHED, "--max-steps", 5, "--set",
                      'checkpoint={"every_wall_seconds":1e-9,"keep":9}')
        self.assertEqual(len(checkpoints(self.output)), 5)
        self.output = self.directory / "never"
        self.run_code(FINISHED, "--max-steps", 5, "--set",
                      'checkpoint={"every_wall_seconds":1e9}')
        self.assertEqual(len(checkpoints(self.output)), 1)  # that of the end

    def test_none_unless_asked_for(self):
        self.run_code(FINISHED, "--max-steps", 5, "--set", "checkpoint={}")
        self.assertFalse((self.output / "checkpoints").exists())

    def test_overwrite_removes_them(self):
        self.run_code(FINISHED, "--max-steps", 40)
        (self.output / "stop").touch()
        self.run_code(IO_FAILURE)  # holds a run
        self.run_code(FINISHED, "--overwrite", "--set", "checkpoint={}")
        self.assertEqual(checkpoints(self.output), [])
        self.assertSameRun()


def checksum(path, values):
    """Of a dataset of a checkpoint, as core/checkpoint.cpp has it."""
    most = (1 << 64) - 1

    def mix(z):
        z = (z + 0x9e3779b97f4a7c15) & most
        z = ((z ^ (z >> 30)) * 0xbf58476d1ce4e5b9) & most
        z = ((z ^ (z >> 27)) * 0x94d049bb133111eb) & most
        return z ^ (z >> 31)

    place = 0
    for c in path.encode():
        place = mix(place ^ c)
    total = 0
    for value in values:
        total += mix(int(value) ^ mix(place))
        place = (place + 1) & most
    return total


def forge(file, name, value):
    """Adds an integer that all ranks share to a checkpoint."""
    with h5py.File(file, "a") as f:
        old = bytes(f["header"][...])
        header = json.loads(old)
        header["entries"].append({"name": name, "type": "integer",
                                  "is_distributed": False})
        new = json.dumps(header, separators=(",", ":")).encode()
        total = (int(f.attrs["checksum"]) - checksum("header", old)
                 + checksum("header", new)
                 + checksum("shared/" + name, [value])) % (1 << 64)
        del f["header"]
        f["header"] = numpy.frombuffer(new, dtype=numpy.uint8)
        f["shared/" + name] = numpy.int64(value)
        f.attrs.modify("checksum",
                       numpy.array(total, dtype=numpy.uint64).view(numpy.int64))


class Restarted(RestartTest):
    def setUp(self):
        super().setUp()
        self.run_code(FINISHED, "--max-steps", 47)

    def contents(self):
        return {path: path.read_bytes() for path in self.output.rglob("*")
                if path.is_file()}

    def test_falls_back_from_a_truncated_file(self):
        newest, former = reversed(checkpoints(self.output))
        with open(newest, "r+b") as file:
            file.truncate(newest.stat().st_size // 2)
        stderr = self.run_code(FINISHED, "--restart", "latest")
        self.assertIn(str(newest), stderr)
        self.assertIn(f"falls back to {former}", stderr)
        self.assertSameRun()

    def test_from_a_named_file(self):
        self.run_code(FINISHED, "--restart", checkpoints(self.output)[0])
        self.assertSameRun()

    def test_into_another_directory(self):
        file = checkpoints(self.output)[-1]
        self.output = self.directory / "other"
        self.run_code(FINISHED, "--restart", file)
        self.require_repeats()
        found, expected = outputs(self.output), outputs(self.whole)
        for name, value in found.items():
            if not name.endswith(".xdmf"):
                self.assertEqual(value, expected[name], name)
        last = max((self.whole / "particles").glob("*.h5")).name
        self.assertIn(f"particles/{last}", found)
        # Its collections list what is there, and no more.
        listed = re.findall(r"particles/\d+\.h5",
                            (self.output / "particles.xdmf").read_text())
        self.assertEqual(set(listed), {name for name in found
                                       if name.count("/") == 1
                                       and name.startswith("particles")})
        self.assertEqual(summary(self.output), summary(self.whole))

    def test_a_folder_that_is_a_link(self):
        """To another disk, say, is the user's."""
        link = self.output / "particles"
        link.rename(self.directory / "elsewhere")
        link.symlink_to(self.directory / "elsewhere")
        self.run_code(FINISHED, "--restart", checkpoints(self.output)[0])
        self.assertTrue(link.is_symlink())
        self.assertSameRun()
        self.run_code(FINISHED, "--overwrite")
        self.assertTrue(link.is_symlink())
        self.assertSameRun()

    def test_to_a_later_end(self):
        self.run_code(FINISHED, "--restart", "latest")
        self.run_code(FINISHED, "--restart", "latest", "--set", "time.end=0.65",
                      "--set", "output.every=0.13")
        self.assertEqual(summary(self.output)["final_time"], 0.65)

    def test_another_scene_is_refused(self):
        before = self.contents()
        for change, words in [
                ("grid.cells=[32,33]", ["/grid/cells/1", "33", "32"]),
                ("scene=other", ["/scene", "other", "restart"]),
                ("method.name=apic", ["/method/name", "apic", "conservative"]),
                ("method.basis=cubic", ["/method/basis", "cubic", "quadratic"]),
                ("time.cfl=0.3", ["/time/cfl", "0.3", "0.8"]),
                ("particles.seed=2", ["/particles/seed", "2", "1"]),
                ("boundary.4.shape.radius=0.13",
                 ["/boundary/4/shape/radius", "0.13", "0.12"])]:
            with self.subTest(change=change):
                more = ["--set", "method={}"] if "apic" in change else []
                stderr = self.run_code(WRONG_INPUT, "--restart", "latest",
                                       *more, "--set", change)
                if more:
                    words = ["/method"]
                for word in [*words, str(self.input)]:
                    self.assertIn(word, stderr)
        # All that differs is told, of a list of numbers the first one.
        stderr = self.run_code(
            WRONG_INPUT, "--restart", "latest", "--set", "time.cfl=0.3",
            "--set", "particles.seed=2", "--set", "grid.cells=[33,33]")
        self.assertEqual(re.findall(r"(/\S+) is \S+ here, but", stderr),
                         ["/grid/cells/0", "/particles/seed", "/time/cfl"])
        self.assertEqual(self.contents(), before)

    def test_what_is_no_checkpoint_is_refused(self):
        text = self.directory / "text.h5"
        text.write_text("no checkpoint")
        for file, reason in [
                (text, "cannot be read as an HDF5 file"),
                (self.directory / "absent.h5", "there is no such file"),
                (self.directory, "it is a directory"),
                (next((self.output / "particles").glob("*.h5")),
                 "it is no checkpoint")]:
            with self.subTest(file=file):
                before = self.contents()
                stderr = self.run_code(IO_FAILURE, "--restart", file)
                self.assertIn(str(file), stderr)
                self.assertIn(reason, stderr)
                self.assertEqual(self.contents(), before)

    def test_a_refusal_removes_nothing(self):
        """A checkpoint with an entry that only another program knows."""
        self.run_code(FINISHED, "--restart", "latest")
        checkpoint = checkpoints(self.output)[-1]
        for name in "run/unknown", "outputs/unknown":
            file = self.directory / "forged.h5"
            shutil.copy(checkpoint, file)
            forge(file, name, 7)
            before = self.contents()
            stderr = self.run_code(IO_FAILURE, "--restart", file, "--overwrite")
            self.assertIn(f"{name} is unknown here", stderr)
            self.assertEqual(self.contents(), before)
        forge(checkpoint, "run/unknown", 7)
        before = self.contents()
        self.run_code(IO_FAILURE, "--restart", "latest")
        self.assertEqual(self.contents(), before)

    def test_beside_a_run(self):
        """Which may be about to write a checkpoint."""
        before = self.contents()
        directory = os.open(self.output, os.O_RDONLY)
        self.addCleanup(os.close, directory)
        fcntl.flock(directory, fcntl.LOCK_EX)
        for file in checkpoints(self.output):
            file.rename(self.directory / file.name)
        stderr = self.run_code(IO_FAILURE, "--restart", "latest")
        self.assertIn("another run or study is writing there", stderr)
        for file in self.directory.glob("*.h5"):
            file.rename(self.output / "checkpoints" / file.name)
        self.assertEqual(self.contents(), before)

    def test_no_checkpoint_to_fall_back_to(self):
        for file in checkpoints(self.output):
            file.write_bytes(random.Random(3).randbytes(5000))
        stderr = self.run_code(IO_FAILURE, "--restart", "latest")
        for file in checkpoints(self.output):
            self.assertIn(str(file), stderr)
        self.output = self.directory / "nothing"
        self.run_code(IO_FAILURE, "--restart", "latest")
        self.assertFalse(self.output.exists())


class FullDisk(RestartTest):
    def test_the_former_checkpoint_stays_whole(self):
        self.output.mkdir()
        self.run_code(FINISHED, "--set", "output.particles=false", "--set",
                      "output.grid=false", "--max-steps", 20, "--overwrite")
        size = checkpoints(self.output)[0].stat().st_size
        room = (3 * size // 2) // 1024
        disk = self.directory / "disk"
        disk.mkdir()
        mount = subprocess.run(["mount", "-t", "tmpfs", "-o", f"size={room}k",
                                "tmpfs", str(disk)], capture_output=True)
        if mount.returncode != 0:
            self.skipTest("mounting a small tmpfs is not permitted")
        self.addCleanup(subprocess.run, ["umount", str(disk)], check=True)
        self.output = disk / "out"
        quiet = ["--set", "output.particles=false", "--set",
                 "output.grid=false", "--set", "checkpoint.every_steps=20"]
        stderr = self.run_code(IO_FAILURE, *quiet)
        self.assertIn("No space left", stderr)
        self.assertIn("00000040.h5", stderr)
        self.assertEqual([path.name for path in checkpoints(self.output)],
                         ["00000020.h5"])
        self.assertEqual(list(self.output.rglob("*.tmp")), [])
        # A stop that finds no room does not leave its request behind, either.
        (self.output / "stop").touch()
        self.run_code(IO_FAILURE, *quiet, "--restart", "latest")
        self.assertFalse((self.output / "stop").exists())
        file = checkpoints(self.output)[0]
        self.output = self.directory / "roomy"
        self.run_code(FINISHED, *quiet, "--restart", file)
        self.require_repeats()
        self.assertEqual(summary(self.output)["steps"],
                         summary(self.whole)["steps"])


if __name__ == "__main__":
    unittest.main()
