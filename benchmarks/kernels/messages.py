"""What ranks tell each other in a step: `halo` and `migrate` of two ranks with one
thread each."""
import shlex
import shutil

import results

PARTS = ["halo", "migrate"]


class Lacking(Exception):
    """Ranks cannot be started; the text says why."""


def launcher(found, command):
    """Words that start two ranks. found: what a run of one rank measured;
    command: of MPI, None for the first of the PATH. \\raises Lacking"""
    if found["context"]["mpi"] != "yes":
        raise Lacking("built without MPI")
    words = shlex.split(command or "mpiexec")
    if not words or not shutil.which(words[0]):
        raise Lacking(f"there is no {command or 'mpiexec'}")
    return [*words, "-n", "2"]


def measure(executable, found, words, command):
    """The JSON of these parts of the cases that one rank has run: mixed
    particles, or ordered ones where no others were. \\raises Lacking"""
    start = launcher(found, command)
    cases = {key[:4]: results.case_name(key) for key in results.rows(found)
             if key[4] != "unsorted"}
    if not cases:
        raise Lacking("only unsorted particles were asked for")
    some = f"^({'|'.join(cases.values())})/({'|'.join(PARTS)})/"
    return results.run(executable, [f"--benchmark_filter={some}", *words], 1,
                       start)


def joined(one, two):
    """Rows of both runs, case by case. \\param one, two: of results.rows"""
    cases = list(dict.fromkeys(key[:5] for key in one))
    both = {**one, **two}
    return {key: both[key] for key in
            sorted(both, key=lambda key: cases.index(key[:5]))}
