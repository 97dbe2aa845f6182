"""The roofline of a session: what the parts reach of what the machine allows."""
from figure import np, plt

PARTS = {"step": ("o", "black"), "prepare": ("P", "tab:purple"),
         "P2G": ("o", "tab:blue"), "G2P": ("D", "tab:red"),
         "grid": ("^", "tab:green"), "sort": ("v", "tab:brown"),
         "EOS": ("X", "tab:orange")}
INTENSITY = np.logspace(-2.4, 2, 200)


def _style(part):
    """Of its marker: a ring for the step, through which others are seen."""
    marker, colour = PARTS[part]
    if part == "step":
        return {"marker": marker, "color": colour, "linestyle": "",
                "markersize": 15, "markerfacecolor": "none",
                "markeredgewidth": 1.5}
    return {"marker": marker, "color": colour, "linestyle": "",
            "markersize": 9, "markeredgecolor": "white"}


def _roof(axes, limits):
    """Bandwidth and arithmetic; where stores past the cache make the bandwidth
    another, ordinary ones dashed."""
    peak = limits["fma_all"]
    triads = {"": limits["triad_all"]}
    if limits["streamed_all"]:
        triads = {"past the cache ": limits["streamed_all"],
                  "ordinary ": limits["ordinary_all"]}
    for name, triad in triads.items():
        axes.loglog(INTENSITY, np.minimum(INTENSITY * triad, peak) / 1e9,
                    color="black", linewidth=1,
                    linestyle="-" if triad == limits["triad_all"] else "--")
    text = "\n".join(f"triad {name}{triad / 1e9:.1f} GB/s"
                     for name, triad in triads.items())
    axes.text(0.03, 0.95, f"multiply-adds {peak / 1e9:.0f} Gflop/s\n{text}",
              transform=axes.transAxes, va="top", fontsize=8)


def draw(some, limits, path, title):
    """some: of results.rows, of one dimension, basis and order; a panel for
    each method, a marker for each part."""
    methods = list(dict.fromkeys(key[0] for key in some))
    lines = (len(methods) + 1) // 2
    figure, panels = plt.subplots(
        lines, min(len(methods), 2), figsize=(9, 0.8 + 3.4 * lines),
        sharex=True, sharey=True, squeeze=False, layout="constrained")
    for axes in panels.flat[len(methods):]:
        axes.axis("off")
    rates = [limits["fma_all"] / 1e9]
    for method, axes in zip(methods, panels.flat):
        _roof(axes, limits)
        for part in PARTS:
            row = next((row for key, row in some.items()
                        if key[0] == method and key[5] == part), None)
            if row is None or row["flops"] <= 0:
                continue
            rates.append(row["flops"] * row["updates_per_second"] / 1e9)
            axes.plot(row["flops"] / row["bytes"], rates[-1], **_style(part))
        axes.set_title(method.replace("_", " "), fontsize=10)
        axes.grid(True, which="major", color="0.9")
    axes.set_xlim(0.005, 100)
    axes.set_ylim(min(rates) / 3, 5 * max(rates))
    handles = [plt.Line2D([], [], label=part, **_style(part))
               for part in PARTS]
    figure.legend(handles=handles, fontsize=9, loc="center left",
                  bbox_to_anchor=(1, 0.5))
    figure.supxlabel("flops per byte, counted", fontsize=10)
    figure.supylabel("Gflop/s", fontsize=10)
    figure.suptitle(title, fontsize=11)
    figure.savefig(path, dpi=110, bbox_inches="tight")
    plt.close(figure)
