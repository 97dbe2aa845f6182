"""The benchmarks of speed: they run and give finite figures, and what they do with
these is right. No time passes or fails a test.

The executable comes from MACHPOINT_EXECUTABLE; machpoint_kernels and
both machpoint_plain_loop lie beside it, where they are built.
"""
import argparse
import contextlib
import importlib.util
import io
import itertools
import json
import math
import os
import pathlib
import subprocess
import sys
import tempfile
import unittest
import unittest.mock

import running

# Ahead of launcher, which takes a copy.
os.environ.update(running.OPEN_MPI)
ROOT = pathlib.Path(__file__).resolve().parent.parent / "benchmarks"
sys.path += [str(ROOT / name) for name in
             ("performance", "kernels", "speed", "sod_sweep")]

import executable as named
import jobs
import machine
import options
import page
import pairs
import results
import sweep
import targets
from median import Median
from sizes import FULL

TINY = ["--small", "--particles", "300", "--samples", "1"]
MACHPOINT = pathlib.Path(os.environ["MACHPOINT_EXECUTABLE"])


def program(name):
    """A main module: all of them are called __main__.py."""
    spec = importlib.util.spec_from_file_location(
        name, ROOT / name / "__main__.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def built(test, name):
    path = MACHPOINT.parent / name
    if not path.exists():
        test.skipTest(f"{name} is not built")
    return path


class AccuracyTest(unittest.TestCase):

    def test_a_study_becomes_a_table(self):
        built(self, "machpoint_reference")
        accuracy = program("accuracy")
        with tempfile.TemporaryDirectory() as scratch:
            study, shown = accuracy.run(MACHPOINT.resolve(), "leblanc",
                                        pathlib.Path(scratch), 1)
        self.assertIn("halving this error takes", shown)
        head, _, *lines = accuracy.runs_table(study).splitlines()
        self.assertIn("| 180 | 360 | 720 |", head)
        self.assertEqual(len(lines), len(study["laws"]))
        self.assertTrue(any(line.startswith("| finite_volume |")
                            for line in lines))
        front = [r for r in study["rows"] if r["id"] in study["pareto"]]
        self.assertTrue(front)
        self.assertEqual("".join(lines).count("**"), 2 * len(front))
        for row in front:
            self.assertIn(f"**{row['errors']['density.L1']:.2e}, ",
                          "".join(lines))

    def test_advice_beside_the_truth(self):
        proof = {"request": "density.L1=1e-3", "value": 1.1e-3, "seconds": 2,
                 "predicted": {"seconds": 1, "error": 1e-3},
                 "row": {"line": "apic", "cells": [4, 2]}}
        text = program("accuracy").advice_table(
            [{"study": "sod", "proofs": [proof, {**proof, "value": None}]}])
        self.assertIn("| apic, 4x2 | 1, 2 (+100 %) | 0.001, 0.0011 (+10 %) |",
                      text)
        self.assertIn("| 1, 2 (+100 %) | - |", text)


class CheckpointTest(unittest.TestCase):

    def test_a_file_that_cannot_be_opened_ends_it(self):
        """Here it is a folder, of which each writer complains on stderr."""
        with tempfile.TemporaryDirectory() as folder, \
                self.assertRaisesRegex(SystemExit, "cannot be written"):
            program("checkpoint").plain_write(pathlib.Path(folder), 10, 2)


class KernelsTest(unittest.TestCase):

    def test_every_part_of_every_case_is_finite(self):
        executable = built(self, "machpoint_kernels")
        some = "/quadratic/[12]D/[34]/(ord|uns)|/cubic/[23]D/[48]/mixed"
        found = results.run(executable, [f"--benchmark_filter={some}", *TINY])
        on_cpu = found["context"]["backend"] in ("Serial", "OpenMP")
        for name, value in results.limits(found).items():
            if "streamed" in name: # 0 where kernels cannot
                continue
            if on_cpu or not name.endswith("_one"):
                self.assertGreater(value, 0, name)
        rows = results.rows(found)
        self.assertIn("step", {key[5] for key in rows})
        for key, row in rows.items():
            for name in results.FIGURES:
                self.assertTrue(math.isfinite(row[name]), (key, name))
            self.assertGreater(row["updates_per_second"], 0, key)
            for name in ("bytes", "flops"):
                self.assertEqual(row[name] > 0, key[5] != "other", key)
        for key, row in rows.items():
            if key[5] != "step":
                continue
            parts = [other for name, other in rows.items()
                     if name[:5] == key[:5] and name[5] != "step"]
            # One sample: the parts, and what is in none, are the step.
            self.assertAlmostEqual(sum(row["updates_per_second"] /
                                       part["updates_per_second"]
                                       for part in parts), 1, msg=key)
            self.assertAlmostEqual(sum(part["bytes"] for part in parts) /
                                   row["bytes"], 1, msg=key)
        with tempfile.TemporaryDirectory() as scratch:
            path = pathlib.Path(scratch) / "roofline.png"
            program("kernels").picture(found, path)
            self.assertGreater(path.stat().st_size, 0)

    def test_builds_in_turn(self):
        build = built(self, "machpoint_kernels").parent
        result = subprocess.run(
            [sys.executable, ROOT / "kernels" / "pairs.py", build, build,
             "--rounds", "2", "--filter", "^apic/quadratic/1D/3/ordered/step/",
             "--particles", "300"], check=True, capture_output=True, text=True)
        first, second = [line.split("|") for line in
                         result.stdout.splitlines() if line.startswith("| ap")]
        self.assertEqual([float(word) for word in first[5:7]], [1, 1])
        self.assertAlmostEqual(float(second[5]),
                               float(second[3]) / float(first[3]), delta=0.01)

    def test_least_and_median_are_over_the_first_build(self):
        case = ("apic", "linear", 1, 3, "mixed", "step")
        _, _, first, second = pairs.table(
            ["a", "b"], {case: [[2, 9, 4], [3, 8, 1]]}).splitlines()[:4]
        self.assertIn("| a | 2.00 | 4.00 | 1.000 | 1.000 |", first)
        self.assertIn("| b | 1.00 | 3.00 | 0.500 | 0.750 |", second)
        with self.assertRaises(SystemExit):
            pairs.table(["a", "b"], {case: [[2], []]})

    def test_trials_stay_off_the_page(self):
        for words in (["--small"], ["--filter", "step"], ["--samples", "2"],
                      ["--particles", "65536"]):
            result = subprocess.run(
                [sys.executable, ROOT / "kernels", "--docs", *words],
                capture_output=True, text=True)
            self.assertEqual(result.returncode, 2, words)
            self.assertRegex(result.stderr, f"leave out .*{words[0]}")
        row = {"name": "apic/quadratic/2D/4/mixed/step/iterations:1"}
        with self.assertRaisesRegex(SystemExit, "lacks paper/quadratic/1D/3"):
            program("kernels").require_all([results.key(row["name"])])

    def test_what_was_measured_is_kept_before_it_is_judged(self):
        kernels = program("kernels")
        names = [f"apic/quadratic/2D/4/mixed/{part}" for part in ("step", "P2G")]
        found = {"context": {"mpi": "no"}, "benchmarks": [
            {"name": names[0], "spread": 0.25},
            {"name": names[1], "error_occurred": True, "error_message": "lost"}]}
        with tempfile.TemporaryDirectory() as scratch:
            words = ["kernels", "--kernels", f"{scratch}/none", "--output", scratch]
            with unittest.mock.patch.object(results, "run", lambda *_: found), \
                    unittest.mock.patch.object(
                        results, "cases", lambda *_: list(map(results.key, names))), \
                    unittest.mock.patch("sys.argv", words), \
                    self.assertRaisesRegex(SystemExit, "P2G: lost"):
                kernels.main()
            kept = json.loads((pathlib.Path(scratch) / "results.json").read_text())
        self.assertEqual(kept["benchmarks"], found["benchmarks"])
        self.assertEqual(kept["machine"]["median_spread"], 0.25)
        self.assertEqual(kept["lacks"], "built without MPI")

    def test_cases_are_looked_for_before_anything_is_timed(self):
        executable = built(self, "machpoint_kernels")
        with tempfile.TemporaryDirectory() as scratch:
            words = ["kernels", "--kernels", str(executable), "--output", scratch,
                     "--filter", "nothing"]
            with unittest.mock.patch.object(results, "run") as run, \
                    unittest.mock.patch("sys.argv", words), \
                    self.assertRaisesRegex(SystemExit, "nothing"):
                program("kernels").main()
            run.assert_not_called()

    @unittest.skipUnless(os.environ.get("MACHPOINT_MPIEXEC"), "without MPI")
    def test_a_launcher_that_fails_costs_its_rows_alone(self):
        executable = built(self, "machpoint_kernels")
        with tempfile.TemporaryDirectory() as scratch:
            command = [sys.executable, ROOT / "kernels", "--kernels", executable,
                       "--small", "--particles", "300", "--output", scratch,
                       "--filter", "^apic/linear/1D/3/ordered/step/", "--mpiexec"]
            text = subprocess.run([*command, "false"], check=True,
                                  capture_output=True, text=True).stdout
            found = json.loads((pathlib.Path(scratch) / "results.json").read_text())
            wrong = subprocess.run([*command, "no_such_launcher"], capture_output=True,
                                   text=True)
        reason = "false -n 2: exit code 1"
        self.assertIn(f"left out, halo and migrate: {reason}", text)
        self.assertEqual(found["lacks"], reason)
        self.assertNotIn("ranks", found)
        self.assertEqual(wrong.returncode, 2)

    def test_its_own_options_are_told_first(self):
        text = subprocess.run(
            [built(self, "machpoint_kernels"), "--help"], check=True,
            capture_output=True, text=True).stdout
        own, google = map(text.find, ("--particles", "--benchmark_filter"))
        self.assertTrue(0 < own < google, text)

    def test_a_program_that_is_not_there(self):
        with self.assertRaisesRegex(SystemExit, "No such file"):
            results.run("/nonexistent", [])

    @unittest.skipUnless(os.environ.get("MACHPOINT_MPIEXEC"), "without MPI")
    def test_what_ranks_tell_each_other_stands_in_the_table(self):
        executable = built(self, "machpoint_kernels")
        with tempfile.TemporaryDirectory() as scratch:
            text = subprocess.run(
                [sys.executable, ROOT / "kernels", "--kernels", executable,
                 "--small", "--particles", "300", "--output", scratch,
                 "--filter", "^apic/quadratic/2D/4/ordered/step/",
                 "--mpiexec", os.environ["MACHPOINT_MPIEXEC"]],
                check=True, capture_output=True, text=True).stdout
        self.assertEqual([line.split(" | ")[5] for line in text.splitlines()
                          if line.startswith("| apic")],
                         ["step", "halo", "migrate"])

    @unittest.skipUnless(os.environ.get("MACHPOINT_MPIEXEC"), "without MPI")
    def test_two_ranks(self):
        executable = built(self, "machpoint_kernels")
        found = results.run(
            executable, ["--benchmark_filter=apic/quadratic/2D/4/ordered",
                         *TINY], 1,
            [os.environ["MACHPOINT_MPIEXEC"], "-n", "2"])
        rows = results.rows(found)
        self.assertEqual(results.limits(found)["ranks"], 2)
        for part in ("halo", "migrate"):
            row = rows["apic", "quadratic", 2, 4, "ordered", part]
            self.assertGreater(row["updates_per_second"], 0)
            self.assertGreater(row["bytes"], 0)

    def test_an_unknown_case_is_an_error(self):
        executable = built(self, "machpoint_kernels")
        with self.assertRaises(SystemExit):
            results.run(executable, ["--benchmark_filter=nothing", "--small"])


class PlainLoopTest(unittest.TestCase):

    def test_the_block_falls_freely(self):
        executables = [built(self, name) for name in jobs.PLAIN_LOOPS.values()]
        cells, steps, samples = 48, 4, 2
        for executable, words in itertools.product(executables, ([], ["mixed"])):
            texts = [subprocess.run(
                [executable, *map(str, (cells, steps, samples)), *words],
                check=True, capture_output=True, text=True,
                env=dict(os.environ, OMP_NUM_THREADS=threads)).stdout
                for threads in ("1", "2")]
            for found in map(json.loads, texts):
                self.assertEqual(len(found["updates_per_second"]), samples)
                n = 5 + steps * samples
                dt = 2e-4 * 128 / cells
                fall = 9.8 * dt ** 2 * n * (n + 1) / 2
                # Random places have a mean of their own.
                accuracy = 2e-3 if words else 1e-11
                self.assertAlmostEqual(found["mean"][0], 0.5, delta=accuracy)
                self.assertAlmostEqual(found["mean"][1], 0.5 - fall,
                                       delta=accuracy)


class SpeedTest(unittest.TestCase):

    def test_targets(self):
        figures = {
            ("ours", "apic", 2, "ordered", 1): [30e6],
            ("ours", "apic", 2, "mixed", 1): [24e6],
            ("ours", "conservative_midpoint", 2, "ordered", 1): [20e6],
            ("ours", "apic", 3, "ordered", 1): [5e6],
            ("part", "apic", "G2P"): [60e6],
            ("part", "conservative_midpoint", "G2P"): [30e6, 20e6, 40e6],
            ("part", "apic", "grid"): [60e6],
            ("part", "conservative_midpoint", "grid"): [50e6],
            ("part", "conservative_midpoint", "prepare"): [60e6],
            ("bytes", "conservative_midpoint", "prepare"): [80],
            ("part", "apic", "other"): [60e6], ("bytes", "apic", "other"): [0],
            ("part", "conservative_midpoint", "other"): [50e6],
            ("bytes", "conservative_midpoint", "other"): [0],
            ("bytes", "apic", "G2P"): [100],
            ("bytes", "conservative_midpoint", "G2P"): [147],
            ("bytes", "apic", "grid"): [50],
            ("bytes", "conservative_midpoint", "grid"): [72],
            ("plain", "ordered", 1): [20e6, 18e6, 100e6],
            ("plain without SLP", "ordered", 1): [19e6],
            ("plain", "ordered", 2): [30e6],
            ("plain without SLP", "ordered", 2): [30.5e6],
            ("taichi", "ordered", 1): [40e6],
            ("cylinder",): [34.0, 34.0],
            ("bytes",): [112], ("memory", "apic"): [224.0],
            ("memory, no retries", "apic"): [155.0],
            ("held", "apic"): [192.0], ("held, no retries", "apic"): [110.0]}
        rows = {row.text: row for row in targets.rows(figures, FULL)}
        # Of repeated texts the last; only `midpoint` has parts.
        verdicts = {text: row.met for text, row in rows.items()
                    if row.met is not None}
        over = "2D `apic`, with {}, memory of a particle over one AoSoA's bytes"
        part = "the same, {} alone, bound by its bytes over those of `apic`"
        self.assertEqual(verdicts, {
            "2D `apic`, ordered, 1 thread(s), over the plain loop": True,
            "2D `apic`, 1 thread(s), mixed over ordered": False,
            "3D `apic`, 8 per cell, 1 thread(s)": False,
            "2D `conservative` midpoint over `apic`, cost of a particle step":
                True,
            part.format("G2P"): False, part.format("grid"): True,
            "`cylinder_mach3`, 400x200 to t = 4, 2 threads": True,
            over.format("the old state to return to"): False,
            over.format("`time.retries` 0"): True})
        self.assertEqual(
            rows[part.format("G2P")].words()[1:5],
            ["2", "<= 1.47", "**missed**", 1])
        self.assertEqual(targets.Row("", Median(1.4003, 2), most=1.4).words()[1:5],
                         ["1.4003", "<= 1.4", "**missed**", 2])
        # Nobody asks for these.
        for text, value in (
                ("2D `apic`, ordered, 1 thread(s), over Taichi", 30 / 40),
                ("2D `apic`, with the old state to return to, memory over all "
                 "that its AoSoAs hold", 224 / 192)):
            self.assertAlmostEqual(rows[text].figure.value, value)
            self.assertIsNone(rows[text].met)
        # Half as fast a host on two threads, two thirds on one.
        scaled = [row.figure.value for row in rows.values()
                  if "scaled" in row.text]
        self.assertAlmostEqual(scaled[0], 5 * 31.6 / 20)
        self.assertAlmostEqual(scaled[1], 34.0 / 2)
        text = targets.verdicts(rows.values())
        self.assertIn("| 0.8 | >= 0.85 | **missed** | 1 |", text)
        self.assertIn("| 34 s | <= 35 s | met | 2 |", text)
        self.assertEqual({row.met for row in targets.unjudged(rows.values())},
                         {None})

    def test_the_faster_plain_loop_counts(self):
        def row(with_slp, without):
            return next(iter(targets.rows(
                {("ours", "apic", 2, "ordered", 1): [30e6],
                 ("plain", "ordered", 1): with_slp,
                 ("plain without SLP", "ordered", 1): without}, FULL)))
        found = row([20e6, 10e6, 30e6], [24e6])
        self.assertAlmostEqual(found.figure.value, 30 / 24)
        self.assertEqual(found.note, "`machpoint_plain_loop_no_slp`")
        found = row([20e6, 20e6, 30e6], [10e6])
        self.assertAlmostEqual(found.figure.value, 30 / 20)
        self.assertEqual(found.note, "`machpoint_plain_loop`")

    def test_parts_are_of_the_same_steps(self):
        executable = built(self, "machpoint_kernels")
        own = results.run(executable, TINY + [
            "--benchmark_filter=^apic/linear/1D/"])["context"]["revision"]
        name = ("any",)
        found = jobs.updates_and_parts(name, executable, own, "apic", 2,
                                       "ordered", 1000, 1)
        parts = {key: rate for key, rate in found.items() if key != name}
        self.assertIn(("part", "apic", "G2P"), parts)
        self.assertAlmostEqual(
            sum(1 / rate for rate in parts.values()) * found[name], 1,
            delta=.3) # medians, each of its own samples
        moved = jobs.counted_bytes(executable, own, ["apic"])
        self.assertGreater(moved["bytes", "apic", "G2P"], moved["bytes",])

    def test_sod_is_solved_to_an_error(self):
        with tempfile.TemporaryDirectory() as scratch:
            run = pathlib.Path(scratch) / "run"
            sets = jobs.sod_settings(MACHPOINT, 1.5e-2, [25, 50, 100], run)
            summary = jobs.scene(MACHPOINT, "sod", sets, 1, run)
            self.assertLessEqual(summary["errors"]["density"]["L1"], 1.5e-2)
            with self.assertRaises(jobs.Lacking):
                jobs.sod_settings(MACHPOINT, 1e-9, [25], run)

    def test_what_is_lacking_is_named_and_not_tried_again(self):
        session_type = program("speed").Session
        calls = []

        class Quiet:
            def probe(self, _):
                pass

        def lacking():
            calls.append(1)
            raise jobs.Lacking("pip install it")
        session = session_type(Quiet(), 0)
        session.run([jobs.Job(("a",), lacking), jobs.Job(("b",), lambda: 2),
                     jobs.Job(("c",), lambda: 3, rounds=1)], 3)
        self.assertEqual(len(calls), 1)
        self.assertEqual(session.lacking, {("a",): "pip install it"})
        self.assertEqual(session.figures, {("b",): [2, 2, 2], ("c",): [3]})

    def test_a_program_of_another_revision_is_an_error(self):
        executable = built(self, "machpoint_kernels")
        own = results.run(executable, TINY + [
            "--benchmark_filter=^apic/linear/1D/"])["context"]["revision"]
        case = ("apic", 2, "ordered", 100, 1)
        self.assertGreater(jobs.updates(executable, own, *case), 0)
        with self.assertRaisesRegex(SystemExit, f"of {own}, machpoint of new"):
            jobs.updates(executable, "new", *case)

    def test_a_busy_machine_is_not_called_quiet(self):
        seen = {"load_before": 0, "others": 0, "triad": 1e10,
                "triad_spread": 0, "median_spread": 0}
        self.assertIn("was quiet", machine.in_words(dict(seen, quiet=True)))
        self.assertIn("not quiet", machine.in_words(dict(seen, quiet=False)))
        self.assertAlmostEqual(machine.spread([1, 2, 3]), 1)


class OptionsTest(unittest.TestCase):

    def refused(self, name, *words):
        result = subprocess.run(
            [sys.executable, ROOT / name, *words], capture_output=True, text=True)
        self.assertEqual(result.returncode, 2, result.stderr)
        self.assertNotIn("Traceback", result.stderr)
        return result.stderr

    def test_a_page_shows_no_trials(self):
        before = page.PAGE.read_bytes()
        for name, words, reason in (
                ("speed", ["--fast"], "leave out --docs or --fast"),
                ("speed", ["--rounds", "2"], "at least 3 rounds, not 2"),
                ("speed", ["--dimensions", "2"], "or --dimensions"),
                ("sod_sweep", ["--largest", "2"], "or --largest"),
                ("sod_sweep", ["--cylinders", "0"], "or --cylinders"),
                ("sod_sweep", ["--seconds", ".1"], "or --seconds"),
                ("sod_sweep", ["--rounds", "1"], "at least 3 rounds, not 1"),
                ("performance", ["--rounds", "2"], "2 is no whole number of at least 3")):
            self.assertIn(reason, self.refused(name, *words, *(
                ["--docs"] if name != "performance" else [])))
        self.assertEqual(page.PAGE.read_bytes(), before)

    def test_wrong_options_are_named(self):
        for name, words, reason in (
                ("speed", ["--python", "/nonexistent"], "is no program"),
                ("speed", ["--build", "/nonexistent"], "is missing"),
                ("speed", ["--rounds", "0"], "at least 1"),
                ("sod_sweep", ["--threads", "0"], "at least 1"),
                ("sod_sweep", ["--seconds", "-5"], "no number above 0"),
                ("sod_sweep", ["--build", "/nonexistent"], "is not built"),
                ("performance", ["--python", "/nonexistent"],
                 "is no program")):
            self.assertIn(reason, self.refused(name, *words))

    def test_a_program_on_the_path_is_found_there(self):
        """A benchmark may start it from another folder."""
        parser = argparse.ArgumentParser()
        named.add_option(parser)
        parser.add_argument("--reference", type=options.program)
        path = f"{MACHPOINT.resolve().parent}:{os.environ['PATH']}"
        with unittest.mock.patch.dict(os.environ, PATH=path):
            found = parser.parse_args(["--machpoint", MACHPOINT.name,
                                       "--reference", MACHPOINT.name])
        for result in vars(found).values():
            self.assertEqual(pathlib.Path(result).resolve(), MACHPOINT.resolve())


class SweepTest(unittest.TestCase):

    def test_slope_and_what_is_off_it(self):
        points = [{"cells": [n], "step": 1e-6 * n ** 1.1}
                  for n in (100, 200, 2000, 20000, 200000)]
        points[1]["step"] = 1  # within the first decade
        slope, residual = sweep.fit(points)
        self.assertAlmostEqual(slope, 1.1)
        self.assertAlmostEqual(residual, 0)
        # Half as much again in the middle: a third of its logarithm is the line's.
        points[3]["step"] *= 1.5
        slope, residual = sweep.fit(points)
        self.assertAlmostEqual(slope, 1.1)
        self.assertAlmostEqual(residual, 1.5 ** (2 / 3) - 1)
        self.assertEqual(sweep.fit(points[:3]), (None, None))

    class Runner:
        """Pretends: a timed step takes as long as its cells say, the first as ten
        of them and a mean one to the end as two."""

        def __init__(self, name):
            self.name, self.ran = name, []

        def run(self, cells, steps=None, end=None):
            timed = bool(steps or end)
            steps = steps or (cells[0] // 10 if end else 2 * cells[0])
            self.ran.append((cells[0], steps))
            mean = 1e-5 * math.prod(cells) * (1 if timed else 2)
            seconds = {name: {"sum": 0} for name in sweep.program.ACTIVITIES}
            seconds["compute"]["sum"] = 1e-4 * math.prod(cells) + \
                mean * (steps - 1)
            summary = {"steps": steps, "particles_initial": 3 * cells[0],
                       "first_step_seconds": 1e-4 * math.prod(cells),
                       "final_time": 0.1,
                       "communication": {"seconds": seconds},
                       "peak_memory_bytes": 1000 * math.prod(cells)}
            return summary, sum(part["sum"] for part in seconds.values())

    def test_sizes_are_run_as_far_as_time_and_memory_allow(self):
        runner = self.Runner("sod")
        called = []
        points, reason = sweep.measure(
            runner, [(100,), (200,), (400,), (800,), (6400,), (160000,)], 3, 2.0,
            memory=lambda: 1.5e8, between=lambda: called.append(1))
        self.assertEqual(len(called), 3)
        self.assertEqual([p["steps"] for p in points], [41] * 5)
        for point in points:
            self.assertAlmostEqual(point["step"], 1e-5 * point["cells"][0])
            self.assertAlmostEqual(point["late"], 2)
        # 3.2 s for a run of the finest: that was enough.
        self.assertEqual([p["runs"] for p in points], [3, 3, 3, 3, 1])
        self.assertEqual([p["all_steps"] for p in points],
                         [200, 400, 800, 1600, 12800])
        self.assertEqual([p["measured"] for p in points],
                         [True, True, False, False, False])
        self.assertAlmostEqual(points[2]["seconds"], 4e-2 + 799 * 8e-3)
        self.assertIn("160000 cells and more need some 0.2 GB", reason)
        self.assertEqual([steps for n, steps in runner.ran if n == 100],
                         [41, 200, 41, 41])

    def test_the_cylinder_is_run_to_the_same_time(self):
        runner = self.Runner("cylinder_mach3")
        points, reason = sweep.measure(
            runner, [(100, 50), (200, 100), (400, 200), (800, 400)], 2, 10.0,
            memory=lambda: math.inf)
        self.assertEqual([p["steps"] for p in points], [10, 20, 40])
        # Eight times as long for each: .95, 5.8, 39.2 and more than six times 10.
        self.assertIn("800 x 400 cells and more need some 314 s a run", reason)

    def test_a_sweep_of_sod(self):
        with tempfile.TemporaryDirectory() as scratch:
            scratch = pathlib.Path(scratch)
            mine = scratch / "run" / "mine.txt"
            mine.parent.mkdir()
            mine.write_text("kept")
            code = subprocess.run(
                [sys.executable, ROOT / "sod_sweep", "--build",
                 f"here={MACHPOINT.parent}", "--seconds", "1", "--rounds", "2",
                 "--largest", "5", "--cylinders", "0", "--threads", "1", "--output",
                 scratch], check=True, capture_output=True, text=True)
            self.assertIn("slope", code.stdout)
            record = json.loads((scratch / "results.json").read_text())
            points = record["lines"]["sod, here"]
            self.assertEqual([p["cells"] for p in points],
                             [[100 * 2 ** k] for k in range(6)])
            self.assertEqual(points[0]["runs"], 2)
            self.assertEqual(list(record["revisions"]), ["here"])
            self.assertTrue((scratch / "sod_sweep.png").exists())
            self.assertEqual(mine.read_text(), "kept")

    def test_builds_of_one_name_are_refused_and_revisions_told(self):
        build = MACHPOINT.parent
        result = subprocess.run(
            [sys.executable, ROOT / "sod_sweep", "--build", build, "--build",
             build], capture_output=True, text=True)
        self.assertEqual(result.returncode, 2)
        self.assertIn("are both called", result.stderr)
        record = {"revisions": {"a": "1", "b": "2"}, "processor": "", "threads": 1,
                  "rounds": 3, "slopes": {}, "lines": {}, "left_out": [],
                  "machine": {"quiet": True, "load_before": 0, "others": 0,
                              "median_spread": 0.01}}
        text = program("sod_sweep").section
        self.assertIn("a `1`, b `2`", text(record, False))
        record["revisions"]["b"] = "1"
        self.assertIn("Machpoint `1`", text(record, True))


class GpuCodeTest(unittest.TestCase):
    # What cuobjdump prints, shortened.
    KERNEL = ("void Kokkos::Impl::cuda_parallel_launch_local_memory<Kokkos::Impl::"
              "ParallelFor<Machpoint::{}(Machpoint::State<2> const&)::"
              "{{lambda(int)#{}}}, Kokkos::RangePolicy<Kokkos::Cuda> > >()")

    def test_kernels_are_known_by_their_functions(self):
        gpu_code = program("gpu_code")
        for function, number, expected in (
                ("Impl::gatherParticles<Machpoint::Quadratic, true, true, 2>", 2,
                 ("gatherParticles", "Quadratic, true, true, 2", 2)),
                ("Obstacle<2>::applyToGrid", 1, ("applyToGrid", "", 1)),
                ("Impl::drift<Machpoint::Slice<double, 32> >", 1,
                 ("drift", "Slice<double, 32> ", 1))):
            self.assertEqual(
                gpu_code.function_of(self.KERNEL.format(function, number)),
                expected)
        self.assertIsNone(gpu_code.function_of("void Kokkos::Impl::fill()"))
        # In a loop of ours the kernel is a part of the functor.
        self.assertEqual(
            gpu_code.function_of(
                "void run<Kokkos::Impl::ParallelFor<Machpoint::Impl::Shares<"
                "Machpoint::Impl::DepositTurns<Machpoint::Impl::PlacedPack<3>, "
                "Machpoint::Quadratic, 3, Machpoint::NodeScatter, "
                "Machpoint::Impl::DepositOfPlaced<"
                "Machpoint::Impl::depositParticles<Machpoint::Quadratic, 3, "
                "Machpoint::NodeScatter>(Machpoint::State<3> const&)::"
                "{lambda(Machpoint::Pack, Machpoint::Stencil<Machpoint::"
                "Quadratic, 3, double> const&)#1}> >, Kokkos::Cuda> >()"),
            ("depositParticles", "Quadratic, 3, NodeScatter", 1))

    def test_resources_and_opcodes(self):
        gpu_code = program("gpu_code")
        self.assertEqual(
            gpu_code.resources("Resource usage:\n Function _Zk:\n  REG:72 "
                               "STACK:216 SHARED:0 LOCAL:0\n"),
            {"_Zk": (72, 216)})
        counts = gpu_code.instructions([
            "\t\tFunction : _Zk\n",
            "        /*0000*/                   LDC R1, c[0x0][0x28] ;  /* 0x0 */\n",
            "                                                      /* 0x000 */\n",
            "        /*0010*/              @!P0 LDG.E.128 R4, [R2.64] ;\n",
            "        /*0020*/                   LDG.E.64 R4, [R2.64] ;\n"])
        self.assertEqual(counts, {"_Zk": {"LDC": 1, "LDG.E.128": 1,
                                          "LDG.E.64": 1}})
        self.assertEqual(gpu_code.total(counts["_Zk"], "LDG"), 2)

    def refusal(self, code):
        """What is said of a build with one kernel."""
        gpu_code = program("gpu_code")
        with tempfile.TemporaryDirectory() as build:
            for name in ("machpoint", "revision.cpp", "CMakeCache.txt"):
                (pathlib.Path(build) / name).touch()
            words = ["gpu_code", "--build", build, "--cuobjdump", sys.executable]
            bare = [("gridVelocity", "2", 1, gpu_code.Code(*code))]
            with unittest.mock.patch.object(gpu_code, "read", lambda *_: bare), \
                    unittest.mock.patch.object(gpu_code, "made_of",
                                               lambda _: ("", "double")), \
                    unittest.mock.patch("sys.argv", words), \
                    contextlib.redirect_stderr(io.StringIO()) as said, \
                    self.assertRaises(SystemExit) as end:
                gpu_code.main()
        self.assertEqual(end.exception.code, 2)
        return said.getvalue()

    def test_a_build_without_machine_code_is_an_error(self):
        self.assertIn("needs nvdisasm", self.refusal((32, 0, {})))

    def test_a_build_without_optimisation_is_an_error(self):
        self.assertIn("build it with optimisation", self.refusal((0, 0, {"LDC": 1})))

    def test_registers_bound_the_warps(self):
        gpu_code = program("gpu_code")
        # The occupancy table of compute capability 9.0.
        for registers, warps in ((24, 64), (32, 64), (40, 48), (64, 32),
                                 (128, 16), (168, 12), (255, 8)):
            self.assertEqual(gpu_code.warps(registers), warps)

    def test_local_memory_in_a_step_is_reported(self):
        gpu_code = program("gpu_code")
        kernels = [("gridVelocity", "2", 1, gpu_code.Code(32, 0, {})),
                   ("gatherParticles", "Quadratic, 2", 1,
                    gpu_code.Code(56, 216, {"LDL.64": 3})),
                   ("gatherParticles", "Quadratic, 3", 1,
                    gpu_code.Code(56, 216, {})),
                   ("sumParticles", "2", 1, gpu_code.Code(167, 1344, {}))]
        text, local = gpu_code.section(kernels)
        self.assertEqual(local, [kernels[1]])
        self.assertIn("| G2P of `conservative` | `Quadratic, 2`, 1 | 56 | 36 | "
                      "216 | 3 |", text)
        self.assertIn("`sumParticles`.", text)
        # With all registers that launch bounds leave it.
        for size, wrong in ((104, 0), (300, 1)):
            kernels[1:] = [("gatherParticles", "Quadratic, 2", 1,
                            gpu_code.Code(128, size, {}))]
            self.assertEqual(len(gpu_code.section(kernels)[1]), wrong, size)

    def test_doubles_in_single_precision_are_reported(self):
        gpu_code = program("gpu_code")
        def kernel(name, opcode):
            return (name, "2", 1, gpu_code.Code(32, 0, {opcode: 1}))
        kernels = [kernel("gridVelocity", "DFMA"),
                   kernel("measureMotion", "F2F.F64.F32"),
                   kernel("applyPressure", "FFMA"),
                   kernel("gridToParticlesApic", "F2I.TRUNC.NTZ"),
                   kernel("sumParticles", "DADD")]
        self.assertEqual(gpu_code.section(kernels)[1], [])
        self.assertEqual(gpu_code.section(kernels, "single")[1], kernels[:2])


class PageTest(unittest.TestCase):

    def test_a_section_is_replaced_between_its_markers(self):
        text = "a\n<!-- x -->\nold\n<!-- end of x -->\nb\n"
        self.assertEqual(page.replaced(text, "x", "new\n"),
                         "a\n<!-- x -->\nnew\n<!-- end of x -->\nb\n")
        with self.assertRaises(SystemExit):
            page.replaced(text, "y", "new")
        page.require("speed", "kernels", "sod_sweep", "precision", "gpu code")

    def test_a_place_is_looked_for_before_anything_is_measured(self):
        with tempfile.TemporaryDirectory() as scratch:
            empty = pathlib.Path(scratch) / "accuracy.md"
            empty.touch()
            accuracy = program("accuracy")
            words = ["accuracy", "--docs", "--machpoint", str(MACHPOINT),
                     "--output", scratch]
            with unittest.mock.patch.object(accuracy, "PAGE", empty), \
                    unittest.mock.patch.object(accuracy, "run") as run, \
                    unittest.mock.patch("sys.argv", words), \
                    self.assertRaisesRegex(SystemExit, "no place for it"):
                accuracy.main()
            run.assert_not_called()
        page.require(*(f"study {name}" for name in accuracy.STUDIES), "studies",
                     "advice", path=accuracy.PAGE)


if __name__ == "__main__":
    unittest.main()
