"""The meaning of the codes of diagnostics and checks: the rows of two tables of the stages."""

import functools
import re
from dataclasses import dataclass
from pathlib import Path

import linkwright.stages

_FILES = ("DIAGNOSTICS.md", "CHECKS.md")
_ROW = re.compile(r"^\| `([EWIC]-[A-Z0-9-]+)` \| (.+?) \| (.+?) \| (.+?) \|$", re.MULTILINE)

_LEVELS = {"E": "error", "W": "warning", "I": "info", "C": "check"}


@dataclass(frozen=True, slots=True)
class Explanation:
    """The meaning of a code and its remedy, in Markdown of one line; `stages`: which of them report it."""

    meaning: str
    remedy: str
    stages: str = ""


@functools.cache
def explanations() -> dict[str, Explanation]:
    """Every code; empty where the tables are not installed."""
    files = [Path(folder) / name for folder in linkwright.stages.__path__ for name in _FILES]
    rows = [row for file in files if file.is_file() for row in _ROW.findall(file.read_text(encoding="utf-8"))]
    return {code: Explanation(meaning, remedy, where) for code, where, meaning, remedy in rows}


def remedy(code: str) -> str:
    """What to do about a code; "" where there is nothing to do, or no such code."""
    found = explanations().get(code)
    return "" if found is None or found.remedy == "–" else found.remedy


def level(code: str) -> str:
    """The level of a code: error, warning, info, or check."""
    return _LEVELS.get(code[:1], "info")
