"""The blocks of code in the documents, with the marks that say how each is run.

A mark is an HTML comment on a line of its own directly before a fence, `<!-- name -->` or
`<!-- name: value -->`; several may be stacked.
"""

import re
from dataclasses import dataclass
from textwrap import dedent

from tests.support.places import PROJECT

MARKS = frozenset(
    {
        "add to", "build", "composes", "exit", "file", "folder", "needs", "not run", "output", "published",
        "robot", "slow", "test", "tested by", "your robot",
    }
)  # fmt: skip
REASONS = ("display", "cluster", "network", "unpublished name")
"""How the reason of a block begins that is not run."""

FENCE = re.compile(r"^( *)```(\w*)$")
MARK = re.compile(r"^ *<!-- ([a-z ]+?)(?:: (.*))? -->$")


@dataclass
class Block:
    """A fenced block: its place, language, text and marks, and whether it follows another block directly."""

    page: str
    line: int
    language: str
    text: str
    marks: dict[str, str]
    follows: bool = False

    @property
    def place(self):
        return f"{self.page}:{self.line}"


def pages():
    """The documents whose blocks run, by their paths in the project."""
    documents = sorted(path.relative_to(PROJECT).as_posix() for path in (PROJECT / "docs").rglob("*.md"))
    return ["README.md", *documents]


def blocks(page):
    """The blocks of a page, in their order."""
    return parsed(page, (PROJECT / page).read_text(encoding="utf-8"))


def parsed(page, text):
    """The blocks of a text."""
    lines = text.splitlines()
    result, marks, follows, at = [], {}, False, 0
    while at < len(lines):
        mark, fence = MARK.match(lines[at]), FENCE.match(lines[at])
        if mark:
            marks[mark[1]] = mark[2] or ""
        elif fence:
            end = next(n for n in range(at + 1, len(lines)) if lines[n] == f"{fence[1]}```")
            content = dedent("\n".join(lines[at + 1 : end]) + "\n")
            result.append(Block(page, at + 1, fence[2], content, marks, follows))
            marks, follows, at = {}, True, end
        elif lines[at].strip():
            marks, follows = {}, False
        at += 1
    return result
