"""What accuracy costs: runs the shipped studies and fills docs/accuracy.md.

Usage: python3 benchmarks/accuracy [--machpoint PATH] [--study NAME]...
           [--repeats NUMBER] [--output DIR] [--docs]

Runs input/studies/*.json, but that of the viscous shock, on one thread, each into
DIR/NAME, and the advice of ADVICE below; prints a table for each. --docs, of all studies,
also writes the tables to docs/accuracy.md, and the pictures that it shows to
docs/pictures. What is in
DIR already is not run again. --repeats replaces that of the studies. Exit code: 0; 1 when
a study fails.
"""
import json
import os
import pathlib
import shutil
import subprocess
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] /
                       "performance"))

import executable
import machine
import options
import page

ROOT = page.ROOT
PAGE = ROOT / "docs" / "accuracy.md"
# docs/diffusion.md shows the one left out.
STUDIES = sorted(p.stem for p in (ROOT / "input/studies").glob("*.json")
                 if p.stem != "viscous_shock")
# Held out, that is not among the runs of the study.
ADVICE = [("sod", "--target", "density.L1=1e-3"), ("sod", "--budget", "1s"),
          ("leblanc", "--target", "density.L1=1.5e-2"),
          ("cylinder_mach3", "--budget", "20s")]


def run(machpoint, study, output, repeats, *advice):
    """A study, perhaps with advice. Returns study.json, and what it printed."""
    folder = output / study
    source = ROOT / f"input/studies/{study}.json"
    if repeats:
        text = json.loads(source.read_text())
        text.update(repeats=repeats,
                    input=str((source.parent / text["input"]).resolve()))
        source = output / f"{study}.json"
        source.write_text(json.dumps(text))
    environment = dict(os.environ, OMP_NUM_THREADS="1", OMP_PROC_BIND="false")
    result = subprocess.run([machpoint, "study", source, "--output", folder, *advice],
                            stdout=subprocess.PIPE, text=True, env=environment,
                            check=False)
    # Advice that is out of reach ends with 1.
    if result.returncode not in ((0, 1) if advice else (0,)):
        sys.exit(f"{study}: ended with code {result.returncode}")
    return json.loads((folder / "study.json").read_text()), result.stdout


def seconds(value):
    return f"{value:.2g} s" if value < 10 else f"{value:.0f} s"


def laws(law):
    half = law["halving_takes"]
    return ["-" if law["time_exponent"] is None else f"{law['time_exponent']:.2f}",
            "-" if law["order"] is None else f"{law['order']:.2f}",
            "-" if half is None else "> 1000" if half > 1000 else f"{half:.2f}"]


def runs_table(study):
    """Lines down, cells across: error, seconds; bold on the Pareto front."""
    sizes = []
    for row in study["rows"]:
        if row["cells"] not in sizes:
            sizes.append(row["cells"])
    sizes.sort(key=lambda cells: cells[0])
    rows = []
    for law in study["laws"]:
        line = [law["line"]]
        for cells in sizes:
            found = [r for r in study["rows"] if r["line"] == law["line"] and
                     r["cells"] == cells]
            text = ""
            if found and found[0]["status"] != "finished":
                text = found[0]["status"]
            elif found:
                error = found[0].get("errors", {}).get(study["error"])
                error = "-" if error is None else f"{error:.2e}"
                text = f"{error}, {seconds(found[0]['seconds'])}"
                if found[0]["id"] in study["pareto"]:
                    text = f"**{text}**"
            line.append(text)
        rows.append(line + laws(law))
    head = ["line", *("x".join(map(str, cells)) for cells in sizes),
            "time ~ cells^a", "error ~ h^p", "half the error"]
    return page.table(head, rows)


def difference(told, real):
    return f"{told:.3g}, {real:.3g} ({100 * (real / told - 1):+.0f} %)" \
        if told and real else "-"


def advice_table(studies):
    rows = []
    for study in studies:
        for proof in study["proofs"]:
            row = proof["row"]
            rows.append([f"{study['study']}, `{proof['request']}`",
                         f"{row['line']}, {'x'.join(map(str, row['cells']))}",
                         difference(proof["predicted"]["seconds"], proof["seconds"]),
                         difference(proof["predicted"]["error"], proof["value"])])
    return page.table(["asked", "answer", "seconds, predicted and real",
                       "error, predicted and real"], rows)


def spreads(study):
    return [machine.spread(row["wall_rounds"]) for row in study["rows"]
            if len(row.get("wall_rounds", [])) > 1]


def main():
    parser = options.parser(__doc__)
    executable.add_option(parser)
    parser.add_argument("--study", metavar="NAME", action="append",
                        choices=STUDIES, help="may be repeated; default: all")
    parser.add_argument("--repeats", type=options.whole(1), metavar="NUMBER",
                        help="how often each run is timed; default: as each study says")
    parser.add_argument("--output", metavar="DIR", type=options.folder,
                        default="out/accuracy", help="default: out/accuracy")
    parser.add_argument("--docs", action="store_true",
                        help="write docs/accuracy.md, too")
    arguments = parser.parse_args()
    import figure # says what pictures lack
    if arguments.docs and (arguments.repeats or arguments.study):
        parser.error("--docs is of all studies, with their own repeats: leave out "
                     "--repeats and --study")
    chosen = arguments.study or STUDIES
    if arguments.docs:
        page.require("studies", "advice", *(f"study {name}" for name in STUDIES),
                     path=PAGE)
    machpoint = pathlib.Path(arguments.machpoint).resolve()
    output = arguments.output
    watch = machine.Watch()
    studies = {}
    for name in chosen:
        studies[name], shown = run(machpoint, name, output, arguments.repeats)
        for study, *advice in ADVICE:
            if study == name:
                studies[name], _ = run(machpoint, name, output,
                                       arguments.repeats, *advice)
        folder = output / name
        subprocess.run([sys.executable, ROOT / "tools/plot.py", "study", folder],
                       check=True, stdout=subprocess.DEVNULL)
        is_of_effects = studies[name].get("kind") == "effects"
        picture = "effects.png" if is_of_effects else "work_precision.png"
        # All but the last line, which names the folder.
        text = "```\n" + shown.strip().rsplit("\n", 1)[0] + "\n```\n" \
            if is_of_effects else runs_table(studies[name])
        print(f"{name}\n{text}")
        if arguments.docs:
            page.write(f"study {name}", text, PAGE)
            shown = f"pictures/{name if is_of_effects else f'study_{name}'}.png"
            if shown in PAGE.read_text():
                shutil.copy(folder / picture, ROOT / "docs" / shown)
    text = advice_table(studies.values())
    seen = watch.report(sum(map(spreads, studies.values()), []))
    revisions = {row["revision"] for study in studies.values()
                 for row in study["rows"] if "revision" in row}
    words = (f"{page.written_by('accuracy', arguments.docs)}; Machpoint "
             f"`{', '.join(sorted(revisions))}`, {machine.processor()}, one thread, "
             f"wall clock, medians. {machine.in_words(seen)}")
    print(text, words, sep="\n")
    if arguments.docs:
        page.write("studies", words, PAGE)
        page.write("advice", text, PAGE)
    return 0


if __name__ == "__main__":
    sys.exit(main())
