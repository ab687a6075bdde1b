"""Defines the result of an examination of what builds need, and formats results as text or as JSON."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

from linkwright.pipeline.json_documents.doctor import DoctorDocument, ExaminedDocument
from linkwright.pipeline.reference.exit_status import BUILT, FAILED

State = Literal["ok", "note", "wrong"]
"""ok: the subject works; note: it is optional and missing, or was not tried; wrong: builds fail until it is
repaired."""

_STATE_WIDTH, _SUBJECT_WIDTH = 5, 14
"""Widths of the columns of states and of subjects."""

_DETAIL_COLUMN = _STATE_WIDTH + 2 + _SUBJECT_WIDTH
"""Width of both columns and the gap between them."""


@dataclass(frozen=True, slots=True)
class ExaminationResult:
    """The result of examining a subject: something that builds need."""

    subject: str
    state: State
    detail: str
    """The result in words."""

    hint: str = ""
    """The remedy; "" if nothing needs to be done."""


def as_text(results: Sequence[ExaminationResult]) -> str:
    """Returns a line for each result, with its hint in the next line, and a last line with a summary."""
    lines = []
    for result in results:
        lines.append(f"{result.state:{_STATE_WIDTH}}  {result.subject:{_SUBJECT_WIDTH}} {result.detail}")
        if result.hint:
            lines.append(f"{'':{_DETAIL_COLUMN}} → {result.hint}")
    wrong_subjects = [result.subject for result in results if result.state == "wrong"]
    summary = (
        f"to repair: {', '.join(wrong_subjects)}" if wrong_subjects else "everything that builds need works"
    )
    return "\n".join([*lines, summary])


def as_document(results: Sequence[ExaminationResult]) -> DoctorDocument:
    """Returns the results as a JSON document; its status is that of a failed build if anything is wrong."""
    works = all(result.state != "wrong" for result in results)
    result_documents = tuple(
        ExaminedDocument(result.subject, result.state, result.detail, result.hint) for result in results
    )
    return DoctorDocument(BUILT if works else FAILED, works, result_documents)
