"""report.html of a run: pictures, tables, the resolved input, in one file."""
import base64
import html

from html_page import listing, number, page, table


def facts(summary):
    """Who computed what, and how fast."""
    cells = " x ".join(map(str, summary["cells"]))
    machine = summary.get("machine", {}).get("processor")
    who = [f"{summary['method']}, {summary['basis']} splines, {cells} cells, "
           f"{summary['particles_final']} particles, {summary['steps']} steps to "
           f"t = {summary['final_time']:.6g} in {summary['wall_seconds']:.3g} s: "
           f"{summary['particle_updates_per_second'] / 1e6:.3g} M particle updates/s, "
           f"{summary['peak_memory_bytes'] / 2**20:.4g} MiB at most.",
           f"{summary['backend']}, {summary['ranks']} rank(s) of {summary['threads']} "
           f"thread(s)" + (f", {machine}" if machine else "")
           + f"; revision {summary['revision']}."]
    return "".join(f"<p>{html.escape(line)}</p>" for line in who)


def share(part, whole):
    return f"{100 * part / whole:.1f} %" if whole else "-"


def report(summary, pictures):
    """The text of report.html. pictures: paths of PNG files"""
    title = html.escape(summary["scene"])
    parts = [f"<h1>{title}</h1>", facts(summary)]
    for path in pictures:
        data = base64.b64encode(path.read_bytes()).decode()
        parts.append(f'<figure><img alt="{html.escape(path.stem)}" '
                     f'src="data:image/png;base64,{data}"></figure>')
    if summary["errors"]:
        parts += ["<h2>Errors against the exact solution</h2>",
                  table(["field", "L1", "L2", "Linf"],
                        [("", [field] + [number(norms[n], ".4e")
                                         for n in ("L1", "L2", "Linf")])
                         for field, norms in summary["errors"].items()])]
    kept = summary["conservation"]
    extrema = summary["extrema"]
    parts += ["<h2>Balance</h2><p>Relative drift, what entered and left counted in; "
              "- where sides or walls exchange it.</p>",
              table(["", "drift"], [("", [name.replace("_", " "), number(kept[name])])
                                    for name in ("mass", "momentum", "total_energy")]),
              "<h2>Extremes</h2>",
              table(["", "value"], [("", [name.replace("_", " "), number(value, ".4g")])
                                    for name, value in extrema.items()]
                    + [("", ["steps repeated", summary["retries"]])])]
    whole = sum(phase["seconds"] for phase in summary["phases"])
    parts += ["<h2>Where the time went</h2><p>Of a restarted run in its last "
              "process; the seconds above are of all together.</p>",
              table(["phase", "seconds", "share"],
                    [("", [p["name"], number(p["seconds"]), share(p["seconds"], whole)])
                     for p in sorted(summary["phases"], key=lambda p: -p["seconds"])])]
    if summary["effects"]:
        parts += ["<h2>Effects</h2>",
                  table(["effect", "kernels", "seconds", "share", "bytes"],
                        [("", [e["name"], e["kernels"], number(e["seconds"]),
                               share(e["seconds"], whole), e["bytes"]])
                         for e in summary["effects"]])]
    parts.append(listing("Input", summary["input"]))
    return page(title, parts)
