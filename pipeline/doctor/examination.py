"""Defines the result of examining one thing that builds need, and formats results as text or as a JSON
document."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

from linkwright.pipeline.json_documents.doctor import DoctorDocument, ExaminedDocument
from linkwright.pipeline.reference.exit_status import BUILT, FAILED

State = Literal["ok", "note", "wrong"]
"""ok: it works; note: it is optional and missing, or was not tried; wrong: builds fail until it is
repaired."""

_SUBJECT_WIDTH = 14
"""Width of the column of subjects."""


@dataclass(frozen=True, slots=True)
class Examination:
    """The result of examining one thing that builds need."""

    subject: str
    state: State
    detail: str
    """The finding."""

    hint: str = ""
    """The remedy; "" if nothing needs to be done."""


def as_text(rows: Sequence[Examination]) -> str:
    """Returns a line for each row, with its hint in the next line, and a last line with a summary."""
    lines = []
    for row in rows:
        lines.append(f"{row.state:5}  {row.subject:{_SUBJECT_WIDTH}} {row.detail}")
        if row.hint:
            lines.append(f"{'':{_SUBJECT_WIDTH + 7}} → {row.hint}")
    wrong = [row.subject for row in rows if row.state == "wrong"]
    summary = f"to repair: {', '.join(wrong)}" if wrong else "everything that builds need works"
    return "\n".join([*lines, summary])


def as_document(rows: Sequence[Examination]) -> DoctorDocument:
    """Returns the results as a JSON document; its status is that of a failed build if anything is wrong."""
    works = all(row.state != "wrong" for row in rows)
    examined = tuple(ExaminedDocument(row.subject, row.state, row.detail, row.hint) for row in rows)
    return DoctorDocument(BUILT if works else FAILED, works, examined)
