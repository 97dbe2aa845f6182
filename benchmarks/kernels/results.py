"""Runs machpoint_kernels and reads what it measured."""
import json
import os
import pathlib
import subprocess
import tempfile

import page

EXECUTABLE = "machpoint_kernels"
FIGURES = ["updates_per_second", "bytes", "flops", "of_triad", "of_fma",
           "spread"]


def run(executable, words, threads=None, launcher=()):
    """Its JSON. words: of the command line; threads: of OpenMP, else as the
    environment says; launcher: words of mpirun."""
    environment = dict(os.environ, OMP_PROC_BIND="false")
    if threads:
        environment["OMP_NUM_THREADS"] = str(threads)
    with tempfile.TemporaryDirectory() as scratch:
        path = pathlib.Path(scratch) / "kernels.json"
        result = subprocess.run(
            [*launcher, str(executable), *words, f"--benchmark_out={path}",
             "--benchmark_out_format=json"], env=environment,
            stdin=subprocess.DEVNULL, capture_output=True, text=True)
        if result.returncode != 0:
            raise SystemExit(f"{executable} {' '.join(words)}: exit code "
                             f"{result.returncode}\n{result.stderr}")
        text = path.read_text()
    if not text:
        raise SystemExit(f"{executable}: nothing matches {words}")
    return json.loads(text)


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


def limits(found):
    """Numbers of the context: triad_one, triad_all, fma_one, fma_all,
    threads, ranks."""
    context = found["context"]
    return {key: float(context[key]) for key in
            ("triad_one", "triad_all", "fma_one", "fma_all", "threads",
             "ranks")}


def table(some):
    """A table of rows()."""
    lines = []
    for (method, basis, dim, per_cell, order, part), row in some.items():
        particle = 1e9 / row["updates_per_second"]
        lines.append([
            method.replace("_", " "), basis, f"{dim}D", per_cell, order, part,
            f"{row['updates_per_second'] / 1e6:.2f}", f"{particle:.1f}",
            f"{row['bytes']:.0f}", f"{row['flops']:.0f}",
            f"{100 * row['of_triad']:.1f} %", f"{100 * row['of_fma']:.1f} %"])
    return page.table(
        ["method", "basis", "", "per cell", "order", "part", "M updates/s",
         "ns", "bytes", "flops", "of triad", "of FMA"], lines)
