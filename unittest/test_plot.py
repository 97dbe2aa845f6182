"""tools/plot.py draws a run, and puts all about it into one page.

The executable comes from MACHPOINT_EXECUTABLE. (Studies: test_study.py.)
"""

import json
import os
import pathlib
import re
import subprocess
import sys
import tempfile
import unittest

from running import ONE_THREAD

EXECUTABLE = os.path.abspath(os.environ["MACHPOINT_EXECUTABLE"])
ROOT = pathlib.Path(__file__).resolve().parent.parent
sys.path.append(str(ROOT / "tools"))

import plot


class Pictures(unittest.TestCase):

    def setUp(self):
        scratch = tempfile.TemporaryDirectory()
        self.addCleanup(scratch.cleanup)
        self.output = pathlib.Path(scratch.name) / "out"

    def call(self, *words):
        result = subprocess.run(list(map(str, words)), capture_output=True,
                                text=True, timeout=120, env=ONE_THREAD)
        self.assertEqual(result.returncode, 0, result.stderr)
        return result.stdout

    def run_scene(self, name, cells, *words):
        self.call(EXECUTABLE, "run", ROOT / f"input/{name}.json", "--set",
                  f"grid.cells={cells}", "--output", self.output, "--quiet",
                  *words)

    def run_sod(self, *words):
        self.run_scene("sod", [20], *words)

    def test_report_of_a_run(self):
        self.run_sod()
        shown = self.call(sys.executable, ROOT / "tools/plot.py", self.output,
                          "--no-movie")
        pictures = ["profiles.png", "contact_sheet.png"]
        for name in [*pictures, "report.html"]:
            self.assertIn(str(self.output / name), shown)
        for name in pictures:
            self.assertEqual((self.output / name).read_bytes()[:4], b"\x89PNG")
        page = (self.output / "report.html").read_text()
        self.assertEqual(page.count('src="data:image/png;base64,'), 2)
        summary = json.loads((self.output / "summary.json").read_text())
        self.assertIn(f"{summary['errors']['density']['L1']:.4e}", page)
        self.assertIn(summary["revision"], page)
        phases = page.split("Where the time went")[1].split("<h2>")[0]
        shares = [float(found) for found in re.findall(r"([\d.]+) %", phases)]
        self.assertEqual(len(shares), len(summary["phases"]))
        # Each is rounded to a tenth.
        self.assertAlmostEqual(sum(shares), 100, delta=0.05 * len(shares) + 1e-9)
        # One file, whole without a network.
        self.assertNotRegex(page, r'(src|href)="https?:')
        self.assertNotRegex(page, r"@import|<script|<link")
        # What is drawn goes with what it was drawn from.
        self.run_sod("--overwrite")
        self.assertFalse((self.output / "report.html").exists())
        self.assertTrue((self.output / "summary.json").exists())

    def test_a_run_without_output_is_no_failure(self):
        for name, cells, kind in [("sod", [20], "particles"),
                                  ("sod_2d", [20, 4], "grid")]:
            self.run_scene(name, cells, "--overwrite", "--set",
                           f"output.{kind}=false")
            shown = self.call(sys.executable, ROOT / "tools/plot.py",
                              self.output)
            self.assertIn("holds no output to draw", shown)
            self.assertIn(f"set output.{kind} for", shown)

    def test_a_plane_has_the_proportions_of_its_lengths(self):
        self.run_scene("rayleigh_taylor", [8, 8], "--max-steps", "1")
        run = plot.Run(self.output)
        self.assertAlmostEqual(plot.height_to_width(run, 0), 3)

    def test_gas_that_is_all_the_same_is_amid_its_scale(self):
        for low, high, field in [(1, 1 + 1e-9, "density"), (0, 0, "velocity"),
                                 (-3, -3, "velocity")]:
            bottom, top = plot.without_round_off(low, high, field)
            self.assertLess(bottom, low)
            self.assertAlmostEqual(low - bottom, top - high, delta=1e-14)
        self.assertEqual(plot.without_round_off(1, 1.1, "density"), (1, 1.1))


if __name__ == "__main__":
    unittest.main()
