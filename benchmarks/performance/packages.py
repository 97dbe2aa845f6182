"""Packages that a program needs, and that not every python3 has."""
import importlib

REMEDY = ("tools/setup installs numpy, h5py and matplotlib for Debian's python3: "
          "run this with /usr/bin/python3")
_lacking = {}


def find(name):
    """A package; None where there is none, and then parse ends the program."""
    try:
        return importlib.import_module(name)
    except ImportError as error:
        _lacking[name] = str(error)
        return None


def parse(parser):
    """The options of a command line. Its errors and --help need no package."""
    arguments = parser.parse_args()
    if _lacking:
        parser.exit(2, f"{parser.prog}: {'; '.join(_lacking.values())}: {REMEDY}\n")
    return arguments
