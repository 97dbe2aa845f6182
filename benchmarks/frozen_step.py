#!/usr/bin/env python3
"""How fast the fastest mode of frozen particles grows in a step of
`conservative` with the integrator midpoint (docs/conservative.md, section 1).

Gas at rest in a periodic square on quadratic splines, without viscosity: the
particles' places are kept, and what is left of the step is linear in their
velocities, affine matrices and pressures. A step is applied over and over to
noise. Compared are divergences that the half step's pressure may foresee; the
grid's new one is of the step before. It takes some five minutes.

    python3 benchmarks/frozen_step.py [--docs]
"""
import pathlib
import sys

sys.path.append(str(pathlib.Path(__file__).resolve().parent / "performance"))

import options
import packages
import page

np = packages.find("numpy")

CELLS = 16         # along an axis; units: cells, sound speed, density 1
LEAST_FILLING = 0.2
BLEND = 0.3
DOCS = page.ROOT / "docs/conservative.md"


def lattice():
    g = (np.arange(2 * CELLS) + 0.5) / 2
    return np.stack(np.meshgrid(g, g), -1).reshape(-1, 2)


def random_in_cells():
    cell = np.stack(np.meshgrid(*2 * [np.arange(CELLS)]), -1).reshape(-1, 2)
    cell = np.repeat(cell, 4, axis=0)
    return cell + np.random.default_rng(1).random(cell.shape)


def strands():
    """Four particles per cell, drawn out along x and apart along y."""
    rows = CELLS * 9 // 16
    row = 4 * CELLS**2 // rows
    x = (np.arange(row) + 0.5) * CELLS / row
    y = (np.arange(rows) + 0.3) * CELLS / rows
    return np.stack(np.meshgrid(x, y), -1).reshape(-1, 2)


class Operators:
    """Matrices between particles [n], nodes [CELLS^2] and faces, which have the
    number of the node behind them."""

    def __init__(self, x):
        n = len(x)
        self.mass = np.full(n, CELLS**2 / n)  # and volume
        cell = np.floor(x).astype(int)
        f = x - cell
        spline = [0.5 * (1 - f)**2, 0.75 - (f - 0.5)**2, 0.5 * f**2]
        hat = [1 - f, f]
        self.weights = np.zeros((n, CELLS**2))
        self.arms = np.zeros((2, n, CELLS**2))  # w (x_i - x)
        self.faces = np.zeros((2, n, CELLS**2))

        def node(i, j):
            return ((cell[:, 0] - 1 + i) % CELLS
                    + CELLS * ((cell[:, 1] - 1 + j) % CELLS))

        rows = np.arange(n)
        for i in range(3):
            for j in range(3):
                w = spline[i][:, 0] * spline[j][:, 1]
                self.weights[rows, node(i, j)] += w
                self.arms[0, rows, node(i, j)] += w * (i - 0.5 - f[:, 0])
                self.arms[1, rows, node(i, j)] += w * (j - 0.5 - f[:, 1])
                if i < 2:
                    self.faces[0, rows, node(i, j)] += (hat[i][:, 0]
                                                        * spline[j][:, 1])
                if j < 2:
                    self.faces[1, rows, node(i, j)] += (spline[i][:, 0]
                                                        * hat[j][:, 1])
        self.node_mass = self.weights.T @ self.mass
        self.filling = np.array([w.T @ self.mass for w in self.faces])
        den = np.maximum(self.filling, LEAST_FILLING)
        index = np.arange(CELLS**2).reshape(CELLS, CELLS)
        ahead = [np.roll(index, -1, axis=1 - a).ravel() for a in range(2)]
        one = np.eye(CELLS**2)
        differences = [one[ahead[a]] - one for a in range(2)]

        def divergence(of_face):
            return np.hstack([(self.faces[a] * of_face[a]) @ differences[a]
                              for a in range(2)])

        self.plain = divergence(np.ones_like(den))
        self.over_filling = divergence(1 / den)
        self.foreseen = divergence(self.filling / den**2)
        # Of docs/conservative.md, section 10.
        faces = sum(self.filling[a] / den[a]**2
                    + np.roll((self.filling[a] / den[a]**2).reshape(
                        CELLS, CELLS), 1, axis=1 - a).ravel()
                    for a in range(2))
        self.stiffness = 2 / 3 * 11 / 20 * (faces / self.node_mass).max()

    def fastest_mode(self):
        """Square of its frequency, (c/h)^2."""
        push = (np.sqrt(self.mass)[:, None] * self.over_filling
                / np.sqrt(np.tile(self.node_mass, 2)))
        return np.linalg.norm(push, 2)**2


def growth(op, step, scheme, steps=500):
    """Factor in a step of the fastest mode."""
    rng = np.random.default_rng(0)
    n = len(op.mass)
    v = rng.normal(size=(2, n))
    affine = np.zeros((2, 2, n))
    p = rng.normal(size=n)
    last = {"plain": 0 * p, "over the filling": 0 * p}
    factors = []
    for _ in range(steps):
        grid = np.stack([(op.weights.T @ (op.mass * v[a]) + sum(
            op.arms[b].T @ (op.mass * affine[a, b]) for b in range(2)))
            / op.node_mass for a in range(2)])
        ahead = (affine[0, 0] + affine[1, 1] if scheme == "tr C"
                 else last[scheme])
        force = op.over_filling.T @ (op.mass * (p - step / 2 * ahead))
        new = grid + step * force.reshape(2, -1) / op.node_mass
        change = new - (1 - BLEND) * grid
        v = change @ op.weights.T + (1 - BLEND) * v
        affine = np.stack([[4 * op.arms[b] @ change[a]
                            + (1 - BLEND) * affine[a, b] for b in range(2)]
                           for a in range(2)])
        p = p - step * op.over_filling @ ((grid + new) / 2).ravel()
        last = {"plain": op.plain @ new.ravel(),
                "over the filling": op.foreseen @ new.ravel()}
        size = np.sqrt((op.mass * (p**2 + (v**2).sum(axis=0)
                                   + (affine**2).sum(axis=(0, 1)) / 4)).sum())
        factors.append(size)
        v, affine, p = v / size, affine / size, p / size
        last = {k: d / size for k, d in last.items()}
    return np.exp(np.log(factors[steps // 2:]).mean())


def table():
    schemes = ("tr C", "plain", "over the filling")
    lines = ["| particles, 4 per cell | least filling | fastest mode, $s$, "
             "$(c/h)^2$ | $c \\Delta t / h$ | " + " | ".join(schemes) + " |",
             "|---|---|---|---|" + "---|" * len(schemes)]
    for name, place in (("on a lattice", lattice),
                        ("at random places of their cells", random_in_cells),
                        ("in strands", strands)):
        op = Operators(place())
        most = np.sqrt(2.4 / op.stiffness)
        for step in (0.5 * most, 0.75 * most, most, 1.25 * most):
            lines.append(
                f"| {name} | {op.filling.min():.2f} | {op.fastest_mode():.2f}, "
                f"{op.stiffness:.2f} | {step:.2f} | " + " | ".join(
                    f"{growth(op, step, s):.3f}" for s in schemes) + " |")
    return "\n".join(lines) + "\n"


def main():
    parser = options.parser(__doc__)
    parser.add_argument("--docs", action="store_true",
                        help="write the table to docs/conservative.md")
    arguments = packages.parse(parser)
    if arguments.docs:
        page.require("frozen step", path=DOCS)
    found = table()
    print(found)
    if arguments.docs:
        page.write("frozen step", found, DOCS)


if __name__ == "__main__":
    main()
