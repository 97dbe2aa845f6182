"""Times a step and its parts, beside what the machine allows.

Usage: python3 benchmarks/kernels [--kernels PATH] [--small] [--filter REGEX]
           [--particles NUMBER] [--cycles NUMBER] [--samples NUMBER]
           [--mpiexec COMMAND] [--output DIR] [--docs]

Runs machpoint_kernels on all threads, then on two ranks of one thread each what
these tell each other, prints a table, says whether the machine was quiet, and
writes DIR/results.json (Google Benchmark's, and `ranks`, that of the two) and
DIR/roofline.png. --docs runs a million particles, past the cache, and also writes
docs/performance.md and docs/pictures/roofline.png. Where two ranks cannot be started,
or fail, their rows are left out, and the reason is told. Exit code: 0; 1 when
machpoint_kernels fails or lacks what was asked for, or nothing draws pictures; 2 for
options that cannot be met.
"""
import json
import pathlib
import shutil
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] /
                       "performance"))

import launcher
import machine
import messages
import options
import page
import results

# What the page shows: all of these, with at least these sizes. In 3D a step of
# particles in no order takes as long as all others together.
METHODS = ["paper", "apic", "conservative_symplectic", "conservative_midpoint"]
PER_CELL = {1: 3, 2: 4, 3: 8}
ORDERS = {1: ["ordered", "mixed", "unsorted"],
          2: ["ordered", "mixed", "unsorted"], 3: ["ordered", "mixed"]}
CASES = [(method, "quadratic", dim, PER_CELL[dim], order)
         for method in METHODS for dim, orders in ORDERS.items()
         for order in orders]
SHOWN = "^({})/".format("|".join(
    results.case_name(case) + ("/step" if case[4] == "unsorted" else "")
    for case in CASES))
MPIEXEC = "mpirun"
LEAST = {"particles": 1 << 20, "samples": 3}

HEAD = """{written}; Machpoint `{revision}`,
{backend} on {threads:.0f} threads of {processor}, a million particles. {quiet}

In the same session the triad moved {ordinary_one:.1f} GB/s on one thread and
{ordinary_all:.1f} GB/s on all{streamed}, and
multiply-adds ran at {fma_one:.0f} and {fma_all:.0f} Gflop/s.
{messages}

![Roofline](pictures/roofline.png)

"""
STREAMED = """; past the cache {streamed_one:.1f} and {streamed_all:.1f} GB/s; the
larger is the limit"""
MESSAGES = """`halo` and `migrate` are of two ranks with one thread each, whose
triads moved {triad_all:.1f} GB/s together."""


def section(found):
    """Of docs/performance.md."""
    limits = results.limits(found)
    words = {key: value / 1e9 for key, value in limits.items()}
    words["threads"] = limits["threads"]
    streamed = STREAMED.format(**words) if limits["streamed_all"] else \
        ", with ordinary stores, as this build has no others"
    if "ranks" in found:
        two = results.limits(found["ranks"])
        told = MESSAGES.format(triad_all=two["triad_all"] / 1e9)
    else:
        told = f"No `halo` nor `migrate`: {found['lacks'].splitlines()[0]}."
    return HEAD.format(written=page.written_by("kernels", True),
                       revision=found["context"]["revision"],
                       backend=found["context"]["backend"],
                       processor=machine.processor(), streamed=streamed,
                       messages=told,
                       quiet=machine.in_words(found["machine"]), **words) + \
        results.table(rows(found))


def rows(found):
    """Of one rank, and of two where these ran."""
    one = results.rows(found)
    return messages.joined(one, results.rows(found["ranks"])) \
        if "ranks" in found else one


def picture(found, path):
    """The roofline of the steps in 2D, 4 per cell, or of what there is."""
    import roofline
    every = results.rows(found)
    some = {key: row for key, row in every.items()
            if key[1:5] == ("quadratic", 2, 4, "mixed")}
    if not some:
        first = next(iter(every))
        some = {key: row for key, row in every.items()
                if key[1:5] == first[1:5]}
    _, basis, dim, per_cell, order, _ = next(iter(some))
    roofline.draw(some, results.limits(found), path,
                  f"{dim}D, {basis}, {per_cell} per cell, {order}, "
                  f"{results.limits(found)['threads']:.0f} threads")


def measure(arguments, cases, words):
    """Google Benchmark's JSON, with `ranks` (or what `lacks` for these) and
    `machine`: was it quiet? Rows of one rank may have failed."""
    triad = pathlib.Path(arguments.kernels).parent / "machpoint_triad"
    watch = machine.Watch(triad if triad.exists() else None)
    seconds = 0.1 if arguments.small else 1
    watch.probe(seconds)
    found = results.run(arguments.kernels,
                        [f"--benchmark_filter={arguments.filter}", *words])
    watch.probe(seconds)
    try:
        found["ranks"] = two_ranks(arguments, found, cases, words)
        watch.probe(seconds)
    except messages.Lacking as reason:
        found["lacks"] = str(reason)
    found["machine"] = watch.report(results.spreads(found))
    return found


def two_ranks(arguments, found, cases, words):
    """Their JSON. found: of one rank. \\raises messages.Lacking"""
    if found["context"]["mpi"] != "yes":
        raise messages.Lacking("built without MPI")
    if not arguments.mpiexec:
        raise messages.Lacking(f"there is no {MPIEXEC}")
    return messages.measure(arguments.kernels, cases, words, arguments.mpiexec)


def require_all(cases):
    """Ends where a row of the page is missing. cases: keys of results.rows"""
    steps = {key[:5] for key in cases if key[5] == "step"}
    missing = [results.case_name(case) for case in CASES
               if case not in steps]
    if missing:
        raise SystemExit("--docs: the build lacks " + ", ".join(missing) +
                         "; build all dimensions and methods")


def parse():
    parser = options.parser(__doc__)
    parser.add_argument("--kernels", metavar="PATH",
                        default=page.ROOT / "build/openmp" /
                        results.EXECUTABLE,
                        help=f"default: build/openmp/{results.EXECUTABLE}")
    parser.add_argument("--output", metavar="DIR", type=options.folder,
                        default="out/kernels", help="default: out/kernels")
    parser.add_argument("--filter", metavar="REGEX",
                        help="of names that machpoint_kernels "
                        "--benchmark_list_tests tells; default: all")
    results.add_sizes(parser)
    parser.add_argument("--mpiexec", metavar="COMMAND", default=MPIEXEC,
                        help=f"starts two ranks; default: {MPIEXEC}")
    parser.add_argument("--small", action="store_true",
                        help="tiny cases: does it work?")
    parser.add_argument("--docs", action="store_true",
                        help="write docs/performance.md, too")
    arguments = parser.parse_args()
    if arguments.docs and (arguments.small or arguments.filter):
        parser.error("--docs is of all rows at full size: leave out --small "
                     "and --filter")
    for name, least in LEAST.items() if arguments.docs else ():
        value = getattr(arguments, name) or least
        if value < least:
            parser.error(f"--docs takes at least {least} {name}, or the page "
                         f"would show a trial: leave out --{name}")
        setattr(arguments, name, value)
    if arguments.small:
        arguments.particles = arguments.particles or 1000
        arguments.samples = arguments.samples or 1
    arguments.filter = arguments.filter or (SHOWN if arguments.docs else ".")
    # What nobody named may be missing, and then its rows are left out.
    missing = arguments.mpiexec == MPIEXEC and not shutil.which(MPIEXEC)
    arguments.mpiexec = [] if missing else \
        launcher.find(parser, arguments.mpiexec)
    return arguments


def main():
    arguments = parse()
    import figure # says what pictures lack
    words = results.size_words(arguments)
    if arguments.small:
        words.append("--small")
    cases = results.cases(arguments.kernels,
                          [f"--benchmark_filter={arguments.filter}"])
    if arguments.docs:
        page.require("kernels")
        require_all(cases)
    found = measure(arguments, cases, words)
    (arguments.output / "results.json").write_text(
        json.dumps(found, indent=2) + "\n")
    print(results.table(rows(found)))
    if "lacks" in found:
        print(f"left out, halo and migrate: {found['lacks']}")
    print(machine.in_words(found["machine"]))
    picture(found, arguments.output / "roofline.png")
    if arguments.docs:
        shutil.copy(arguments.output / "roofline.png",
                    page.ROOT / "docs" / "pictures" / "roofline.png")
        page.write("kernels", section(found))
    return 0


if __name__ == "__main__":
    sys.exit(main())
