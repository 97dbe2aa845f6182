"""What a hard case is: runs of a scene, what is measured, what is asked."""
import dataclasses
import typing


# Source of bounds on values that only the fast version measures.
COARSE = "fast version"


@dataclasses.dataclass(frozen=True)
class Bound:
    """What a measured value must lie between; `source` says who says so."""
    low: float = float("-inf")
    high: float = float("inf")
    source: str = ""
    prototype: typing.Optional[float] = None

    def holds(self, value):
        return value is not None and self.low <= value <= self.high

    def __str__(self):
        if self.low == float("-inf"):
            return f"<= {self.high:.4g}"
        if self.high == float("inf"):
            return f">= {self.low:.4g}"
        return f"{self.low:.4g} .. {self.high:.4g}"


def at_most(high, source="", prototype=None):
    return Bound(high=high, source=source, prototype=prototype)


def at_least(low, source="", prototype=None):
    return Bound(low=low, source=source, prototype=prototype)


def about(value, part, source="", prototype=None):
    """Within a relative distance of a value."""
    distance = abs(value) * part
    return Bound(value - distance, value + distance, source, prototype)


@dataclasses.dataclass
class Case:
    """A group of runs of one scene.

    runs: overrides of each run, {dotted path: value}; fast: those of the
    seconds-long version, by default the same. measure( runs ) gives
    {label: value}; labels name the size, so bounds apply to the version that
    measured them. A bound holds for `conservative`; of every method and run the
    invariants are asked.
    """
    name: str
    group: str
    scene: str
    about: str
    measure: typing.Callable
    runs: list = dataclasses.field(default_factory=lambda: [{}])
    fast: typing.Optional[list] = None
    bounds: dict = dataclasses.field(default_factory=dict)
    methods: tuple = ("conservative", "apic", "paper")
    timeout: float = 1800
    most_steps: typing.Optional[int] = None
    # Measures against machpoint_reference at full size: {label: value}.
    reference: typing.Optional[typing.Callable] = None
    # Axes of the last grid output about which it must be its own mirror image.
    mirrors: tuple = ()

    def variants(self, fast):
        return self.fast if fast and self.fast is not None else self.runs
