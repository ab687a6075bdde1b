"""The meaning of the codes of diagnostics: the rows of stages/DIAGNOSTICS.md."""

import functools
import re
from dataclasses import dataclass
from pathlib import Path

import stages

_FILE = "DIAGNOSTICS.md"
_ROW = re.compile(r"^\| `([EWI]-[A-Z0-9-]+)` \| (.+?) \| (.+?) \| (.+?) \|$", re.MULTILINE)

_LEVELS = {"E": "error", "W": "warning", "I": "info"}


@dataclass(frozen=True, slots=True)
class Explanation:
    """The meaning of a code and its remedy, in Markdown of one line; `stages`: which of them report it."""

    meaning: str
    remedy: str
    stages: str = ""


@functools.cache
def explanations() -> dict[str, Explanation]:
    """Every code; empty where the table is not installed."""
    for folder in stages.__path__:
        path = Path(folder) / _FILE
        if path.is_file():
            rows = _ROW.findall(path.read_text(encoding="utf-8"))
            return {code: Explanation(meaning, remedy, where) for code, where, meaning, remedy in rows}
    return {}


def level(code: str) -> str:
    """The level of a code: error, warning or info."""
    return _LEVELS.get(code[:1], "info")
