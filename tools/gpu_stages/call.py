"""A call of tools/gpu_check: what it runs, and what it remembers."""
import hashlib
import json
import math
import os
import pathlib
import shlex
import subprocess
import sys
import tempfile
import time

ROOT = pathlib.Path(__file__).resolve().parents[2]
for folder in ("unittest", "benchmarks/scaling", "benchmarks/gpu_code",
               "benchmarks/performance", "benchmarks/kernels"):
    sys.path.insert(0, str(ROOT / folder))

from program import digest_of_file


class Failure(Exception):
    """A stage cannot go on; its text says why."""


class Unfinished(Failure):
    """The time limit came first."""

    def __init__(self):
        super().__init__("the time limit came first; call this stage again")


def table(head, rows):
    """Lines of a Markdown table."""
    return [f"| {' | '.join(map(str, row))} |"
            for row in [head, ["---"] * len(head), *rows]]


class Call:
    """One call: its options, its builds, and the commands of its stages."""

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
            except BaseException as error: # SIGINT reaches this process alone
                # Its compilers and tests, too.
                os.killpg(process.pid, 15)
                process.wait()
                if isinstance(error, subprocess.TimeoutExpired):
                    raise Unfinished() from None
                raise

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
