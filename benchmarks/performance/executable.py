"""The option that names the program to run."""
import options
import program
from page import ROOT


def _type(text):
    found = options.program(text)
    program.version(found)
    return found


def add_option(parser, name="--machpoint"):
    """It ends the program where what is named is no machpoint."""
    parser.add_argument(name, metavar="PATH", type=_type,
                        default=str(ROOT / "build/openmp/machpoint"),
                        help="default: build/openmp/machpoint")
