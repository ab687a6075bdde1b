"""Explains the codes of diagnostics and checks, from the rows of two tables of the stages."""

import functools
import re
from dataclasses import dataclass
from pathlib import Path

import linkwright.stages

_TABLE_FILES = ("DIAGNOSTICS.md", "CHECKS.md")
_ROW_PATTERN = re.compile(r"^\| `([EWIC]-[A-Z0-9-]+)` \| (.+?) \| (.+?) \| (.+?) \|$", re.MULTILINE)

_LEVELS = {"E": "error", "W": "warning", "I": "info", "C": "check"}


@dataclass(frozen=True, slots=True)
class Explanation:
    """The meaning of a code and its remedy, each a line of Markdown; `stages`: the stages that report the
    code."""

    meaning: str
    remedy: str
    stages: str = ""


@functools.cache
def explanations() -> dict[str, Explanation]:
    """Returns the explanation of each code; {} if the tables are not installed."""
    files = [Path(folder) / name for folder in linkwright.stages.__path__ for name in _TABLE_FILES]
    rows = [
        row
        for file in files
        if file.is_file()
        for row in _ROW_PATTERN.findall(file.read_text(encoding="utf-8"))
    ]
    return {code: Explanation(meaning, remedy, stages) for code, stages, meaning, remedy in rows}


def remedy(code: str) -> str:
    """Returns the remedy of a code; "" if there is none, or no such code."""
    explanation = explanations().get(code)
    return "" if explanation is None or explanation.remedy == "–" else explanation.remedy


def level(code: str) -> str:
    """Returns the level of a code: error, warning, info, or check."""
    return _LEVELS.get(code[:1], "info")
