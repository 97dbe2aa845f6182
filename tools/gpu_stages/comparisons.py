"""Stages of tools/gpu_check that hold runs against others: scenes and hard cases."""
import json
import math
import subprocess
import sys

from call import ROOT, Call, Failure, table

# The verdict where these alone were compared.
SUMMARIES = "summaries agree"
# Of summary.json; the same on both builds where there are no particles to read.
SUMMARY = ["steps", "particles_final", "final_time", "errors", "extrema"]
# Of scenes; of double, compare_backends.py has it. Adding in another order, on two ranks,
# came to 7e-10 and 2e-3 in 2D.
TOLERANCES = {"mixed": 1e-6, "single": 1e-2}


def flat(value, path=""):
    """{path: number} of nested dictionaries and lists."""
    if isinstance(value, dict):
        value = value.items()
    elif isinstance(value, list):
        value = enumerate(value)
    else:
        return {path: value}
    return {key: number for name, part in value
            for key, number in flat(part, f"{path}/{name}").items()}


class Comparisons(Call):

    def scenes(self):
        rows, failed, lack = [], [], ""
        if not self.options.dry_run:
            lack = self.hides_particles()
        accepted = ["ok", SUMMARIES,
                    *(["not compiled"] if self.restricted() else [])]
        for path in sorted((ROOT / "input").glob("*.json")):
            name = path.stem
            if self.options.dry_run:
                print(f"  compare {name}")
                continue
            sets = self.coarse(path) if self.options.quick else []
            found = self.remembered(["scene", path.read_text(), sets, lack],
                                    lambda: self.compare(name, sets))
            rows.append([name, found["verdict"], found["difference"],
                         *found["speed"]])
            if found["verdict"] not in accepted:
                failed.append(f"{name}: {found['verdict']}")
        return {"failed": failed, "rows": rows, "but": lack and
                f"by summaries alone, not particle by particle: {lack}",
                "text": table(
            ["scene", "verdict", "largest relative difference",
             f"{self.options.preset}, updates/s",
             f"{self.options.reference}, updates/s"], rows)}

    def restricted(self):
        """Was less to be compiled, now or when the builds were made?"""
        path = self.output / "build.json"
        built = (json.loads(path.read_text()).get("set") or []
                 if path.exists() else [])
        return any(option.startswith(("Machpoint_DIMENSIONS", "Machpoint_BASES"))
                   for option in [*self.options.set, *built])

    @staticmethod
    def coarse(path):
        """Overrides that leave a scene at most some 20000 particles."""
        scene = json.loads(path.read_text())
        cells = scene["grid"]["cells"]
        particles = math.prod(cells) * scene["particles"]["per_cell"]
        by = math.ceil(max(1, particles / 20000)**(1 / len(cells)))
        return ["grid.cells=" + json.dumps([max(2, n // by) for n in cells])]

    def compare(self, scene, sets):
        """One scene on both builds."""
        found = {"difference": "", "speed": ["", ""]}
        try:
            (summary, particles), (other, others) = [
                self.few_steps(machpoint, scene, sets)
                for machpoint in (self.machpoint, self.host)]
        except subprocess.CalledProcessError as error:
            lacks = error.returncode == 2 and "this build has no" in error.stderr
            last = (error.stderr.strip().splitlines() or ["nothing said"])[-1]
            return dict(found, verdict="not compiled" if lacks else
                        f"exit code {error.returncode}: {last}")
        found["speed"] = [f"{s['particle_updates_per_second']:.3g}"
                          for s in (summary, other)]
        from compare_backends import TOLERANCE, difference
        if particles is not None:
            verdict, (worst, where) = "ok", difference(particles, others)
        else:
            verdict, (worst, where) = SUMMARIES, self.difference_of_summaries(
                summary, other)
        found["difference"] = f"{worst:.1e} ({where})"
        tolerance = TOLERANCES.get(summary["precision"], TOLERANCE)
        found["verdict"] = verdict if worst <= tolerance else "differs"
        return found

    def few_steps(self, machpoint, scene, sets):
        import compare_backends
        if not self.hides_particles():
            particles, summary = compare_backends.run(
                machpoint, scene, sets, timeout=self.seconds_left())
            return summary, particles
        return self.summary_of(machpoint, scene, compare_backends.STEPS,
                               sets), None

    def hides_particles(self):
        """Why runs cannot be compared particle by particle; "": they can."""
        from compare_backends import h5py
        if not self.has_hdf5():
            return "these builds lack HDF5"
        return "" if h5py else (
            f"{sys.executable} lacks numpy or h5py; MACHPOINT_PYTHON names another")

    @staticmethod
    def difference_of_summaries(a, b):
        parts = {}
        for key in SUMMARY:
            first, second = flat(a[key], key), flat(b[key], key)
            for path, value in first.items():
                # Below it lies round-off, of errors and of gas at rest.
                size = max(abs(value), abs(second[path]), 1e-3)
                parts[path] = abs(value - second[path]) / size
        worst = max(parts, key=parts.get)
        return parts[worst], worst

    def cases(self):
        if not self.options.dry_run and not self.has_hdf5():
            raise Failure("the hard cases read what runs write, and this "
                          "build lacks HDF5")
        results = self.cleared("hard_cases/results.json")
        code = self.run(sys.executable, ROOT / "benchmarks/hard_cases",
                        "--fast", "--method", "conservative", "--draws", "100",
                        "--machpoint", self.machpoint, "--output",
                        results.parent)
        if self.options.dry_run:
            return {"text": []}
        lines = [line for line in self.log.read_text().splitlines()
                 if not line.startswith("$")]
        if not results.exists():
            raise Failure(self.tail())
        return {"failed": [] if code == 0 else
                [line.strip() for line in lines
                 if "BROKEN" in line or "MISSED" in line] or [self.tail()],
                "results": json.loads(results.read_text()),
                "text": ["```", *lines, "```"]}
