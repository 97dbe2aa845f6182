"""What the figures are held against, and the table of them."""
import dataclasses
import statistics

import machine
import page
from jobs import PLAIN_LOOPS
from median import Median, Medians

#: Updates/s of the plain loop, by threads, on the host that the targets were
#: set on.
PLAIN_LOOP_THEN = {1: 31.6e6, 2: 61e6}
RATES = ("ours", *PLAIN_LOOPS, "taichi", "warp", "serial")
TIMES = ("symplectic", "midpoint")


@dataclasses.dataclass(frozen=True)
class Row:
    """least or most: what is asked for, neither where nothing is."""

    text: str
    figure: Median
    unit: str = ""
    least: float | None = None
    most: float | None = None
    note: str = ""

    @property
    def met(self):
        value = self.figure.value
        if value is None or self.least is None and self.most is None:
            return None
        return ((self.least is None or value >= self.least) and
                (self.most is None or value <= self.most))

    def words(self):
        value, unit = self.figure.value, f" {self.unit}" if self.unit else ""
        bound, sign = (self.most, "<=") if self.least is None else \
            (self.least, ">=")
        asked = "-" if bound is None else f"{bound:.3g}"
        measured = "-" if value is None else f"{value:.3g}"
        if self.met is False and measured == asked:
            measured = f"{value:.5g}"  # by how little
        verdict = {None: "-", True: "met", False: "**missed**"}[self.met]
        return [self.text, measured if value is None else measured + unit,
                asked if bound is None else f"{sign} {asked}{unit}", verdict,
                self.figure.runs or "-", self.note]


class PlainLoop:
    """The faster one of its builds, on each number of threads and in each order
    of the particles."""

    def __init__(self, of):
        self._of = of

    def name(self, order, threads):
        return self._of.fastest([(build, order, threads)
                                 for build in PLAIN_LOOPS])

    def rate(self, order, threads):
        return self._of[self.name(order, threads)]

    def note(self, order, threads):
        """Which one, if any ran."""
        build = PLAIN_LOOPS[self.name(order, threads)[0]]
        return f"`{build}`" if self.rate(order, threads).value else ""

    def host(self, threads):
        """How fast the host is beside that of the targets, and words for a
        row."""
        then = PLAIN_LOOP_THEN[threads]
        return (self.rate("ordered", threads).scaled(1 / then),
                f"the same, scaled by the plain loop to a host where that makes "
                f"{then / 1e6:g} M updates/s on {threads} thread(s)")


def speed_rows(of, plain):
    apic = {(order, threads): of["ours", "apic", 2, order, threads]
            for order in ("ordered", "mixed") for threads in (1, 2)}
    for threads in (1, 2):
        yield Row(f"2D `apic`, ordered, {threads} thread(s), over the plain loop",
                  apic["ordered", threads] / plain.rate("ordered", threads),
                  least=1.4, note=plain.note("ordered", threads))
    for threads in (1, 2):
        yield Row(f"2D `apic`, {threads} thread(s), mixed over ordered",
                  apic["mixed", threads] / apic["ordered", threads], least=0.85)
    for threads in (1, 2):
        yield Row(f"2D `apic`, mixed, {threads} thread(s), over the plain loop's "
                  "mixed", apic["mixed", threads] / plain.rate("mixed", threads),
                  note=plain.note("mixed", threads))
    for name, threads in (("taichi", 1), ("taichi", 2), ("warp", 1)):
        yield Row(f"2D `apic`, ordered, {threads} thread(s), over {name.title()}",
                  apic["ordered", threads] / of[name, "ordered", threads])
    for threads, least in ((1, 10), (2, 20)):
        mine = of["ours", "apic", 3, "ordered", threads].scaled(1e-6)
        yield Row(f"3D `apic`, 8 per cell, {threads} thread(s)", mine,
                  "M updates/s", least=least)
        host, words = plain.host(threads)
        yield Row(words, mine / host, "M updates/s")
    for dim in (2, 3):
        yield Row(f"{dim}D `apic`, OpenMP on 2 threads over Serial",
                  of["ours", "apic", dim, "ordered", 2] / of["serial", dim],
                  least=1.8)
    yield Row("the plain loop on 2 threads over 1",
              plain.rate("ordered", 2) / plain.rate("ordered", 1))


def cost_rows(of):
    """`conservative` over `apic`, as a whole and by parts: these may take as
    much longer as they move more bytes."""
    apic = of["ours", "apic", 2, "ordered", 1]
    for time in TIMES:
        method = f"conservative_{time}"
        yield Row(f"2D `conservative` {time} over `apic`, cost of a particle step",
                  apic / of["ours", method, 2, "ordered", 1], most=1.8)
        for part in (name[2] for name in of if name[:2] == ("part", method)):
            # A part that `apic` does without, or whose bytes nobody counts, has
            # nothing to be held against.
            if not of["bytes", "apic", part].value or \
                    not of["bytes", method, part].value:
                continue
            longer = of["part", "apic", part] / of["part", method, part]
            more = of["bytes", method, part] / of["bytes", "apic", part]
            yield Row(f"the same, {part} alone, bound by its bytes over those of "
                      "`apic`", longer, most=more.value)


def run_rows(of, plain, sizes, sod_note):
    cylinder = of["cylinder",]
    how_far = f"for {sizes.cylinder_steps} steps" if sizes.cylinder_steps else \
        "to t = 4"
    yield Row(f"`cylinder_mach3`, {'x'.join(map(str, sizes.cylinder))} {how_far}, "
              "2 threads", cylinder, "s", most=35)
    host, words = plain.host(2)
    yield Row(words, cylinder * host, "s")
    yield Row("`cylinder_mach3` at `time.cfl` 1.2 instead of 0.8",
              of["cylinder", "cfl 1.2"], "s")
    yield Row(f"Sod at L1(rho) <= {sizes.sod_error:g}, 1 thread", of["sod",], "s",
              most=0.1, note=sod_note)


def memory_rows(of):
    bare = of["bytes",]
    for method in ("apic", "conservative"):
        for retries, words in (("", "with the old state to return to"),
                               (", no retries", "with `time.retries` 0")):
            taken = of["memory" + retries, method]
            over = taken / bare
            note = "" if over.value is None else \
                f"{taken.value:.0f} of {bare.value:.0f} bytes"
            yield Row(f"2D `{method}`, {words}, memory of a particle over one "
                      "AoSoA's bytes", over, most=1.4, note=note)
            yield Row(f"2D `{method}`, {words}, memory over all that its AoSoAs "
                      "hold", taken / of["held" + retries, method])


def rows(figures, sizes, sod_note=""):
    """The table. figures: {name of a job: [figures]}, lacking names left out."""
    of = Medians(figures)
    plain = PlainLoop(of)
    return [*speed_rows(of, plain), *cost_rows(of),
            *run_rows(of, plain, sizes, sod_note), *memory_rows(of)]


def unjudged(table):
    """The same rows without targets: of tiny sizes."""
    return [dataclasses.replace(row, least=None, most=None) for row in table]


def spreads(figures):
    """Of what was repeated; parts of a step are within it."""
    return [machine.spread(values) for name, values in figures.items()
            if len(values) > 1 and name[0] != "part"]


def verdicts(table):
    return page.table(["", "measured", "asked for", "", "runs", ""],
                      [row.words() for row in table])


def speeds(figures):
    """A table of all rates, medians and spreads."""
    lines = []
    for name, values in figures.items():
        if name[0] not in RATES:
            continue
        lines.append([" ".join(map(str, name)).replace("_", " "),
                      f"{statistics.median(values) / 1e6:.2f}",
                      f"{min(values) / 1e6:.2f} to {max(values) / 1e6:.2f}",
                      len(values)])
    return page.table(["who, dimension, order, threads", "M updates/s",
                       "range", "runs"], lines)
