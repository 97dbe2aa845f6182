"""Runs hard cases, keeps their results, and judges them."""
import hashlib
import json
import math
import pathlib
import shutil

import lines
import packages
import planes
import program
import run as runs_of
import spaces
from case import COARSE
from program import digest_of_file
from run import ROOT, broken_invariants, execute, settings

np = packages.find("numpy")

CASES = lines.CASES + planes.CASES + spaces.CASES


def digest(*parts):
    text = json.dumps(parts, sort_keys=True, default=str)
    return hashlib.sha256(text.encode()).hexdigest()[:12]


def asymmetry(run, axes):
    """Mean difference of the nodes' density to its mirror image over the mean
    density. axes: of the grid, x is 0; "xy" is its diagonal."""
    rho = run.read("grid")["density"]
    worst = 0.0
    for axis in axes:
        image = rho.T if axis == "xy" else np.flip(rho, rho.ndim - 1 - axis)
        worst = float(np.maximum(worst, abs(rho - image).mean() / rho.mean()))
    return worst


class Suite:
    """Where things are, and what was measured so far.

    machpoint, reference: executables; output: results are kept there, one
    file for each case, method, size, executable and state of these scripts;
    keep: leave fields; kept: take what is there, of others where these have
    nothing, and run nothing; sets: {dotted path: value} for all runs, after
    those of a case.
    """

    def __init__(self, machpoint, output, reference=None, fast=False,
                 keep=False, kept=False, sets=None):
        self.machpoint = str(pathlib.Path(machpoint).resolve())
        self.reference = reference and str(pathlib.Path(reference).resolve())
        self.output = pathlib.Path(output)
        self.fast, self.keep, self.kept = fast, keep, kept
        self.sets = sets or {}
        # Of all that a result hangs on, but for the scene.
        here = pathlib.Path(__file__).parent
        self.identity = digest(digest_of_file(self.machpoint), *(
            digest_of_file(path) for path in sorted(here.glob("*.py"))
            if path.stem not in ("__main__", "ablation", "report")))
        self.revision = program.revision(self.machpoint)
        (self.output / "results").mkdir(parents=True, exist_ok=True)

    @staticmethod
    def scene(name):
        """A shipped input as a dictionary."""
        return json.loads((ROOT / "input" / f"{name}.json").read_text())

    def remembered(self, key, make):
        """The result kept under a key, else made and kept; None if it would
        have to be made and nothing may be run."""
        path = self.output / "results" / f"{key}.json"
        if path.exists():
            return json.loads(path.read_text())
        if self.kept:
            return None
        result = make()
        temporary = path.with_suffix(".tmp")
        temporary.write_text(json.dumps(result, indent=1))
        temporary.rename(path)
        return result

    def measure(self, case, method):
        """Result of one case by one method, as JSON."""
        scene = ROOT / "input" / f"{case.scene}.json"
        text = scene.read_text() if scene.exists() else ""
        # Without the reference the same case measures less.
        reference = case.reference and self.reference and not self.fast
        key = digest(case.variants(self.fast), text, self.identity,
                     reference and digest_of_file(self.reference),
                     *([self.sets] if self.sets else []))
        name = f"{case.name}-{method}-{self._of_sets()}" + \
            ("fast" if self.fast else "full")
        return self.remembered(f"{name}-{key}",
                               lambda: self._measure(case, method)) \
            or self._newest_of_others(name)

    def _of_sets(self):
        """What tells results with other settings from the others by name."""
        return f"{digest(self.sets)}-" if self.sets else ""

    def _newest_of_others(self, name):
        """The newest result that another executable left; None without any."""
        found = sorted((self.output / "results").glob(f"{name}-*.json"),
                       key=lambda path: path.stat().st_mtime)
        return json.loads(found[-1].read_text()) if found else None

    def _measure(self, case, method):
        scene = f"input/{case.scene}.json"
        result = {"case": case.name, "method": method, "fast": self.fast,
                  "commands": [], "broken": [], "values": {}, "retries": 0,
                  "seconds": 0.0, "particle_steps": 0, "revision": None,
                  "energy_drift": None, "mass_drift": None, "codes": []}
        if not (ROOT / scene).exists():
            result["broken"].append(f"{scene} does not exist")
            return result
        document = self.scene(case.scene)
        runs = []
        for number, sets in enumerate(case.variants(self.fast)):
            document["dimension"] = sets.get("dimension",
                                             document["dimension"])
            keys = settings(document, method, {**sets, **self.sets})
            # All methods have bases; what else `conservative` has is its own.
            if "method.basis" in self.sets:
                keys["method.basis"] = self.sets["method.basis"]
            keys.setdefault("output.every", 1e9)
            run = execute(self.machpoint, scene, keys,
                          self.output / "runs" / f"{case.name}-{method}" /
                          str(number), case.timeout)
            result["commands"].append(run.command)
            result["codes"].append(run.code)
            result["seconds"] += run.seconds
            broken = broken_invariants(run, case.most_steps)
            result["broken"] += [f"run {number}: {text}" for text in broken]
            if run.summary:
                runs.append(run)
                self._note(result, run)
        if runs:
            try:
                result["values"] = case.measure(runs)
                if case.mirrors:
                    result["values"]["asymmetry"] = asymmetry(runs[-1],
                                                              case.mirrors)
                if case.reference and self.reference and not self.fast:
                    result["values"].update(case.reference(
                        runs, lambda sets: self._finer(case, document, sets)))
            # Whatever it is, the other cases are measured.
            except Exception as error:
                result["broken"].append(f"nothing to measure: {error!r}")
            if not self.fast:
                self._keep_picture(case, method, runs[-1])
        if "energy drift" in case.bounds:
            result["values"]["energy drift"] = result["energy_drift"]
        for label, value in result["values"].items():
            if value is not None and not math.isfinite(value):
                result["values"][label] = None
        if not self.keep:
            shutil.rmtree(self.output / "runs" / f"{case.name}-{method}",
                          ignore_errors=True)
        return result

    @staticmethod
    def _note(result, run):
        summary = run.summary
        result["retries"] += summary["retries"]
        result["revision"] = summary["revision"]
        result["particle_steps"] += int(
            summary["particle_updates_per_second"] * summary["wall_seconds"])
        for key, name in [("mass_drift", "mass"),
                          ("energy_drift", "total_energy")]:
            drift = summary["conservation"][name]
            if drift is not None:
                result[key] = max(abs(drift), result[key] or 0.0)

    def _finer(self, case, document, sets):
        """A run of the finite-volume reference; kept for all methods."""
        scene = f"input/{case.scene}.json"
        # The case's own come last here: they say how much finer it is.
        sets = {**{path: value for path, value in self.sets.items()
                   if not path.startswith("method")}, **sets}
        directory = self.output / "reference" / (
            f"{case.name}-" + digest(document, sets,
                                     digest_of_file(self.reference)))
        if (directory / "summary.json").exists():
            return runs_of.Run(directory, 0, "", "", 0)
        return runs_of.execute_reference(self.reference, scene, sets,
                                         directory, case.timeout)

    def _keep_picture(self, case, method, run):
        """What a picture needs: a profile in 1D, density on nodes else."""
        folder = self.output / "pictures"
        folder.mkdir(exist_ok=True)
        path = folder / f"{self._of_sets()}{case.name}-{method}.npz"
        if run.summary["dimension"] == 1:
            data = run.read()
            order = np.argsort(data["position"][:, 0])
            keep = {"x": data["position"][order, 0],
                    "density": data["density"][order]}
            if run.files("exact"):
                exact = run.read("exact")
                keep.update(exact_x=exact["position"],
                            exact_density=exact["density"])
        elif run.files("grid"):
            data = run.read("grid")
            rho = data["density"]
            if rho.ndim == 3:
                rho = rho[0]  # all scenes have a plane of symmetry there
            keep = {"density": rho, "lower": data["lower"][:2],
                    "spacing": data["spacing"][:2]}
        else:
            return
        np.savez_compressed(path, **keep)


def misses(case, result):
    """Bounds that a result does not keep: a list of texts. That includes bounds
    of values which were not measured, except those of full size in a fast run."""
    missed = []
    for label, bound in case.bounds.items():
        if bound.source == COARSE and not result["fast"]:
            continue
        if label in result["values"]:
            value = result["values"][label]
            if not bound.holds(value):
                missed.append(f"{label} = {value} not {bound}")
        elif not result["fast"] or bound.source == COARSE:
            missed.append(f"{label} not measured")
    return missed
