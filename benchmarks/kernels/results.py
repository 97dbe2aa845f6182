"""Runs machpoint_kernels and reads what it measured."""
import json
import os
import pathlib
import subprocess
import tempfile

import launcher
import options
import page
import program

EXECUTABLE = "machpoint_kernels"
FIGURES = ["updates_per_second", "bytes", "flops", "of_triad", "of_fma",
           "spread"]
SIZES = {"particles": "of a case, about", "cycles": "of sorts in a sample",
         "samples": "of a case, of which the median counts"}


class Failed(SystemExit):
    """A run that failed; it ends a session that does not catch it. why: less
    its command."""

    def __init__(self, command, why):
        super().__init__(f"{' '.join(map(str, command))}: {why}")
        self.why = why


def add_sizes(parser):
    """Options of machpoint_kernels that a script hands on."""
    for name, text in SIZES.items():
        parser.add_argument(f"--{name}", metavar="NUMBER",
                            type=options.whole(1), help=text)


def size_words(arguments):
    """Of the command line of machpoint_kernels: the sizes that were given."""
    return [word for name in SIZES if (value := getattr(arguments, name))
            for word in (f"--{name}", str(value))]


def cases(executable, words):
    """Keys of rows() that a run would have; nothing but the machine is measured,
    in milliseconds."""
    lines = program.execute([executable, *words, "--small",
                             "--benchmark_list_tests"], 1).splitlines()
    return [key(line) for line in lines]


def run(executable, words, threads=None, start=()):
    """Its JSON. words: of the command line; threads: of OpenMP, else as the
    environment says, or one of each rank; start: words of mpirun.
    \\raises Failed"""
    environment = launcher.ENVIRONMENT if start else os.environ
    environment = dict(environment, OMP_PROC_BIND="false")
    if threads:
        environment["OMP_NUM_THREADS"] = str(threads)
    with tempfile.TemporaryDirectory() as scratch:
        path = pathlib.Path(scratch) / "kernels.json"
        command = [*start, str(executable), *words]
        try:
            result = subprocess.run(
                [*command, f"--benchmark_out={path}",
                 "--benchmark_out_format=json"],
                env=environment, stdin=subprocess.DEVNULL,
                capture_output=True, text=True)
        except OSError as error:
            raise Failed(command[:1], error.strerror) from error
        if result.returncode != 0 or not path.exists():
            raise Failed(command, f"exit code {result.returncode}\n"
                         f"{result.stderr}")
        return json.loads(path.read_text())


def key(name):
    """(method, basis, dimension, per_cell, order, part) of a benchmark's."""
    method, basis, dim, per_cell, order, part = name.split("/")[:6]
    return method, basis, int(dim[0]), int(per_cell), order, part


def rows(found):
    """{key: figures}. \\raises Failed for a benchmark that did"""
    result = {}
    for row in found["benchmarks"]:
        if row.get("error_occurred"):
            raise Failed([row["name"]], row["error_message"])
        result[key(row["name"])] = row
    return result


def spreads(found):
    """Of the steps' samples, but for those that failed."""
    return [row["spread"] for row in found["benchmarks"]
            if key(row["name"])[5] == "step" and not row.get("error_occurred")]


def case_name(case):
    """What machpoint_kernels calls it. case: the first five of a key of
    rows()."""
    method, basis, dim, per_cell, order = case[:5]
    return f"{method}/{basis}/{dim}D/{per_cell}/{order}"


def limits(found):
    """Numbers of the context, of one thread and of all: bandwidths of the triad
    (ordinary, past the cache or 0, the larger of the two) and of multiply-adds,
    bytes and flops per second; threads, ranks."""
    context = found["context"]
    rates = [f"{name}_{who}" for name in ("triad", "ordinary", "streamed",
                                          "fma") for who in ("one", "all")]
    return {key: float(context[key]) for key in [*rates, "threads", "ranks"]}


def counted(number):
    """Of bytes or flops: whole ones, or two digits of few."""
    return f"{number:.0f}" if number >= 10 else f"{number:.2g}"


def table(some):
    """A table of rows(). What is not counted has no share of a limit."""
    lines = []
    for (method, basis, dim, per_cell, order, part), row in some.items():
        particle = 1e9 / row["updates_per_second"]
        bytes_moved, flops, of_triad, of_fma = "----"
        if row["bytes"]:
            bytes_moved = counted(row["bytes"])
            of_triad = f"{100 * row['of_triad']:.1f} %"
        if row["flops"]:
            flops = counted(row["flops"])
            of_fma = f"{100 * row['of_fma']:.1f} %"
        lines.append([
            method.replace("_", " "), basis, f"{dim}D", per_cell, order, part,
            f"{row['updates_per_second'] / 1e6:.2f}", f"{particle:.1f}",
            bytes_moved, flops, of_triad, of_fma])
    return page.table(
        ["method", "basis", "", "per cell", "order", "part", "M updates/s",
         "ns", "bytes", "flops", "of triad", "of FMA"], lines)
