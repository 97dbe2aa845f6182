#!/usr/bin/env python3
"""Draws what a run of machpoint left in its output directory.

1D: profiles of the particles against the exact solution (profiles.png).
2D: a field and a numerical schlieren (schlieren.png).
3D: the same on three planes through the middle (slices.png).
All: a sheet of every output time (contact_sheet.png) and a movie (movie.mp4,
or movie.gif where ffmpeg is missing), and for a run of particles report.html:
pictures, tables and the input in one file. Prints the path of each.
Of a study: plot.py study DIR (plot_study.py).
"""
import argparse
import itertools
import json
import pathlib
import subprocess
import sys

try:
    import h5py
    import matplotlib
    import numpy as np

    matplotlib.use("Agg")
    import matplotlib.animation as animation
    import matplotlib.pyplot as plt

    import plot_report
    import plot_study
except ImportError as error:
    sys.exit(f"plot.py: {error}; it needs numpy, h5py and matplotlib (Debian: apt-get "
             "install python3-numpy python3-h5py python3-matplotlib, then run it with "
             "/usr/bin/python3)")

PROFILES = ["density", "velocity", "pressure", "specific_internal_energy"]
FIELDS = PROFILES + ["schlieren"]
SHEET_PANELS = 24  # a sheet with more would show nothing
CONTRAST = 40.0  # of the schlieren: how far weak gradients are raised
MOVIE_SECONDS = 6.0
MOVIE_FRAMES = 250  # of a run with more outputs

plt.rcParams["axes.formatter.useoffset"] = False  # tell values, not 1e-6+1


# --------------------------------------------------------------------------
# Reading a run.
# --------------------------------------------------------------------------


class Run:
    """The files of one output directory, found but not yet read."""

    def __init__(self, directory):
        self.directory = directory
        self.particles = self._files("particles")
        self.grid = self._files("grid")
        self.exact = self._files("exact")
        # A run that was killed has none; its pictures are still wanted.
        summary = directory / "summary.json"
        self.summary = json.loads(summary.read_text()) if summary.exists() else {}
        self.dimension = self._dimension()
        files = self.particles if self.dimension == 1 else self.grid
        self.times = {}
        for step, path in files.items():
            with h5py.File(path) as file:
                self.times[step] = float(file.attrs["time"])

    def _files(self, kind):
        """{step: path} in order; what is still being written ends in .tmp."""
        paths = (self.directory / kind).glob("*.h5")
        return dict(sorted((int(p.stem), p) for p in paths if p.stem.isdigit()))

    def _dimension(self):
        """From the grid; 1D is drawn from particles, the others from the grid."""
        for path in self.grid.values():
            with h5py.File(path) as file:
                dimension = len(file.attrs["lower"])
            if dimension > 1 or self.particles:
                return dimension
        for path in self.particles.values():
            with h5py.File(path) as file:
                if file["position"].shape[1] == 1:
                    return 1
        missing = (f"plot.py: {self.directory}: holds no output to draw (particles/*.h5 "
                   "in 1D, grid/*.h5 in 2D and 3D)")
        if self.summary: # of a run that was to write none
            kind = "particles" if self.summary["dimension"] == 1 else "grid"
            print(f"{missing}; set output.{kind} for pictures")
            sys.exit(0)
        sys.exit(f"{missing}; give the directory that machpoint run named with --output")

    def steps_at(self, times):
        """The outputs nearest to the times asked for; all without any."""
        if not times:
            return list(self.times)
        nearest = lambda time: min(self.times, key=lambda s: abs(self.times[s] - time))
        return sorted({nearest(time) for time in times})

    def title(self, step):
        """Scene, method, basis, cells, time: as many as are known."""
        cells = self.summary.get("cells")
        if isinstance(cells, list):
            cells = "\N{MULTIPLICATION SIGN}".join(str(n) for n in cells)
        parts = [self.summary.get("scene", self.directory.resolve().name)]
        parts += [self.summary.get("method"), self.summary.get("basis")]
        parts += [f"{cells} cells" if cells else None]
        parts += [f"t = {self.times[step]:.4g}"]
        return ", ".join(str(part) for part in parts if part)


def read_profile(path):
    """Position and the profile fields of a 1D file, sorted by position."""
    with h5py.File(path) as file:
        data = {name: file[name][...].ravel() for name in ["position"] + PROFILES}
    order = np.argsort(data["position"])
    return {name: values[order] for name, values in data.items()}


def read_plane(run, step, field, normal=2):
    """A field on the grid or, in 3D, on the plane of nodes amid an axis.

    Returns the values [rows][columns], NaN where there is no gas (density 0,
    inside obstacles), the extent for imshow, the two axes' names, and for a
    title where the plane is: of an even number, half a cell beyond the middle.
    """
    with h5py.File(run.grid[step]) as file:
        lower, spacing = file.attrs["lower"], file.attrs["spacing"]
        axes, plane, place = [0, 1], (), ""
        if run.dimension == 3:
            axes = [a for a in range(3) if a != normal]
            storage = 2 - normal  # x is the last axis of a dataset
            middle = file["density"].shape[storage] // 2
            plane = (slice(None),) * storage + (middle,)
            where = lower[normal] + middle * spacing[normal]
            place = f", {'xyz'[normal]} = {where:.4g}"
        density = file["density"][plane or ...]
        values = density
        if field == "velocity":
            values = np.linalg.norm(file["velocity"][plane or ...], axis=-1)
        elif field != "schlieren":
            values = file[field][plane or ...]
    values = np.where(density > 0, values, np.nan)
    h = [spacing[axes[1]], spacing[axes[0]]]
    if field == "schlieren":
        values = gradient_magnitude(values, h)
    rows, columns = values.shape
    first = [lower[a] - spacing[a] / 2 for a in axes]  # a node fills a pixel
    extent = [first[0], first[0] + columns * h[1], first[1], first[1] + rows * h[0]]
    return values, extent, ["xyz"[a] for a in axes], place


def gradient_magnitude(values, spacing):
    """Central differences, one-sided beside nodes without gas; no round-off."""
    total = np.zeros_like(values)
    for axis, h in enumerate(spacing):
        slope = np.diff(values, axis=axis) / h
        pad = [(0, 0), (0, 0)]
        pad[axis] = (1, 1)
        slope = np.pad(slope, pad, constant_values=np.nan)
        sides = np.stack([np.delete(slope, -1, axis), np.delete(slope, 0, axis)])
        known = np.isfinite(sides)
        sides = np.where(known, sides, 0).sum(axis=0)
        total += (sides / np.maximum(known.sum(axis=0), 1)) ** 2
    gradient = np.sqrt(total)
    largest = np.max(values, initial=0.0, where=np.isfinite(values))
    gradient[gradient < 1e-9 * largest / max(spacing)] = 0.0
    return np.where(np.isnan(values), np.nan, gradient)


def scale(run, steps, field, normals=(2,)):
    """Limits of a field over some outputs and planes, a few outliers aside."""
    low, high = [], []
    for step, normal in itertools.product(steps, normals):
        values = read_plane(run, step, field, normal)[0]
        values = values[np.isfinite(values)]
        if values.size:
            low.append(np.percentile(values, 0.2))
            high.append(np.percentile(values, 99.8))
    if not low:
        return 0.0, 1.0
    return without_round_off(min(low), max(high), field)


def without_round_off(low, high, field):
    """Limits that show none: gas that is all the same is in their middle."""
    size = max(abs(low), abs(high))
    least = 1e-12 if field == "velocity" else 1e-300  # of gas at rest
    if high - low > max(1e-6 * size, least):
        return low, high
    middle, half = 0.5 * (low + high), max(0.01 * size, least)
    return middle - half, middle + half


def shade(gradient, reference):
    """Log-normalised gradient: 0 (white) where flat, 1 (black) at shocks."""
    relative = np.clip(gradient / reference, 0.0, 1.0)
    return np.log1p(CONTRAST * relative) / np.log1p(CONTRAST)


# --------------------------------------------------------------------------
# Figures: each is made once and gives a function that shows an output in it.
# --------------------------------------------------------------------------


def profile_figure(run, steps):
    """Four profiles, particles as dots, the exact solution as a line."""
    figure, axes = plt.subplots(2, 2, figsize=(10, 7), sharex=True,
                                constrained_layout=True)
    title = figure.suptitle(run.title(steps[0]))
    frames = {step: read_profile(run.particles[step]) for step in steps}
    exact = {s: read_profile(run.exact[s]) for s in steps if s in run.exact}
    dots, lines = {}, {}
    for field, axis in zip(PROFILES, axes.flat):
        (lines[field],) = axis.plot([], [], "k-", lw=1, label="exact")
        (dots[field],) = axis.plot([], [], "o", ms=2.5, color="C0", label="particles")
        error = ((run.summary.get("errors") or {}).get(field) or {}).get("L1")
        note = f"  (L1 at the end: {error:.3g})" if error is not None else ""
        axis.set_title(field.replace("_", " ") + note, fontsize=10)
        every = list(frames.values()) + list(exact.values())
        axis.set_xlim(*value_range(every, "position", 0.0))
        axis.set_ylim(*value_range(every, field, 0.06))
        axis.grid(alpha=0.3)
    for axis in axes[1]:
        axis.set_xlabel("x")
    if exact:
        axes[0, 0].legend(loc="best", fontsize=9)

    def show(step):
        title.set_text(run.title(step))
        for field in PROFILES:
            data = frames[step]
            dots[field].set_data(data["position"], data[field])
            data = exact.get(step, {"position": [], field: []})
            lines[field].set_data(data["position"], data[field])

    return figure, show


def value_range(frames, field, margin):
    values = np.concatenate([frame[field] for frame in frames])
    values = values[np.isfinite(values)]
    if not values.size:
        return 0.0, 1.0
    low, high = without_round_off(values.min(), values.max(), field)
    pad = margin * (high - low)
    return low - pad, high + pad


def height_to_width(run, step, normals=(2,)):
    """Of the tallest plane, in lengths: cells need not be squares."""
    ratios = []
    for normal in normals:
        left, right, low, high = read_plane(run, step, "density", normal)[1]
        ratios.append((high - low) / (right - left))
    return min(max(*ratios, 0.15), 4.0)


def plane_figure(run, steps, field, normals=(2,)):
    """A field above its schlieren, beside it where the scene is tall; in 3D a
    column for each plane."""
    ratio = height_to_width(run, steps[0], normals)
    rows, columns, longest = 2, len(normals), 3.8  # in inches, of a panel
    if run.dimension == 2:
        rows, columns, longest = (1, 2, 5.0) if ratio > 0.9 else (2, 1, 6.4)
    width, height = longest / max(ratio, 1), longest * min(ratio, 1)
    size = (max(columns * (width + 0.8) + 0.8, 7.0),
            rows * (height + 0.7) + 0.3)
    figure, axes = plt.subplots(rows, columns, figsize=size, squeeze=False,
                                layout="compressed")
    axes = axes.reshape(2, len(normals))
    figure.get_layout_engine().set(h_pad=0.08)  # between x and the title below
    title = figure.suptitle(run.title(steps[0]))
    top = "density" if field == "schlieren" else field
    limits = {name: scale(run, steps, name, normals) for name in (top, "schlieren")}
    images = {}
    for column, normal in enumerate(normals):
        for row, name in enumerate([top, "schlieren"]):
            axis = axes[row, column]
            values, extent, labels, place = read_plane(run, steps[0], name,
                                                       normal)
            images[name, normal] = draw_image(axis, values, extent, name, limits)
            axis.set_xlabel(labels[0])
            axis.set_ylabel(labels[1])
            what = "schlieren of the density" if row else label_of(run, top)
            axis.set_title(what + place, fontsize=10)
    figure.colorbar(images[top, normals[-1]], ax=list(axes.flat),
                    shrink=0.92 / rows, anchor=(0.0, 1.0),
                    label=label_of(run, top))

    def show(step):
        title.set_text(run.title(step))
        for (name, normal), image in images.items():
            values = read_plane(run, step, name, normal)[0]
            image.set_data(picture(values, name, limits))

    return figure, show


def label_of(run, field):
    is_speed = field == "velocity" and run.dimension > 1
    return "speed" if is_speed else field.replace("_", " ")


def thinned(steps, most):
    """The first, the last, and others evenly between, `most` at most."""
    if len(steps) <= most:
        return steps
    return [steps[i] for i in np.linspace(0, len(steps) - 1, most).round().astype(int)]


def picture(values, field, limits):
    """What imshow gets: the values, or the shade of a gradient."""
    return shade(values, limits[field][1]) if field == "schlieren" else values


def draw_image(axis, values, extent, field, limits):
    is_schlieren = field == "schlieren"
    low, high = (0.0, 1.0) if is_schlieren else limits[field]
    return axis.imshow(picture(values, field, limits), origin="lower", extent=extent,
                       cmap="gray_r" if is_schlieren else "viridis",
                       vmin=low, vmax=high)


def contact_sheet(run, steps, field):
    """One small panel for each output time, evenly thinned if too many."""
    steps = thinned(steps, SHEET_PANELS)
    ratio, labels, place = 0.7, ["x", label_of(run, field)], ""
    if run.dimension > 1:
        limits = {field: scale(run, steps, field)}
        ratio = height_to_width(run, steps[0])
        _, _, labels, place = read_plane(run, steps[0], field)
    width, height = 3.2 / max(ratio, 1), 3.2 * min(ratio, 1)
    columns = min(int(15 / (width + 0.5)), len(steps))
    rows = -(-len(steps) // columns)
    size = (max(columns * (width + 0.5) + 0.4, 7.0),
            rows * (height + 0.5) + 0.8)
    figure, axes = plt.subplots(rows, columns, figsize=size, squeeze=False,
                                sharex=True, sharey=True, layout="compressed")
    figure.get_layout_engine().set(w_pad=0.1, h_pad=0.06)
    for axis in axes.flat[len(steps) :]:
        axis.set_axis_off()
    for axis in axes.flat[max(len(steps) - columns, 0) : len(steps)]:
        axis.set_xlabel(labels[0])
        axis.tick_params(labelbottom=True)  # also above an empty place
    for axis in axes.flat:
        axis.tick_params(labelsize=8)
    for axis in axes[:, 0]:
        axis.set_ylabel(labels[1])
    for step, axis in zip(steps, axes.flat):
        axis.set_title(f"t = {run.times[step]:.4g}", fontsize=9)
        if run.dimension == 1:
            if step in run.exact:
                data = read_profile(run.exact[step])
                axis.plot(data["position"], data[field], "k-", lw=0.8,
                          label="exact")
            data = read_profile(run.particles[step])
            axis.plot(data["position"], data[field], "o", ms=1.2,
                      label="particles")
            axis.grid(alpha=0.3)
            axis.margins(x=0)
        else:
            values, extent = read_plane(run, step, field)[:2]
            image = draw_image(axis, values, extent, field, limits)
    if run.dimension > 1 and field != "schlieren":
        figure.colorbar(image, ax=axes, shrink=0.6, aspect=40)
    if run.dimension == 1:
        frames = [read_profile(files[step]) for step in steps
                  for files in (run.particles, run.exact) if step in files]
        axes[0, 0].set_ylim(*value_range(frames, field, 0.06))
        if run.exact:
            axes[0, 0].legend(fontsize=7)
    head = run.title(steps[-1]).rsplit(", t = ", 1)[0]
    figure.suptitle(f"{head}: {label_of(run, field)}{place}")
    return figure


def movie(figure, show, steps, folder):
    """movie.mp4 by ffmpeg, movie.gif without it; removes the other one."""
    rate = min(max(len(steps) / MOVIE_SECONDS, 4.0), 25.0)
    if animation.writers.is_available("ffmpeg"):
        path, other = folder / "movie.mp4", folder / "movie.gif"
        # yuv420p, which every player knows, takes even sizes only.
        options = ["-pix_fmt", "yuv420p"]
        options += ["-vf", "pad=ceil(iw/2)*2:ceil(ih/2)*2:color=white"]
        writer = animation.FFMpegWriter(fps=rate, extra_args=options)
    else:
        path, other = folder / "movie.gif", folder / "movie.mp4"
        writer = animation.PillowWriter(fps=rate)
    with writer.saving(figure, str(path), dpi=100):
        for step in steps:
            show(step)
            if step == steps[1]:  # laid out by the first; redoing it is slow
                figure.set_layout_engine("none")
            writer.grab_frame()
    other.unlink(missing_ok=True)  # of an earlier call, now out of date
    return path


# --------------------------------------------------------------------------


def save(figure, path):
    figure.savefig(path, dpi=130)
    plt.close(figure)
    print(path)


def draw(run, steps, options, folder):
    kinds = {1: "profiles.png", 2: "schlieren.png", 3: "slices.png"}

    def main_figure(chosen):
        if run.dimension == 1:
            return profile_figure(run, chosen)
        normals = (2,) if run.dimension == 2 else (2, 1, 0)
        return plane_figure(run, chosen, options.field, normals)

    figure, show = main_figure(steps[-1:])
    show(steps[-1])
    pictures = [folder / kinds[run.dimension], folder / "contact_sheet.png"]
    save(figure, pictures[0])
    save(contact_sheet(run, steps, options.field), pictures[1])
    if "particles_final" in run.summary: # the finite-volume reference has none
        path = folder / "report.html"
        path.write_text(plot_report.report(run.summary, pictures))
        print(path)
    if not options.no_movie and len(steps) > 1:
        steps = thinned(steps, MOVIE_FRAMES)
        figure, show = main_figure(steps)
        print(movie(figure, show, steps, folder))


def main():
    if sys.argv[1:2] == ["study"]:
        return plot_study.main(sys.argv[2:])
    parser = argparse.ArgumentParser(
        prog="plot.py", description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter)
    add = parser.add_argument
    add("directory", type=pathlib.Path, help="output directory of a run")
    add("--field", choices=FIELDS, default="density",
        help="of the sheet and of 2D and 3D pictures (default: density)")
    add("--times", type=float, nargs="+", metavar="T",
        help="only the outputs nearest to these times")
    add("--no-movie", action="store_true", help="pictures only")
    add("--output", type=pathlib.Path, metavar="DIR",
        help="where the pictures go (default: the run's directory)")
    options = parser.parse_args()

    try:
        run = Run(options.directory)
        if run.dimension == 1 and options.field == "schlieren":
            parser.error("--field schlieren needs a 2D or 3D run")
        folder = options.output or options.directory
        folder.mkdir(parents=True, exist_ok=True)
        draw(run, run.steps_at(options.times), options, folder)
    except (OSError, KeyError, ValueError, subprocess.SubprocessError) as error:
        sys.exit(f"plot.py: {options.directory}: cannot be drawn: {error}")


if __name__ == "__main__":
    main()
