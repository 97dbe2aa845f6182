"""What tools/gpu_check does; it is run by that, which has the usage."""
import argparse
import math
import os
import pathlib
import subprocess
import sys

from call import ROOT
from check import STAGES, Check


def has_gpu():
    """nvidia-smi names one."""
    try:
        found = subprocess.run(["nvidia-smi", "-L"], capture_output=True,
                               text=True)
    except FileNotFoundError:
        return False
    return found.returncode == 0 and "GPU" in found.stdout


def main():
    presets = ["serial", "openmp", "cuda"]
    stages = argparse.ArgumentParser(add_help=False)
    stages.add_argument("--stage", action="append", choices=STAGES)
    parser = argparse.ArgumentParser(prog="tools/gpu_check", parents=[stages])
    parser.add_argument("--limit", type=float, default=math.inf,
                        metavar="SECONDS")
    parser.add_argument("--quick", action="store_true",
                        help="coarser scenes, smaller measurements")
    parser.add_argument("--output", type=pathlib.Path, metavar="DIR",
                        default=ROOT / "out/gpu_check")
    parser.add_argument("--set", action="append", default=[],
                        metavar="OPTION=VALUE", help="for CMake")
    parser.add_argument("--preset", choices=presets, default="cuda")
    parser.add_argument("--reference", choices=presets, default="openmp")
    parser.add_argument("--dry-run", action="store_true",
                        help="show what would be run")
    options = parser.parse_args()
    # Commands run at the root of the repository, wherever this one does.
    if deps := os.environ.get("MACHPOINT_DEPS"):
        os.environ["MACHPOINT_DEPS"] = os.path.abspath(deps)
    # To call another stage with.
    options.others = stages.parse_known_args()[1]
    if options.preset == options.reference:
        parser.error("a preset compared with itself tells nothing")
    if options.preset == "cuda" and not options.dry_run and not has_gpu():
        print("gpu_check: nvidia-smi names no GPU on this machine; to try the "
              "check itself, add --preset openmp --reference serial",
              file=sys.stderr)
        return 2
    check = Check(options)
    if not options.dry_run:
        check.output.mkdir(parents=True, exist_ok=True)
    # All are run, also after one has failed.
    passed = [check.perform(stage) for stage in options.stage or STAGES]
    if not options.dry_run:
        check.report()
    return 0 if all(passed) else 1


if __name__ == "__main__":
    sys.exit(main())
