"""What a checkpoint costs, beside a plain write of as many bytes.

Usage: python3 benchmarks/checkpoint [--machpoint PATH] [--cells NUMBER]
           [--ranks NUMBER,...] [--repeats NUMBER] [--set path=value]...
           [--mpiexec COMMAND] [--output DIR]

Runs `kelvin_helmholtz` with CELLS x CELLS cells of four particles (default 1600:
10 million particles) for no step, without a checkpoint and with one, then a restart
from it, then writes as many bytes by as many processes to one file in the same
directory: each its own part, 4 MiB a call. All that in turn; figures are medians, and
their ranges in brackets. Seconds end when the file is on the disk (fsync), of both;
a checkpoint's are those of its phase. Processor time (user and system) tells more on
a busy machine; a checkpoint's is what a run with one takes more than one without.
Memory is that of all ranks. Before each measurement the disk's queue is emptied
(sync). All files are in a folder of their own in DIR, which is gone at the end; with
DIR in /dev/shm there is no disk. Exit code: 0.
"""
import json
import multiprocessing
import os
import pathlib
import resource
import shlex
import shutil
import statistics
import subprocess
import sys
import tempfile
import time

sys.path.append(str(pathlib.Path(__file__).resolve().parents[1] / "performance"))

import executable
import launcher
import options
from page import ROOT

BLOCK = 4 << 20


def processor_seconds():
    """User and system time of all child processes that have ended."""
    usage = resource.getrusage(resource.RUSAGE_CHILDREN)
    return usage.ru_utime + usage.ru_stime


def write_part(path, first, size, start):
    """Writes part of a file when all are ready to."""
    block = memoryview(os.urandom(BLOCK))
    # Whatever may fail comes later: the others would wait for ever.
    start.wait()
    with open(path, "r+b", buffering=0) as file:
        while size > 0:
            written = os.pwrite(file.fileno(), block[:min(BLOCK, size)], first)
            first += written
            size -= written
        os.fsync(file.fileno())


def plain_write(path, size, processes):
    """Seconds, and processor time, of so many processes that write so many bytes
    to one file."""
    path.touch()
    before = processor_seconds()
    start = multiprocessing.Barrier(processes + 1)
    ends = [size * k // processes for k in range(processes + 1)]
    writers = [multiprocessing.Process(
        target=write_part, args=(path, first, end - first, start))
        for first, end in zip(ends, ends[1:])]
    for writer in writers:
        writer.start()
    start.wait()
    begin = time.monotonic()
    for writer in writers:
        writer.join()
    seconds = time.monotonic() - begin
    if any(writer.exitcode for writer in writers):
        sys.exit(f"{path} cannot be written")
    path.unlink()
    return seconds, processor_seconds() - before


def run(arguments, directory, ranks, *more):
    """Summary of a run, and its processor time."""
    scene = ROOT / "input" / "kelvin_helmholtz.json"
    keys = {"grid.cells": [arguments.cells] * 2, "output.particles": False,
            "output.grid": False}
    settings = [*(f"{key}={json.dumps(value)}" for key, value in keys.items()),
                *arguments.settings]
    command = [str(arguments.machpoint), "run", str(scene), "--quiet",
               "--output", str(directory), *more]
    for setting in settings:
        command += ["--set", setting]
    if ranks > 1:
        command = [*arguments.mpiexec, "-n", str(ranks), *command]
    os.sync()
    before = processor_seconds()
    code = subprocess.run(command, env=launcher.ENVIRONMENT, check=False,
                          stdout=subprocess.DEVNULL).returncode
    if code != 0:
        sys.exit(f"exit code {code}: {shlex.join(command)}")
    return (json.loads((directory / "summary.json").read_text()),
            processor_seconds() - before)


def measure(arguments, folder, ranks):
    """One round in an empty folder: {figure: value}."""
    directory = folder / "run"
    without, least = run(arguments, directory, ranks, "--max-steps", "0")
    shutil.rmtree(directory)
    kept, more = run(arguments, directory, ranks, "--max-steps", "0", "--set",
                     'checkpoint={"every_steps":1}')
    phase, = [p for p in kept["phases"] if p["name"] == "checkpoint"]
    file, = (directory / "checkpoints").glob("*.h5")
    size = file.stat().st_size
    restarted, _ = run(arguments, directory, ranks, "--max-steps", "0",
                       "--restart", "latest")
    shutil.rmtree(directory)
    os.sync()
    plain, plain_work = plain_write(folder / "plain", size, ranks)
    return {"particles": kept["particles_final"], "bytes": size,
            "checkpoint": phase["seconds"], "plain": plain,
            "checkpoint_work": more - least, "plain_work": plain_work,
            "memory": without["peak_memory_bytes"],
            "memory_checkpoint": kept["peak_memory_bytes"],
            "memory_restart": restarted["peak_memory_bytes"]}


def show(ranks, rounds):
    """Prints medians."""
    def figures(name):
        return [r[name] for r in rounds]

    def seconds(name):
        values = figures(name)
        rates = [r["bytes"] / 1e6 / r[name] for r in rounds]
        return (f"{statistics.median(values):.2f} s ({min(values):.2f} to "
                f"{max(values):.2f}), {statistics.median(rates):.0f} MB/s, "
                f"processor {statistics.median(figures(name + '_work')):.2f} s")

    ratios = [r["checkpoint"] / r["plain"] for r in rounds]
    memory = {name: statistics.median(figures(name)) / 1e9 for name in
              ("memory", "memory_checkpoint", "memory_restart")}
    print(f"{ranks} ranks, {rounds[0]['particles']} particles, "
          f"{rounds[0]['bytes'] / 1e9:.2f} GB:\n"
          f"  checkpoint    {seconds('checkpoint')}\n"
          f"  plain write   {seconds('plain')}\n"
          f"  ratio         {statistics.median(ratios):.2f} "
          f"({min(ratios):.2f} to {max(ratios):.2f})\n"
          f"  peak memory   {memory['memory']:.2f} GB without a checkpoint, "
          f"{memory['memory_checkpoint']:.2f} GB with one, "
          f"{memory['memory_restart']:.2f} GB of a restart", flush=True)


def counts(text):
    """A type of argparse: whole numbers above 0."""
    return list(map(options.whole(1), text.split(",")))


def main():
    parser = options.parser(__doc__)
    executable.add_option(parser)
    parser.add_argument("--cells", type=options.whole(1), default=1600,
                        metavar="NUMBER", help="along an axis; default: 1600")
    parser.add_argument("--ranks", type=counts, default="1,2",
                        metavar="NUMBER,...", help="measured in turn; default: 1,2")
    parser.add_argument("--repeats", type=options.whole(1), default=5,
                        metavar="NUMBER", help="default: 5")
    parser.add_argument("--set", action="append", dest="settings", default=[],
                        metavar="path=value",
                        help="of the scene, as machpoint run takes it")
    parser.add_argument("--mpiexec", default="mpirun", metavar="COMMAND",
                        help="starts several ranks; default: mpirun")
    parser.add_argument("--output", type=options.folder, metavar="DIR",
                        default="out/checkpoint", help="default: out/checkpoint")
    arguments = parser.parse_args()
    if max(arguments.ranks) > 1:
        arguments.mpiexec = launcher.find(parser, arguments.mpiexec)
    rounds = {ranks: [] for ranks in arguments.ranks}
    with tempfile.TemporaryDirectory(dir=arguments.output) as folder:
        for _ in range(arguments.repeats):
            for ranks, found in rounds.items():
                found.append(measure(arguments, pathlib.Path(folder), ranks))
    for ranks, found in rounds.items():
        show(ranks, found)
    return 0


if __name__ == "__main__":
    sys.exit(main())
