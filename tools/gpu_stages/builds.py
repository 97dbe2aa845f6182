"""Stages of tools/gpu_check that need no scene: the machine, builds and tests."""
import os
import shutil
import subprocess
import sys
import time
import xml.etree.ElementTree

from call import ROOT, Call, Failure

# Tried in turn: what a machine may lack.
LIBRARIES = {"MPI and HDF5": ("ON", "ON"), "HDF5, no MPI": ("OFF", "ON"),
             "no MPI, no HDF5": ("OFF", "OFF")}


class Builds(Call):

    def device(self):
        text = []
        for words in [["nvidia-smi"], ["nvcc", "--version"],
                      ["g++", "--version"], ["lscpu"]]:
            if not shutil.which(words[0]):
                text.append(f"no {words[0]}")
                continue
            found = subprocess.run(words, capture_output=True, text=True)
            lines = [line for line in found.stdout.strip().splitlines()
                     if words[0] != "lscpu" or line.startswith(
                         ("Model name", "CPU(s)"))]
            text += ["```", *lines, "```"]
        return {"text": text}

    def setup(self):
        self.require(ROOT / "tools/setup",
                     *[f"--preset={preset}" for preset in self.builds])
        return {"text": []}

    def build(self):
        lacks = None
        for name, (mpi, hdf5) in LIBRARIES.items():
            # What was set or found before would stay in the cache.
            for folder in self.builds.values():
                if not self.options.dry_run:
                    (folder / "CMakeCache.txt").unlink(missing_ok=True)
            codes = [self.run(
                "cmake", "--preset", preset, "-B", folder,
                f"-DMachpoint_ENABLE_MPI={mpi}",
                f"-DMachpoint_ENABLE_HDF5={hdf5}",
                f"-DMachpoint_PYTHON={sys.executable}",
                *[f"-D{option}" for option in self.options.set])
                for preset, folder in self.builds.items()]
            if not any(codes):
                lacks = name
                break
        if lacks is None:
            raise Failure(self.tail(20))
        # What all other stages need comes first, and then each test that
        # compiles, whatever becomes of the others.
        seconds = {}
        first = self.options.preset
        for preset, *words in [(first, "--target", "machpoint"),
                               (self.options.reference, "--target", "machpoint"),
                               (first, "--", "-k", 0)]:
            start = time.monotonic()
            self.require("cmake", "--build", self.builds[preset], "--parallel",
                         self.jobs, *words)
            seconds[preset] = (seconds.get(preset, 0) +
                               time.monotonic() - start)
        return {"text": [f"Built with {lacks}; " + ", ".join(
            f"{preset} in {time_of:.0f} s"
            for preset, time_of in seconds.items()) + "."],
                "libraries": lacks, "seconds_of": seconds}

    def test(self):
        results = self.cleared("ctest.xml")
        code = self.run(
            "ctest", "--test-dir", self.builds[self.options.preset],
            "--output-on-failure", "--parallel", self.processes(),
            "--exclude-regex", "^test_hard_cases$", "--output-junit", results,
            env={"OMP_WAIT_POLICY": "passive", "OMP_PROC_BIND": "false"})
        if self.options.dry_run:
            return {"text": []}
        if not results.exists():
            raise Failure(f"ctest left no results: {self.tail()}")
        cases = xml.etree.ElementTree.parse(results).getroot().findall(
            "testcase")
        states = {case.get("name"): case.get("status") for case in cases}
        failed = [name for name, state in states.items()
                  if state == "fail" or name.endswith("_NOT_BUILT")]
        skipped = [name for name, state in states.items()
                   if state != "run" and name not in failed]
        slowest = sorted(cases, key=lambda case: -float(case.get("time")))[:5]
        if code != 0 and not failed or not states:
            failed.append(f"ctest: {self.tail()}")
        return {"failed": failed, "tests": states, "text": [
            f"{len(states)} tests, {len(failed)} failed, {len(skipped)} "
            f"skipped; slowest: " + ", ".join(
                f"{case.get('name')} {float(case.get('time')):.1f} s"
                for case in slowest) + ".",
            *[f"- skipped: {name}" for name in skipped]]}

    def processes(self):
        """How many may use the GPU at a time: each has some memory of it."""
        if self.options.preset != "cuda" or not shutil.which("nvidia-smi"):
            return os.cpu_count()
        mode = subprocess.run(
            ["nvidia-smi", "--query-gpu=compute_mode", "--format=csv,noheader"],
            capture_output=True, text=True).stdout
        return 1 if "Exclusive" in mode else min(8, os.cpu_count())
