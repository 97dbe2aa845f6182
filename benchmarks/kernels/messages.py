"""What ranks tell each other in a step: `halo` and `migrate` of two ranks with one
thread each."""
import shlex

import results

PARTS = ["halo", "migrate"]


class Lacking(Exception):
    """Two ranks cannot be started, or fail; the text says why."""


def measure(executable, cases, words, mpiexec):
    """The JSON of these parts of the cases that one rank has run: mixed
    particles, or ordered ones where no others were. cases: keys of
    results.rows; mpiexec: words of the launcher. \\raises Lacking"""
    some = {key[:4]: results.case_name(key) for key in cases
            if key[4] != "unsorted"}
    if not some:
        raise Lacking("only unsorted particles were asked for")
    start = [*mpiexec, "-n", "2"]
    some = f"^({'|'.join(some.values())})/({'|'.join(PARTS)})/"
    try:
        found = results.run(executable, [f"--benchmark_filter={some}", *words],
                            start=start)
        results.rows(found)
    except results.Failed as failure:
        raise Lacking(f"{shlex.join(start)}: {failure.why.strip()}") from failure
    return found


def joined(one, two):
    """Rows of both runs, case by case. \\param one, two: of results.rows"""
    cases = list(dict.fromkeys(key[:5] for key in one))
    both = {**one, **two}
    return {key: both[key] for key in
            sorted(both, key=lambda key: cases.index(key[:5]))}
