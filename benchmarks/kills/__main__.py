"""Kills a run again and again, restarts it, and compares what is left with an
undisturbed run.

Usage: python3 benchmarks/kills [INPUT] [--kills NUMBER] [--seed NUMBER]
           [--ranks NUMBER] [--machpoint PATH] [--mpiexec COMMAND]
           [--output DIR] [--set path=value]...

Each kill is a SIGKILL at a random moment: while a step is computed, or an output
or a checkpoint written, or a checkpoint read. Of several ranks it hits any one,
and the others have to end within half a minute. (The launcher itself may not: see
ranks.py. It is ended then, and counted.) The last word has a run that is
let finish. Every dataset of its outputs must then have the same bytes as those of
the undisturbed run (on one thread sums repeat exactly), and no file may be
broken. All runs have a folder of their own in DIR, which stays if something is
wrong. Exit code: 0 if nothing is, else 1.
"""
import os
import pathlib
import random
import shutil
import signal
import subprocess
import sys
import tempfile
import time

sys.path.append(str(pathlib.Path(__file__).resolve().parents[1] / "performance"))

import executable
import launcher
import options
import packages
import ranks
from page import ROOT

h5py = packages.find("h5py")


def parse():
    parser = options.parser(__doc__)
    parser.add_argument("input", nargs="?",
                        default=ROOT / "input" / "cylinder_mach3.json",
                        help="scene; default: input/cylinder_mach3.json")
    parser.add_argument("--kills", type=options.whole(1), default=50,
                        help="how often a run is killed; default: 50")
    parser.add_argument("--seed", type=int, default=1,
                        help="of the moments and ranks; default: 1")
    parser.add_argument("--ranks", type=options.whole(1), default=1,
                        help="of a run; default: 1")
    executable.add_option(parser)
    parser.add_argument("--mpiexec", default="mpirun",
                        help="starts several ranks; default: mpirun")
    parser.add_argument("--output", type=options.folder, default="out/kills",
                        help="default: out/kills")
    parser.add_argument("--set", action="append", dest="settings", default=[],
                        help="path=value: of the scene, as machpoint run takes it")
    arguments = packages.parse(parser)
    if arguments.ranks > 1:
        arguments.mpiexec = launcher.find(parser, arguments.mpiexec)
    if not arguments.settings and "cylinder_mach3" in str(arguments.input):
        arguments.settings = ["grid.cells=[80,40]", "time.end=1",
                              "output.every=0.05"]
    return arguments


class Run:
    """Runs of one input, each in a directory of its own."""

    def __init__(self, arguments):
        self.command = [str(arguments.machpoint), "run", str(arguments.input),
                        "--quiet", "--set", 'checkpoint={"every_steps":5}']
        if arguments.ranks > 1:
            self.command = [*arguments.mpiexec, "-n", str(arguments.ranks),
                            *self.command]
        for setting in arguments.settings:
            self.command += ["--set", setting]

    def start(self, directory, *more):
        return subprocess.Popen(
            [*self.command, "--output", str(directory), *more],
            stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
            env=launcher.ENVIRONMENT)

    def finish(self, directory, *more):
        """Seconds of a run to its end."""
        begin = time.monotonic()
        process = self.start(directory, *more)
        text = process.communicate()[0]
        if process.returncode != 0:
            sys.exit(f"exit code {process.returncode}: {text}")
        return time.monotonic() - begin


def outputs(directory):
    """Every dataset of a run's outputs by name; fails for a broken file."""
    found = {}
    for kind in ["particles", "grid", "exact"]:
        for path in sorted((directory / kind).glob("*.h5")):
            with h5py.File(path) as file:
                for key in file:
                    if key != "xdmf":
                        found[f"{kind}/{path.name}/{key}"] = (
                            file[key][()].tobytes())
    for path in [*directory.glob("*.xdmf"), *directory.glob("series/*.csv")]:
        found[str(path.relative_to(directory))] = path.read_bytes()
    return found


def kill(process, rng):
    """Kills a run, or one of its ranks. Returns what it said, and whether the
    launcher stayed behind."""
    # A launcher's children are its ranks; one alone has none.
    victims = [pid for pid in ranks.children(process.pid)
               if not ranks.has_ended(pid)]
    os.kill(rng.choice(victims or [process.pid]), signal.SIGKILL)
    try:
        return ranks.end(process)
    except subprocess.TimeoutExpired:
        process.kill()
        sys.exit("the other ranks did not end")


def how_to_start(directory):
    """Options to go on with, or to start with where nothing is kept."""
    if list((directory / "checkpoints").glob("*.h5")):
        return ["--restart", "latest"]
    return ["--overwrite"]


def main():
    arguments = parse()
    run = Run(arguments)
    rng = random.Random(arguments.seed)
    folder = pathlib.Path(tempfile.mkdtemp(dir=arguments.output))
    whole, killed = folder / "whole", folder / "killed"
    seconds = run.finish(whole)
    print(f"undisturbed: {seconds:.1f} s", flush=True)
    kills = fallbacks = finished = launchers = 0
    while kills < arguments.kills:
        process = run.start(killed, *how_to_start(killed))
        try:
            # Mostly short lives, so that starts and restarts are hit too.
            text = process.communicate(
                timeout=seconds * rng.choice([0.02, 0.05, 0.2])
                * rng.uniform(0.5, 2))[0]
            if process.returncode != 0:
                sys.exit(f"exit code {process.returncode}: {text}")
            finished += 1
            shutil.rmtree(killed)
        except subprocess.TimeoutExpired:
            text, stayed = kill(process, rng)
            kills += 1
            launchers += stayed
            outputs(killed)  # all that bears its final name is whole
        fallbacks += "falls back" in text
    run.finish(killed, *how_to_start(killed))
    expected, found = outputs(whole), outputs(killed)
    wrong = [name for name in sorted({*expected, *found})
             if expected.get(name) != found.get(name)]
    print(f"{kills} kills, {finished} runs that finished between them, "
          f"{fallbacks} checkpoints passed over, {launchers} launchers that "
          f"stayed behind; {len(wrong)} of {len(expected)} datasets and files "
          f"differ")
    if wrong:
        print("\n  ".join([f"in {folder}:", *wrong]))
        return 1
    shutil.rmtree(folder)
    return 0


if __name__ == "__main__":
    sys.exit(main())
