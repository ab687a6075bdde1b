"""What the codes of diagnostics mean: the rows of stages/DIAGNOSTICS.md."""

import functools
import re
from dataclasses import dataclass
from pathlib import Path

import stages

_FILE = "DIAGNOSTICS.md"
_ROW = re.compile(r"^\| `([EWI]-[A-Z0-9-]+)` \| (.+?) \| (.+?) \| (.+?) \|$", re.MULTILINE)


@dataclass(frozen=True, slots=True)
class Explanation:
    """What a code means and what to do about it, in Markdown of one line."""

    meaning: str
    remedy: str


@functools.cache
def explanations() -> dict[str, Explanation]:
    """Every code that there is; empty where the table was not installed."""
    for folder in stages.__path__:
        path = Path(folder) / _FILE
        if path.is_file():
            rows = _ROW.findall(path.read_text(encoding="utf-8"))
            return {code: Explanation(meaning, remedy) for code, _, meaning, remedy in rows}
    return {}
