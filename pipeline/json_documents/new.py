"""Defines the document of `linkwright new`."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

from linkwright.pipeline.json_documents.document import AnyValue, CommandDocument
from linkwright.pipeline.json_documents.findings import DiagnosticDocument


@dataclass(frozen=True)
class NewJointDocument:
    """A coordinate of a joint; a joint with several has an entry for each.

    name: the name by which the keys `joints` and `actuators` know it.
    type: the type of the joint.
    unit: the unit of `lower` and `upper`.
    lower: the lower limit; null without one.
    upper: the upper limit; null without one.
    follows: the joint that it follows, and how: `-1.5 × drive`; empty for an independent joint.
    loop: whether it closes a loop, so that it is no joint of the tree.
    missing: keys without a value in the source, each with the value that the file proposes.
    """

    name: str
    type: str
    unit: str
    lower: float | None
    upper: float | None
    follows: str
    loop: bool
    missing: AnyValue


@dataclass(frozen=True)
class NewDocument(CommandDocument):
    """A robot's file that was written (`linkwright new`).

    exit_status: 0, also if the build will end with problems.
    path: the file.
    name: the robot's name: `linkwright robot=NAME` builds it.
    source: the section `source` of the file.
    joints: the joints that were found.
    problems: the problems with which the build ends until they are solved; the file explains them.
    remarks: what `--from` leaves out, and what it changes.
    weighed: whether the masses are known; else `--deep` asks for them.
    calls: API calls `made` and `saved`.
    """

    FORMAT: ClassVar[str] = "linkwright-new"

    exit_status: int
    path: str
    name: str
    source: AnyValue
    joints: tuple[NewJointDocument, ...]
    problems: tuple[DiagnosticDocument, ...]
    remarks: tuple[str, ...]
    weighed: bool
    calls: Mapping[str, int]
