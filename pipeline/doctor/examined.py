"""Holds the result of an examination, and writes results as text or JSON."""

import json
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Literal

State = Literal["ok", "note", "wrong"]
"""ok: it works; note: something optional is missing, or was not tried; wrong: builds fail until it is
repaired."""

_WIDTH = 14


@dataclass(frozen=True, slots=True)
class Examined:
    """The result of an examination."""

    subject: str
    state: State
    detail: str
    """The finding."""

    hint: str = ""
    """The remedy; "" if nothing is to be done."""


def as_text(rows: Sequence[Examined]) -> str:
    """Returns a line for each row, with its hint in the next line, and a last line with a summary."""
    lines = []
    for row in rows:
        lines.append(f"{row.state:5}  {row.subject:{_WIDTH}} {row.detail}")
        if row.hint:
            lines.append(f"{'':{_WIDTH + 7}} → {row.hint}")
    wrong = [row.subject for row in rows if row.state == "wrong"]
    return "\n".join([*lines, f"to mend: {', '.join(wrong)}" if wrong else "builds can work here"])


def as_json(rows: Sequence[Examined]) -> str:
    """Returns `{"works": whether nothing is wrong, "examined": [{"subject", "state", "detail", "hint"},
    ...]}`."""
    works = all(row.state != "wrong" for row in rows)
    return json.dumps({"works": works, "examined": [asdict(row) for row in rows]}, indent=2)
