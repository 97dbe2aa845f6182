"""Times kernels of several builds in turn, so that a restless host slows all alike.

Usage: python3 benchmarks/kernels/pairs.py BUILD BUILD... [--filter REGEX]
           [--threads NUMBER] [--rounds NUMBER] [--particles NUMBER]
           [--cycles NUMBER] [--samples NUMBER]

BUILD is a folder with machpoint_kernels. Prints for each case and build the least and
the median of the rounds in ns a particle step, and the ratio of both to the first
build's. A round has one sample unless told. Exit code: 0.
"""
import pathlib
import statistics
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] /
                       "performance"))

import options
import page
import results


def measure(builds, rounds, words, threads=None):
    """{case: [ns of each round, for each build]}"""
    times = {}
    for _ in range(rounds):
        for number, build in enumerate(builds):
            found = results.run(pathlib.Path(build) / results.EXECUTABLE,
                                words, threads)
            for case, row in results.rows(found).items():
                of_builds = times.setdefault(case, [[] for _ in builds])
                of_builds[number].append(1e9 / row["updates_per_second"])
    return times


def table(builds, times):
    """A row for each case and build."""
    lines = []
    for case, of_builds in times.items():
        name = "/".join(str(word) for word in case)
        first = of_builds[0]
        for build, own in zip(builds, of_builds):
            if not first or not own:
                raise SystemExit(f"{build} lacks {name}, or the first build does")
            least, median = min(own), statistics.median(own)
            lines.append([name, build, f"{least:.2f}", f"{median:.2f}",
                          f"{least / min(first):.3f}",
                          f"{median / statistics.median(first):.3f}"])
    return page.table(["case", "build", "least, ns", "median, ns",
                       "least over the first's", "median over the first's"],
                      lines)


def main():
    parser = options.parser(__doc__)
    parser.add_argument("builds", metavar="BUILD", nargs="+",
                        help="a folder with machpoint_kernels")
    parser.add_argument("--filter", metavar="REGEX",
                        default="^apic/quadratic/2D/4/ordered/(step|P2G|G2P)/",
                        help="of the names of cases; default: apic in 2D")
    parser.add_argument("--threads", metavar="NUMBER", default=1,
                        type=options.whole(1), help="default: 1")
    parser.add_argument("--rounds", metavar="NUMBER", default=8,
                        type=options.whole(1), help="default: 8")
    results.add_sizes(parser)
    parser.set_defaults(samples=1)
    arguments = parser.parse_args()
    for build in arguments.builds:
        if not (pathlib.Path(build) / results.EXECUTABLE).exists():
            parser.error(f"{build} has no {results.EXECUTABLE}")
    # Limits of the machine, which nobody reads here, in milliseconds.
    words = ["--small", *results.size_words(arguments)]
    times = measure(arguments.builds, arguments.rounds,
                    [f"--benchmark_filter={arguments.filter}", *words],
                    arguments.threads)
    print(table(arguments.builds, times))
    return 0


if __name__ == "__main__":
    sys.exit(main())
