"""What options of the benchmarks may be, and what a page of docs/ is made of."""
import argparse
import pathlib
import shutil

ROUNDS = 3  # of what a page shows, at least


def parser(text):
    """A parser whose --help shows text, a program's docstring, as it stands."""
    return argparse.ArgumentParser(
        description=text, formatter_class=argparse.RawDescriptionHelpFormatter)


def whole(least):
    """A type of argparse: whole numbers that are not below least."""
    def number(text):
        try:
            value = int(text)
        except ValueError:
            value = least - 1
        if value < least:
            raise argparse.ArgumentTypeError(
                f"{text} is no whole number of at least {least}")
        return value
    return number


def positive(text):
    """A type of argparse."""
    try:
        value = float(text)
    except ValueError:
        value = 0.0
    if not 0 < value < float("inf"):
        raise argparse.ArgumentTypeError(f"{text} is no number above 0")
    return value


def program(text):
    """A type of argparse: what can be started, as a path also where the PATH has it."""
    found = shutil.which(text)
    if not found:
        raise argparse.ArgumentTypeError(f"{text} is no program")
    return found


def folder(text):
    """A type of argparse: a folder, which is made where there is none."""
    try:
        pathlib.Path(text).mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise argparse.ArgumentTypeError(f"{text}: {error.strerror}") from None
    return pathlib.Path(text)


def require_full(parser, arguments, rounds, names):
    """Refuses --docs for a trial. names: of options that a page's tables have at
    their defaults."""
    if not arguments.docs:
        return
    changed = [name for name in names
               if getattr(arguments, name) != parser.get_default(name)]
    if changed:
        parser.error("--docs is of the full size: leave out --docs or " +
                     " and ".join(f"--{name}" for name in changed))
    if rounds < ROUNDS:
        parser.error(f"--docs shows medians of at least {ROUNDS} rounds, not "
                     f"{rounds}: leave out --docs or ask for more")
