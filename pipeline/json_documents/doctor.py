"""Defines the document of `linkwright doctor`."""

from dataclasses import dataclass
from typing import ClassVar, Literal

from linkwright.pipeline.json_documents.document import CommandDocument


@dataclass(frozen=True)
class ExaminedDocument:
    """A thing that was examined.

    subject: the thing.
    state: `ok`; `note`: something optional is missing, or was not tried; `wrong`: builds fail until it is
        repaired.
    detail: the finding.
    hint: what to do; may be empty.
    """

    subject: str
    state: Literal["ok", "note", "wrong"]
    detail: str
    hint: str


@dataclass(frozen=True)
class DoctorDocument(CommandDocument):
    """Whether builds can work on this computer (`linkwright doctor`).

    exit_status: 0: nothing is wrong; 1: something is.
    works: whether nothing is wrong.
    examined: the things that were examined.
    """

    FORMAT: ClassVar[str] = "linkwright-doctor"

    exit_status: int
    works: bool
    examined: tuple[ExaminedDocument, ...]
