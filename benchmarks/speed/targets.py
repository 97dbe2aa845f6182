"""What the figures are held against, and the table of them."""
import dataclasses
import statistics

import machine
import page


#: Updates/s of the plain loop, by threads, on the host that the targets were
#: set on.
PLAIN_LOOP_THEN = {1: 31.6e6, 2: 61e6}


@dataclasses.dataclass(frozen=True)
class Row:
    """value: None where a job was left out; least or most: what is asked for,
    neither where nothing is."""

    text: str
    value: float | None
    unit: str = ""
    least: float | None = None
    most: float | None = None
    note: str = ""

    @property
    def met(self):
        if self.value is None or self.least is None and self.most is None:
            return None
        return ((self.least is None or self.value >= self.least) and
                (self.most is None or self.value <= self.most))

    def words(self):
        unit = f" {self.unit}" if self.unit else ""
        value = "-" if self.value is None else f"{self.value:.3g}{unit}"
        asked = "-"
        if self.least is not None:
            asked = f">= {self.least:g}{unit}"
        elif self.most is not None:
            asked = f"<= {self.most:g}{unit}"
        verdict = {None: "-", True: "met", False: "**missed**"}[self.met]
        return [self.text, value, asked, verdict, self.note]


def ratio(above, below):
    return None if above is None or below is None else above / below


def scaled(of, threads):
    """How slow the host is beside that of the targets, and words for a row."""
    then = PLAIN_LOOP_THEN[threads]
    return (ratio(of.get(("plain", "ordered", threads)), then),
            f"the same, scaled by the plain loop to a host where that makes "
            f"{then / 1e6:g} M updates/s on {threads} thread(s)")


def product(a, b):
    return None if a is None or b is None else a * b


def rows(of, sod_note=""):
    """The table. of: {name of a job: median figure}, lacking names left out."""
    ours = {key[1:]: value for key, value in of.items() if key[0] == "ours"}
    mega = {key: value / 1e6 for key, value in of.items()
            if key[0] in ("ours", "plain", "taichi", "warp", "serial")}
    found = []
    for threads in (1, 2):
        mine = ours.get(("apic", 2, "ordered", threads))
        found.append(Row(
            f"2D `apic`, ordered, {threads} thread(s), over the plain loop",
            ratio(mine, of.get(("plain", "ordered", threads))), least=1.4))
    for threads in (1, 2):
        found.append(Row(
            f"2D `apic`, {threads} thread(s), mixed over ordered",
            ratio(ours.get(("apic", 2, "mixed", threads)),
                  ours.get(("apic", 2, "ordered", threads))), least=0.85))
    for threads in (1, 2):
        found.append(Row(
            f"2D `apic`, mixed, {threads} thread(s), over the plain loop's mixed",
            ratio(ours.get(("apic", 2, "mixed", threads)),
                  of.get(("plain", "mixed", threads)))))
    for name, threads in (("taichi", 1), ("taichi", 2), ("warp", 1)):
        found.append(Row(
            f"2D `apic`, ordered, {threads} thread(s), over {name.title()}",
            ratio(ours.get(("apic", 2, "ordered", threads)),
                  of.get((name, "ordered", threads))), least=1))
    for threads, least in ((1, 10), (2, 20)):
        mine = mega.get(("ours", "apic", 3, "ordered", threads))
        found.append(Row(f"3D `apic`, 8 per cell, {threads} thread(s)", mine,
                         "M updates/s", least=least))
        host, words = scaled(of, threads)
        found.append(Row(words, ratio(mine, host), "M updates/s"))
    for time in ("symplectic", "midpoint"):
        found.append(Row(
            f"2D `conservative` {time} over `apic`, cost of a particle step",
            ratio(ours.get(("apic", 2, "ordered", 1)),
                  ours.get((f"conservative_{time}", 2, "ordered", 1))),
            most=1.8))
    for dim in (2, 3):
        found.append(Row(
            f"{dim}D `apic`, OpenMP on 2 threads over Serial",
            ratio(ours.get(("apic", dim, "ordered", 2)),
                  of.get(("serial", dim))), least=1.8))
    found.append(Row("the plain loop on 2 threads over 1",
                     ratio(of.get(("plain", "ordered", 2)),
                           of.get(("plain", "ordered", 1)))))
    found.append(Row("`cylinder_mach3`, 400x200 to t = 4, 2 threads",
                     of.get(("cylinder",)), "s", most=35))
    host, words = scaled(of, 2)
    found.append(Row(words, product(of.get(("cylinder",)), host), "s"))
    found.append(Row("`cylinder_mach3` at `time.cfl` 1.2 instead of 0.8",
                     of.get(("cylinder", "cfl 1.2")), "s"))
    found.append(Row("Sod at L1(rho) <= 1.5e-3, 1 thread", of.get(("sod",)),
                     "s", most=0.1, note=sod_note))
    bare = of.get(("bytes",))
    for method in ("apic", "conservative"):
        for job, words in (
                ("memory", ""),
                ("memory, no retries", ", with `time.retries` 0")):
            taken = of.get((job, method))
            note = (f"{taken:.0f} of {bare:.0f} bytes" if taken and bare
                    else "")
            found.append(Row(
                f"2D `{method}`{words}, memory of a particle over one AoSoA's "
                "bytes", ratio(taken, bare), most=1.4, note=note))
        for job, held, words in (
                ("memory", "held", "with the old state to return to"),
                ("memory, no retries", "held, no retries",
                 "with `time.retries` 0")):
            found.append(Row(
                f"2D `{method}`, {words}, memory over all that its AoSoAs hold",
                ratio(of.get((job, method)), of.get((held, method))),
                most=1.4))
    return found


def unjudged(table):
    """The same rows without targets: of tiny sizes."""
    return [dataclasses.replace(row, least=None, most=None) for row in table]


def medians(figures):
    """{name: median} of {name: [figures]}."""
    return {name: statistics.median(values)
            for name, values in figures.items()}


def spreads(figures):
    """Of what was repeated."""
    return [machine.spread(values) for values in figures.values()
            if len(values) > 1]


def verdicts(table):
    return page.table(["", "measured", "asked for", "", ""],
                      [row.words() for row in table])


def speeds(figures):
    """A table of all rates, medians and spreads."""
    lines = []
    for name, values in figures.items():
        if name[0] not in ("ours", "plain", "taichi", "warp", "serial"):
            continue
        lines.append([" ".join(map(str, name)).replace("_", " "),
                      f"{statistics.median(values) / 1e6:.2f}",
                      f"{min(values) / 1e6:.2f} to {max(values) / 1e6:.2f}"])
    return page.table(["who, dimension, order, threads", "M updates/s",
                       "range"], lines)
