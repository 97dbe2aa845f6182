"""The hard cases: which method survives them, and how well.

Usage: python3 benchmarks/hard_cases [--fast] [--case NAME]... [--method NAME]...
           [--machpoint PATH] [--reference PATH] [--output DIR] [--docs]

Prints a line for each case and method and writes DIR/results.json; results are
kept in DIR, so that a long run can be continued. --docs writes
docs/stability.md and docs/pictures/hard_cases_*.png from what DIR holds.
Exit code: 0 if `conservative` keeps every invariant and bound, else 1.
"""
import argparse
import json
import pathlib
import sys

import suite
from run import METHODS, ROOT, relative


def line(case, result):
    """One line for a terminal."""
    missed = suite.misses(case, result)
    verdict = "BROKEN" if result["broken"] else "MISSED" if missed else "ok"
    values = ", ".join(f"{label} {relative(value)}"
                       for label, value in result["values"].items())
    text = (f"{case.name:<20} {result['method']:<13} {verdict:<7}"
            f"{result['seconds']:7.1f} s  retries {result['retries']}, "
            f"energy {relative(result['energy_drift'])}; {values}")
    for problem in result["broken"] + missed:
        text += f"\n    {problem}"
    return text


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--fast", action="store_true",
                        help="seconds instead of hours")
    parser.add_argument("--case", action="append", metavar="NAME")
    parser.add_argument("--method", action="append", choices=list(METHODS))
    parser.add_argument("--machpoint", metavar="PATH",
                        default=ROOT / "build/openmp/machpoint")
    parser.add_argument("--reference", metavar="PATH",
                        help="machpoint_reference; default: beside machpoint")
    parser.add_argument("--output", metavar="DIR", default="out/hard_cases")
    parser.add_argument("--docs", action="store_true")
    parser.add_argument("--keep", action="store_true", help="keep all fields")
    arguments = parser.parse_args()

    names = [case.name for case in suite.CASES]
    for name in arguments.case or []:
        if name not in names:
            parser.error(f"no case {name}; there are {', '.join(names)}")
    reference = arguments.reference
    beside = pathlib.Path(arguments.machpoint).parent / "machpoint_reference"
    if reference is None and beside.exists():
        reference = beside
    work = suite.Suite(arguments.machpoint, arguments.output, reference,
                       arguments.fast, arguments.keep)
    results, failed = [], False
    for case in suite.CASES:
        if arguments.case and case.name not in arguments.case:
            continue
        for method in arguments.method or case.methods:
            result = work.measure(case, method)
            results.append(result)
            print(line(case, result), flush=True)
            failed |= method == "conservative" and bool(
                result["broken"] or suite.misses(case, result))
    (work.output / "results.json").write_text(json.dumps(results, indent=1))
    return failed


if __name__ == "__main__":
    sys.exit(main())
