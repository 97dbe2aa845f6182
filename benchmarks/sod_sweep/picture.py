"""Time against cells, as figure 2 of Baioni et al. 2023."""
import math

from figure import plt


def draw(record, path):
    """Left: time of a step; right: time to the end, hollow where predicted."""
    figure, (left, right) = plt.subplots(1, 2, figsize=(11, 4.8),
                                         layout="constrained")
    for number, (name, points) in enumerate(record["lines"].items()):
        cells = [math.prod(point["cells"]) for point in points]
        slope = record["slopes"][name]
        label = name.replace("_", " ")
        if slope is not None:
            label += f": slope {slope:.2f}"
        colour = f"C{number}"
        left.loglog(cells, [point["step"] for point in points], "o-",
                    color=colour, markersize=4, label=label)
        right.loglog(cells, [point["seconds"] for point in points], "-",
                     color=colour)
        for count, point in zip(cells, points):
            right.plot(count, point["seconds"], "o", color=colour,
                       markersize=5,
                       markerfacecolor=colour if point["measured"] else "white")
    low, high = left.get_ylim()
    first, last = left.get_xlim()
    # A line of slope 1 below all others, for the eye.
    below = 0.6 * min(point["step"] / math.prod(point["cells"])
                      for points in record["lines"].values() for point in points)
    left.loglog([first, last], [below * first, below * last], ":",
                color="grey", label="slope 1")
    left.set_xlim(first, last)
    left.set_ylim(low, high)
    left.set_ylabel("seconds a step")
    left.legend(fontsize=8, loc="upper left")
    right.set_ylabel("seconds to the end")
    right.plot([], [], "o", color="grey", label="run to the end")
    right.plot([], [], "o", color="grey", markerfacecolor="white",
               label="predicted from the time of a step")
    right.legend(fontsize=8, loc="upper left")
    for axes in (left, right):
        axes.set_xlabel("cells")
        axes.grid(True, color="0.9")
    figure.savefig(path, dpi=110)
    plt.close(figure)
