"""Defines the document of `linkwright diff`."""

from dataclasses import dataclass
from typing import ClassVar, Literal

from linkwright.pipeline.json_documents.document import AnyValue, CommandDocument


@dataclass(frozen=True)
class ComparedRobot:
    """A robot that was compared.

    place: the folder, file or revision as it was named.
    name: the robot's name.
    source: the source in its robot.json, or null.
    """

    place: str
    name: str
    source: AnyValue


@dataclass(frozen=True)
class ChangeDocument:
    """A difference.

    section: the table of robot.json with the row, such as `links`; or `robot`.
    name: the row's name in the second robot, or in the first if the row was removed.
    kind: what happened.
    field: the field that differs, with dots between levels; empty if the whole row was added or removed.
    before: the value in the first robot.json.
    after: the value in the second robot.json.
    text: both values in words, with units.
    """

    section: str
    name: str
    kind: Literal["added", "removed", "renamed", "changed"]
    field: str
    before: AnyValue
    after: AnyValue
    text: str


@dataclass(frozen=True)
class DiffDocument(CommandDocument):
    """The differences between two robots (`linkwright diff`).

    exit_status: 0: equal; 3: different.
    before: the first robot.
    after: the second robot.
    alike: whether they are equal.
    changes: the differences.
    """

    FORMAT: ClassVar[str] = "linkwright-diff"

    exit_status: int
    before: ComparedRobot
    after: ComparedRobot
    alike: bool
    changes: tuple[ChangeDocument, ...]
