"""How much benchmarks/speed runs."""
import dataclasses


@dataclasses.dataclass(frozen=True)
class Sizes:
    cells: int  # of the box, along an axis
    steps: int  # of a yardstick
    cylinder: tuple  # its cells
    cylinder_steps: int | None  # None: to the end
    sod_error: float  # of the density, L1
    sod_cells: tuple  # with which it is tried to be met
    probe_seconds: float

    @property
    def particles(self):
        return 4 * self.cells ** 2


FULL = Sizes(512, 20, (400, 200), None, 1.5e-3,
             (100, 150, 200, 250, 300, 400, 500, 600, 800, 1000, 1200), 1)
TINY = Sizes(32, 2, (40, 20), 5, 5e-2, (50, 100), 0.1)
