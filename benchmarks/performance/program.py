"""Runs Machpoint's programs, and asks them what they were built of."""
import hashlib
import os
import pathlib
import subprocess

# That summary.json splits the time of a run's steps into.
ACTIVITIES = ["compute", "halo", "halo_wait", "migration", "collectives"]


def run(words, threads):
    """What became of a command; OpenMP's threads are not tied to cores, which a
    virtual machine hands out as it likes."""
    words = [str(word) for word in words]
    environment = dict(os.environ, OMP_NUM_THREADS=str(threads),
                       OMP_PROC_BIND="false")
    try:
        return subprocess.run(words, env=environment,
                              stdin=subprocess.DEVNULL, capture_output=True,
                              text=True)
    except OSError as error:
        raise SystemExit(f"{words[0]}: {error.strerror}") from None


def failure(result):
    """What a command that failed ends a benchmark with."""
    return SystemExit(f"{' '.join(result.args)}: exit code "
                      f"{result.returncode}\n{result.stderr}")


def execute(words, threads):
    """stdout of a command."""
    result = run(words, threads)
    if result.returncode != 0:
        raise failure(result)
    return result.stdout


def digest_of_file(path):
    """Of a program, or of what else a kept result hangs on."""
    return hashlib.sha256(pathlib.Path(path).read_bytes()).hexdigest()[:12]


def version(machpoint):
    """{name: value} of what a program says of itself: revision, backend, ..."""
    lines = execute([machpoint, "--version"], 1).splitlines()
    found = dict(line.split(maxsplit=1) for line in lines if " " in line)
    if "revision" not in found or "backend" not in found:
        raise SystemExit(f"{machpoint} does not say what it was built of: is it "
                         "machpoint?")
    return found


def revision(machpoint):
    return version(machpoint)["revision"]
