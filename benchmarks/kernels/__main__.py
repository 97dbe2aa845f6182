"""Times a step and its parts, beside what the machine allows.

Usage: python3 benchmarks/kernels [--kernels PATH] [--small] [--filter REGEX]
           [--output DIR] [--docs] [WORD]...

Runs machpoint_kernels on all threads, prints a table and writes
DIR/results.json (Google Benchmark's) and DIR/roofline.png. --docs also writes the
quadratic rows to docs/performance.md, and docs/pictures/roofline.png. Words are
handed on (--particles NUMBER, --cycles NUMBER, --samples NUMBER). Exit code: 0.
"""
import argparse
import json
import pathlib
import shutil
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] /
                       "performance"))

import machine
import page
import results
import roofline

HEAD = """Written by `python3 benchmarks/kernels --docs`; Machpoint `{revision}`,
{backend} on {threads:.0f} threads of {processor}. In the same session the triad
moved {triad_one:.1f} GB/s on one thread and {triad_all:.1f} GB/s on all, and
multiply-adds ran at {fma_one:.0f} and {fma_all:.0f} Gflop/s.

![Roofline](pictures/roofline.png)

"""


def section(found):
    """Of docs/performance.md."""
    some = {key: row for key, row in results.rows(found).items()
            if key[1] == "quadratic"}
    limits = results.limits(found)
    words = {key: value / 1e9 for key, value in limits.items()}
    words["threads"] = limits["threads"]
    return HEAD.format(revision=found["context"]["revision"],
                       backend=found["context"]["backend"],
                       processor=machine.processor(), **words) + \
        results.table(some)


def picture(found, path):
    """The roofline of the steps in 2D, 4 per cell, or of what there is."""
    rows = results.rows(found)
    some = {key: row for key, row in rows.items()
            if key[1:5] == ("quadratic", 2, 4, "mixed")}
    if not some:
        first = next(iter(rows))
        some = {key: row for key, row in rows.items() if key[1:5] == first[1:5]}
    _, basis, dim, per_cell, order, _ = next(iter(some))
    roofline.draw(some, results.limits(found), path,
                  f"{dim}D, {basis}, {per_cell} per cell, {order}, "
                  f"{results.limits(found)['threads']:.0f} threads")


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--kernels", metavar="PATH",
                        default=page.ROOT / "build/openmp" /
                        results.EXECUTABLE)
    parser.add_argument("--output", metavar="DIR", default="out/kernels")
    parser.add_argument("--filter", metavar="REGEX", default=".")
    parser.add_argument("--small", action="store_true",
                        help="tiny cases: does it work?")
    parser.add_argument("--docs", action="store_true")
    arguments, words = parser.parse_known_args()
    if arguments.docs and arguments.small:
        parser.error("--docs is of the full size")
    if arguments.small:
        words += ["--small", "--particles", "1000", "--samples", "1"]
    found = results.run(arguments.kernels,
                        [f"--benchmark_filter={arguments.filter}", *words])
    print(results.table(results.rows(found)))
    output = pathlib.Path(arguments.output)
    output.mkdir(parents=True, exist_ok=True)
    (output / "results.json").write_text(json.dumps(found, indent=2) + "\n")
    picture(found, output / "roofline.png")
    if arguments.docs:
        shutil.copy(output / "roofline.png",
                    page.ROOT / "docs" / "pictures" / "roofline.png")
        page.write("kernels", section(found))
    return 0


if __name__ == "__main__":
    sys.exit(main())
