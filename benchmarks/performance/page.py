"""A page of docs/, by default performance.md, whose tables the benchmarks write
between markers."""
import pathlib
import re

ROOT = pathlib.Path(__file__).resolve().parents[2]
PAGE = ROOT / "docs" / "performance.md"


def table(header, rows):
    lines = ["| " + " | ".join(header) + " |", "|" + "---|" * len(header)]
    lines += ["| " + " | ".join(map(str, row)) + " |" for row in rows]
    return "\n".join(lines) + "\n"


def written_by(name, docs):
    """How a section, or what is printed in its place, begins."""
    return (f"Written by `python3 benchmarks/{name} --docs`" if docs else
            f"Printed by `python3 benchmarks/{name}`, for no page")


def replaced(page, section, text):
    """The page with the text of a section, which stands between
    <!-- section --> and <!-- end of section -->."""
    begin, end = f"<!-- {section} -->", f"<!-- end of {section} -->"
    found = re.search(f"{re.escape(begin)}.*{re.escape(end)}", page, re.DOTALL)
    if not found:
        raise SystemExit(f"no place for it: add the lines {begin} and {end} to "
                         "the page")
    return (page[:found.start()] + f"{begin}\n{text.strip()}\n{end}" +
            page[found.end():])


def require(*sections, path=PAGE):
    """Ends the program where a page has no place for one of them: a benchmark asks
    before it measures."""
    text = path.read_text()
    for section in sections:
        replaced(text, section, "")


def write(section, text, path=PAGE):
    whole = path.with_name(path.name + ".tmp")
    whole.write_text(replaced(path.read_text(), section, text))
    whole.replace(path)
