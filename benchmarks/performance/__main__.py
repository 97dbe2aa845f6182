"""Regenerates the tables and pictures of docs/performance.md, in turn.

Usage: python3 benchmarks/performance [--python PATH]

Runs benchmarks/speed, benchmarks/kernels and benchmarks/sod_sweep with --docs, on
the presets that are built. PATH: an interpreter that has taichi and warp. Takes
an hour or more, of a quiet machine. Exit code: 0, or that of the one that failed.
"""
import argparse
import pathlib
import subprocess
import sys

HERE = pathlib.Path(__file__).resolve().parents[1]


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--python", metavar="PATH", default=sys.executable)
    arguments = parser.parse_args()
    for words in (["speed", "--python", arguments.python], ["kernels"],
                  ["sod_sweep"]):
        code = subprocess.run([sys.executable, HERE / words[0], *words[1:],
                               "--docs"], check=False).returncode
        if code != 0:
            return code
    return 0


if __name__ == "__main__":
    sys.exit(main())
