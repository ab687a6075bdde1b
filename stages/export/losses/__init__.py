"""Lists what each format cannot express or expresses differently, with the message and the hint."""

from collections.abc import Iterator
from typing import Any

from linkwright.stages.export.losses.contacts import CONTACTS
from linkwright.stages.export.losses.control import CONTROL_LOSSES
from linkwright.stages.export.losses.joints import JOINTS
from linkwright.stages.export.losses.loss import Loss
from linkwright.stages.export.writer import Case
from linkwright.stages.robot.errors import Diagnostic

LOSSES: tuple[Loss, ...] = (*JOINTS, *CONTACTS, *CONTROL_LOSSES)
"""All losses, in the order in which a build reports them for a format."""


def losses(case: Case[Any]) -> Iterator[Diagnostic]:
    """Yields a diagnostic for each kind of loss that the robot has in the format of the case."""
    for loss in LOSSES:
        yield from loss.diagnostics(case)
