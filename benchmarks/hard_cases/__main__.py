"""The hard cases: which method survives them, and how well.

Usage: python3 benchmarks/hard_cases [--fast] [--case NAME]... [--method NAME]...
           [--machpoint PATH] [--reference PATH] [--output DIR] [--keep]
           [--set PATH=VALUE]... [--draws NUMBER] [--cfl] [--docs] [--kept]

Prints a line for each case and method and writes DIR/results.json; results are
kept in DIR, so that a long run can be continued, by one process at a time. --set
overrides a parameter in all cases: do they stay stable with time.cfl=1.2, or
method.basis=cubic? --draws solves that many random Riemann problems too, --cfl
searches the largest stable CFL numbers; --docs does both, for all cases and
methods, and writes docs/stability.md and docs/pictures/hard_cases_*.png. --kept
runs nothing and takes what DIR holds.
Exit code: 0 if `conservative` keeps every invariant and bound, else 1.
"""
import argparse
import fcntl
import json
import pathlib
import sys

sys.path.append(str(pathlib.Path(__file__).resolve().parents[1] / "performance"))

import draws
import executable
import options
import packages
import report
import stable_cfl
import suite
from run import METHODS, relative


def line(case, result):
    """One line for a terminal."""
    missed = suite.misses(case, result) \
        if result["method"] == "conservative" else []
    verdict = "BROKEN" if result["broken"] else "MISSED" if missed else "ok"
    values = ", ".join(f"{label} {relative(value)}"
                       for label, value in result["values"].items())
    text = (f"{case.name:<20} {result['method']:<13} {verdict:<7}"
            f"{result['seconds']:7.1f} s  retries {result['retries']}, "
            f"energy {relative(result['energy_drift'])}; {values}")
    for problem in result["broken"] + missed:
        text += f"\n    {problem}"
    return text


def override(text):
    """(path, value) of PATH=VALUE, the value JSON or a text."""
    path, equals, value = text.partition("=")
    if not path or not equals:
        raise argparse.ArgumentTypeError(f"{text!r} is not PATH=VALUE")
    try:
        return path, json.loads(value)
    except json.JSONDecodeError:
        return path, value


def hold(output):
    """A lock of the output folder, held until it is closed: another process
    would put its runs in the place of this one's. SystemExit if one has it."""
    output = pathlib.Path(output)
    output.mkdir(parents=True, exist_ok=True)
    lock = open(output / "lock", "w", encoding="ascii")
    try:
        fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        sys.exit(f"{output}: another process measures hard cases there; wait for "
                 "it, or give another --output")
    return lock


def main():
    parser = options.parser(__doc__)
    parser.add_argument("--fast", action="store_true",
                        help="small versions, seconds each")
    parser.add_argument("--case", action="append", metavar="NAME",
                        help="may be repeated; default: all")
    parser.add_argument("--method", action="append", choices=list(METHODS),
                        help="may be repeated; default: all")
    executable.add_option(parser)
    parser.add_argument("--reference", metavar="PATH", type=options.program,
                        help="machpoint_reference; default: beside machpoint")
    parser.add_argument("--output", metavar="DIR", type=options.folder,
                        default="out/hard_cases", help="default: out/hard_cases")
    parser.add_argument("--keep", action="store_true", help="keep all fields")
    parser.add_argument("--set", action="append", type=override, default=[],
                        metavar="PATH=VALUE", dest="sets",
                        help="of every scene, as machpoint run takes it")
    parser.add_argument("--draws", type=options.whole(1), metavar="NUMBER",
                        help="solve that many random Riemann problems, too")
    parser.add_argument("--cfl", action="store_true",
                        help="search the largest stable CFL numbers, too")
    parser.add_argument("--docs", action="store_true",
                        help="all of that; write docs/stability.md")
    parser.add_argument("--kept", action="store_true",
                        help="run nothing: take the results that DIR holds")
    arguments = packages.parse(parser)
    if arguments.docs and (arguments.fast or arguments.case or
                           arguments.method or arguments.sets):
        parser.error("--docs is of all cases and methods at full size, as "
                     "they are")
    if arguments.sets and (arguments.draws or arguments.cfl):
        parser.error("--set is for the cases, not for --draws and --cfl")
    if arguments.docs:
        import figure # says what pictures lack

    names = [case.name for case in suite.CASES]
    for name in arguments.case or []:
        if name not in names:
            parser.error(f"no case {name}; there are {', '.join(names)}")
    reference = arguments.reference
    beside = pathlib.Path(arguments.machpoint).parent / "machpoint_reference"
    if reference is None and beside.exists():
        reference = beside
    lock = hold(arguments.output)
    work = suite.Suite(arguments.machpoint, arguments.output, reference,
                       arguments.fast, arguments.keep, arguments.kept,
                       dict(arguments.sets))
    methods = arguments.method or list(METHODS)
    results, failed = {}, False
    for case in suite.CASES:
        if arguments.case and case.name not in arguments.case:
            continue
        for method in methods:
            if method not in case.methods:
                continue
            result = work.measure(case, method)
            if result is None:
                failed |= method == "conservative"
                continue
            results[case.name, method] = result
            print(line(case, result), flush=True)
            failed |= method == "conservative" and bool(
                result["broken"] or suite.misses(case, result))
    (work.output / "results.json").write_text(
        json.dumps(list(results.values()), indent=1))

    number = arguments.draws or (1000 if arguments.docs else 0)
    found_draws = {}
    for method in methods if number else []:
        found_draws[method] = draws.solve_all(work, method, range(number))
        print(f"{number} random Riemann problems, {method}: " + ", ".join(
            f"{key} {relative(value)}" for key, value in draws.digest(
                found_draws[method]).items()), flush=True)
        for result in found_draws[method]:
            if method == "conservative" and result["broken"]:
                failed = True
                print(f"    {result['broken'][0]}\n    {result['command']}")
    found_cfl = None
    if (arguments.cfl or arguments.docs) and (
            stable_cfl.is_kept(work) or not arguments.kept):
        found_cfl = stable_cfl.table(work)
    for integrator, found in (found_cfl or {}).items():
        print(f"largest CFL, {integrator}: " + ", ".join(
            f"{name} {relative(value)}" for name, value in found.items()))
    if arguments.docs:
        if not (found_cfl and all(len(found) == number
                                  for found in found_draws.values())):
            sys.exit(f"{work.output} lacks random problems or CFL numbers of this "
                     "program; leave out --kept")
        report.write(work, results, found_draws, found_cfl)
    lock.close()
    return failed


if __name__ == "__main__":
    sys.exit(main())
