"""Are predictions right? Prices told beforehand beside those that runs then paid.

Usage: python3 benchmarks/price.py [--machpoint PATH] [--threads NUMBER] [NAME]...

For each scene of a list, or those named, compares `machpoint run --estimate` with
the run itself (time of the steps alone, without outputs; the better of two runs),
and, where an exact solution is known, the error that `--estimate-error` tells with
the true one. Prints both tables in Markdown, as in docs/accuracy.md. A scene that
the program was not built for is left out, and named. Exit code: 0.
"""
import json
import os
import pathlib
import re
import subprocess
import sys
import tempfile

sys.path.append(str(pathlib.Path(__file__).resolve().parent / "performance"))

import executable
import options
from page import ROOT

# What is timed: some seconds each.
TIMED = {
    "two_blasts": ["grid.cells=[1600]"],
    "shu_osher": ["grid.cells=[1800]"],
    "kelvin_helmholtz": ["grid.cells=[96,96]"],
    "isentropic_vortex": ["time.end=4"],
    "cylinder_mach3": ["grid.cells=[100,50]"],
    "filling": [],
    "noh_2d": ["grid.cells=[120,120]"],
    "sedov_2d": [],
    "noh_3d": [],
    "sod_3d": ["grid.cells=[256,4,4]"],
}
# Whose error is known.
JUDGED = {
    "sod": [], "toro3": [], "leblanc": [], "noh_1d": [], "slow_shock": [],
    "vacuum": [], "moving_contact": [], "acoustic_wave": [],
    "isentropic_vortex": ["time.end=2"], "noh_2d": ["grid.cells=[64,64]"],
    "sedov_2d": ["grid.cells=[64,64]"], "noh_3d": [],
}
UNITS = {"s": 1, "min": 60, "h": 3600, "days": 86400, "MiB": 1, "GiB": 1024}


class Lacking(Exception):
    """The program was not built for this scene."""


def machpoint(arguments, scene, sets, *options):
    """What `machpoint run` prints."""
    words = [arguments.machpoint, "run", str(ROOT / "input" / f"{scene}.json"),
             *options]
    for text in sets:
        words += ["--set", text]
    result = subprocess.run(
        words, capture_output=True, text=True, check=False,
        env=dict(os.environ, OMP_NUM_THREADS=str(arguments.threads),
                 OMP_PROC_BIND="false"))
    if "this build has no" in result.stderr:
        raise Lacking(scene)
    if result.returncode:
        sys.exit(f"{' '.join(words)}:\n{result.stdout}{result.stderr}")
    return result.stdout


def summary(arguments, scene, sets, *options):
    """A run's summary.json."""
    with tempfile.TemporaryDirectory() as directory:
        machpoint(arguments, scene,
                  [*sets, "output.particles=false", "output.grid=false"],
                  "--output", directory, "--quiet", *options)
        return json.loads(
            (pathlib.Path(directory) / "summary.json").read_text())


def estimate(text):
    """What `--estimate` printed: steps, particles at the end, seconds from the
    least to the most, MiB."""
    seconds = [float(number) * UNITS[unit] for number, unit in re.findall(
        r"([\d.e+-]+) (s|min|h|days)\b",
        re.search(r"^  time +(.*)$", text, re.M)[1])]
    memory = re.search(r"^  memory +([\d.e+-]+) (\w+)", text, re.M)
    return {
        "steps": int(re.search(r"^  steps +(\d+)", text, re.M)[1]),
        "particles": int(re.search(r"start, (\d+) at", text)[1]),
        "seconds": seconds[0], "least": seconds[1], "most": seconds[2],
        "mebibytes": float(memory[1]) * UNITS[memory[2]]
    }


def time_row(arguments, scene, sets):
    """Predicted and real price of a scene."""
    told = estimate(machpoint(
        arguments, scene,
        [*sets, "output.particles=false", "output.grid=false"], "--estimate"))
    runs = [summary(arguments, scene, sets) for _ in range(2)]
    real = min(runs, key=lambda run: run["wall_seconds"])
    seconds = real["wall_seconds"]
    memory = real["peak_memory_bytes"] / 2**20

    def ratio(predicted, measured):
        return f"{100 * (predicted / measured - 1):+.0f} %"

    return [
        f"`{scene}` {' '.join(sets)}".strip(),
        f"{told['steps']}, {real['steps']} "
        f"({ratio(told['steps'], real['steps'])})",
        f"{told['particles']}, {real['particles_final']} "
        f"({ratio(told['particles'], real['particles_final'])})",
        f"{told['seconds']:.3g} ({told['least']:.3g} to {told['most']:.3g}), "
        f"{seconds:.3g} ({ratio(told['seconds'], seconds)})",
        f"{told['mebibytes']:.3g}, {memory:.3g} "
        f"({ratio(told['mebibytes'], memory)})"
    ]


def error_row(arguments, scene, sets):
    """Estimated and true error of a scene: L1 of three fields."""
    run = summary(arguments, scene, sets, "--estimate-error")
    fields = run["error_estimate"].get("fields")
    row = [f"`{scene}` {' '.join(sets)}".strip()]
    if not fields:
        return [*row, run["error_estimate"]["message"], "", "", ""]
    for name in ["density", "velocity", "pressure"]:
        told, true = fields[name]["L1"], run["errors"][name]["L1"]
        ratio = f" ({told / true:.2f})" if true > 1e-12 else ""
        row.append(f"{told:.2e}, {true:.2e}{ratio}")
    order = fields["density"]["observed_order"]
    row.append("-" if order is None else f"{order:.2f}")
    price = sum(c["seconds"] for c in run["error_estimate"]["companions"])
    row.append(f"{100 * price / run['wall_seconds']:.0f} %")
    return row


def table(arguments, head, scenes, make_row):
    """Prints a table as it grows."""
    print("| " + " | ".join(head) + " |")
    print("|" + "---|" * len(head))
    for scene, sets in scenes.items():
        if arguments.names and scene not in arguments.names:
            continue
        try:
            print("| " + " | ".join(make_row(arguments, scene, sets)) + " |",
                  flush=True)
        except Lacking:
            print(f"{scene}: the program was not built for it",
                  file=sys.stderr)
    print()


def main():
    parser = options.parser(__doc__)
    parser.add_argument("names", nargs="*", metavar="NAME",
                        help="of a scene; default: all of the list")
    executable.add_option(parser)
    parser.add_argument("--threads", type=options.whole(1), default=1,
                        metavar="NUMBER", help="default: 1")
    arguments = parser.parse_args()
    for name in arguments.names:
        if name not in TIMED and name not in JUDGED:
            parser.error(f"no scene {name}; there are "
                         + ", ".join(sorted({*TIMED, *JUDGED})))
    table(arguments,
          ["`--estimate`: told, real", "steps", "particles at the end", "seconds",
           "MiB"], TIMED, time_row)
    table(arguments,
          ["`--estimate-error`: told, true", "density", "velocity", "pressure",
           "observed order", "companions' time"], JUDGED, error_row)


if __name__ == "__main__":
    main()
