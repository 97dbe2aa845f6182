"""Stages of tools/gpu_check that measure: speed, kernels, sweep and profile."""
import csv
import json
import shutil
import subprocess
import sys

from call import ROOT, Call, Failure, table

# Scene, cells, steps; --quick takes the first line of each scene.
SPEED = [
    ("sod", (10000,), 200), ("sod", (1000000,), 50),
    ("isentropic_vortex", (64, 64), 50), ("isentropic_vortex", (1024, 1024), 20),
    ("cylinder_mach3", (80, 40), 50), ("cylinder_mach3", (1600, 800), 20),
    ("sedov_3d", (16, 16, 16), 20), ("sedov_3d", (96, 96, 96), 20),
]
METHODS = [("conservative", "quadratic"), ("apic", "quadratic"),
           ("paper", "linear")]
# Scene, cells, cells with --quick, methods.
PROFILED = [("isentropic_vortex", (1024, 1024), (256, 256),
             ["apic", "conservative"]),
            ("sedov_3d", (96, 96, 96), (32, 32, 32), ["apic", "conservative"])]
# What ncu measures of a kernel.
METRICS = {
    "ns": "gpu__time_duration.sum",
    "instructions": "smsp__inst_executed.sum",
    "bytes": "dram__bytes.sum",
    "issue %": "sm__inst_issued.avg.pct_of_peak_sustained_active",
    "L1 %": "l1tex__throughput.avg.pct_of_peak_sustained_active",
    "L2 %": "lts__throughput.avg.pct_of_peak_sustained_elapsed",
    "DRAM %": "dram__throughput.avg.pct_of_peak_sustained_elapsed",
    "warps %": "sm__warps_active.avg.pct_of_peak_sustained_active",
    "registers": "launch__registers_per_thread",
}


class Measurements(Call):

    def speed(self):
        from case import Case
        rows, failed = [], []
        first = {}
        for item in SPEED:
            first.setdefault(item[0], item)
        for scene, cells, steps in (first.values() if self.options.quick
                                    else SPEED):
            for method, basis in METHODS:
                keys = Case(scene, cells, 1, steps, method=method,
                            basis=basis).settings()
                del keys["output.every"]
                sets = [f"{key}={json.dumps(value)}"
                        for key, value in keys.items()]
                name = f"{scene} {'x'.join(map(str, cells))} {method} {basis}"
                print(f"  {name}", flush=True)
                if self.options.dry_run:
                    continue
                try:
                    text = (ROOT / f"input/{scene}.json").read_text()
                    one, two = self.remembered(
                        ["speed", text, sets, steps],
                        lambda: [self.summary_of(build, scene, steps, sets)
                                 for build in (self.machpoint, self.host)])
                except subprocess.CalledProcessError as error:
                    if "this build has no" not in error.stderr:
                        failed.append(f"{name}: exit code {error.returncode}: "
                                      + error.stderr.strip()[-300:])
                    continue
                phases = sorted(one["phases"], key=lambda p: -p["seconds"])
                rates = [s["particle_updates_per_second"] for s in (one, two)]
                rows.append([name, one["particles_final"],
                             *[f"{rate:.3g}" for rate in rates],
                             f"{rates[0] / rates[1]:.2f}",
                             ", ".join(f"{p['name']} "
                                       f"{1e3 * p['seconds'] / steps:.2f}"
                                       for p in phases[:4])])
        return {"failed": failed, "rows": rows, "text": table(
            ["scene", "particles", f"{self.options.preset}, updates/s",
             f"{self.options.reference}, updates/s", "ratio",
             "ms per step in the longest phases"], rows)}

    def kernels(self):
        import results
        executable = self.builds[self.options.preset] / results.EXECUTABLE
        if not self.options.dry_run and not executable.exists():
            raise Failure("not built: this machine lacks Google Benchmark")
        path = self.cleared("kernels.json")
        self.require(executable, "--benchmark_filter=quadratic",
                     f"--benchmark_out={path}", "--benchmark_out_format=json",
                     *(["--particles", 65536] if self.options.quick else []))
        if self.options.dry_run:
            return {"text": []}
        found = json.loads(path.read_text())
        limits = results.limits(found)
        return {"results": found, "text": [
            f"The triad moved {limits['triad_all'] / 1e9:.0f} GB/s, and "
            f"multiply-adds ran at {limits['fma_all'] / 1e9:.0f} Gflop/s.", "",
            *results.table(results.rows(found)).splitlines()]}

    def sweep(self):
        folder = self.output / "sod_sweep"
        self.require(
            sys.executable, ROOT / "benchmarks/sod_sweep",
            *[f"--build={path}" for path in self.builds.values()],
            "--output", folder, *(["--seconds", 2, "--largest", 8,
                                   "--cylinders", 2]
                                  if self.options.quick else []))
        if self.options.dry_run:
            return {"text": []}
        found = json.loads((folder / "results.json").read_text())
        return {"results": found, "text": [
            *[f"- {name}: slope {slope:.3f}" for name, slope
              in found["slopes"].items() if slope is not None],
            *[f"- left out: {reason}" for reason in found["left_out"]], "",
            *table(["", "cells", "ms a step", "seconds to the end"],
                   [[name, "x".join(map(str, point["cells"])),
                     f"{1e3 * point['step']:.3g}", f"{point['seconds']:.3g}"]
                    for name, points in found["lines"].items()
                    for point in points])]}

    def profile(self):
        if self.options.preset != "cuda":
            return {"text": ["Only a GPU is profiled."]}
        if not self.options.dry_run and not shutil.which("ncu"):
            raise Failure("no ncu on the PATH; it comes with the CUDA toolkit")
        text = []
        for scene, cells, few, methods in PROFILED:
            for method in methods:
                text += self.profile_of(
                    scene, few if self.options.quick else cells, method)
        return {"text": text}

    def profile_of(self, scene, cells, method):
        """Lines on the kernels of a step, the slowest first."""
        from case import Case
        from kernel_names import STEP
        settings = Case(scene, cells, 1, 2, method=method).settings()
        del settings["output.every"]
        path, folder = self.cleared("ncu.csv"), self.output / "profiled"
        self.require(
            "ncu", "--clock-control", "none", "--csv", "--page", "raw",
            "--print-units", "base", "--print-kernel-base", "mangled",
            "--kernel-name-base", "mangled", "--kernel-name",
            "regex:" + "|".join(STEP), "--metrics", ",".join(METRICS.values()),
            "--log-file", path, self.machpoint, "run",
            ROOT / f"input/{scene}.json", "--quiet", "--max-steps", 2,
            "--overwrite", "--output", folder,
            *[f"--set={key}={json.dumps(value)}"
              for key, value in settings.items()],
            '--set=output={"particles": false, "grid": false}')
        if self.options.dry_run:
            return []
        particles = json.loads(
            (folder / "summary.json").read_text())["particles_final"]
        kernels = self.kernels_of(path.read_text())
        rows = [[name, f"{k['ns'] / 1e3:.0f}",
                 f"{32 * k['instructions'] / particles:.0f}",
                 f"{k['bytes'] / particles:.0f}",
                 *[f"{k[key]:.0f}" for key in list(METRICS)[3:]]]
                for name, k in sorted(kernels.items(),
                                      key=lambda item: -item[1]["ns"])]
        return ["", f"{scene}, {'x'.join(map(str, cells))} cells, {method}, "
                f"{particles} particles; instructions and bytes of memory are "
                "of a particle, % of what the GPU could:", "",
                *table(["kernel", "us", "instructions", "bytes",
                        *list(METRICS)[3:]], rows)]

    @staticmethod
    def kernels_of(text):
        """{function and template arguments: {key of METRICS: number}} of the
        kernels of a step in what ncu wrote, as each was run last."""
        from kernel_names import STEP, function_of
        lines = text.splitlines()
        start = next(k for k, line in enumerate(lines)
                     if line.startswith('"ID"'))
        head, _, *rows = csv.reader(lines[start:])
        readable = subprocess.run(
            ["c++filt"], input="\n".join(row[head.index("Kernel Name")]
                                         for row in rows),
            check=True, capture_output=True, text=True).stdout.splitlines()
        found = {}
        for row, name in zip(rows, readable):
            function = function_of(name)
            if function and function[0] in STEP:
                found["`{}<{}>` {}".format(*function)] = {
                    key: float(row[head.index(metric)].replace(",", ""))
                    for key, metric in METRICS.items()}
        return found
