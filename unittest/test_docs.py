"""The documents name what there is: files, headings of other documents, and where in
the layers each header of core/ stands."""

import fnmatch
import pathlib
import re
import unittest

ROOT = pathlib.Path(__file__).resolve().parent.parent
FOLDERS = ["docs", "benchmarks", "core", "examples", "input", "tools", "unittest"]
DOCUMENTS = sorted([*ROOT.glob("*.md"),
                    *(path for folder in FOLDERS
                      for path in (ROOT / folder).rglob("*.md"))])
# These tell of the past, too.
HISTORIES = ["CHANGELOG.md", "performance_tried.md"]


def prose(document):
    """Its lines without those that are indented or fenced as code."""
    inside = False
    for line in document.read_text().splitlines():
        if line.lstrip().startswith("```"):
            inside = not inside
        elif not inside and not line.startswith("    "):
            yield line


def anchor(heading):
    """As GitHub makes it of a heading's text."""
    return re.sub(r"[^\w\- ]", "", heading.strip().lower()).replace(" ", "-")


def anchors(document):
    """Of all headings; one that comes again is numbered."""
    found = {}
    for line in prose(document):
        if match := re.match(r"#+ (.*)", line):
            name = anchor(match[1])
            found[name] = found.get(name, -1) + 1
    return {f"{name}-{k}" if k else name
            for name, last in found.items() for k in range(last + 1)}


class Documents(unittest.TestCase):

    def test_there_are_some(self):
        names = {path.name for path in DOCUMENTS}
        self.assertLessEqual({"README.md", "CONTRIBUTING.md", "method.md"}, names)

    def test_links_lead_somewhere(self):
        for document in DOCUMENTS:
            text = re.sub(r"`[^`]*`", "", "\n".join(prose(document)))
            for target in re.findall(r"\]\(([^)\s]+)\)", text):
                if re.match(r"\w+:", target):
                    continue
                with self.subTest(document=document.name, link=target):
                    name, _, heading = target.partition("#")
                    place = document.parent / name if name else document
                    self.assertTrue(place.exists())
                    if heading:
                        self.assertIn(heading, anchors(place))

    def test_files_that_they_name_are_there(self):
        # Not physics/ and boundary/: README makes up a module.
        pattern = re.compile(r"`((?:core|drivers|benchmarks|tools|unittest|examples|cmake)"
                             r"/[\w/.-]+\.(?:hpp|cpp|py|cmake|md))`")
        for document in DOCUMENTS:
            if document.name in HISTORIES:
                continue
            for name in pattern.findall(document.read_text()):
                with self.subTest(document=document.name, file=name):
                    self.assertTrue((ROOT / name).exists())

    def test_no_merge_left_its_marks(self):
        for document in DOCUMENTS:
            with self.subTest(document=document.name):
                self.assertNotRegex(document.read_text(), r"(?m)^(<{7}|>{7}) ")


class Layers(unittest.TestCase):

    def test_every_header_of_core_stands_in_one(self):
        text = (ROOT / "CONTRIBUTING.md").read_text()
        chapter = text[text.index("## Where a line of code belongs"):]
        # The table, and the sentence on what stands apart.
        table = chapter[:chapter.index("\n- ")]
        patterns = [name.removeprefix("core/") for name in re.findall(r"`([^`]+)`", table)]
        for header in sorted((ROOT / "core").glob("*.hpp")):
            with self.subTest(header=header.name):
                self.assertTrue(any(fnmatch.fnmatch(header.stem, pattern)
                                    for pattern in patterns))


if __name__ == "__main__":
    unittest.main()
