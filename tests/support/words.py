"""`python -m tests.support.words`: counts words and openings that a reader stumbles over, by room.

Written to `words.json` where a count has fallen; `tests/unit/test_words.py` holds that none grows.
"""

import ast
import json
import re
from collections import Counter
from pathlib import Path

from tests.support.imports import modules
from tests.support.places import PROJECT

LIMITS = Path(__file__).with_name("words.json")

NAMES = frozenset({"one", "ones", "mine", "told", "what", "others", "alone", "found", "given", "known"})
"""Names that say nothing of what they hold, where a noun does."""

OPENING = re.compile(r"\s*(Of|So many|What is|For who|None without)\b")
"""How no docstring begins."""

STUMBLES = re.compile(
    r"\b(is none|are none|of which|so many|so much|but for|is wished|anew|of others)\b", re.IGNORECASE
)
"""Phrases that a reader reads twice, in texts for users."""


def counts():
    """Kind → room → count: bindings of `one`, bindings of the other names, openings of docstrings, and
    stumbles in texts for users."""
    found = {kind: Counter() for kind in ("one", "names", "openings", "stumbles")}
    for path in [*modules(), *sorted((PROJECT / "tests").rglob("*.py"))]:
        room, nodes = _room(path), list(ast.walk(ast.parse(path.read_text(encoding="utf-8"))))
        bound = Counter(name for name in _bound(nodes) if name in NAMES)
        found["one"][room] += bound["one"] + bound["ones"]
        found["names"][room] += sum(bound.values()) - bound["one"] - bound["ones"]
        found["openings"][room] += sum(bool(OPENING.match(text)) for text in _docstrings(nodes))
        if room != "tests":
            found["stumbles"][room] += sum(len(STUMBLES.findall(text)) for text in _messages(nodes))
    for path in documents():
        found["stumbles"][_room(path)] += len(STUMBLES.findall(path.read_text(encoding="utf-8")))
    return {
        kind: {room: rooms[room] for room in sorted(rooms) if rooms[room]} for kind, rooms in found.items()
    }


def documents():
    """The documents for users, and the options of groups, whose comments they read."""
    folders = [PROJECT / "docs", PROJECT / "pipeline" / "reference", PROJECT / "stages"]
    marked = [PROJECT / "README.md", *(path for folder in folders for path in folder.rglob("*.md"))]
    return sorted([*marked, *(PROJECT / "conf").rglob("*.yaml")])


def _room(path):
    parts = path.relative_to(PROJECT).parts
    return "/".join(parts[:2]) if parts[0] in ("pipeline", "stages") and len(parts) > 2 else parts[0]


def _bound(nodes):
    """Each name that is given to a variable, a parameter or a function."""
    for node in nodes:
        if isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store):
            yield node.id
        elif isinstance(node, ast.arg):
            yield node.arg
        elif isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef):
            yield node.name


def _docstrings(nodes):
    """The docstrings, also those below a constant or a field."""
    for node in nodes:
        if isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant):
            text = node.value.value
            if isinstance(text, str):
                yield text


def _messages(nodes):
    """The texts of a module that are no docstring: most of them are shown to users."""
    documentation = {id(node.value) for node in nodes if isinstance(node, ast.Expr)}
    for node in nodes:
        if isinstance(node, ast.Constant) and isinstance(node.value, str) and id(node) not in documentation:
            yield node.value


def limits():
    """The counts that may not grow."""
    return json.loads(LIMITS.read_text(encoding="utf-8"))


def main():
    before = limits() if LIMITS.exists() else None
    now = counts()
    if before:
        now = {
            kind: {room: min(count, before[kind].get(room, 0)) for room, count in rooms.items()}
            for kind, rooms in now.items()
        }
    LIMITS.write_text(json.dumps(now, indent=1, sort_keys=True) + "\n", encoding="utf-8")
    print({kind: sum(rooms.values()) for kind, rooms in now.items()})


if __name__ == "__main__":
    main()
