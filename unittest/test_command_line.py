"""What machpoint answers on its command line, above all to what is wrong.

The executable comes from MACHPOINT_EXECUTABLE. Inputs that are wrong are made
by mutating the shipped ones; every mutation is wrong by construction, and says
which place the message has to name.
"""

import copy
import json
import math
import os
import pathlib
import random
import re
import resource
import signal
import subprocess
import tempfile
import time
import unittest
import unittest.mock

import h5py
import numpy

import running
from running import (ALARMING, ENVIRONMENT, FINISHED, IO_FAILURE, NUMERICAL_FAILURE,
                     ONE_THREAD, STOPPED_EARLY, WRONG_INPUT)

EXECUTABLE = os.path.abspath(os.environ["MACHPOINT_EXECUTABLE"])
SINGLE = os.environ.get("MACHPOINT_PRECISION") == "single"
INPUTS = pathlib.Path(__file__).resolve().parent.parent / "input"
SOD = INPUTS / "sod.json"

SHIPPED = {
    path.name: json.loads(path.read_text())
    for path in sorted(INPUTS.glob("*.json"))
}


def machpoint(*arguments, timeout=20, **keywords):
    """Runs the executable to its end."""
    return subprocess.run([EXECUTABLE, *map(str, arguments)],
                          stdin=subprocess.DEVNULL, capture_output=True,
                          text=True, errors="replace", timeout=timeout,
                          **{"env": ENVIRONMENT, **keywords})


def contents(directory):
    """Every file below a directory with its bytes."""
    return {
        str(path.relative_to(directory)):
            path.read_bytes() if path.is_file() else None
        for path in sorted(pathlib.Path(directory).rglob("*"))
    }


class CommandLineTest(unittest.TestCase):
    """Gives each test an empty directory."""

    def setUp(self):
        scratch = tempfile.TemporaryDirectory()
        self.addCleanup(scratch.cleanup)
        self.directory = pathlib.Path(scratch.name)
        self.output = self.directory / "out"

    def assertCode(self, result, code):
        text = result.stdout + result.stderr
        self.assertEqual(result.returncode, code, text)
        self.assertNotRegex(text, ALARMING)

    def run_sod(self, *arguments, **keywords):
        return machpoint("run", SOD, "--output", self.output, *arguments,
                         **keywords)

    def summary(self):
        return json.loads((self.output / "summary.json").read_text())


# --- Inputs that are wrong --------------------------------------------------#

REQUIRED = {
    "scene", "dimension", "grid", "particles", "physics", "initial", "boundary",
    "lower", "upper", "cells", "per_cell", "end", "density", "pressure", "side",
    "type", "shape", "center", "radius", "left", "right", "gravity",
    "acceleration"
}
WHOLE = ["/dimension", "/grid/cells/0", "/particles/per_cell",
         "/particles/seed"]
# Key -> values that no input of ours may have there.
OUT_OF_RANGE = {
    "density": [0, -1], "pressure": [0, -0.1, -1e300], "gamma": [1, 0.5, -1.4],
    "cfl": [0, -0.4, 3], "end": [0, -1], "every": [0, -0.5],
    "per_cell": [0, -3, 10**9], "seed": [-1], "linear": [-1e-9],
    "quadratic": [-1], "radius": [0, -0.25], "dimension": [0, 4, -1, 10**15]
}
# Key -> texts that are not among its choices.
UNKNOWN = {
    "type": ["ideal_gaz", "slipwall", "", "SOD", "inflow "],
    "side": ["w_lower", "x", "left", "x-lower"],
    "name": ["flip", "Apic"],
    "basis": ["cubicc", "bilinear"],
    "time": ["implicit"],
    "placement": ["latice", "halton"],
    "axis": ["w", "X"]
}
CHOICE_PARENTS = {"name": ["method"], "basis": ["method"], "time": ["method"]}


def places(node, path=()):
    """Every place below an input as (path, value)."""
    items = node.items() if isinstance(node, dict) else enumerate(node)
    for key, value in items:
        yield path + (key,), value
        if isinstance(value, (dict, list)):
            yield from places(value, path + (key,))


def at(node, path):
    for key in path:
        node = node[key]
    return node


def pointer(path):
    return "".join(f"/{key}" for key in path)


def keys_of(document, names=None):
    return [path for path, _ in places(document)
            if isinstance(path[-1], str) and (names is None
                                              or path[-1] in names)]


def misspell(rng, document):
    path = rng.choice(keys_of(document))
    parent, key = at(document, path[:-1]), path[-1]
    cut = rng.randrange(len(key))
    known = {p[-1] for p in keys_of(document)} | {"name", "every", "normal"}
    wrong = rng.choice([key[:cut] + key[cut + 1:], key + "s", key.upper(),
                        key[:cut] + "_" + key[cut:]])
    wrong = key + "q" if not wrong or wrong in known else wrong
    # In place, so that the order of the keys stays.
    items = [(wrong if k == key else k, v) for k, v in parent.items()]
    parent.clear()
    parent.update(items)
    return document, pointer(path[:-1] + (wrong,)) + ": unknown key"


def remove_key(rng, document):
    path = rng.choice(keys_of(document, REQUIRED))
    del at(document, path[:-1])[path[-1]]
    return document, pointer(path)


def wrong_type(rng, document):
    path, value = rng.choice(list(places(document)))
    wrong = [None, True, [[]], {"value": 1}]
    if not isinstance(value, str):
        wrong.append("text")
    if not isinstance(value, (int, float)):
        wrong += [7, 0.5]
    at(document, path[:-1])[path[-1]] = rng.choice(wrong)
    return document, pointer(path)


def not_whole(rng, document):
    path = rng.choice(WHOLE).strip("/").split("/")
    path = [int(key) if key.isdigit() else key for key in path]
    at(document, path[:-1])[path[-1]] = rng.choice([3.7, 2.0, 1e300])
    return document, pointer(path)


def out_of_range(rng, document):
    path = rng.choice(keys_of(document, OUT_OF_RANGE))
    at(document, path[:-1])[path[-1]] = rng.choice(OUT_OF_RANGE[path[-1]])
    return document, pointer(path)


def wrong_cells(rng, document):
    axis = rng.randrange(document["dimension"])
    document["grid"]["cells"][axis] = rng.choice([0, -5, 10**12])
    return document, f"/grid/cells/{axis}"


def reverse_bounds(rng, document):
    grid, axis = document["grid"], rng.randrange(document["dimension"])
    low, high = grid["lower"][axis], grid["upper"][axis]
    grid["lower"][axis], grid["upper"][axis] = rng.choice([(high, low),
                                                           (low, low)])
    return document, f"/grid/upper/{axis}"


def unknown_word(rng, document):
    path = rng.choice([
        path for path in keys_of(document, UNKNOWN)
        if isinstance(at(document, path), str) and path[-2] in
        CHOICE_PARENTS.get(path[-1], [path[-2]])
    ])
    at(document, path[:-1])[path[-1]] = rng.choice(UNKNOWN[path[-1]])
    return document, pointer(path)


def wrong_length(rng, document):
    path = rng.choice([
        path for path in keys_of(document, ["lower", "upper", "cells",
                                            "velocity", "acceleration",
                                            "center", "normal"])
        if isinstance(at(document, path), list)
    ])
    vector = at(document, path)
    at(document, path[:-1])[path[-1]] = rng.choice(
        [vector + [1], [], vector * 4, vector[1:]])
    return document, pointer(path)


def duplicate_key(rng, document):
    path = rng.choice(keys_of(document))
    parent, key = at(document, path[:-1]), path[-1]
    parent["SECOND"] = copy.deepcopy(parent[key])
    return (json.dumps(document).replace('"SECOND"', json.dumps(key)),
            pointer(path) + ": given twice")


def without_side(rng, document):
    sides = [entry for entry in document["boundary"] if "side" in entry]
    document["boundary"].remove(rng.choice(sides))
    return document, "/boundary"


def second_entry(rng, document):
    sides = [entry for entry in document["boundary"] if "side" in entry]
    document["boundary"].append(copy.deepcopy(rng.choice(sides)))
    return document, "/boundary"


SYNTAX = r":\d+:\d+: "


def truncate(rng, document):
    text = json.dumps(document, indent=2)
    return text[:rng.randrange(1, len(text) - 1)], SYNTAX


def junk(rng, document):
    return b"\x89" + rng.randbytes(rng.randrange(1, 3000)), SYNTAX


def foreign_byte(rng, document):
    text = json.dumps(document, indent=2).encode()
    cut = rng.randrange(len(text))
    foreign = rng.choice([b"\xff", b"\0", b"\xc3\x28"])
    return text[:cut] + foreign + text[cut:], SYNTAX


def bad_literal(rng, document):
    path = rng.choice([path for path, value in places(document)
                       if isinstance(value, (int, float))])
    at(document, path[:-1])[path[-1]] = "LITERAL"
    literal = rng.choice(["NaN", "Infinity", "-inf", "1e999", "0x10", "01",
                          "1,5", "'1'", "one", "1 /* one */", "1,,", "+1"])
    if literal == "1,5" and isinstance(path[-1], int):
        literal = "1;5"  # in a list a comma would only make it longer
    return json.dumps(document, indent=2).replace('"LITERAL"', literal), SYNTAX


RANDOM_MUTATIONS = [
    misspell, remove_key, wrong_type, not_whole, out_of_range, wrong_cells,
    reverse_bounds, unknown_word, wrong_length, duplicate_key, without_side,
    second_entry, truncate, junk, foreign_byte, bad_literal
]


def chosen_mutations():
    """Wrong inputs that chance would not find, as (name, content, place)."""
    yield "empty", "", ": empty"
    yield "blank", " \n\t \n", ": empty"
    for text in ["[]", "3", '"sod"', "null", "true"]:
        yield f"root {text}", text, ": /: "
    yield "deep list", "[" * 200000, "nested"
    yield "deep objects", '{"grid":' * 5000, "nested"
    yield "long line", '{"' + "x" * 1000000, SYNTAX
    yield "no brace", SOD.read_text().replace("}", "", 1), SYNTAX
    yield "two documents", SOD.read_text() * 2, SYNTAX

    def changed(name, place, change):
        document = copy.deepcopy(SHIPPED[name])
        change(document)
        return f"{name} {place}", document, place

    def put(**values):
        return lambda document: document.update(values)

    def boundary(k, **values):
        return lambda document: document["boundary"][k].update(values)

    def obstacle(**shape):
        return lambda document: document["boundary"].append(
            {"type": "obstacle", "shape": shape})

    yield changed("sod.json", "/initial",
                  obstacle(type="box", lower=[-1], upper=[2]))
    yield changed("sod.json", "/initial",
                  obstacle(type="sphere", center=[0.5], radius=0.6))
    yield changed("sod.json", "/initial/0/normal",
                  lambda d: d["initial"][0].update(normal=[0]))
    yield changed("sod.json", "/scene", put(scene="../sod"))
    yield changed("sod.json", "/scene", put(scene=""))
    yield changed("sod.json", "/physics", lambda d: d["physics"].pop(0))
    yield changed("sod.json", "/physics/2",
                  lambda d: d["physics"].append({"type": "ideal_gas"}))
    yield changed("sod.json", "/physics", put(physics=[]))
    yield changed("sod.json", "/initial", put(initial=[]))
    yield changed("sod.json", "/boundary", put(boundary=[]))
    yield changed("sod.json", "/exact", put(exact={"type": "hydrostatic"}))
    yield changed("sod.json", "/grid/cells",
                  lambda d: d["grid"].update(cells=[100000000]) or
                  d["particles"].update(per_cell=100))
    yield changed("sod.json", "/boundary/0/region",
                  boundary(0, region={"type": "box", "lower": [1],
                                      "upper": [0]}))
    yield changed("translation.json", "/boundary",
                  boundary(1, type="slip_wall"))
    yield changed("translation.json", "/boundary",
                  boundary(2, type="outflow"))
    yield changed("toro2.json", "/boundary/1/velocity",
                  boundary(1, velocity=1))
    yield changed("toro2.json", "/boundary/1/pressure",
                  boundary(1, pressure=0))
    yield changed("translation.json", "/particles/per_cell",
                  lambda d: d["particles"].update(per_cell=5))
    yield changed("cylinder_mach3.json", "/boundary/0/velocity",
                  boundary(0, velocity=[-3, 0]))
    yield changed("cylinder_mach3.json", "/boundary/0/velocity",
                  boundary(0, velocity=[0, 3]))
    yield changed("cylinder_mach3_recycle.json", "/boundary/0/velocity",
                  boundary(0, velocity=[-3, 0]))
    yield changed("step_mach3.json", "/boundary/4/shape/upper/1",
                  boundary(4, shape={"type": "box", "lower": [0.6, 0.2],
                                     "upper": [3, 0]}))
    yield changed("cylinder_mach3.json", "/boundary/4/shape/vertices",
                  boundary(4, shape={"type": "polygon",
                                     "vertices": [[0, 0], [0, 1], [1, 0]]}))
    yield changed("cylinder_mach3.json", "/boundary/4/name",
                  boundary(4, name="../cylinder"))
    yield changed("cylinder_mach3.json", "/boundary/5/name",
                  lambda d: d["boundary"].append(d["boundary"][4]))


def wrong_inputs(count, seed=1):
    """So many different wrong inputs (name, bytes, place), always the same."""
    result = {}

    def add(name, content, place):
        if isinstance(content, dict):
            content = json.dumps(content, indent=2)
        if isinstance(content, str):
            content = content.encode()
        result.setdefault(content, (name, content, place))

    for mutation in chosen_mutations():
        add(*mutation)
    rng = random.Random(seed)
    while len(result) < count:
        mutate = RANDOM_MUTATIONS[len(result) % len(RANDOM_MUTATIONS)]
        name = rng.choice(sorted(SHIPPED))
        add(f"{mutate.__name__} of {name}",
            *mutate(rng, copy.deepcopy(SHIPPED[name])))
    return list(result.values())


class WrongInput(CommandLineTest):

    def test_wrong_inputs_are_refused(self):
        inputs = wrong_inputs(200)
        self.assertEqual(len(inputs), 200)
        for number, (name, content, place) in enumerate(inputs):
            with self.subTest(number=number, name=name):
                self.refuse(content, place)

    def refuse(self, content, place):
        with tempfile.TemporaryDirectory() as inputs:
            file = pathlib.Path(inputs) / "wrong.json"
            file.write_bytes(content)
            result = machpoint("run", file, "--output", self.output,
                               cwd=self.directory)
            self.assertCode(result, WRONG_INPUT)
            self.assertEqual(result.stdout, "")
            lines = result.stderr.splitlines()
            for line in lines:
                self.assertTrue(line.startswith(f"{file}:"), line)
            # A pattern where line and column are due, else a place as it is.
            pattern = place if place == SYNTAX else re.escape(place)
            self.assertTrue(
                any(re.search(re.escape(str(file)) + r".*" + pattern, line)
                    for line in lines), f"{place} is not named in {lines}")
            self.assertEqual(contents(inputs), {"wrong.json": content})
        self.assertEqual(contents(self.directory), {})

    def test_states_that_nobody_would_see(self):
        for scene, key, place in [
                ("cylinder_mach3", "boundary[0].buffer=401",
                 "/boundary: x_lower and x_upper keep 401 layers of cells"),
                ("kelvin_helmholtz", "initial[0].lower=0.75",
                 "/initial/0: upper must be greater than lower"),
                ("two_blasts", "initial[0].left_end=0.9",
                 "/initial/0: right_start must be greater than left_end")]:
            result = machpoint("check", INPUTS / f"{scene}.json", "--set", key)
            self.assertCode(result, WRONG_INPUT)
            self.assertIn(place, result.stderr)

    def test_every_mistake_is_reported_at_once(self):
        document = copy.deepcopy(SHIPPED["sod.json"])
        document["physics"][0]["gamma"] = 1
        document["boundary"][0]["tpye"] = document["boundary"][0].pop("type")
        document["time"]["cfl"] = -0.4
        file = self.directory / "three.json"
        file.write_text(json.dumps(document))
        for command in ["check", "run"]:
            result = machpoint(command, file, cwd=self.directory)
            self.assertCode(result, WRONG_INPUT)
            lines = result.stderr.splitlines()
            self.assertEqual(len(lines), 3, result.stderr)
            for place in ["/physics/0/gamma: ", "/boundary/0/tpye: ",
                          "/time/cfl: "]:
                self.assertTrue(
                    any(line.startswith(f"{file}: {place}") for line in lines),
                    result.stderr)

    def test_mistakes_of_all_kinds_are_reported_at_once(self):
        # An unknown key, a wrong type, a conflict between entries, one between keys,
        # and a key given twice.
        document = copy.deepcopy(SHIPPED["sod.json"])
        document["time"]["cffl"] = 0.4
        document["particles"]["per_cell"] = 3.7
        document["boundary"][0]["type"] = "periodic"
        document["grid"]["upper"] = [-1]
        document["SECOND"] = copy.deepcopy(document["exact"])
        file = self.directory / "five.json"
        file.write_text(json.dumps(document).replace("SECOND", "exact"))
        for command in ["check", "run"]:
            result = machpoint(command, file, cwd=self.directory)
            self.assertCode(result, WRONG_INPUT)
            lines = result.stderr.splitlines()
            self.assertEqual(len(lines), 5, result.stderr)
            for place in ["/time/cffl: ", "/particles/per_cell: ",
                          "/boundary: x_lower is periodic", "/grid/upper/0: ",
                          "/exact: given twice"]:
                self.assertTrue(
                    any(line.startswith(f"{file}: {place}") for line in lines),
                    result.stderr)

    def test_what_hangs_on_a_mistake_is_not_told(self):
        # Nobody knows how many cells a method needs that is not known.
        for method in [{"basis": "cubicc"}, {"nme": "apic"}]:
            result = machpoint("check", SOD, "--set", f"method={json.dumps(method)}",
                               "--set", "grid.cells=[2]")
            self.assertCode(result, WRONG_INPUT)
            line, = result.stderr.splitlines()
            self.assertIn(": /method/", line)
        # Nor which method it is whose object is misspelt.
        document = copy.deepcopy(SHIPPED["sod.json"])
        document["methdo"] = {"name": "paper"}
        document["grid"]["cells"] = [2]
        file = self.directory / "methdo.json"
        file.write_text(json.dumps(document))
        line, = machpoint("check", file).stderr.splitlines()
        self.assertIn('/methdo: unknown key; did you mean "method"?', line)

    def test_wrong_overrides_are_reported_with_the_rest(self):
        result = machpoint("check", SOD, "--set", "nothing.here=1", "--set", "time.cfl",
                           "--set", "particles.per_cell=3.7")
        self.assertCode(result, WRONG_INPUT)
        self.assertEqual([line.split(": ")[0] for line in result.stderr.splitlines()],
                         ["--set nothing.here=1", "--set time.cfl", str(SOD)])
        self.assertIn("physics.1.linear=0.3", result.stderr)

    def test_a_study_is_told_from_an_input(self):
        study = INPUTS / "studies/sod.json"
        for file, verbs, right in [(study, ["run", "check"], "machpoint study"),
                                   (SOD, ["study"], "machpoint run")]:
            for verb in verbs:
                result = machpoint(verb, file, cwd=self.directory)
                self.assertCode(result, WRONG_INPUT)
                line, = result.stderr.splitlines()
                self.assertTrue(line.startswith(f"{file}: "), line)
                self.assertIn(f"give it to {right}", line)

    def test_conflicts_are_reported_at_once(self):
        result = machpoint("check", SOD, "--set", "grid.upper=[-1]", "--set",
                           "boundary.0.type=periodic", "--set",
                           "physics=[{\"type\":\"gravity\","
                           "\"acceleration\":[1]}]")
        self.assertCode(result, WRONG_INPUT)
        for place in ["/grid/upper/0", "/boundary", "/physics"]:
            self.assertIn(f"{SOD}: {place}: ", result.stderr)

    def test_names_that_no_file_can_have(self):
        for name, words in [("a/b", "no slash"), ("..", "no slash"),
                            ("x" * 201, "at most 200 bytes, not 201")]:
            result = machpoint("check", SOD, "--set", f"scene={json.dumps(name)}")
            self.assertCode(result, WRONG_INPUT)
            self.assertIn("/scene: names a file", result.stderr)
            self.assertIn(words, result.stderr)

    def test_the_nearest_name_is_suggested(self):
        for override, meant in [("boundary.0.tpye=slip_wall", "type"),
                                ("method.basis=quadratc", "quadratic"),
                                ("method.name=apci", "apic"),
                                ("boundary.0.side=x_lowr", "x_lower"),
                                ("physics.1.type=artifical_viscosity",
                                 "artificial_viscosity"),
                                ("grid.cels=[100]", "cells")]:
            result = machpoint("check", SOD, "--set", override)
            self.assertCode(result, WRONG_INPUT)
            self.assertIn(f'did you mean "{meant}"?', result.stderr)

    def test_more_than_a_process_can_hold(self):
        for scene, cells, per_cell, words in [
                ("sod_2d", [40000, 40000], 1, "1.6e+09 cells are more than one "
                 "process can hold (536870911 each); take fewer cells, or more "
                 "ranks"),
                ("sod", [100000000], 30, "3e+09 particles are more than one "
                 "process")]:
            result = machpoint("check", INPUTS / f"{scene}.json", "--set",
                               f"grid.cells={cells}", "--set",
                               f"particles.per_cell={per_cell}")
            self.assertCode(result, WRONG_INPUT)
            self.assertIn(f"/grid/cells: {words}", result.stderr)

    def test_bad_overrides(self):
        for override, reason in [
                ("time.cfl", "expected path=value"),
                ("=3", "expected path=value"),
                ("nothing.here=1", "the input has no nothing"),
                ("grid.cells.7=5", "a list of 1 entry"),
                ("grid.cells=[4", "unexpected end of input"),
                ("scene.name=x", "scene is no object; set it itself, --set scene=VALUE"),
                ("time.cfl.x=3", "time.cfl is no object; set it itself"),
                ("time.cfl[0]=3", "time.cfl is no object; set it itself"),
                ("time..cfl=0.4", "expected path=value"),
                ("physics[x].gamma=2", "expected path=value"),
                ("particles.per_cell=3.7", "expected a whole number")]:
            with self.subTest(override=override):
                result = self.run_sod("--set", override, cwd=self.directory)
                self.assertCode(result, WRONG_INPUT)
                # What is no value of its place is told of the input.
                place = (f"{SOD}: /particles/per_cell" if "3.7" in override
                         else f"--set {override}")
                self.assertRegex(result.stderr, re.escape(f"{place}: ") + ".*"
                                 + re.escape(reason))
                self.assertEqual(contents(self.directory), {})


class Usage(CommandLineTest):

    def test_wrong_usage(self):
        for arguments in [[], ["frobnicate"], ["run"], ["check"], ["describe"],
                          ["run", SOD, "--frobnicate"], ["--frobnicate"],
                          ["run", SOD, "--max-steps", "x"],
                          ["run", SOD, "--max-steps", "-3"],
                          ["run", SOD, "--output"], ["run", SOD, "--set"],
                          ["run", SOD, SOD], ["schema", "sod"],
                          ["run", "missing.json"], ["check", "missing.json"],
                          ["check", self.directory]]:
            with self.subTest(arguments=arguments):
                result = machpoint(*arguments, cwd=self.directory)
                self.assertCode(result, WRONG_INPUT)
                self.assertNotEqual(result.stderr, "")
                self.assertEqual(contents(self.directory), {})

    def test_unknown_commands(self):
        for words, message in [
                (["chek", "a"], 'unknown command "chek"; did you mean "check"?'),
                (["frobnicate"], 'unknown command "frobnicate"\n'),
                (["-x"], 'unknown option "-x"\n'),
                (["--versoin"], 'unknown option "--versoin"; did you mean "--version"?')]:
            with self.subTest(words=words):
                result = machpoint(*words)
                self.assertCode(result, WRONG_INPUT)
                self.assertIn(message, result.stderr)

    def test_stdout_that_cannot_be_written(self):
        run = ["run", SOD, "--max-steps", "1", "--output", self.output]
        for words in [["list"], ["schema"], ["--help"], ["--version"],
                      ["check", SOD], run, [*run, "--overwrite", "--quiet"]]:
            with self.subTest(words=words), open("/dev/full", "w") as full:
                result = subprocess.run(
                    [EXECUTABLE, *map(str, words)], stdin=subprocess.DEVNULL,
                    stdout=full, stderr=subprocess.PIPE, text=True, timeout=20,
                    env=ENVIRONMENT)
                self.assertEqual(result.returncode, IO_FAILURE)
                self.assertIn("machpoint: cannot write to stdout: No space left",
                              result.stderr)

    def test_threads_that_cannot_be(self):
        for name, text in [("KOKKOS_NUM_THREADS", "abc"), ("KOKKOS_NUM_THREADS", "0"),
                           ("KOKKOS_NUM_THREADS", ""), ("KOKKOS_NUM_THREADS", "513")]:
            with self.subTest(name=name, text=text), unittest.mock.patch.dict(
                    ENVIRONMENT, {name: text}):
                result = machpoint("list")
                self.assertEqual(result.returncode, WRONG_INPUT)
                self.assertIn(f"{name}: must be a number of threads", result.stderr)

    def test_a_missing_file_is_named(self):
        result = machpoint("run", "missing.json", cwd=self.directory)
        self.assertIn("missing.json", result.stderr)

    def test_help(self):
        for arguments in [["--help"], ["run", "--help"]]:
            result = machpoint(*arguments)
            self.assertCode(result, FINISHED)
            self.assertNotEqual(result.stdout.strip(), "")
            self.assertEqual(result.stderr, "")

    def test_version(self):
        result = machpoint("--version")
        self.assertEqual((result.returncode, result.stderr), (FINISHED, ""))
        found = dict(line.split(" ", 1) for line in result.stdout.splitlines())
        self.assertEqual(list(found), ["machpoint", "revision", "backend", "precision",
                                       "Kokkos", "MPI", "HDF5", "Cabana"])
        self.assertRegex(found["machpoint"], r"^\d+\.\d+\.\d+$")
        self.assertRegex(found["revision"], r"^(unknown|[-\w.]+)$")
        self.assertIn(found["precision"], ["double", "mixed", "single"])
        self.assertRegex(found["Kokkos"], r"^\d+\.\d+")
        for name in ["MPI", "HDF5"]:
            self.assertRegex(found[name], r"^(no$|\d+\.\d+)")
        self.assertRegex(found["Cabana"], "(bundled|external)$")
        # A run tells the same of itself.
        self.run_sod("--max-steps", "0")
        for name in ["revision", "backend", "precision"]:
            self.assertEqual(found[name], self.summary()[name])

    def test_check_writes_nothing(self):
        result = machpoint("check", SOD, cwd=self.directory)
        self.assertCode(result, FINISHED)
        self.assertEqual(result.stdout, f"{SOD}: ok\n")
        self.assertEqual(contents(self.directory), {})

    def test_all_that_is_listed_is_described(self):
        result = machpoint("list")
        self.assertCode(result, FINISHED)
        # A heading may have a space: columns are two blanks apart or more.
        rows = [re.split(r" {2,}", line) for line in result.stdout.splitlines()]
        names = [row[1] for row in rows]
        for row in rows:
            self.assertEqual(len(row), 3, row)
        for name in ["paper", "apic", "linear", "quadratic", "cubic",
                     "ideal_gas", "stiffened_gas", "artificial_viscosity",
                     "gravity", "slip_wall", "no_slip_wall", "periodic",
                     "inflow", "outflow", "recycle", "obstacle", "sphere",
                     "box", "half_space", "polygon", "naca4", "union",
                     "uniform", "riemann"]:
            self.assertIn(name, names)
        for name in set(names):
            with self.subTest(name=name):
                result = machpoint("describe", name)
                self.assertCode(result, FINISHED)
                self.assertTrue(result.stdout.startswith(name), result.stdout)
                # Its title stands once.
                titles = [line for line in result.stdout.splitlines()
                          if line.startswith(name)]
                self.assertEqual(len(titles), names.count(name), titles)

    def test_description_of_a_parameter(self):
        text = machpoint("describe", "ideal_gas").stdout
        for part in ["gamma", "> 1", "1.4", "Toro"]:
            self.assertIn(part, text)

    def test_keys_of_an_input_are_described(self):
        for key, name in [("method", "apic"), ("basis", "cubic"),
                          ("physics", "gravity"), ("boundary", "outflow"),
                          ("initial", "blast"), ("exact", "riemann")]:
            result = machpoint("describe", key)
            self.assertEqual(result.returncode, FINISHED, result.stderr)
            self.assertIn(f" {name} ", result.stdout)
            for line in result.stdout.splitlines():
                self.assertEqual(line.split()[0], key)
        self.assertIn("ranks", machpoint("describe", "decomposition").stdout)

    def test_keys_are_described(self):
        text = machpoint("describe", "gamma").stdout
        for name in ["ideal_gas", "stiffened_gas"]:
            self.assertRegex(text, f"(?m)^{name} \\(physics\\): ")
        self.assertEqual(len(re.findall(r"(?m)^  gamma ", text)), 2, text)
        self.assertNotIn("reference_pressure", text)
        # Of an object's key that the whole input has, too.
        text = machpoint("describe", "per_cell").stdout
        self.assertTrue(text.startswith("particles (input)"), text)
        self.assertEqual(text.count("per_cell"), 1, text)
        # A key of the whole input alone.
        self.assertIn("  reproducible ", machpoint("describe", "reproducible").stdout)
        result = machpoint("describe", "gama")
        self.assertCode(result, WRONG_INPUT)
        self.assertIn('did you mean "gamma"?', result.stderr)

    def described(self, name):
        """Key -> default, from `describe`."""
        rows = [re.split(r" {2,}", line.strip()) for line in
                machpoint("describe", name).stdout.splitlines()[1:]
                if re.match(r"  \S", line)]
        column = rows[0].index("default")
        return {row[0]: row[column] for row in rows[1:]}

    def test_a_method_is_described_by_its_own_keys(self):
        for method in ["paper", "apic", "conservative"]:
            found = self.described(method)
            for scene in ["sod", "cylinder_mach3", "sedov_3d"]:
                self.run_scene(scene, method)
                used = self.summary()["input"]["method"]
                self.assertEqual({f"method.{key}" for key in used},
                                 set(found) - {"method"})
                for key, value in used.items():
                    if key == "name":
                        continue
                    default = found[f"method.{key}"]
                    if " in 1D, else " in default:
                        default = default.split(" in 1D, else ")[
                            SHIPPED[f"{scene}.json"]["dimension"] > 1]
                    self.assertEqual(json.loads(default), value, key)
        self.assertEqual(self.described("conservative")["method.blend"],
                         "0.1 in 1D, else 0.3")

    def run_scene(self, scene, method):
        """Of a method's defaults, at its start."""
        cells = [16] * SHIPPED[f"{scene}.json"]["dimension"]
        result = machpoint(
            "run", INPUTS / f"{scene}.json", "--output", self.output, "--overwrite",
            "--max-steps", "0", "--set", f'method={{"name":"{method}"}}', "--set",
            f"grid.cells={json.dumps(cells)}", "--set", "output={\"particles\":false}")
        self.assertCode(result, FINISHED)

    def test_describe_suggests(self):
        result = machpoint("describe", "artifical_viscosity")
        self.assertCode(result, WRONG_INPUT)
        self.assertIn('did you mean "artificial_viscosity"?', result.stderr)

    def test_schema_is_json(self):
        result = machpoint("schema")
        self.assertCode(result, FINISHED)
        self.assertIn("draft-07", json.loads(result.stdout)["$schema"])


class Run(CommandLineTest):

    def test_overrides(self):
        overrides = {
            "grid.cells": [50], "boundary.1.type": "no_slip_wall",
            "physics[1].linear": 0.25, "method.basis": "linear",
            "time": {"end": 0.1}, "output.grid": False
        }
        arguments = []
        for path, value in overrides.items():
            # Texts go as bare words, all else as JSON.
            text = value if isinstance(value, str) else json.dumps(value)
            arguments += ["--set", f"{path}={text}"]
        self.assertCode(self.run_sod("--max-steps", "3", *arguments), FINISHED)
        summary = self.summary()
        used = summary["input"]
        self.assertEqual(summary["cells"], [50])
        self.assertEqual(used["boundary"][1]["type"], "no_slip_wall")
        self.assertEqual(used["physics"][1]["linear"], 0.25)
        self.assertEqual(summary["basis"], "linear")
        self.assertEqual(used["time"]["end"], 0.1)
        self.assertEqual(used["time"]["cfl"], 0.4)  # the default came back
        self.assertFalse((self.output / "grid").exists())

    def test_max_steps(self):
        self.assertCode(self.run_sod("--max-steps", "7"), FINISHED)
        self.assertEqual(self.summary()["steps"], 7)
        self.assertTrue((self.output / "particles/00000007.h5").is_file())

    def test_max_steps_are_decimal(self):
        self.assertCode(self.run_sod("--max-steps", "00000010"), FINISHED)
        self.assertEqual(self.summary()["steps"], 10)
        for text in ["0x10", "1e3", "7 ", "+7", "99999999999999999999", "-3", ""]:
            with self.subTest(text=text):
                result = self.run_sod("--overwrite", f"--max-steps={text}")
                self.assertCode(result, WRONG_INPUT)
                self.assertRegex(result.stderr, "--max-steps: must (be a whole number "
                                 "from 0 to 9223372036854775807|not be empty)")
                self.assertEqual(self.summary()["steps"], 10)

    def test_extrema_are_of_the_last_state_too(self):
        result = machpoint("run", INPUTS / "toro2.json", "--max-steps", "1",
                           "--output", self.output)
        self.assertCode(result, FINISHED)
        with h5py.File(self.output / "particles/00000001.h5") as file:
            least = file["density"][:].min()
            energy = file["specific_internal_energy"][:].min()
        self.assertLess(least, 1)  # the start has 1 everywhere
        extrema = self.summary()["extrema"]
        # Up to the rounding of single precision.
        self.assertAlmostEqual(extrema["min_density"] / least, 1, 6)
        self.assertAlmostEqual(extrema["min_specific_internal_energy"] / energy, 1, 6)

    def test_extrema_do_not_know_of_checkpoints(self):
        found = []
        for every in ['{}', '{"every_steps":1}']:
            result = machpoint("run", INPUTS / "leblanc.json", "--max-steps", "60",
                               "--set", f"checkpoint={every}", "--output", self.output,
                               "--overwrite", env=ONE_THREAD)
            self.assertCode(result, FINISHED)
            found.append(self.summary()["extrema"])
        for key, value in found[0].items():
            self.assertAlmostEqual(found[1][key] / value, 1, 6, key)

    def test_memory_is_that_of_the_run(self):
        # Linux hands the largest memory of whoever starts a program on to it.
        ballast = b"x" * 2**29
        self.assertCode(self.run_sod("--max-steps", "1"), FINISHED)
        self.assertLess(self.summary()["peak_memory_bytes"], len(ballast))

    def test_no_steps(self):
        self.assertCode(self.run_sod("--max-steps", "0"), FINISHED)
        summary = self.summary()
        self.assertEqual((summary["steps"], summary["final_time"]), (0, 0))
        self.assertEqual(summary["ended"], "max steps")
        self.assertEqual(summary["errors"]["density"]["Linf"], 0)

    def test_whole_run(self):
        result = self.run_sod()
        self.assertCode(result, FINISHED)
        summary = self.summary()
        self.assertEqual(summary["final_time"], 0.2)
        # Start and end are outputs, and ten intervals lie between.
        for kind in ["particles", "grid"]:
            self.assertEqual(len(list((self.output / kind).glob("*.h5"))), 11)
        for text in ["sod", "density", "phase", "effect", "relative drift"]:
            self.assertIn(text, result.stdout)
        self.assertIn(str(self.output), result.stdout)

    def test_shares_are_of_the_whole(self):
        # Of a run that is all set-up and first output.
        result = self.run_sod("--max-steps", "0")
        phases, effects = result.stdout.split("\n  effect")
        shares = [float(found) for found in re.findall(r" ([\d.]+) %", phases)]
        self.assertGreater(len(shares), 1, result.stdout)
        # Each is rounded to a tenth.
        self.assertAlmostEqual(sum(shares), 100, delta=0.05 * len(shares) + 1e-9)
        for share in re.findall(r" ([\d.]+) %", effects):
            self.assertLessEqual(float(share), 100)

    def test_default_output(self):
        result = machpoint("run", SOD, "--max-steps", "1", cwd=self.directory)
        self.assertCode(result, FINISHED)
        self.assertTrue((self.directory / "out/sod/summary.json").is_file())

    def test_quiet(self):
        result = self.run_sod("--max-steps", "3", "--quiet")
        self.assertCode(result, FINISHED)
        self.assertEqual(result.stderr, "")
        self.assertNotIn("phase", result.stdout)
        self.assertLessEqual(len(result.stdout.splitlines()), 1)

    def test_states_beyond_floating_point(self):
        # Legal one by one, but e = p / ((gamma - 1) rho) is infinite.
        result = self.run_sod("--set", "initial.0.left.pressure=1e308")
        self.assertCode(result, WRONG_INPUT)
        self.assertIn("/initial/0: no gas has", result.stderr)
        self.assertFalse(self.output.exists())

    def test_the_text_of_an_option_is_not_empty(self):
        for option in ("--restart", "--output"):
            result = machpoint("run", SOD, option, "", cwd=self.directory)
            self.assertCode(result, WRONG_INPUT)
            self.assertIn(f"{option}: must not be empty", result.stderr)
            self.assertEqual(list(self.directory.iterdir()), [])
        # Nor is it the next word.
        for option in ("--restart", "--output", "--set"):
            for word in ("--quiet", "time.end=0.1"):
                result = machpoint("run", SOD, f"{option}=", word, cwd=self.directory)
                self.assertCode(result, WRONG_INPUT)
                self.assertIn(f"{option}: must not be empty", result.stderr)
                self.assertEqual(list(self.directory.iterdir()), [])

    def test_more_outputs_than_can_be_counted(self):
        for words in ([], ["--estimate"]):
            result = machpoint("run", SOD, "--set", "output.every=1e-300",
                               *words, cwd=self.directory)
            self.assertCode(result, WRONG_INPUT)
            self.assertIn("/output/every", result.stderr)

    def test_an_end_before_the_restart(self):
        keep = ("--set", 'checkpoint={"every_steps": 3}')
        self.assertCode(self.run_sod("--max-steps", "6", *keep), FINISHED)
        result = self.run_sod("--restart", "latest", *keep,
                              "--set", "time.end=1e-5")
        self.assertCode(result, WRONG_INPUT)
        self.assertIn("/time/end: 1e-05 lies before", result.stderr)
        result = self.run_sod("--restart", "latest", *keep, "--max-steps", "5")
        self.assertCode(result, WRONG_INPUT)
        self.assertIn("--max-steps 5: ", result.stderr)
        self.assertIn("has step 6", result.stderr)
        # Nor does it take the place of another run.
        other = self.directory / "other"
        machpoint("run", SOD, "--output", other, "--max-steps", "2")
        first = next((self.output / "checkpoints").glob("*.h5"))
        result = machpoint("run", SOD, "--output", other, "--overwrite",
                           "--restart", first, *keep, "--set", "time.end=1e-5")
        self.assertCode(result, WRONG_INPUT)
        self.assertTrue((other / "summary.json").is_file())

    def assertFinite(self):
        """Every value of every output is."""
        files = list(self.output.glob("*/*.h5"))
        self.assertGreater(len(files), 0)
        for path in files:
            with h5py.File(path) as file:
                for value in file.values():
                    if isinstance(value, h5py.Dataset):
                        self.assertTrue(numpy.isfinite(value[...]).all(), path)

    def test_far_too_long_steps_are_repeated(self):
        result = self.run_sod("--set", "time.cfl=50")
        self.assertCode(result, FINISHED)
        summary = json.loads((self.output / "summary.json").read_text())
        self.assertGreater(summary["retries"], 10)
        self.assertEqual(summary["final_time"], 0.2)
        self.assertEqual(summary["ended"], "finished")
        self.assertFinite()

    def test_failure_writes_the_last_good_state(self):
        result = self.run_sod("--set", "time.cfl=50", "--set", "time.retries=1")
        self.assertCode(result, NUMERICAL_FAILURE)
        # Which quantity, where, when, and what to try.
        for text in ["particle ", " at (", "step ", "t = ", "try "]:
            self.assertIn(text, result.stderr)
        summary = json.loads((self.output / "summary.json").read_text())
        self.assertLess(summary["final_time"], 0.2)
        self.assertEqual(summary["retries"], 1)
        self.assertEqual(summary["ended"], "broken down")
        last = self.output / f"particles/{summary['steps']:08}.h5"
        with h5py.File(last) as file:
            self.assertEqual(file.attrs["time"], summary["final_time"])
        self.assertFinite()

    def test_a_vacuum_ten_times_harder(self):
        scene = SOD.with_name("receding.json")
        result = machpoint(
            "run", scene, "--output", self.output,
            "--set", "initial.0.left.velocity=[-100]",
            "--set", "initial.0.right.velocity=[100]",
            "--set", "time.end=0.005", cwd=self.directory)
        self.assertCode(result, FINISHED)
        self.assertFinite()

    def test_existing_output_is_refused(self):
        self.assertCode(self.run_sod("--max-steps", "2"), FINISHED)
        (self.output / "notes.txt").write_text("mine")
        before = contents(self.output)
        result = self.run_sod("--max-steps", "3")
        self.assertCode(result, IO_FAILURE)
        self.assertIn("--overwrite", result.stderr)
        self.assertIn(str(self.output), result.stderr)
        self.assertEqual(contents(self.output), before)

    def test_overwrite(self):
        self.assertCode(self.run_sod("--max-steps", "2"), FINISHED)
        (self.output / "notes.txt").write_text("mine")
        result = self.run_sod("--max-steps", "3", "--overwrite")
        self.assertCode(result, FINISHED)
        self.assertEqual(self.summary()["steps"], 3)
        # No file of the former run is left, and no other one is lost.
        self.assertFalse((self.output / "particles/00000002.h5").exists())
        self.assertEqual((self.output / "notes.txt").read_text(), "mine")

    def test_overwrite_keeps_the_former_run_when_the_input_is_wrong(self):
        self.assertCode(self.run_sod("--max-steps", "2"), FINISHED)
        before = contents(self.output)
        result = self.run_sod("--overwrite", "--set", "time.cfl=0")
        self.assertCode(result, WRONG_INPUT)
        self.assertEqual(contents(self.output), before)

    def test_output_that_cannot_be_made(self):
        file = self.directory / "file"
        file.write_text("in the way")
        for output in [file, file / "out"]:
            result = machpoint("run", SOD, "--output", output)
            self.assertCode(result, IO_FAILURE)
            self.assertIn(str(output), result.stderr)
        self.assertEqual(contents(self.directory), {"file": b"in the way"})

    def test_full_disk(self):
        # Enough for the probe, for small files, and for some whole outputs.
        for limit in [1000, 30000, 39000]:
            with self.subTest(limit=limit):
                output = self.directory / str(limit)

                def fill():
                    resource.setrlimit(resource.RLIMIT_FSIZE, (limit, limit))

                result = machpoint("run", SOD, "--output", output,
                                   preexec_fn=fill)
                self.assertCode(result, IO_FAILURE)
                self.assertIn(str(output), result.stderr)
                self.assert_whole(output)
                self.assertFalse((output / "summary.json").exists())

    def test_full_disk_for_a_checkpoint(self):
        # All else is smaller, checkpoints are not.
        limit = 39000
        result = self.run_sod(
            "--max-steps", "2", "--set", 'checkpoint={"every_steps": 1}',
            "--set", "output.particles=false", "--set", "grid.cells=[200]",
            preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (limit, limit)))
        self.assertCode(result, IO_FAILURE)
        self.assertIn(str(self.output / "checkpoints"), result.stderr)

    def assert_whole(self, output):
        for path in output.rglob("*"):
            if path.is_dir():
                continue
            self.assertIn(path.suffix, [".h5", ".xdmf", ".json", ".csv"])
            if path.suffix == ".h5":
                with h5py.File(path) as file:
                    names = [name for name in file if name != "xdmf"]
                    self.assertIn("density", names)
                    for name in names:
                        self.assertEqual(len(file[name]),
                                         len(file["density"]))

    def test_a_log_that_is_full_ends_no_run(self):
        out = self.directory / "out"
        with open("/dev/full", "w") as full:
            result = subprocess.run(
                [EXECUTABLE, "run", SOD, "--set", "grid.cells=[20]", "--output", out],
                stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=full,
                timeout=20, env=ENVIRONMENT)
        self.assertEqual(result.returncode, FINISHED)
        summary = json.loads((out / "summary.json").read_text())
        self.assertEqual(summary["final_time"], summary["input"]["time"]["end"])
        self.assert_whole(out)

    def test_a_log_without_a_reader_ends_no_run(self):
        out = self.directory / "out"
        reader, writer = os.pipe()
        os.close(reader)
        try:
            run = subprocess.run(
                [EXECUTABLE, "run", SOD, "--set", "grid.cells=[20]", "--output", out],
                stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=writer,
                timeout=20, env=ENVIRONMENT)
            listed = subprocess.run(
                [EXECUTABLE, "list"], stdin=subprocess.DEVNULL, stdout=writer,
                stderr=subprocess.PIPE, text=True, timeout=20, env=ENVIRONMENT)
        finally:
            os.close(writer)
        self.assertEqual(run.returncode, FINISHED)
        self.assertTrue((out / "summary.json").exists())
        self.assert_whole(out)
        self.assertEqual(listed.returncode, IO_FAILURE)
        self.assertIn("cannot write to stdout", listed.stderr)

    def test_a_log_that_is_full_hides_no_exit_code(self):
        with open("/dev/full", "w") as full:
            result = subprocess.run(
                [EXECUTABLE, "check", SOD, "--set", "grid.cells=0"],
                stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=full,
                timeout=20, env=ENVIRONMENT)
        self.assertEqual(result.returncode, WRONG_INPUT)


class Interrupted(CommandLineTest):
    """A run that would take minutes is stopped after its second output."""

    def start(self):
        process = running.start(
            self, [EXECUTABLE, "run", SOD, "--output", self.output, "--set",
                   "grid.cells=[20000]", "--set", "output.every=1e-6"], ENVIRONMENT)
        running.wait_for(self, process, 2, self.output, "particles/*.h5")
        return process

    def test_signals(self):
        for number in [signal.SIGINT, signal.SIGTERM]:
            with self.subTest(signal=number):
                self.output = self.directory / number.name
                process = self.start()
                process.send_signal(number)
                stdout, stderr = process.communicate(timeout=60)
                self.assertEqual(process.returncode, STOPPED_EARLY,
                                 stdout + stderr)
                self.assertNotRegex(stdout + stderr, ALARMING)
                summary = self.summary()
                self.assertLess(summary["final_time"], 0.2)
                self.assertEqual(summary["ended"], "stopped")
                for kind in ["particles", "grid"]:
                    last = max((self.output / kind).glob("*.h5"))
                    self.assertEqual(int(last.stem), summary["steps"])
                    with h5py.File(last) as file:
                        self.assertEqual(file.attrs["step"], summary["steps"])
                        self.assertEqual(file.attrs["time"],
                                         summary["final_time"])

    def test_a_second_signal_ends_what_heeds_none(self):
        """A run that waits for room in a pipe comes to the end of no step."""
        ends = os.pipe()
        for end in ends:
            self.addCleanup(os.close, end)
        os.set_blocking(ends[1], False)
        for size in (4096, 1):
            try:
                while True:
                    os.write(ends[1], size * b" ")
            except BlockingIOError:
                pass
        os.set_blocking(ends[1], True)
        process = subprocess.Popen(
            [EXECUTABLE, "run", SOD, "--output", self.output, "--set",
             "time.end=0.01"], env=ENVIRONMENT, stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL, stderr=ends[1])
        self.addCleanup(process.wait)
        self.addCleanup(process.kill)
        running.wait_for(self, process, 1, self.output, "particles/*.h5")
        # `timeout` sends the same one twice, which is one.
        for _ in range(2):
            process.send_signal(signal.SIGTERM)
            time.sleep(0.05)
        time.sleep(1)
        self.assertIsNone(process.poll())
        # A step may have heeded those; the first of these is not heeded then.
        process.send_signal(signal.SIGINT)
        time.sleep(1)
        process.send_signal(signal.SIGINT)
        self.assertEqual(process.wait(timeout=10), -signal.SIGINT)

    def test_kill(self):
        process = self.start()
        process.kill()
        process.communicate(timeout=60)
        files = sorted(self.output.rglob("*.h5"))
        self.assertGreaterEqual(len(files), 2)
        for path in files:
            with h5py.File(path) as file:
                self.assertIn("step", file.attrs)
                self.assertGreater(len(file["density"]), 0)
        self.assertFalse((self.output / "summary.json").exists())


class Warnings(unittest.TestCase):
    """machpoint check: an input that is right, and seems not to be meant."""

    BARE = "physics=[{\"type\":\"ideal_gas\"}]"

    def warnings(self, name, *assignments, of="/physics"):
        arguments = [word for text in assignments for word in ("--set", text)]
        result = machpoint("check", INPUTS / f"{name}.json", *arguments)
        self.assertEqual(result.returncode, FINISHED, result.stderr)
        self.assertIn(": ok\n", result.stdout)
        start = f"{INPUTS / name}.json: warning: "
        lines = result.stderr.splitlines()
        for line in lines:
            self.assertTrue(line.startswith(start), line)
        return [line for line in lines
                if line.startswith(start + of)]

    def odd(self, *assignments):
        arguments = [word for text in assignments for word in ("--set", text)]
        result = machpoint("check", INPUTS / "cylinder_mach3.json", *arguments)
        self.assertEqual(result.returncode, FINISHED, result.stderr)
        return [line.split(": warning: ")[1]
                for line in result.stderr.splitlines()]

    def test_a_body_that_no_gas_meets(self):
        # The domain is [0, 4] x [0, 2].
        place = "boundary.4.shape.center=[0.6,{}]".format
        coarse = "grid.cells=[60,40]"
        self.assertEqual(self.odd(coarse, place(2.4)), [])
        line, = self.odd(coarse, place(3))
        self.assertTrue(line.startswith("/boundary/4: the body is outside"),
                        line)

    def test_a_body_that_leaves_no_room(self):
        line, *_ = self.odd("grid.cells=[60,40]",
                            "boundary.4.shape.radius=10")
        self.assertTrue(line.startswith("/initial: no gas is at any place"),
                        line)

    def test_a_body_that_parts_no_gas(self):
        def plate(cells, *more):
            return self.odd(
                "grid.cells=[40,20]", "boundary.4.shape={\"type\":\"box\","
                f"\"lower\":[2,0.5],\"upper\":[{2 + 0.1 * cells},1.5]}}", *more)
        self.assertEqual(plate(5), [])
        self.assertEqual(plate(1, "boundary.4.treatment=projection"), [])
        for cells in (1, 4):
            line, = plate(cells)
            self.assertTrue(line.startswith(
                f"/boundary/4: the body is {cells} cells thick"), line)
        # On a wall it has gas on one side.
        self.assertEqual(
            self.odd("grid.cells=[40,20]", "boundary.4.shape={\"type\":\"box\","
                     "\"lower\":[2,-1],\"upper\":[3,0.1]}"), [])

    def test_keys_of_another_treatment(self):
        boundary = json.loads(
            (INPUTS / "cylinder_mach3.json").read_text())["boundary"]
        for treatment, key, value in (("images", "reach", 0.2),
                                      ("images", "projection", "unilateral"),
                                      ("projection", "image_reach", 1.5)):
            body = {**boundary[4], "treatment": treatment, key: value}
            result = machpoint("check", INPUTS / "cylinder_mach3.json", "--set",
                               "boundary=" + json.dumps(boundary[:4] + [body]))
            self.assertEqual(result.returncode, WRONG_INPUT, result.stderr)
            self.assertRegex(result.stderr, f"/boundary/4/{key}: is of the treatment"
                             f" .*; leave it out")

    def test_bodies_of_different_treatments(self):
        boundary = json.loads(
            (INPUTS / "cylinder_mach3.json").read_text())["boundary"]

        def pair(cells, *treatments):
            bodies = [
                {"type": "obstacle", "name": f"{y}", "treatment": treatment,
                 "shape": {"type": "sphere", "center": [2, y], "radius": 0.4}}
                for y, treatment in zip((0.5, 1.3 + 0.05 * cells), treatments)]
            return self.odd("grid.cells=[80,40]", "boundary="
                            + json.dumps(boundary[:4] + bodies))
        line, = pair(0, "images", "projection")
        self.assertRegex(line, r"^/boundary/4: the body has images, and "
                         r"/boundary/5, which is projected, is less than 4 cells")
        line, = pair(2, "projection", "images")
        self.assertTrue(line.startswith("/boundary/5: the body has images"), line)
        self.assertEqual(pair(6, "projection", "images"), [])
        for treatment in ("images", "projection"):
            self.assertEqual(pair(0, treatment, treatment), [])

    def test_a_ramp_that_a_wall_hides(self):
        def ramp(slope, *more):
            a = math.radians(slope)
            return self.odd(
                "grid.cells=[40,20]", "boundary.4.shape={\"type\":"
                "\"half_space\",\"point\":[1,0],\"normal\":"
                f"[{-math.sin(a)},{math.cos(a)}]}}", *more)
        line, = ramp(15)
        self.assertRegex(line, r"^/boundary/4: the body rises from y_lower at "
                         r"15 degrees near \(0.95, 0\)")
        self.assertEqual(ramp(30), [])
        self.assertEqual(ramp(15, "boundary.4.treatment=projection"), [])
        # The floor is a body, too.
        self.assertEqual(self.warnings("wedge", of="/boundary"), [])
        self.assertEqual(len(self.warnings(
            "wedge", "grid.lower=[0,0]", "grid.cells=[120,80]",
            of="/boundary/4: the body rises")), 1)
        # From above.
        line, = self.odd(
            "grid.cells=[40,20]", "boundary.4.shape={\"type\":\"sphere\","
            "\"center\":[2,11.9],\"radius\":10}")
        self.assertIn("rises from y_upper at 8.3 degrees", line)

    def test_a_body_in_a_buffer(self):
        def nose(at, *more):
            return self.odd("grid.cells=[40,20]", *more,
                            "boundary.4.shape.radius=0.26",
                            f"boundary.4.shape.center=[{0.26 + 0.1 * at},1]")
        self.assertEqual(nose(4.5), [])
        line, = nose(3.4)
        self.assertRegex(line, r"^/boundary/4: the body is 3\.4 cells from "
                         r"x_lower near \(0\.34")
        self.assertIn("or take a smaller buffer", line)
        self.assertEqual(nose(3.4, "boundary.0.buffer=1"), [])
        self.assertEqual(len(nose(4.5, "boundary.0.buffer=3")), 1)
        # Elsewhere than where the stream enters.
        below = "{\"type\":\"half_space\",\"point\":[0,0.5],\"normal\":[0,1]}"
        scene = json.loads((INPUTS / "cylinder_mach3.json").read_text())
        boundary = scene["boundary"]
        boundary[0]["region"] = json.loads(below)
        boundary.append({"type": "slip_wall", "side": "x_lower", "region":
                         json.loads(below.replace("[0,1]", "[0,-1]"))})
        self.assertEqual(nose(3.4, "boundary=" + json.dumps(boundary)), [])
        # The stream passes along a floor.
        self.assertEqual(self.odd("grid.cells=[40,20]",
                                  f"boundary.4.shape={below}"), [])

    def test_a_blast_between_particles(self):
        self.assertEqual(self.warnings("sedov_2d", of=""), [])
        line, = self.warnings("sedov_2d", "initial.0.radius=0.001",
                              of="/initial")
        self.assertRegex(line, "/initial/0/radius: 0.001 is so small")

    def test_shocks_without_viscosity(self):
        # Two gases, a blast, a wall that gas runs into, cold gas that meets
        # itself, a body in a fast stream, an inflow that pushes.
        for name in ["toro1", "leblanc", "sedov_2d", "two_blasts", "piston",
                     "noh_1d", "shu_osher", "stationary_shock", "cylinder_mach3",
                     "wedge", "naca0012", "double_mach_reflection"]:
            with self.subTest(scene=name):
                line, = self.warnings(name, self.BARE)
                self.assertRegex(line, "/physics: .*sends off a shock, .* times "
                                 "the pressure, .*artificial_viscosity")
        line, = self.warnings("sod", self.BARE)
        self.assertIn("near (0.495) sends off a shock, 3.03 times", line)
        # A far gas that pushes, and one that goes on as the stream does.
        line, = self.warnings("moving_contact", self.BARE,
                              "boundary.1.pressure=9")
        self.assertIn("sends off a shock", line)
        self.assertEqual(self.warnings(
            "moving_contact", self.BARE, "boundary.1.pressure=1",
            "boundary.1.velocity=0.1"), [])

    def test_steps_longer_than_measured(self):
        line, = self.warnings("sod", "time.cfl=50", of="/time")
        self.assertRegex(line, "/time/cfl: 50 is more than .* take 1.2 or less")
        self.assertEqual(self.warnings("sod", "time.cfl=1.2", of="/time"), [])

    def test_no_shock_no_warning(self):
        for name, *assignments in [
            ("stationary_contact",), ("moving_contact",), ("receding",),
            ("einfeldt_1203",), ("expansion_corner",),
            ("isentropic_vortex", "grid.cells=[16,16]"),
            ("acoustic_wave", "grid.cells=[16]"),
            ("sod", "method={\"name\":\"paper\"}"),
            ("cylinder_mach3", "initial.0.velocity=[0.3,0]",
             "boundary.0.velocity=[0.3,0]")]:
            with self.subTest(scene=name):
                bare = [] if name in ["acoustic_wave",
                                      "isentropic_vortex"] else [self.BARE]
                self.assertEqual(self.warnings(name, *assignments, *bare), [])

    def test_exact_solutions_of_another_flow(self):
        def doubts(name, *assignments):
            return self.warnings(name, *assignments, of="/exact")

        for scene in sorted(INPUTS.glob("*.json")):
            if "exact" in json.loads(scene.read_text()):
                with self.subTest(scene=scene.stem):
                    self.assertEqual(doubts(scene.stem), [])
        rotated = doubts("sod_2d_rotated", 'exact={"type": "riemann"}')
        # Gas moves inwards along its lower sides, which let none in.
        self.assertEqual(len(rotated), 1)
        # The right wave is at the wall at t = 0.285, the left one at 0.42.
        self.assertEqual(doubts("sod", "time.end=0.28"), [])
        line, = doubts("sod", "time.end=0.4")
        self.assertRegex(line, r"at t = 0\.3 .* side x_upper near \(0\.99")
        # A vortex beside a periodic side has its images from the start.
        self.assertEqual(doubts("isentropic_vortex", "grid.cells=[40,40]",
                                "initial.0.center=[1,5]"), [])
        # Gas of a side, and the seam of a periodic one, where two gases meet.
        line, = doubts("moving_contact", "boundary.1.pressure=9")
        self.assertIn("side x_upper", line)
        periodic = "boundary=" + json.dumps(
            [{"type": "periodic", "side": f"x_{end}"}
             for end in ("lower", "upper")])
        line, = doubts("sod", periodic)
        self.assertIn("side x_lower", line)
        # A blast that arrives; what lies on top; a gas that fills a ball only.
        line, = doubts("sedov_2d", "time.end=3", "grid.cells=[40,40]")
        self.assertIn("the sedov solution does not fit the side", line)
        initial = json.loads((INPUTS / "sod.json").read_text())["initial"]
        patch = {"type": "uniform", "density": 1, "velocity": [0], "pressure": 2,
                 "region": {"type": "box", "lower": [0.2], "upper": [0.3]}}
        line, = doubts("sod", "initial=" + json.dumps(initial + [patch]))
        self.assertIn("near (0.205) does not start as the riemann", line)
        ball = {"type": "sphere", "center": [0.5, 0.5], "radius": 0.2}
        line, = doubts("translation_2d",
                       "initial.0.region=" + json.dumps(ball))
        self.assertIn("does not start as the uniform", line)
        # Friction, which shock tubes in books have none of.
        line, = doubts("sod", 'physics=[{"type": "ideal_gas"}, {"type": '
                       '"viscosity", "shear": 1e-3}]')
        self.assertIn("the riemann solution knows no viscosity", line)
        self.assertEqual(doubts("sod", 'physics=[{"type": "ideal_gas"}, {"type": '
                                '"viscosity", "shear": 0}]'), [])
        # Weight, of all but gas that stands in it.
        line, = doubts("sod", 'physics=[{"type": "ideal_gas"}, {"type": '
                       '"gravity", "acceleration": [1]}]')
        self.assertIn("the riemann solution knows no gravity", line)
        self.assertEqual(doubts("gravity_column"), [])
        # Gas that leaves faster than sound does not feel what is beyond.
        stream = [{"type": "inflow", "side": "x_lower", "density": 1.4,
                   "velocity": [3], "pressure": 1},
                  {"type": "outflow", "side": "x_upper", "pressure": 1}]
        gas = {"type": "uniform", "density": 1.4, "pressure": 1}
        for velocity, number in (3, 0), (0.5, 1):
            stream[0]["velocity"] = [velocity]
            self.assertEqual(len(doubts(
                "translation", "dimension=1", 'grid={"lower":[0],"upper":[1],'
                '"cells":[50]}', "boundary=" + json.dumps(stream), "initial="
                + json.dumps([{**gas, "velocity": [velocity]}]))), number)
        # A body in a stream, and one in gas at rest.
        for scene, expected in [("translation_2d", 1), ("gas_at_rest_2d", 0)]:
            boundary = json.loads(
                (INPUTS / f"{scene}.json").read_text())["boundary"]
            boundary.append({"type": "obstacle", "name": "ball", "shape": ball})
            lines = doubts(scene, "boundary=" + json.dumps(boundary))
            self.assertEqual(len(lines), expected)
            for line in lines:
                self.assertIn("does not fit the body near", line)

    def test_waves_that_grow(self):
        line, = self.warnings("acoustic_wave", "method.time=symplectic")
        self.assertIn("symplectic lets waves grow", line)
        self.assertEqual(
            self.warnings("translation", "method.time=symplectic"), [])

    def test_viscosity_in_a_uniform_flow(self):
        line, = self.warnings("translation_2d")
        self.assertIn("/physics/1: the gas is uniform", line)
        for change in [
            # Their random places are felt by a method that is not exact.
            "method={\"name\":\"apic\"}",
            "boundary=[{\"type\":\"slip_wall\",\"side\":\"x_lower\"},"
            "{\"type\":\"slip_wall\",\"side\":\"x_upper\"},"
            "{\"type\":\"periodic\",\"side\":\"y_lower\"},"
            "{\"type\":\"periodic\",\"side\":\"y_upper\"}]",
            "initial.0.region={\"type\":\"sphere\",\"center\":[0.5,0.5],"
            "\"radius\":0.2}"]:
            with self.subTest(change=change):
                self.assertEqual(self.warnings("translation_2d", change), [])

    def test_a_region_between_the_samples(self):
        gas = {"type": "uniform", "density": 1.4, "velocity": [0, 0]}
        ball = {"type": "sphere", "center": [0.5, 0.5], "radius": 0.001}
        initial = json.dumps([{**gas, "pressure": 1},
                              {**gas, "pressure": 1000, "region": ball}])
        self.assertEqual(self.warnings("gas_at_rest_2d", "grid.cells=[2000,2000]",
                                       f"initial={initial}"), [])
        self.assertEqual(len(self.warnings("gas_at_rest_2d")), 1)

    def test_gravity(self):
        def uniform(g):
            return self.warnings(
                "translation", "physics=[{\"type\":\"ideal_gas\"},"
                f"{{\"type\":\"gravity\",\"acceleration\":[0,{g}]}}]")
        self.assertEqual(uniform(-1e-3), [])
        felt, vanishing, froude = (
            ("1e-3", "1e-6", "4e+03") if SINGLE else
            ("1e-11", "1e-14", "4e+07"))
        self.assertEqual(uniform("-" + felt), [])
        line, = uniform("-" + vanishing)
        # |v| + c = 4 on a length of 1.
        self.assertIn(f"/physics/1: with a Froude number of {froude} gravity "
                      "vanishes", line)
        line, = self.warnings("gravity_column", self.BARE)
        self.assertIn("/physics: the gas of hydrostatic is in balance with a "
                      "gravity of -1 along x, and the scene has 0", line)
        line, = self.warnings("rayleigh_taylor",
                              "physics.1.acceleration=[0,0.1]")
        self.assertIn("/physics/1: the gas of rayleigh_taylor", line)
        line, = self.warnings("buoyancy", "physics.1.acceleration=[0.5,-1]")
        self.assertIn("with a gravity of 0 along x, and the scene has 0.5", line)


if __name__ == "__main__":
    unittest.main()
