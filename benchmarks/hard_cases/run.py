"""One run of machpoint: its command line, what it left, and its invariants."""
import json
import math
import os
import pathlib
import re
import shlex
import shutil
import subprocess
import time

import packages
from page import ROOT

h5py = packages.find("h5py")
np = packages.find("numpy")

FIELDS = ["position", "velocity", "mass", "density", "pressure",
          "specific_internal_energy"]

# `method` of an input; paper is the published algorithm, which has no artificial
# viscosity.
METHODS = {
    "paper": {"name": "paper", "basis": "linear"},
    "apic": {"name": "apic", "basis": "quadratic"},
    "conservative": {"name": "conservative", "basis": "quadratic"},
}

# Bounds on the relative drift of mass (any scene; relative to all mass that was
# ever inside) and of total energy (closed ones): round-off summed over
# thousands of steps.
MASS_DRIFT = 1e-12
ENERGY_DRIFT = 1e-11


def settings(scene, method, sets):
    """Overrides {dotted path: value} for one method; `sets` come last.

    `conservative` runs as the scene ships it, the others as in METHODS.
    scene: the input as a dictionary.
    """
    keys = {}
    if "method" in sets:
        keys["method"] = sets["method"]
    elif method != scene["method"]["name"] or method != "conservative":
        keys["method"] = METHODS[method]
    if method == "paper":
        keys["physics"] = [p for p in sets.get("physics", scene["physics"])
                           if p["type"] != "artificial_viscosity"]
    for path, value in sets.items():
        if path == "method" or path == "physics" and method == "paper":
            continue
        # Parts of `conservative` mean nothing to the others.
        if path.startswith("method.") and method != "conservative":
            continue
        keys[path] = value
    return keys


class Run:
    """What a run left behind.

    code: exit code; "time" if it took longer than allowed.
    summary: summary.json, {} if there is none.
    """

    def __init__(self, directory, code, message, command, seconds):
        self.directory = pathlib.Path(directory)
        self.code, self.message = code, message
        self.command, self.seconds = command, seconds
        path = self.directory / "summary.json"
        self.summary = json.loads(path.read_text()) if path.exists() else {}

    @property
    def input(self):
        return self.summary["input"]

    @property
    def spacing(self):
        grid = self.input["grid"]
        return (grid["upper"][0] - grid["lower"][0]) / grid["cells"][0]

    def error(self, field="density", norm="L1"):
        return self.summary["errors"][field][norm]

    def files(self, kind):
        return sorted((self.directory / kind).glob("*.h5"))

    def read(self, kind="particles", index=-1):
        """Datasets and attributes of one output as a dictionary."""
        with h5py.File(self.files(kind)[index]) as file:
            data = {name: file[name][...] for name in file
                    if isinstance(file[name], h5py.Dataset)}
            data.update(file.attrs)
        return data

    def later(self, first, kind="particles"):
        """The outputs from the time `first` on, one after the other."""
        for index, path in enumerate(self.files(kind)):
            with h5py.File(path) as file:
                early = file.attrs["time"] < first - 1e-9
            if not early:
                yield self.read(kind, index)


def execute(machpoint, scene, sets, directory, timeout):
    """Runs a scene on one thread; never raises for what the run does.

    scene: path of an input below the repository's root; sets: {dotted path:
    value}; directory: replaced; timeout: seconds.
    """
    directory = pathlib.Path(directory)
    shutil.rmtree(directory, ignore_errors=True)
    words = []
    for path, value in sets.items():
        words += ["--set", f"{path}={json.dumps(value)}"]
    shown = shlex.join(["machpoint", "run", str(scene), *words])
    environment = dict(os.environ, OMP_PROC_BIND="false", OMP_NUM_THREADS="1")
    start = time.monotonic()
    try:
        result = subprocess.run(
            [machpoint, "run", str(ROOT / scene), *words, "--output",
             str(directory), "--quiet"], stdin=subprocess.DEVNULL,
            capture_output=True, text=True, errors="replace", timeout=timeout,
            env=environment)
        code, message = result.returncode, result.stderr.strip()
    except subprocess.TimeoutExpired:
        code, message = "time", f"not finished after {timeout} s"
    return Run(directory, code, message, shown, time.monotonic() - start)


def _naca4(shape):
    """Vertices of an aerofoil's outline: those of core/shape.hpp.

    Abbott and von Doenhoff 1959, but -0.1036 for -0.1015, which closes the
    trailing edge.
    """
    m, p, t = (int(shape["digits"][0]) / 100, int(shape["digits"][1]) / 10,
               int(shape["digits"][2:]) / 100)
    x = 0.5 * (1 - np.cos(np.linspace(0, math.pi, 201)))
    half = 5 * t * (0.2969 * np.sqrt(x) - 0.126 * x - 0.3516 * x**2 +
                    0.2843 * x**3 - 0.1036 * x**4)
    line, slope = np.zeros_like(x), np.zeros_like(x)
    if m > 0:
        front = x < p
        line = np.where(front, m / p**2 * (2 * p * x - x**2),
                        m / (1 - p)**2 * (1 - 2 * p + 2 * p * x - x**2))
        slope = np.where(front, 2 * m / p**2, 2 * m / (1 - p)**2) * (p - x)
    angle = np.arctan(slope)
    upper = np.c_[x - half * np.sin(angle), line + half * np.cos(angle)]
    lower = np.c_[x + half * np.sin(angle), line - half * np.cos(angle)]
    outline = np.r_[lower, upper[::-1]] * shape["chord"]
    attack = -math.radians(shape.get("angle", 0))
    turn = np.array([[math.cos(attack), math.sin(attack)],
                     [-math.sin(attack), math.cos(attack)]])
    return outline @ turn + shape["leading_edge"]


def _depth_in_polygon(vertices, x):
    """Depth of points [n][2] below a closed outline [m][2], <= 0 outside."""
    inside = np.zeros(len(x), bool)
    nearest = np.full(len(x), np.inf)
    for a, b in zip(vertices, np.roll(vertices, -1, 0)):
        edge = b - a
        length = edge @ edge
        if length == 0:
            continue
        crosses = (a[1] > x[:, 1]) != (b[1] > x[:, 1])
        if edge[1] != 0:
            inside ^= crosses & (
                x[:, 0] < a[0] + (x[:, 1] - a[1]) / edge[1] * edge[0])
        s = np.clip((x - a) @ edge / length, 0, 1)
        nearest = np.minimum(nearest,
                             np.hypot(*(x - a - s[:, None] * edge).T))
    return np.where(inside, nearest, -nearest)


def depth_in(shape, x):
    """How deep points [n][Dim] lie in a solid; <= 0 outside."""
    kind = shape["type"]
    if kind == "sphere":
        return shape["radius"] - np.linalg.norm(x - shape["center"], axis=1)
    if kind == "box":
        return np.minimum(x - shape["lower"], shape["upper"] - x).min(axis=1)
    if kind == "half_space":
        normal = np.array(shape["normal"], float)
        return -(x - shape["point"]) @ normal / np.linalg.norm(normal)
    if kind == "polygon":
        return _depth_in_polygon(np.array(shape["vertices"], float), x)
    if kind == "naca4":
        return _depth_in_polygon(_naca4(shape), x)
    if kind == "union":
        return np.max([depth_in(s, x) for s in shape["shapes"]], axis=0)
    raise NotImplementedError(f"depth in a {kind}")


def broken_invariants(run, most_steps=None):
    """What a run did that no run may do: a list of texts, empty if none.

    most_steps: above this number the time step has collapsed; by default 100
    for each cell of the longest axis.
    """
    if run.code != 0:
        first = run.message.splitlines()[0] if run.message else ""
        return [f"exit code {run.code}: {first}"]
    broken = []
    summary = run.summary

    def require(holds, text):
        if not holds:
            broken.append(text)

    end = run.input["time"]["end"]
    require(summary["final_time"] >= end * (1 - 1e-12),
            f"stopped at t = {summary['final_time']:.4g} of {end:.4g}")
    extrema = summary["extrema"]
    for key in ["min_density", "min_specific_internal_energy"]:
        require(extrema[key] > 0, f"{key} = {extrema[key]:.3g}")
    conservation = summary["conservation"]
    mass, energy = conservation["mass"], conservation["total_energy"]
    if run.files("particles"):
        before = (run.read()["mass"].sum() - conservation["mass_in"] +
                  conservation["mass_out"])
        mass /= 1 + conservation["mass_in"] / before
    require(abs(mass) <= MASS_DRIFT, f"mass drifts by {mass:.2e}")
    require(energy is None or abs(energy) <= ENERGY_DRIFT,
            f"total energy drifts by {energy}")
    most_steps = most_steps or 100 * max(summary["cells"])
    require(summary["steps"] <= most_steps,
            f"{summary['steps']} steps: the time step collapsed")
    if run.files("particles"):
        data = run.read()
        for name in FIELDS:
            require(np.isfinite(data[name]).all(), f"{name} is not finite")
        for name in ["mass", "density", "specific_internal_energy"]:
            require((data[name] > 0).all(), f"a particle has {name} <= 0")
        grid, x = run.input["grid"], data["position"]
        require((x >= grid["lower"]).all() and (x <= grid["upper"]).all(),
                "particles outside of the domain")
        for entry in run.input["boundary"]:
            if entry["type"] == "obstacle":
                depth = depth_in(entry["shape"], x).max()
                require(depth <= 1e-9 * run.spacing,
                        f"particles {depth:.2g} inside of a solid")
    return broken


def relative(value):
    """A number as a short text."""
    if value is None:
        return "-"
    if isinstance(value, str):
        return value
    text = f"{value:.3g}"
    return re.sub(r"e([+-])0", r"e\1", text)


def execute_reference(reference, scene, sets, directory, timeout):
    """A run of the finite-volume reference. RuntimeError: it failed."""
    shutil.rmtree(directory, ignore_errors=True)
    words = []
    for path, value in sets.items():
        words += ["--set", f"{path}={json.dumps(value)}"]
    result = subprocess.run(
        [reference, str(ROOT / scene), *words, "--output", str(directory)],
        stdin=subprocess.DEVNULL, capture_output=True, text=True,
        timeout=timeout)
    if result.returncode != 0:
        raise RuntimeError(f"{scene}: {result.stderr.strip()}")
    return Run(directory, 0, "", "", 0)
