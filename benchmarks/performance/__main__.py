"""Regenerates the tables and pictures of docs/performance.md, in turn.

Usage: python3 benchmarks/performance [--python PATH] [--rounds NUMBER]

Runs benchmarks/speed, benchmarks/kernels and benchmarks/sod_sweep with --docs, once it
has seen that there is what they need: the presets serial and openmp, of one revision,
and what draws pictures. PATH: an interpreter that has taichi and warp. NUMBER: rounds
of the first and the last, at least 3 (default: as each has it); with 3 it takes 25 minutes
of a quiet machine with two cores. Exit code: 0, or that of the one that failed.
"""
import pathlib
import subprocess
import sys

HERE = pathlib.Path(__file__).resolve().parents[1]
sys.path += [str(HERE / "kernels"), str(HERE / "speed")]

import jobs
import options
import page


def main():
    parser = options.parser(__doc__)
    parser.add_argument("--python", metavar="PATH", type=options.program,
                        default=sys.executable,
                        help="interpreter that has taichi and warp")
    parser.add_argument("--rounds", metavar="NUMBER",
                        type=options.whole(options.ROUNDS),
                        help="of speed and sod_sweep; default: as each has it")
    arguments = parser.parse_args()
    import figure # says what pictures lack
    page.require("speed", "kernels", "sod_sweep")
    build = page.ROOT / "build"
    missing = jobs.missing(build / "openmp") or jobs.missing(build / "serial")
    if missing:
        parser.error(f"{missing.relative_to(page.ROOT)} is missing: build the "
                     "presets serial and openmp")
    revisions = {jobs.revision(build / name / "machpoint")
                 for name in ("serial", "openmp")}
    if len(revisions) > 1:
        parser.error(f"the builds are of {' and '.join(sorted(revisions))}: build "
                     "both anew")
    rounds = ["--rounds", str(arguments.rounds)] if arguments.rounds else []
    for words in (["speed", "--python", arguments.python, *rounds], ["kernels"],
                  ["sod_sweep", *rounds]):
        code = subprocess.run([sys.executable, HERE / words[0], *words[1:],
                               "--docs"], check=False).returncode
        if code != 0:
            return code
    return 0


if __name__ == "__main__":
    sys.exit(main())
