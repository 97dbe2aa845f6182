"""Runs machpoint_kernels and reads what it measured."""
import argparse
import json
import os
import pathlib
import subprocess
import tempfile

import page

EXECUTABLE = "machpoint_kernels"
FIGURES = ["updates_per_second", "bytes", "flops", "of_triad", "of_fma",
           "spread"]
SIZES = {"particles": "of a case, about", "cycles": "of sorts in a sample",
         "samples": "of a case, of which the median counts"}
# Of Open MPI: ranks may share a core, and a container's user is root.
LAUNCHED = {"OMPI_MCA_rmaps_base_oversubscribe": "1",
            "OMPI_ALLOW_RUN_AS_ROOT": "1",
            "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1"}


def positive(text):
    """A whole number for argparse."""
    if not text.isdecimal() or int(text) < 1:
        raise argparse.ArgumentTypeError(f"{text} is no number from 1 on")
    return int(text)


def add_sizes(parser):
    """Options of machpoint_kernels that a script hands on."""
    for name, text in SIZES.items():
        parser.add_argument(f"--{name}", metavar="NUMBER", type=positive,
                            help=text)


def size_words(arguments):
    """Of the command line of machpoint_kernels: the sizes that were given."""
    return [word for name in SIZES if (value := getattr(arguments, name))
            for word in (f"--{name}", str(value))]


def run(executable, words, threads=None, launcher=()):
    """Its JSON. words: of the command line; threads: of OpenMP, else as the
    environment says; launcher: words of mpirun."""
    environment = dict(os.environ, OMP_PROC_BIND="false")
    if launcher:
        environment.update(LAUNCHED)
    if threads:
        environment["OMP_NUM_THREADS"] = str(threads)
    with tempfile.TemporaryDirectory() as scratch:
        path = pathlib.Path(scratch) / "kernels.json"
        try:
            result = subprocess.run(
                [*launcher, str(executable), *words,
                 f"--benchmark_out={path}", "--benchmark_out_format=json"],
                env=environment, stdin=subprocess.DEVNULL,
                capture_output=True, text=True)
        except OSError as error:
            raise SystemExit(f"{error.filename}: {error.strerror}") from error
        if result.returncode != 0 or not path.exists():
            raise SystemExit(f"{executable} {' '.join(words)}: exit code "
                             f"{result.returncode}\n{result.stderr}")
        return json.loads(path.read_text())


def rows(found):
    """{(method, basis, dimension, per_cell, order, part): figures}; a
    benchmark that failed ends the session."""
    result = {}
    for row in found["benchmarks"]:
        if row.get("error_occurred"):
            raise SystemExit(f"{row['name']}: {row['error_message']}")
        method, basis, dim, per_cell, order, part = row["name"].split("/")[:6]
        result[method, basis, int(dim[0]), int(per_cell), order, part] = row
    return result


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
