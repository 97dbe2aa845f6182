"""The roofline of a session: what the parts reach of what the machine allows."""
from figure import np, plt
from matplotlib.patches import Patch

PARTS = {"P2G": "o", "G2P": "D", "grid": "^", "sort": "v",
         "EOS": "X", "step": "*"}
COLOURS = ["tab:blue", "tab:orange", "tab:green", "tab:red"]


def draw(some, limits, path, title):
    """some: of results.rows, of one dimension, basis and order; a colour for
    each method, a marker for each part."""
    figure, axes = plt.subplots(figsize=(9, 5.2), layout="constrained")
    intensity = np.logspace(-2.4, 2, 200)
    roof = np.minimum(intensity * limits["triad_all"], limits["fma_all"])
    axes.loglog(intensity, roof / 1e9, color="black", linewidth=1.2)
    axes.annotate(f"triad {limits['triad_all'] / 1e9:.1f} GB/s",
                  (0.013, 0.013 * limits["triad_all"] / 1e9),
                  xytext=(0, 14), textcoords="offset points", rotation=34,
                  rotation_mode="anchor", fontsize=9)
    axes.annotate(f"multiply-adds {limits['fma_all'] / 1e9:.0f} Gflop/s",
                  (100, limits["fma_all"] / 1e9), xytext=(0, 5),
                  textcoords="offset points", ha="right", fontsize=9)
    methods = list(dict.fromkeys(key[0] for key in some))
    lowest = highest = limits["fma_all"] / 1e9
    for (method, _, _, _, _, part), row in some.items():
        if part not in PARTS or row["flops"] <= 0:
            continue
        rate = row["flops"] * row["updates_per_second"] / 1e9
        lowest, highest = min(lowest, rate), max(highest, rate)
        axes.plot(row["flops"] / row["bytes"], rate, PARTS[part],
                  color=COLOURS[methods.index(method)],
                  markersize=13 if part == "step" else 7)
    handles = [Patch(color=colour, label=method.replace("_", " "))
               for method, colour in zip(methods, COLOURS)]
    handles += [plt.Line2D([], [], color="grey", marker=marker, linestyle="",
                           label=part) for part, marker in PARTS.items()]
    axes.legend(handles=handles, fontsize=8, loc="center left",
                bbox_to_anchor=(1, 0.5))
    axes.set_xlim(0.005, 100)
    axes.set_ylim(lowest / 3, 3 * highest)
    axes.set_xlabel("flops per byte, counted")
    axes.set_ylabel("Gflop/s")
    axes.set_title(title, fontsize=10)
    axes.grid(True, which="major", color="0.9")
    figure.savefig(path, dpi=110)
    plt.close(figure)
