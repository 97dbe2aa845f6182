"""Medians of what was repeated, and what is computed from them."""
import dataclasses
import operator
import statistics


@dataclasses.dataclass(frozen=True)
class Median:
    """value: None of what was left out. A quotient or a product is of as many
    runs as that of its two which has fewer."""

    value: float | None = None
    runs: int = 0

    def _with(self, other, operation):
        if self.value is None or other.value is None:
            return Median()
        return Median(operation(self.value, other.value),
                      min(self.runs, other.runs))

    def __truediv__(self, other):
        return self._with(other, operator.truediv)

    def __mul__(self, other):
        return self._with(other, operator.mul)

    def scaled(self, factor):
        return self if self.value is None else \
            Median(factor * self.value, self.runs)


class Medians:
    """By name, of {name: [figures]}."""

    def __init__(self, figures):
        self._figures = figures

    def __getitem__(self, name):
        values = self._figures.get(name)
        return Median(statistics.median(values), len(values)) if values else \
            Median()

    def __iter__(self):
        return iter(self._figures)

    def fastest(self, names):
        """The name of the highest; the first where there is none."""
        return max(names, key=lambda name: self[name].value or 0)
