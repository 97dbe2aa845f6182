"""The machine that something is measured on, and whether it was quiet."""
import os
import pathlib
import resource
import statistics
import subprocess

# Noise that a quiet machine stays below, relative.
QUIET = 0.1


def processor():
    """Model of this machine's CPU."""
    for line in pathlib.Path("/proc/cpuinfo").read_text().splitlines():
        if line.startswith("model name"):
            return line.partition(": ")[2]
    return "an unnamed processor"


def spread(values):
    """Largest less smallest, over the median."""
    return (max(values) - min(values)) / statistics.median(values)


def _all_busy():
    """Seconds that the machine's cores were busy or stolen since it started."""
    fields = pathlib.Path("/proc/stat").read_text().split("\n")[0].split()[1:]
    ticks = list(map(int, fields))
    idle = ticks[3] + ticks[4]
    # Guests' time is in user and nice already.
    return (sum(ticks[:8]) - idle) / os.sysconf("SC_CLK_TCK")


def _own_busy():
    """Seconds that this process and its finished children computed."""
    usages = [resource.getrusage(who) for who in
              (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)]
    return sum(u.ru_utime + u.ru_stime for u in usages)


class Watch:
    """Looks at the machine during a session: bandwidth probes, how long others
    kept its cores, and the load before it began."""

    def __init__(self, triad=None):
        """triad: the program that probes; without it probe does nothing"""
        self.triad = triad
        self.load = float(
            pathlib.Path("/proc/loadavg").read_text().split()[0])
        self.rates = []
        self._all, self._own = _all_busy(), _own_busy()

    def probe(self, seconds):
        """Bandwidth of one process, bytes per second."""
        if self.triad is None:
            return
        result = subprocess.run([self.triad, str(seconds)], check=True,
                                capture_output=True, text=True)
        self.rates.append(float(result.stdout))

    def report(self, spreads):
        """What it saw. spreads: of the repeated measurements."""
        own = _own_busy() - self._own
        others = max(0, _all_busy() - self._all - own) / max(own, 1e-9)
        seen = {"load_before": self.load, "others": others,
                "median_spread": statistics.median(spreads or [0])}
        # No spread at all: nothing was repeated, and nobody knows.
        seen["quiet"] = others < QUIET and 0 < seen["median_spread"] < QUIET
        if self.rates:
            seen["triad"] = statistics.median(self.rates)
            seen["triad_spread"] = spread(self.rates)
            seen["quiet"] = seen["quiet"] and seen["triad_spread"] < QUIET
        return seen


def in_words(seen):
    """A paragraph on what a Watch saw."""
    verdict = "The machine was quiet" if seen["quiet"] else \
        "**The machine was not quiet, so these figures mean little**"
    probes = "" if "triad" not in seen else (
        f"probes of the bandwidth between these gave "
        f"{seen['triad'] / 1e9:.2f} GB/s on one thread, "
        f"{100 * seen['triad_spread']:.1f} % apart; ")
    repeats = "nothing was repeated" if not seen["median_spread"] else (
        f"repeated measurements lie {100 * seen['median_spread']:.1f} % apart in "
        "the median")
    return (
        f"{verdict}: other processes took {100 * seen['others']:.1f} % as much "
        f"processor time as the measurements; {probes}{repeats}. Quiet is below "
        f"{100 * QUIET:.0f} % in all of these. (The load before the session, "
        f"{seen['load_before']:.2f}, is of what may have ended by then, and is not "
        "judged.)")
