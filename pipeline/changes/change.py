"""One difference between two robots."""

from dataclasses import dataclass
from typing import Any, Literal

Kind = Literal["added", "removed", "renamed", "changed"]


@dataclass(frozen=True, slots=True)
class Change:
    """What is different about one thing.

    `section`: the table of robot.json that has it ("links"), or "robot"; `name`: the thing's name in the
    second robot, or in the first where it was removed; `field`: what of it, with dots between levels (""
    where all of it came or went); `before`, `after`: the values as robot.json has them; `text`: both for
    people, with units.
    """

    section: str
    name: str
    kind: Kind
    field: str = ""
    before: Any = None
    after: Any = None
    text: str = ""
