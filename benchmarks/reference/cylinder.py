"""A run past a cylinder that a command line names, and what is known of its flow."""
import json
import pathlib
import types

import options
import packages


def parse(text):
    """folder; scene, the run's input; body, its sphere; gas of the free stream;
    behind, the density behind a normal shock; first, the least time that counts.

    text: the docstring of what is run.
    """
    parser = options.parser(text)
    parser.add_argument("folder", metavar="DIR", type=pathlib.Path,
                        help="a run of input/cylinder_mach3.json")
    parser.add_argument("first", metavar="first_time", type=float, nargs="?",
                        help="default: the last quarter")
    arguments = packages.parse(parser)
    try:
        scene = json.loads((arguments.folder / "summary.json").read_text())["input"]
    except OSError as error:
        parser.error(f"DIR is no finished run: {error.filename}: {error.strerror}")
    body = next((b["shape"] for b in scene["boundary"] if b["type"] == "obstacle"
                 and b["shape"]["type"] == "sphere"), None)
    if body is None or scene["dimension"] != 2:
        parser.error(f"{arguments.folder} holds no run past a cylinder")
    gamma = next(p["gamma"] for p in scene["physics"] if "gamma" in p)
    gas = scene["initial"][0]
    mach2 = gas["velocity"][0]**2 * gas["density"] / (gamma * gas["pressure"])
    ratio = (gamma + 1) * mach2 / ((gamma - 1) * mach2 + 2)
    first = 0.75 * scene["time"]["end"] if arguments.first is None \
        else arguments.first
    return types.SimpleNamespace(folder=arguments.folder, scene=scene, body=body,
                                 gas=gas, behind=ratio * gas["density"],
                                 first=first)
