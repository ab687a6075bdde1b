"""The project's pages, and the code that is in them."""

import re

from tests.support.places import PROJECT

FORMATS = PROJECT / "pipeline" / "reference" / "formats"


def page(path):
    """The text of a page of the project, or by its bare name of a page on a format."""
    return ((PROJECT if "/" in path or path == "README.md" else FORMATS) / path).read_text(encoding="utf-8")


def blocks(path):
    """The marked blocks of a page, by their marks."""
    pattern = r"^<!-- (\w+) -->\n```\w+\n(.*?)^```$"
    return dict(re.findall(pattern, page(path), re.DOTALL | re.MULTILINE))


def code(path, language):
    """All code of a page in a language."""
    return re.findall(rf"^```{language}\n(.*?)^```$", page(path), re.DOTALL | re.MULTILINE)
