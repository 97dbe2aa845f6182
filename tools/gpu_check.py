"""What tools/gpu_check does; it is run by that, which has the usage."""
import argparse
import csv
import hashlib
import json
import math
import os
import pathlib
import shlex
import shutil
import subprocess
import sys
import tempfile
import time
import xml.etree.ElementTree

ROOT = pathlib.Path(__file__).resolve().parent.parent
for folder in ("unittest", "benchmarks/scaling", "benchmarks/gpu_code",
               "benchmarks/performance", "benchmarks/kernels"):
    sys.path.insert(0, str(ROOT / folder))

# Tried in turn: what a machine may lack.
LIBRARIES = {"MPI and HDF5": ("ON", "ON"), "HDF5, no MPI": ("OFF", "ON"),
             "no MPI, no HDF5": ("OFF", "OFF")}
# The verdict where these alone were compared.
SUMMARIES = "summaries agree"
# Of summary.json; the same on both builds where there are no particles to read.
SUMMARY = ["steps", "particles_final", "final_time", "errors", "extrema"]
# Of scenes; of double, compare_backends.py has it. Adding in another order, on two ranks,
# came to 7e-10 and 2e-3 in 2D.
TOLERANCES = {"mixed": 1e-6, "single": 1e-2}
# Scene, cells, steps; --quick takes the first line of each scene.
SPEED = [
    ("sod", (10000,), 200), ("sod", (1000000,), 50),
    ("isentropic_vortex", (64, 64), 50), ("isentropic_vortex", (1024, 1024), 20),
    ("cylinder_mach3", (80, 40), 50), ("cylinder_mach3", (1600, 800), 20),
    ("sedov_3d", (16, 16, 16), 20), ("sedov_3d", (96, 96, 96), 20),
]
METHODS = [("conservative", "quadratic"), ("apic", "quadratic"),
           ("paper", "linear")]
# Scene, cells, cells with --quick, methods.
PROFILED = [("isentropic_vortex", (1024, 1024), (256, 256),
             ["apic", "conservative"]),
            ("sedov_3d", (96, 96, 96), (32, 32, 32), ["apic", "conservative"])]
# What ncu measures of a kernel.
METRICS = {
    "ns": "gpu__time_duration.sum",
    "instructions": "smsp__inst_executed.sum",
    "bytes": "dram__bytes.sum",
    "issue %": "sm__inst_issued.avg.pct_of_peak_sustained_active",
    "L1 %": "l1tex__throughput.avg.pct_of_peak_sustained_active",
    "L2 %": "lts__throughput.avg.pct_of_peak_sustained_elapsed",
    "DRAM %": "dram__throughput.avg.pct_of_peak_sustained_elapsed",
    "warps %": "sm__warps_active.avg.pct_of_peak_sustained_active",
    "registers": "launch__registers_per_thread",
}


class Failure(Exception):
    """A stage cannot go on; its text says why."""


class Unfinished(Failure):
    """The time limit came first."""

    def __init__(self):
        super().__init__("the time limit came first; call this stage again")


def digest_of_file(path):
    return hashlib.sha256(pathlib.Path(path).read_bytes()).hexdigest()[:12]


def table(head, rows):
    """Lines of a Markdown table."""
    return [f"| {' | '.join(map(str, row))} |"
            for row in [head, ["---"] * len(head), *rows]]


def flat(value, path=""):
    """{path: number} of nested dictionaries and lists."""
    if isinstance(value, dict):
        value = value.items()
    elif isinstance(value, list):
        value = enumerate(value)
    else:
        return {path: value}
    return {key: number for name, part in value
            for key, number in flat(part, f"{path}/{name}").items()}


class Check:
    """One call. Each stage is a method that returns what it found, which its
    record keeps: {"text": lines of Markdown, "failed": texts, ...}."""

    def __init__(self, options):
        self.options = options
        self.output = options.output.resolve()
        self.deadline = time.monotonic() + options.limit
        self.log = None
        presets = [options.preset, options.reference]
        # Not the presets' own, which tools/run takes: there, options would stay.
        self.builds = {p: ROOT / "build/gpu_check" / p for p in presets}
        self.jobs = os.environ.get("CMAKE_BUILD_PARALLEL_LEVEL", os.cpu_count())
        self.machpoint, self.host = (self.builds[p] / "machpoint"
                                     for p in presets)

    # --- Commands ------------------------------------------------------------

    def run(self, *words, env=None):
        """Runs a command and logs what it prints. Returns the exit code."""
        words = [str(word) for word in words]
        line = shlex.join(words)
        print(f"  {line}", flush=True)
        if self.options.dry_run:
            return 0
        with open(self.log, "a") as log:
            log.write(f"$ {line}\n")
            log.flush()
            process = subprocess.Popen(
                words, cwd=ROOT, stdin=subprocess.DEVNULL, stdout=log,
                stderr=subprocess.STDOUT, env=dict(os.environ, **(env or {})),
                start_new_session=True)
            try:
                return process.wait(self.seconds_left())
            except subprocess.TimeoutExpired:
                # Its compilers and tests, too.
                os.killpg(process.pid, 15)
                process.wait()
                raise Unfinished() from None

    def seconds_left(self):
        """Until the time limit, for one command; None: no limit."""
        left = self.deadline - time.monotonic()
        return None if math.isinf(left) else max(1, left)

    def require(self, *words, env=None):
        code = self.run(*words, env=env)
        if code != 0:
            raise Failure(f"exit code {code} of {shlex.join(map(str, words))}: "
                          + self.tail())

    def tail(self, lines=5):
        return " / ".join(self.log.read_text(
            errors="replace").splitlines()[-lines:])

    def remembered(self, key, make):
        """What was found before with these executables, or what is now."""
        name = hashlib.sha256(json.dumps(
            [key, *map(digest_of_file, (self.machpoint, self.host))],
            default=str).encode()).hexdigest()[:16]
        path = self.output / "found" / f"{name}.json"
        if path.exists():
            return json.loads(path.read_text())
        if time.monotonic() > self.deadline:
            raise Unfinished()
        try:
            found = make()
        except subprocess.TimeoutExpired:
            raise Unfinished() from None
        # What failed is tried again.
        if not (isinstance(found, dict) and
                found.get("verdict", "").startswith("exit code")):
            path.parent.mkdir(exist_ok=True)
            path.write_text(json.dumps(found))
        return found

    def cleared(self, name):
        """A file of DIR, less what an earlier call left there."""
        path = self.output / name
        if not self.options.dry_run:
            path.unlink(missing_ok=True)
        return path

    # --- Stages --------------------------------------------------------------

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

    def scenes(self):
        rows, failed, lack = [], [], ""
        if not self.options.dry_run:
            lack = self.hides_particles()
        accepted = ["ok", SUMMARIES,
                    *(["not compiled"] if self.restricted() else [])]
        for path in sorted((ROOT / "input").glob("*.json")):
            name = path.stem
            if self.options.dry_run:
                print(f"  compare {name}")
                continue
            sets = self.coarse(path) if self.options.quick else []
            found = self.remembered(["scene", path.read_text(), sets, lack],
                                    lambda: self.compare(name, sets))
            rows.append([name, found["verdict"], found["difference"],
                         *found["speed"]])
            if found["verdict"] not in accepted:
                failed.append(f"{name}: {found['verdict']}")
        return {"failed": failed, "rows": rows, "but": lack and
                f"by summaries alone, not particle by particle: {lack}",
                "text": table(
            ["scene", "verdict", "largest relative difference",
             f"{self.options.preset}, updates/s",
             f"{self.options.reference}, updates/s"], rows)}

    def restricted(self):
        """Was less to be compiled, now or when the builds were made?"""
        path = self.output / "build.json"
        built = (json.loads(path.read_text()).get("set") or []
                 if path.exists() else [])
        return any(option.startswith(("Machpoint_DIMENSIONS", "Machpoint_BASES"))
                   for option in [*self.options.set, *built])

    @staticmethod
    def coarse(path):
        """Overrides that leave a scene at most some 20000 particles."""
        scene = json.loads(path.read_text())
        cells = scene["grid"]["cells"]
        particles = math.prod(cells) * scene["particles"]["per_cell"]
        by = math.ceil(max(1, particles / 20000)**(1 / len(cells)))
        return ["grid.cells=" + json.dumps([max(2, n // by) for n in cells])]

    def compare(self, scene, sets):
        """One scene on both builds."""
        found = {"difference": "", "speed": ["", ""]}
        try:
            (summary, particles), (other, others) = [
                self.few_steps(machpoint, scene, sets)
                for machpoint in (self.machpoint, self.host)]
        except subprocess.CalledProcessError as error:
            lacks = error.returncode == 2 and "this build" in error.stderr
            last = (error.stderr.strip().splitlines() or ["nothing said"])[-1]
            return dict(found, verdict="not compiled" if lacks else
                        f"exit code {error.returncode}: {last}")
        found["speed"] = [f"{s['particle_updates_per_second']:.3g}"
                          for s in (summary, other)]
        from compare_backends import TOLERANCE, difference
        if particles is not None:
            verdict, (worst, where) = "ok", difference(particles, others)
        else:
            verdict, (worst, where) = SUMMARIES, self.difference_of_summaries(
                summary, other)
        found["difference"] = f"{worst:.1e} ({where})"
        tolerance = TOLERANCES.get(summary["precision"], TOLERANCE)
        found["verdict"] = verdict if worst <= tolerance else "differs"
        return found

    def few_steps(self, machpoint, scene, sets):
        import compare_backends
        if not self.hides_particles():
            particles, summary = compare_backends.run(
                machpoint, scene, sets, timeout=self.seconds_left())
            return summary, particles
        return self.summary_of(machpoint, scene, compare_backends.STEPS,
                               sets), None

    def hides_particles(self):
        """Why runs cannot be compared particle by particle; "": they can."""
        from compare_backends import h5py
        if not self.has_hdf5():
            return "these builds lack HDF5"
        return "" if h5py else (
            f"{sys.executable} lacks numpy or h5py; MACHPOINT_PYTHON names another")

    def has_hdf5(self):
        cache = (self.machpoint.parent / "CMakeCache.txt").read_text()
        return "Machpoint_ENABLE_HDF5:BOOL=OFF" not in cache

    def summary_of(self, machpoint, scene, steps, sets):
        """summary.json of a run that writes nothing else."""
        words = [f"--set={text}" for text in
                 [*sets, 'output={"particles": false, "grid": false}']]
        with tempfile.TemporaryDirectory() as folder:
            subprocess.run(
                [machpoint, "run", ROOT / f"input/{scene}.json", "--quiet",
                 "--max-steps", str(steps), "--output", folder, *words],
                check=True, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE,
                text=True, timeout=self.seconds_left())
            return json.loads((pathlib.Path(folder) / "summary.json").read_text())

    @staticmethod
    def difference_of_summaries(a, b):
        parts = {}
        for key in SUMMARY:
            first, second = flat(a[key], key), flat(b[key], key)
            for path, value in first.items():
                # Below it lies round-off, of errors and of gas at rest.
                size = max(abs(value), abs(second[path]), 1e-3)
                parts[path] = abs(value - second[path]) / size
        worst = max(parts, key=parts.get)
        return parts[worst], worst

    def cases(self):
        if not self.options.dry_run and not self.has_hdf5():
            raise Failure("the hard cases read what runs write, and this "
                          "build lacks HDF5")
        results = self.cleared("hard_cases/results.json")
        code = self.run(sys.executable, ROOT / "benchmarks/hard_cases",
                        "--fast", "--method", "conservative", "--draws", "100",
                        "--machpoint", self.machpoint, "--output",
                        results.parent)
        if self.options.dry_run:
            return {"text": []}
        lines = [line for line in self.log.read_text().splitlines()
                 if not line.startswith("$")]
        if not results.exists():
            raise Failure(self.tail())
        return {"failed": [] if code == 0 else
                [line.strip() for line in lines
                 if "BROKEN" in line or "MISSED" in line] or [self.tail()],
                "results": json.loads(results.read_text()),
                "text": ["```", *lines, "```"]}

    def speed(self):
        from case import Case
        rows, failed = [], []
        first = {}
        for item in SPEED:
            first.setdefault(item[0], item)
        for scene, cells, steps in (first.values() if self.options.quick
                                    else SPEED):
            for method, basis in METHODS:
                keys = Case(scene, cells, 1, steps, method=method,
                            basis=basis).settings()
                del keys["output.every"]
                sets = [f"{key}={json.dumps(value)}"
                        for key, value in keys.items()]
                name = f"{scene} {'x'.join(map(str, cells))} {method} {basis}"
                print(f"  {name}", flush=True)
                if self.options.dry_run:
                    continue
                try:
                    text = (ROOT / f"input/{scene}.json").read_text()
                    one, two = self.remembered(
                        ["speed", text, sets, steps],
                        lambda: [self.summary_of(build, scene, steps, sets)
                                 for build in (self.machpoint, self.host)])
                except subprocess.CalledProcessError as error:
                    if "this build" not in error.stderr:
                        failed.append(f"{name}: exit code {error.returncode}: "
                                      + error.stderr.strip()[-300:])
                    continue
                phases = sorted(one["phases"], key=lambda p: -p["seconds"])
                rates = [s["particle_updates_per_second"] for s in (one, two)]
                rows.append([name, one["particles_final"],
                             *[f"{rate:.3g}" for rate in rates],
                             f"{rates[0] / rates[1]:.2f}",
                             ", ".join(f"{p['name']} "
                                       f"{1e3 * p['seconds'] / steps:.2f}"
                                       for p in phases[:4])])
        return {"failed": failed, "rows": rows, "text": table(
            ["scene", "particles", f"{self.options.preset}, updates/s",
             f"{self.options.reference}, updates/s", "ratio",
             "ms per step in the longest phases"], rows)}

    def kernels(self):
        import results
        executable = self.builds[self.options.preset] / results.EXECUTABLE
        if not self.options.dry_run and not executable.exists():
            raise Failure("not built: this machine lacks Google Benchmark")
        path = self.cleared("kernels.json")
        self.require(executable, "--benchmark_filter=quadratic",
                     f"--benchmark_out={path}", "--benchmark_out_format=json",
                     *(["--particles", 65536] if self.options.quick else []))
        if self.options.dry_run:
            return {"text": []}
        found = json.loads(path.read_text())
        limits = results.limits(found)
        return {"results": found, "text": [
            f"The triad moved {limits['triad_all'] / 1e9:.0f} GB/s, and "
            f"multiply-adds ran at {limits['fma_all'] / 1e9:.0f} Gflop/s.", "",
            *results.table(results.rows(found)).splitlines()]}

    def sweep(self):
        folder = self.output / "sod_sweep"
        self.require(
            sys.executable, ROOT / "benchmarks/sod_sweep",
            *[f"--build={path}" for path in self.builds.values()],
            "--output", folder, *(["--seconds", 2, "--largest", 8,
                                   "--cylinders", 2]
                                  if self.options.quick else []))
        if self.options.dry_run:
            return {"text": []}
        found = json.loads((folder / "results.json").read_text())
        return {"results": found, "text": [
            *[f"- {name}: slope {slope:.3f}" for name, slope
              in found["slopes"].items() if slope is not None],
            *[f"- left out: {reason}" for reason in found["left_out"]], "",
            *table(["", "cells", "ms a step", "seconds to the end"],
                   [[name, "x".join(map(str, point["cells"])),
                     f"{1e3 * point['step']:.3g}", f"{point['seconds']:.3g}"]
                    for name, points in found["lines"].items()
                    for point in points])]}

    def profile(self):
        if self.options.preset != "cuda":
            return {"text": ["Only a GPU is profiled."]}
        if not self.options.dry_run and not shutil.which("ncu"):
            raise Failure("no ncu on the PATH; it comes with the CUDA toolkit")
        text = []
        for scene, cells, few, methods in PROFILED:
            for method in methods:
                text += self.profile_of(
                    scene, few if self.options.quick else cells, method)
        return {"text": text}

    def profile_of(self, scene, cells, method):
        """Lines on the kernels of a step, the slowest first."""
        from case import Case
        from kernel_names import STEP
        settings = Case(scene, cells, 1, 2, method=method).settings()
        del settings["output.every"]
        path, folder = self.cleared("ncu.csv"), self.output / "profiled"
        self.require(
            "ncu", "--clock-control", "none", "--csv", "--page", "raw",
            "--print-units", "base", "--print-kernel-base", "mangled",
            "--kernel-name-base", "mangled", "--kernel-name",
            "regex:" + "|".join(STEP), "--metrics", ",".join(METRICS.values()),
            "--log-file", path, self.machpoint, "run",
            ROOT / f"input/{scene}.json", "--quiet", "--max-steps", 2,
            "--overwrite", "--output", folder,
            *[f"--set={key}={json.dumps(value)}"
              for key, value in settings.items()],
            '--set=output={"particles": false, "grid": false}')
        if self.options.dry_run:
            return []
        particles = json.loads(
            (folder / "summary.json").read_text())["particles_final"]
        kernels = self.kernels_of(path.read_text())
        rows = [[name, f"{k['ns'] / 1e3:.0f}",
                 f"{32 * k['instructions'] / particles:.0f}",
                 f"{k['bytes'] / particles:.0f}",
                 *[f"{k[key]:.0f}" for key in list(METRICS)[3:]]]
                for name, k in sorted(kernels.items(),
                                      key=lambda item: -item[1]["ns"])]
        return ["", f"{scene}, {'x'.join(map(str, cells))} cells, {method}, "
                f"{particles} particles; instructions and bytes of memory are "
                "of a particle, % of what the GPU could:", "",
                *table(["kernel", "us", "instructions", "bytes",
                        *list(METRICS)[3:]], rows)]

    @staticmethod
    def kernels_of(text):
        """{function and template arguments: {key of METRICS: number}} of the
        kernels of a step in what ncu wrote, as each was run last."""
        from kernel_names import STEP, function_of
        lines = text.splitlines()
        start = next(k for k, line in enumerate(lines)
                     if line.startswith('"ID"'))
        head, _, *rows = csv.reader(lines[start:])
        readable = subprocess.run(
            ["c++filt"], input="\n".join(row[head.index("Kernel Name")]
                                         for row in rows),
            check=True, capture_output=True, text=True).stdout.splitlines()
        found = {}
        for row, name in zip(rows, readable):
            function = function_of(name)
            if function and function[0] in STEP:
                found["`{}<{}>` {}".format(*function)] = {
                    key: float(row[head.index(metric)].replace(",", ""))
                    for key, metric in METRICS.items()}
        return found

    # --- Records and report --------------------------------------------------

    def perform(self, stage):
        """Runs a stage and keeps its record. Returns whether it has passed."""
        print(f"gpu_check: {stage}", flush=True)
        self.log = self.cleared(f"{stage}.log")
        start = time.monotonic()
        try:
            found = getattr(self, stage)()
        # Whatever it is, the next stage is run; a benchmark's reader may exit.
        except (Exception, SystemExit) as error:
            found = {"text": [], "failed": [
                str(error) if isinstance(error, Failure) else repr(error)]}
        found.setdefault("failed", [])
        record = {"stage": stage, "passed": not found["failed"],
                  "seconds": time.monotonic() - start,
                  "finished": time.strftime("%Y-%m-%d %H:%M:%S"),
                  "revision": self.revision(), "preset": self.options.preset,
                  "reference": self.options.reference,
                  "quick": self.options.quick, "set": self.options.set, **found}
        if not self.options.dry_run:
            (self.output / f"{stage}.json").write_text(
                json.dumps(record, indent=1))
        for text in found["failed"]:
            print(f"  failed: {text}")
        if found.get("but"):
            print(f"  but {found['but']}")
        return record["passed"]

    @staticmethod
    def revision():
        try:
            found = subprocess.run(["git", "describe", "--always", "--dirty"],
                                   cwd=ROOT, capture_output=True, text=True)
        except FileNotFoundError: # no git
            return "unknown"
        return found.stdout.strip() or "unknown"

    def report(self):
        records = {stage: json.loads(path.read_text()) for stage in STAGES
                   if (path := self.output / f"{stage}.json").exists()}
        (self.output / "report.json").write_text(
            json.dumps(list(records.values()), indent=1))
        rows = []
        for stage in STAGES:
            if stage not in records:
                again = shlex.join(["tools/gpu_check", *self.options.others,
                                    "--stage", stage])
                rows.append([stage, f"not run: `{again}`", "", "", "", ""])
                continue
            r = records[stage]
            rows.append([stage, ("passed" if r["passed"] else "**failed**") +
                         (f", but {r['but']}" if r.get("but") else ""),
                         f"{r['preset']} against {r['reference']}",
                         f"{r['seconds']:.0f}", r["finished"],
                         r["revision"] + (", quick" if r["quick"] else "")])
        lines = ["# GPU check", "",
                 *table(["stage", "", "builds", "seconds", "finished",
                         "revision"], rows)]
        for stage, record in records.items():
            lines += ["", f"## {stage}", "",
                      *[f"- failed: {text}" for text in record["failed"]],
                      "", *record["text"]]
        (self.output / "report.md").write_text("\n".join(lines) + "\n")
        print(f"gpu_check: the report is {self.output / 'report.md'}")


STAGES = ["device", "setup", "build", "test", "scenes", "cases", "speed",
          "kernels", "sweep", "profile"]


def has_gpu():
    """nvidia-smi names one."""
    try:
        found = subprocess.run(["nvidia-smi", "-L"], capture_output=True,
                               text=True)
    except FileNotFoundError:
        return False
    return found.returncode == 0 and "GPU" in found.stdout


def main():
    presets = ["serial", "openmp", "cuda"]
    stages = argparse.ArgumentParser(add_help=False)
    stages.add_argument("--stage", action="append", choices=STAGES)
    parser = argparse.ArgumentParser(prog="tools/gpu_check", parents=[stages])
    parser.add_argument("--limit", type=float, default=math.inf,
                        metavar="SECONDS")
    parser.add_argument("--quick", action="store_true",
                        help="coarser scenes, smaller measurements")
    parser.add_argument("--output", type=pathlib.Path, metavar="DIR",
                        default=ROOT / "out/gpu_check")
    parser.add_argument("--set", action="append", default=[],
                        metavar="OPTION=VALUE", help="for CMake")
    parser.add_argument("--preset", choices=presets, default="cuda")
    parser.add_argument("--reference", choices=presets, default="openmp")
    parser.add_argument("--dry-run", action="store_true",
                        help="show what would be run")
    options = parser.parse_args()
    # To call another stage with.
    options.others = stages.parse_known_args()[1]
    if options.preset == options.reference:
        parser.error("a preset compared with itself tells nothing")
    if options.preset == "cuda" and not options.dry_run and not has_gpu():
        print("gpu_check: nvidia-smi names no GPU on this machine; to try the "
              "check itself, add --preset openmp --reference serial",
              file=sys.stderr)
        return 2
    check = Check(options)
    if not options.dry_run:
        check.output.mkdir(parents=True, exist_ok=True)
    # All are run, also after one has failed.
    passed = [check.perform(stage) for stage in options.stage or STAGES]
    if not options.dry_run:
        check.report()
    return 0 if all(passed) else 1


if __name__ == "__main__":
    sys.exit(main())
