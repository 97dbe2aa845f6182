"""What reports in HTML have in common: one page that needs no other file."""
import html
import json

STYLE = """
:root { color-scheme: light dark; }
body { font: 15px/1.45 system-ui, sans-serif; max-width: 70rem; margin: 2rem auto;
       padding: 0 1rem; }
table { border-collapse: collapse; margin: 1rem 0; display: block; overflow-x: auto; }
td, th { padding: .2rem .7rem; text-align: right; border-bottom: 1px solid #8886; }
td:first-child, th:first-child { text-align: left; }
tr.front td { font-weight: 600; }
figure { margin: 1rem 0; padding: .5rem; background: white; border-radius: .4rem; }
figure svg, figure img { width: 100%; height: auto; }
pre { overflow-x: auto; padding: .7rem; border: 1px solid #8886; }
"""


def table(head, rows):
    """rows: (class, cells)"""
    def line(tag, cells, kind=""):
        inner = "".join(f"<{tag}>{html.escape(str(c))}</{tag}>" for c in cells)
        return f'<tr class="{kind}">{inner}</tr>' if kind else f"<tr>{inner}</tr>"
    body = "".join(line("td", cells, kind) for kind, cells in rows)
    return f"<table>{line('th', head)}{body}</table>"


def number(value, form=".3g"):
    return "-" if value is None else format(value, form)


def listing(title, value):
    """JSON, as text."""
    return (f"<h2>{html.escape(title)}</h2>"
            f"<pre>{html.escape(json.dumps(value, indent=2))}</pre>")


def page(title, parts):
    """parts: HTML; title: escaped"""
    return ('<!doctype html><html lang="en"><head><meta charset="utf-8">'
            '<meta name="viewport" content="width=device-width, initial-scale=1">'
            f"<title>{title}</title><style>{STYLE}</style></head><body>"
            + "\n".join(parts) + "</body></html>\n")
