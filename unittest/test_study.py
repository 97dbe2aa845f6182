"""machpoint study: rows, resuming, failures, wrong studies, advice.

The executable comes from MACHPOINT_EXECUTABLE. Studies here take few cells, so
that a run takes hundredths of a second; what they measure is not under test.
"""

import csv
import fcntl
import json
import math
import os
import pathlib
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import unittest
import unittest.mock

import running
from running import (FINISHED, IO_FAILURE, NUMERICAL_FAILURE, ONE_THREAD,
                     STOPPED_EARLY, WRONG_INPUT)

EXECUTABLE = os.path.abspath(os.environ["MACHPOINT_EXECUTABLE"])
INPUTS = pathlib.Path(__file__).resolve().parent.parent / "input"
PLOT = INPUTS.parent / "tools/plot.py"


class StudyTest(unittest.TestCase):

    def setUp(self):
        scratch = tempfile.TemporaryDirectory()
        self.addCleanup(scratch.cleanup)
        self.directory = pathlib.Path(scratch.name)
        self.output = self.directory / "out"

    def write(self, **keys):
        """A study of the Sod tube."""
        study = {"study": "tiny", "input": str(INPUTS / "sod.json"), **keys}
        path = self.directory / "study.json"
        path.write_text(json.dumps(study))
        return path

    def command(self, path, *arguments):
        return [EXECUTABLE, "study", str(path), "--output", str(self.output),
                *arguments]

    def study(self, path, *arguments, code=FINISHED):
        result = subprocess.run(self.command(path, *arguments),
                                stdin=subprocess.DEVNULL, capture_output=True,
                                text=True, timeout=120, env=ONE_THREAD)
        self.assertEqual(result.returncode, code,
                         result.stdout + result.stderr)
        return result

    def result(self):
        return json.loads((self.output / "study.json").read_text())


MATRIX = [{"method.name": ["conservative", "apic"],
           "grid.cells": [[20], [40]]}]


class Rows(StudyTest):

    def test_rows_laws_and_front(self):
        shown = self.study(self.write(vary=MATRIX, repeats=2)).stdout
        study = self.result()
        rows = study["rows"]
        self.assertEqual([(r["line"], r["cells"]) for r in rows],
                         [("conservative", [20]), ("conservative", [40]),
                          ("apic", [20]), ("apic", [40])])
        for row in rows:
            self.assertEqual(row["status"], "finished")
            self.assertEqual(len(row["wall_rounds"]), 2)
            self.assertEqual(len(row["cpu_rounds"]), 2)
            self.assertAlmostEqual(row["seconds"], sum(row["wall_rounds"]) / 2)
            self.assertGreater(row["particle_updates"], row["steps"] * 50)
            self.assertGreater(row["memory_bytes"], 1e6)
            # The run's own summary says the same.
            summary = json.loads(
                (self.output / "runs" / row["id"] / "summary.json").read_text())
            self.assertEqual(summary["cells"], row["cells"])
            self.assertEqual(summary["errors"]["density"]["L1"],
                             row["errors"]["density.L1"])
        coarse, fine = (r["errors"]["density.L1"] for r in rows[:2])
        law = study["laws"][0]
        self.assertAlmostEqual(law["order"], math.log2(coarse / fine))
        seconds = [r["seconds"] for r in rows[:2]]
        self.assertAlmostEqual(law["time_exponent"],
                               math.log2(seconds[1] / seconds[0]))
        self.assertAlmostEqual(
            law["halving_takes"],
            2**(law["time_exponent"] / law["order"]))
        self.assertIn("halving this error takes", shown)
        front = [r for r in rows if r["id"] in study["pareto"]]
        self.assertTrue(front)
        for row in front:
            self.assertFalse(any(
                other["seconds"] < row["seconds"] and
                other["errors"]["density.L1"] < row["errors"]["density.L1"]
                for other in rows))
        with open(self.output / "study.csv") as file:
            table = list(csv.DictReader(file))
        self.assertEqual([float(r["density.L1"]) for r in table],
                         [r["errors"]["density.L1"] for r in rows])
        self.assertEqual([r["grid.cells"] for r in table],
                         ["[20]", "[40]", "[20]", "[40]"])

    def test_lines_have_names_of_their_own(self):
        # Pressures of the left and of the right, of the same numbers.
        path = self.write(repeats=1, reference={"type": "finer"}, vary=[
            {"initial.0.left.pressure": [2], "grid.cells": [[10], [40]]},
            {"initial.0.right.pressure": [2], "grid.cells": [[20], [80]]}])
        self.study(path)
        rows = self.result()["rows"]
        self.assertEqual([row["line"] for row in rows],
                         2 * ["initial.0.left.pressure=2"] +
                         2 * ["initial.0.right.pressure=2"])
        for coarse, fine in (rows[:2], rows[2:]):
            self.assertEqual(coarse["compared_to"], fine["id"])
            self.assertNotIn("compared_to", fine)
        self.assertEqual(len(self.result()["laws"]), 2)
        # A finest grid is compared to nothing, whatever was before.
        path = self.write(repeats=1, reference={"type": "finer"}, vary=[
            {"initial.0.left.pressure": [2], "grid.cells": [[10], [20], [40]]}])
        self.study(path)
        path = self.write(repeats=1, reference={"type": "finer"}, vary=[
            {"initial.0.left.pressure": [2], "grid.cells": [[10], [20]]}])
        self.study(path)
        self.assertNotIn("compared_to", self.result()["rows"][1])

    def test_directories_of_others_are_refused(self):
        # Those of a run, and of studies of another name or kind.
        self.output.mkdir()
        (self.output / "summary.json").write_text("{}")
        path = self.write(vary=MATRIX, repeats=1)
        shown = self.study(path, code=IO_FAILURE).stderr
        self.assertIn(f"{self.output}: holds another run (summary.json exists); "
                      "choose another directory", shown)
        self.assertEqual([p.name for p in self.output.iterdir()], ["summary.json"])
        (self.output / "summary.json").unlink()
        self.study(path)
        before = self.result()
        for other in ({"study": "other", "vary": MATRIX}, {"kind": "effects"}):
            path = self.write(repeats=1, **other)
            shown = self.study(path, code=IO_FAILURE).stderr
            self.assertIn(f'{self.output}: holds another study ("tiny" of kind accuracy)',
                          shown)
            self.assertEqual(self.result(), before)

    def test_a_path_that_leads_nowhere_is_named(self):
        self.output.mkdir()
        (self.output / "study.json").symlink_to("study.json")
        result = self.study(
            self.write(vary=[{"grid.cells": [[100]]}]), code=IO_FAILURE)
        self.assertEqual(
            result.stderr, f"machpoint: {self.output / 'study.json'}: Too many "
            "levels of symbolic links\n")

    def test_a_run_does_not_take_a_studys_directory(self):
        self.study(self.write(vary=MATRIX, repeats=1))
        before = sorted(self.output.iterdir())
        for option in ([], ["--overwrite"]):
            run = subprocess.run(
                [EXECUTABLE, "run", str(INPUTS / "sod.json"), "--output",
                 str(self.output), *option],
                capture_output=True, text=True, timeout=120, env=ONE_THREAD)
            self.assertEqual(run.returncode, IO_FAILURE, run.stdout + run.stderr)
            self.assertIn(f"{self.output}: holds a study (study.csv exists); choose "
                          "another directory", run.stderr)
            self.assertEqual(sorted(self.output.iterdir()), before)

    def test_what_met_no_memory_is_tried_again(self):
        path = self.write(vary=MATRIX, repeats=1)
        self.study(path)
        study = self.result()
        study["rows"][0].update(status="failed", exit_code=WRONG_INPUT,
                                message="out of memory")
        (self.output / "study.json").write_text(json.dumps(study))
        self.study(path)
        self.assertEqual(self.result()["rows"][0]["status"], "finished")

    def test_a_run_on_more_threads_is_another_one(self):
        # KOKKOS_NUM_THREADS comes before OMP_NUM_THREADS.
        path = self.write(vary=[{"grid.cells": [[20]]}], repeats=1)
        made = set()
        for variables, runs in [({"KOKKOS_NUM_THREADS": "1"}, 1),
                                ({"OMP_NUM_THREADS": "1"}, 1),
                                ({"KOKKOS_NUM_THREADS": "2"}, 2)]:
            with self.subTest(**variables), unittest.mock.patch.dict(
                    ONE_THREAD, variables):
                self.study(path)
                made.add(self.result()["rows"][0]["id"])
                self.assertEqual(len(made), runs)
                kept = list(self.output.glob("runs/*/summary.json"))
                self.assertEqual(len(kept), runs)

    def test_finite_volumes_beside_particles(self):
        path = self.write(vary=[{"grid.cells": [[40]]},
                                {"solver": ["finite_volume"],
                                 "grid.cells": [[20], [40]]}], repeats=1)
        if not pathlib.Path(EXECUTABLE).with_name("machpoint_reference").exists():
            # Built without benchmarks.
            self.assertIn("/vary/1/solver/0: machpoint_reference is missing",
                          self.study(path, code=WRONG_INPUT).stderr)
            return
        shown = self.study(path, "--target", "density.L1=1e-1").stdout
        ours, coarse, fine = self.result()["rows"]
        self.assertEqual([r["line"] for r in (ours, coarse, fine)],
                         ["tiny", "finite_volume", "finite_volume"])
        self.assertEqual([r["status"] for r in (ours, coarse, fine)],
                         ["finished"] * 3)
        self.assertNotEqual(ours["id"], fine["id"])
        self.assertGreater(ours["particles"], 0)
        self.assertEqual(fine["particles"], 0)
        self.assertGreater(fine["memory_bytes"], 1e6)
        summary = json.loads((self.output / "runs" / fine["id"] /
                              "summary.json").read_text())
        self.assertEqual(summary["method"], "muscl_hllc")
        self.assertEqual(summary["errors"]["density"]["L1"],
                         fine["errors"]["density.L1"])
        # Second order in space, with a shock: between first order and none.
        self.assertLess(fine["errors"]["density.L1"],
                        0.75 * coarse["errors"]["density.L1"])
        # Advice is about settings of Machpoint.
        self.assertIn("the fastest run is tiny", shown.replace("\n", " "))

    def test_probes(self):
        # Sod's shock stands at 0.5 + 1.7522 t; gas ahead of it has not heard
        # of it. The second of two outputs is the second half of the run.
        def probe(kind, name, **keys):
            return {"type": kind, "name": name, **keys}
        line = {"from": [1], "to": [0]}
        known = {"shock.distance": 0.5 - 1.7522 * 0.2, "ahead.pressure": 0.1,
                 "most.density": 1}
        path = self.write(
            vary=[{"grid.cells": [[80]]}], repeats=1,
            probes=[probe("crossing", "shock", value=0.2, **line),
                    probe("crossing", "nowhere", value=7, **line),
                    probe("maximum", "most", **line),
                    probe("point", "ahead", field="pressure", at=[0.95])],
            error="shock.distance",
            reference={"type": "known", "values": known})
        self.study(path)
        row, = self.result()["rows"]
        self.assertEqual(set(row["errors"]), set(known))
        for name, value in known.items():
            self.assertAlmostEqual(row["values"][name], value, delta=0.02)
            self.assertAlmostEqual(row["errors"][name],
                                   abs(row["values"][name] - value))
        self.assertIsNone(row["values"]["nowhere.distance"])

    def test_a_failing_run_is_a_row(self):
        # Without a retry, such a step breaks the gas at once.
        path = self.write(vary=[{"time.cfl": [0.4, 50], "grid.cells": [[20]]}],
                          set={"time.retries": 1}, repeats=2)
        shown = self.study(path).stdout
        good, bad = self.result()["rows"]
        self.assertEqual(good["status"], "finished")
        self.assertEqual(bad["status"], "failed")
        self.assertEqual(bad["exit_code"], NUMERICAL_FAILURE)
        self.assertEqual(bad["wall_rounds"], [])
        self.assertIn("the gas broke down", bad["message"])
        self.assertIn("failed: the gas broke down", shown)

    def test_runs_do_not_believe_in_a_launcher(self):
        # A run that did would look for its launcher, and fail.
        path = self.write(vary=[{"grid.cells": [[20]]}], repeats=1)
        mpiexec = os.environ.get("MACHPOINT_MPIEXEC")
        if not mpiexec:
            self.skipTest("this build has no MPI")
        result = subprocess.run(
            [mpiexec, "-n", "1", *self.command(path)], capture_output=True,
            text=True, timeout=120, stdin=subprocess.DEVNULL, env=ONE_THREAD)
        self.assertEqual(result.returncode, FINISHED, result.stderr)
        self.assertEqual(self.result()["rows"][0]["status"], "finished")

    def test_all_failing(self):
        path = self.write(vary=[{"time.cfl": [50], "grid.cells": [[20]]}],
                          set={"time.retries": 1})
        self.study(path, code=NUMERICAL_FAILURE)

    def test_next_finer_run_as_reference(self):
        path = self.write(vary=[{"grid.cells": [[80], [20], [40]]}],
                          reference={"type": "finer"}, repeats=1)
        self.study(path)
        rows = {r["cells"][0]: r for r in self.result()["rows"]}
        self.assertEqual(rows[20]["compared_to"], rows[40]["id"])
        self.assertEqual(rows[40]["compared_to"], rows[80]["id"])
        self.assertNotIn("errors", rows[80])
        self.assertGreater(rows[20]["errors"]["density.L1"],
                           rows[40]["errors"]["density.L1"])

    def test_one_run_as_reference(self):
        path = self.write(vary=[{"grid.cells": [[20], [40]]}], repeats=1,
                          reference={"type": "run",
                                     "set": {"grid.cells": [40]}})
        self.study(path)
        coarse, same = self.result()["rows"]
        self.assertGreater(coarse["errors"]["density.L1"], 1e-3)
        self.assertEqual(same["errors"], {}) # it is the reference itself

    def test_runs_are_judged_anew_by_another_yardstick(self):
        """Runs are those of before, their errors as of a study of its own."""
        probes = [{"type": "point", "name": "p", "at": [0.4]}]
        last = {"type": "run", "set": {"grid.cells": [80]}}
        known = {"type": "known", "values": {"p.density": 0.7}}
        used = self.output
        for k, (reference, error) in enumerate([
                (last, "density.L1"), ({"type": "finer"}, "density.L1"),
                ({"type": "exact"}, "density.L1"), ({"type": "finer"}, "p.density"),
                (known, "p.density")]):
            path = self.write(vary=[{"grid.cells": [[10], [20], [40]]}],
                              probes=probes, repeats=1, reference=reference,
                              error=error)
            with self.subTest(reference=reference, error=error):
                self.study(path)
                rows = self.result()["rows"]
                made = {row["id"]: row["wall_rounds"] for row in rows}
                if k > 0:
                    self.assertEqual(made, before)
                before = made
                self.output = self.directory / f"alone{k}"
                self.study(path)
                alone = self.result()["rows"]
                self.output = used
                self.assertEqual([row.get("errors") for row in rows],
                                 [row.get("errors") for row in alone])

    def test_a_run_is_compared_in_each_round(self):
        """So what a round that was interrupted left does not count."""
        vary = [{"grid.cells": [[10], [20]]}]
        self.study(self.write(vary=vary, repeats=1, reference={"type": "finer"}))
        study = self.result()
        right = study["rows"][0]["errors"]
        study["rows"][0]["errors"] = {"density.L1": 7}
        (self.output / "study.json").write_text(json.dumps(study))
        self.study(self.write(vary=vary, repeats=2, reference={"type": "finer"}))
        self.assertEqual(self.result()["rows"][0]["errors"], right)

    def test_another_error_of_exact_states_repeats_no_run(self):
        rounds = []
        for error in "density.L1", "pressure.L1":
            self.study(self.write(vary=[{"grid.cells": [[10], [20]]}], repeats=1,
                                  error=error))
            rounds.append([row["wall_rounds"] for row in self.result()["rows"]])
        self.assertEqual(*rounds)

    def test_runs_that_are_gone_are_made_anew(self):
        probes = [{"type": "point", "name": "p", "at": [0.4]}]
        for reference in {"type": "finer"}, {"type": "known",
                                             "values": {"p.density": 0.7}}:
            path = self.write(vary=[{"grid.cells": [[10], [20]]}], repeats=1,
                              probes=probes, reference=reference, error="p.density")
            self.study(path)
            for row in self.result()["rows"]:
                self.assertEqual(row["status"], "finished")
            shutil.rmtree(self.output / "runs")

    def test_runs_without_fields_are_made_anew_to_compare(self):
        reference = {"type": "finer"}
        self.study(self.write(vary=[{"grid.cells": [[10], [20]]}], repeats=1,
                              reference=reference))
        shutil.rmtree(self.output / "runs")
        shown = self.study(self.write(vary=[{"grid.cells": [[10], [20]]}],
                                      repeats=1, reference=reference)).stderr
        self.assertNotIn("round", shown) # nothing is left to compare
        shown = self.study(self.write(vary=[{"grid.cells": [[10], [20], [40]]}],
                                      repeats=1, reference=reference)).stderr
        self.assertEqual(shown.count("round 1 of 1"), 2) # not the coarsest
        rows = {row["cells"][0]: row for row in self.result()["rows"]}
        self.assertEqual(rows[20]["compared_to"], rows[40]["id"])
        self.assertEqual(rows[10]["compared_to"], rows[20]["id"])

    def test_proofs_are_of_the_reference(self):
        probes = [{"type": "point", "name": "p", "at": [0.4]}]
        for value, proofs in (0.7, 1), (0.7, 1), (0.8, 0):
            path = self.write(vary=[{"grid.cells": [[20], [40]]}], probes=probes,
                              repeats=1, error="p.density",
                              reference={"type": "known",
                                         "values": {"p.density": value}})
            advice = [] if self.output.exists() else ["--budget", "9s"]
            self.study(path, *advice)
            self.assertEqual(len(self.result()["proofs"]), proofs)

    def test_checkpoints_of_the_scene_are_not_the_runs(self):
        scene = json.loads((INPUTS / "sod.json").read_text())
        scene["checkpoint"] = {"every_steps": 1}
        (self.directory / "scene.json").write_text(json.dumps(scene))
        self.study(self.write(input="scene.json", vary=[{"grid.cells": [[20]]}],
                              repeats=1))
        self.assertEqual(list(self.output.rglob("checkpoints")), [])

    def test_what_an_older_program_told_less_of_is_made_anew(self):
        path = self.write(vary=[{"grid.cells": [[10], [20]]}], repeats=1)
        self.study(path)
        study = self.result()
        del study["rows"][0]["memory_bytes"]
        (self.output / "study.json").write_text(json.dumps(study))
        kept = self.study(path).stderr.count("round 1 of 1")
        self.assertEqual(kept, 1)  # of two
        self.assertGreater(self.result()["rows"][0]["memory_bytes"], 0)


class Advice(StudyTest):

    def test_target_and_out_of_reach(self):
        path = self.write(vary=[{"grid.cells": [[20], [40]]}], repeats=1)
        target = 0.02  # what some 30 cells reach
        self.study(path, "--target", f"density.L1={target}")
        proof = self.result()["proofs"][-1]
        self.assertEqual(proof["request"], "density.L1=0.02")
        self.assertLessEqual(proof["value"], target)
        self.assertGreater(proof["predicted"]["seconds"], 0)
        shown = self.study(path, "--target", "density.L1=1e-9",
                           code=NUMERICAL_FAILURE).stdout
        self.assertIn("out of reach", shown)
        shown = self.study(path, "--budget", "1h").stdout
        self.assertIn("more time is left", shown)
        self.assertEqual(self.result()["proofs"][-1]["row"]["cells"], [80])
        shown = self.study(path, "--budget", "1e-9s",
                           code=NUMERICAL_FAILURE).stdout
        self.assertIn("out of reach", shown)

    def test_an_error_that_falls_too_fast_is_no_law(self):
        def study(value, *advice):
            known = {"shock.distance": value}
            return self.study(self.write(
                vary=[{"grid.cells": [[20], [40]]}], repeats=1,
                probes=[{"type": "crossing", "name": "shock", "value": 0.2,
                         "from": [1], "to": [0]}],
                error="shock.distance",
                reference={"type": "known", "values": known}), *advice).stdout
        study(0)
        coarse, fine = (row["values"]["shock.distance"]
                        for row in self.result()["rows"])
        # Errors that are 16 times apart would be a scheme of fourth order.
        shown = study(fine - (coarse - fine) / 15, "--budget", "1h")
        self.assertIn("too coarse for a law, and finer ones are expected to be "
                      "no better: tiny (h^4.0)", shown)
        self.assertIn("a fall too fast for a scheme of second order", shown)
        law, = self.result()["laws"]
        self.assertAlmostEqual(law["order"], 4)
        self.assertIsNone(law["halving_takes"])
        # The most accurate run is one that is known, not one twice as fine.
        proof, = self.result()["proofs"]
        self.assertEqual(proof["row"]["cells"], [40])
        self.assertAlmostEqual(proof["predicted"]["error"] / proof["value"], 1)
        # Of second order it is one that is finer.
        shown = study(fine - (coarse - fine) / 3, "--budget", "1h")
        self.assertNotIn("too coarse for a law", shown)
        self.assertEqual(self.result()["proofs"][-1]["row"]["cells"], [80])

    def test_what_cannot_be_asked(self):
        path = self.write(vary=MATRIX)
        for arguments, text in [
            (["--target", "densty.L1=1"], 'did you mean "density.L1"?'),
            (["--target", "density.L1"], "NAME=VALUE"),
            (["--target", "density.L1=-1"], "NAME=VALUE"),
            (["--target", "density.L1=0x1"], "NAME=VALUE"),
            (["--budget", "0x10s"], "20s, 3min or 1h"),
            (["--budget", "3d"], "20s, 3min or 1h")]:
            with self.subTest(arguments=arguments):
                shown = self.study(path, *arguments, code=WRONG_INPUT).stderr
                self.assertIn(text, shown)
                self.assertFalse(self.output.exists())


class Interrupted(StudyTest):

    def interrupt(self, number):
        """Signals a study in its second run, which would take minutes."""
        path = self.write(vary=[{"time.end": [0.01, 0.2],
                                 "grid.cells": [[20], [20000]]}], repeats=1)
        process = running.start(self, self.command(path), ONE_THREAD)
        running.wait_for(self, process, 2, self.output, "runs/*.json")
        time.sleep(0.2)
        process.send_signal(signal.SIGUSR1) # asks for a checkpoint, of a run
        process.send_signal(number)
        process.wait(timeout=60)
        return process

    def test_stopped_by_a_signal(self):
        for number in [signal.SIGINT, signal.SIGTERM]:
            with self.subTest(signal=number):
                self.output = self.directory / number.name
                process = self.interrupt(number)
                self.assertEqual(process.returncode, STOPPED_EARLY)
                self.assertEqual([r["status"] for r in self.result()["rows"]],
                                 ["finished"] + 3 * ["waiting"])

    def test_resumes_without_repeating(self):
        matrix = [{"grid.cells": [[20], [30], [40]]}]
        path = self.write(vary=[{"grid.cells": [[20], [30]]}], repeats=1)
        self.study(path)
        before = self.result()["rows"]
        # As a kill leaves it: a row is missing and another one half done.
        study = self.result()
        study["rows"][1].update(status="waiting", wall_rounds=[],
                                cpu_rounds=[])
        (self.output / "study.json").write_text(json.dumps(study))
        stamp = self.summary(before[0]).stat().st_mtime_ns
        other = self.summary(before[1]).stat().st_mtime_ns
        path = self.write(vary=matrix, repeats=1)
        lines = self.study(path).stderr.splitlines()
        self.assertEqual(len(lines), 2, lines)
        after = self.result()["rows"]
        self.assertEqual([r["status"] for r in after], 3 * ["finished"])
        self.assertEqual(after[0], before[0])
        self.assertEqual(self.summary(before[0]).stat().st_mtime_ns, stamp)
        self.assertGreater(self.summary(before[1]).stat().st_mtime_ns, other)
        # Both clocks are kept, so another one repeats nothing.
        self.assertEqual(self.study(path, "--clock", "processor").stderr, "")
        row = self.result()["rows"][0]
        self.assertEqual(row["seconds"], row["cpu_rounds"][0])
        # All is there: nothing is run, and more rounds run what they add.
        self.assertEqual(self.study(path).stderr, "")
        path = self.write(vary=matrix, repeats=2)
        self.assertEqual(len(self.study(path).stderr.splitlines()), 3)

    def summary(self, row):
        return self.output / "runs" / row["id"] / "summary.json"

    def test_killed(self):
        # Kills the study but not its run, which then ends by itself: without
        # minutes of work, so that it does so soon.
        cells = [[n] for n in range(20, 120, 2)]
        path = self.write(vary=[{"grid.cells": cells}], repeats=1)
        process = subprocess.Popen(self.command(path), env=ONE_THREAD,
                                   stdin=subprocess.DEVNULL,
                                   stdout=subprocess.DEVNULL,
                                   stderr=subprocess.PIPE, text=True)
        for _ in range(3):
            process.stderr.readline()
        process.kill()
        process.communicate()
        done = [r for r in self.result()["rows"] if r["status"] == "finished"]
        self.assertGreaterEqual(len(done), 3)
        self.assertLess(len(done), len(cells))
        time.sleep(1)  # the orphan's
        path = self.write(vary=[{"grid.cells": cells[:len(done) + 1]}],
                          repeats=1)
        lines = self.study(path).stderr.splitlines()
        self.assertEqual(len(lines), 1)
        self.assertEqual(self.result()["rows"][:len(done)], done)

    def test_a_broken_study_json_is_kept(self):
        path = self.write(vary=MATRIX)
        self.output.mkdir()
        file = self.output / "study.json"
        for text in ["mine", "[]", "{}"]:
            file.write_text(text)
            result = self.study(path, code=IO_FAILURE)
            self.assertIn(str(file), result.stderr)
            self.assertEqual(file.read_text(), text)

    def test_two_studies_do_not_share_a_directory(self):
        path = self.write(vary=MATRIX)
        self.output.mkdir()
        held = os.open(self.output, os.O_RDONLY)
        fcntl.flock(held, fcntl.LOCK_EX)
        result = self.study(path, code=IO_FAILURE)
        self.assertIn(f"{self.output}: another run or study", result.stderr)
        os.close(held)
        self.study(path)


class Wrong(StudyTest):

    def assertSays(self, path, *texts):
        errors = self.study(path, code=WRONG_INPUT).stderr
        for text in texts:
            self.assertIn(text, errors)
        self.assertFalse(self.output.exists())
        return errors.splitlines()

    def test_all_errors_at_once(self):
        path = self.write(
            inptu=1, repeats=0, error="densty.L1", set={"time.cfll": 1},
            vary=[{"method.nam": ["apic"], "grid.cells": [[20], [2, 2], 7]},
                  {"grd.cells": [[20]], "physics[1].linear": ["x"]}])
        lines = self.assertSays(
            path, '/inptu: unknown key; did you mean "input"?', "/repeats: must",
            '/error: expected', 'did you mean "density.L1"?',
            "/set/time.cfll", 'did you mean "cfl"?',
            "/vary/0/method.nam/0", 'did you mean "name"?',
            "/vary/0/grid.cells/1: ", "/vary/0/grid.cells/2: ",
            "/vary/1/grd.cells/0", 'did you mean "grid"?',
            "/vary/1/physics[1].linear/0: ")
        self.assertEqual(len(lines), 9)
        # A key given twice hides none of them.
        path.write_text(path.read_text().replace('"repeats": 0',
                                                 '"repeats": 0, "repeats": 1'))
        self.assertEqual(len(self.assertSays(path, "/repeats: given twice")), 10)

    def test_shapes(self):
        for keys, place in [
            ({}, "/vary: missing"), ({"vary": []}, "/vary: expected"),
            ({"vary": [3]}, "/vary/0: expected"),
            ({"vary": [{}]}, "/vary/0: expected"),
            ({"vary": [{"time.cfl": 0.3}]}, "/vary/0/time.cfl: expected"),
            ({"vary": MATRIX, "set": [1]}, "/set: expected"),
            ({"vary": MATRIX, "set": {"solver": "finite_volume"}},
             "/set/solver: runs choose their solver in vary"),
            ({"vary": MATRIX, "probes": [
                {"type": "point", "name": "p", "at": [0, 0]},
                {"type": "point", "name": "p", "at": [0]}]},
             "/probes/0/at: expected 1 number(s)"),
            ({"vary": MATRIX, "probes": 2 * [
                {"type": "point", "name": "p", "at": [0]}]},
             "/probes/1/name: is that of another probe"),
            # The domain is that of each run.
            ({"vary": MATRIX, "set": {"grid.upper": [0.9]}, "probes": [
                {"type": "point", "name": "p", "at": [0.95]}]},
             "/probes/0/at/0: 0.95 is outside the domain, which reaches from "
             "0 to 0.9"),
            ({"vary": MATRIX, "error": "p.density", "probes": [
                {"type": "point", "name": "p", "at": [0]}],
              "reference": {"type": "known"}}, "/reference/values: missing"),
            ({"vary": MATRIX, "error": "p.pressure"}, "/error: expected one of"),
            ({"vary": MATRIX, "error": "p.density",
              "probes": [{"type": "point", "name": "p", "at": [0]}],
              "reference": {"type": "known", "values": {"p.pressure": 1}}},
             "/reference/values: expected"),
            ({"vary": [{"solver": ["finite"]}]},
             "/vary/0/solver/0: expected one of machpoint, finite_volume"),
            ({"vary": MATRIX, "study": "a/b"}, "/study: "),
            ({"vary": MATRIX, "study": "a\nb"}, "/study: "),
            ({"vary": MATRIX, "study": 300 * "a"}, "/study: "),
            ({"vary": MATRIX, "probes": [
                {"type": "crossing", "name": "p", "value": 1, "from": [0.5],
                 "to": [0.5]}]}, "/probes/0/to: must be another place"),
            ({"vary": [{"output.grid": [False], "grid.cells": [[10], [20]]}],
              "reference": {"type": "finer"}}, "/output/grid: "),
            ({"vary": MATRIX, "input": "none.json"}, "none.json"),
            ({"vary": MATRIX, "reference": {"type": "run"}},
             "/reference/set: missing"),
            ({"vary": MATRIX, "reference": {"type": "fine"}},
             'did you mean "finer"?')]:
            with self.subTest(keys=keys):
                self.assertSays(self.write(**keys), place)

    def test_conflicts_name_the_run(self):
        path = self.write(vary=[{"method.name": ["apic", "conservative"],
                                 "method.time": ["midpoint"],
                                 "grid.cells": [[20], [1]]}])
        lines = self.assertSays(path, "method.name=apic", "/method/time: ",
                                "grid.cells=[1]: /grid/cells/0: ")
        self.assertEqual(len(lines), 4)

    def test_no_exact_solution(self):
        study = {"study": "x", "input": str(INPUTS / "cylinder_mach3.json"),
                 "vary": [{"grid.cells": [[20, 10]]}]}
        path = self.directory / "study.json"
        path.write_text(json.dumps(study))
        self.assertSays(path, "/reference: the scene names no exact solution")

    def test_shipped_studies_are_right(self):
        paths = sorted((INPUTS / "studies").glob("*.json"))
        self.assertGreaterEqual(len(paths), 7)
        for path in paths:
            with self.subTest(study=path.name):
                shown = self.study(path, "--dry-run").stdout
                self.assertRegex(shown, r"\d+ runs, \d+ time")
                self.assertFalse(self.output.exists())


class Effects(StudyTest):
    """A study of the kind effects."""

    def effects(self, **keys):
        path = self.write(kind="effects", repeats=1, **keys)
        shown = self.study(path).stdout
        return path, shown, self.result()

    def test_a_probe_that_finds_nothing(self):
        _, _, study = self.effects(
            set={"grid.cells": [20]}, error="front.distance",
            probes=[{"type": "crossing", "name": "front", "field": "density",
                     "from": [0.5], "to": [1.0], "value": 5}])
        for row in study["rows"][1:]:
            self.assertIsNone(row["errors"]["front.distance.change"])

    def test_each_effect_is_left_out_once(self):
        path, shown, study = self.effects(set={"grid.cells": [20]})
        whole, *others = study["rows"]
        self.assertEqual(whole["line"], "as it is")
        names = [entry["effect"] for entry in study["effects"]]
        # What the scene has, and nothing that it lacks.
        self.assertEqual(
            set(names),
            {"artificial_viscosity", "viscosity limiter", "loss return",
             "pressure relaxation", "heat mixing", "splitting", "retries",
             "all of them"})
        self.assertEqual([row["line"] for row in others],
                         ["without " + name for name in names])
        for row in study["rows"]:
            self.assertEqual(row["status"], "finished")
            summary = json.loads(
                (self.output / "runs" / row["id"] / "summary.json").read_text())
            self.assertEqual(row["kernels"], summary["kernels"])
            self.assertEqual(row["array_bytes"], summary["peak_array_bytes"])
            self.assertEqual(row["errors"]["density.L1"],
                             summary["errors"]["density"]["L1"])
        by_name = dict(zip(names, study["effects"]))
        for name, row in zip(names, others):
            entry = by_name[name]
            self.assertEqual(entry["id"], row["id"])
            for key in ["seconds", "kernels", "steps", "array_bytes"]:
                self.assertAlmostEqual(entry["price"][key],
                                       whole[key] - row[key])
            self.assertEqual(entry["result"]["density.L1"],
                             row["errors"]["density.L1"])
            self.assertIn(name, shown)
        # It works within P2G, and without it the shock rings.
        viscosity = by_name["artificial_viscosity"]
        self.assertIsNone(viscosity["own"])
        self.assertGreater(viscosity["result"]["density.change"], 1e-3)
        # Kernels and memory of others are gone with them.
        self.assertEqual(by_name["viscosity limiter"]["own"]["kernels"],
                         whole["steps"])
        self.assertGreater(by_name["heat mixing"]["own"]["kernels"], 0)
        self.assertGreater(by_name["pressure relaxation"]["own"]["bytes"], 0)
        self.assertGreater(
            by_name["pressure relaxation"]["price"]["array_bytes"], 0)
        # A step that needs no repetition is the same without a copy.
        self.assertEqual(by_name["retries"]["result"]["density.change"], 0)
        self.assertIsNone(by_name["loss return"]["own"])
        # All of it left out is the bare method.
        self.assertEqual(
            others[-1]["settings"]["physics"],
            [{"type": "ideal_gas", "gamma": 1.4}])
        # Nothing is run again.
        self.assertEqual(self.study(path).stderr, "")
        with open(self.output / "study.csv") as file:
            table = list(csv.DictReader(file))
        self.assertEqual(float(table[1]["density.change"]),
                         viscosity["result"]["density.change"])

        result = subprocess.run([sys.executable, str(PLOT), "study",
                                 str(self.output)], capture_output=True,
                                text=True, timeout=120)
        self.assertEqual(result.returncode, 0, result.stderr)
        picture = self.output / "effects.png"
        self.assertIn(str(picture), result.stdout)
        self.assertEqual(picture.read_bytes()[:4], b"\x89PNG")
        page = (self.output / "report.html").read_text()
        self.assertEqual(page.count("<svg"), 1)
        self.assertIn("pressure relaxation", page)

    def test_the_force_on_a_body(self):
        _, shown, study = self.effects(
            input=str(INPUTS / "cylinder_mach3.json"),
            set={"grid.cells": [16, 8], "time.end": 0.2},
            error="cylinder.force_x")
        self.assertRegex(shown, "left out .* cylinder.force_x\n")
        entry = study["effects"][0]
        self.assertEqual(entry["effect"], "artificial_viscosity")
        whole, without = study["rows"][:2]
        force = [row["values"]["cylinder.force_x"] for row in [whole, without]]
        self.assertAlmostEqual(entry["result"]["cylinder.force_x.change"],
                               abs(force[1] / force[0] - 1))

    def test_failures_are_told(self):
        path, _, study = self.effects(set={"grid.cells": [20]})
        # As a run leaves it that breaks down without an effect.
        row, = (r for r in study["rows"] if r["line"] == "without retries")
        row.update(status="failed", exit_code=NUMERICAL_FAILURE,
                   message="the gas broke down")
        (self.output / "study.json").write_text(json.dumps(study))
        shown = self.study(path).stdout
        self.assertRegex(shown, r"retries .* failed: the gas broke down")
        entry, = (e for e in self.result()["effects"]
                  if e["effect"] == "retries")
        self.assertIsNone(entry["price"])
        self.assertIsNone(entry["result"]["density.change"])

        # Without the scene as it is there is nothing to compare with.
        path = self.write(kind="effects", repeats=1,
                          set={"grid.cells": [20], "time.cfl": 50,
                               "time.retries": 1})
        shown = self.study(path, code=NUMERICAL_FAILURE).stdout
        self.assertRegex(shown, "failed: the gas broke down.* as it is")

    def test_wrong(self):
        for keys, text in [
            ({"vary": MATRIX}, "/vary: a study of effects"),
            ({"reference": {"type": "finer"}}, "/reference: a study of effects"),
            ({"kind": "effect"}, 'did you mean "effects"?'),
            ({"error": "densty.L1"}, 'did you mean "density.L1"?'),
            ({"input": str(INPUTS / "taylor_green.json"),
              "error": "density.L1"}, "/error: ")]:
            with self.subTest(keys=keys):
                path = self.write(**{"kind": "effects", **keys})
                shown = self.study(path, code=WRONG_INPUT).stderr
                self.assertIn(text, shown)
        path = self.write(kind="effects")
        shown = self.study(path, "--budget", "1s", code=WRONG_INPUT).stderr
        self.assertIn("kind accuracy", shown)


class Pictures(StudyTest):

    def test_plot(self):
        self.study(self.write(vary=MATRIX, repeats=1))
        result = subprocess.run([sys.executable, str(PLOT), "study",
                                 str(self.output)], capture_output=True,
                                text=True, timeout=120)
        self.assertEqual(result.returncode, 0, result.stderr)
        for name in ["work_precision.png", "cost.png"]:
            picture = self.output / name
            self.assertIn(str(picture), result.stdout)
            self.assertEqual(picture.read_bytes()[:4], b"\x89PNG")
        page = (self.output / "report.html").read_text()
        self.assertEqual(page.count("<svg"), 2)
        self.assertIn("conservative", page)
        # One file, whole without a network.
        self.assertNotRegex(page, r'(src|href)="https?:')
        self.assertNotRegex(page, r"@import|<script|<link")


if __name__ == "__main__":
    unittest.main()
