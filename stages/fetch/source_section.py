"""Defines the base of every source's configuration, and types that several of them use."""

import math
from typing import Annotated, Any

from pydantic import AfterValidator

from linkwright.stages.robot.section import Section, invalid

ADDRESS = "address"
"""The error type of an invalid address; its context holds `message` and `hint`."""


class SourceSection(Section):
    """The configuration of a kind of source."""

    kind: str
    """Kind of the source; `source=KIND` chooses it."""


def _setting(value: Any) -> bool | float | str:
    if isinstance(value, bool | int | float | str) and (isinstance(value, str) or math.isfinite(value)):
        return value
    raise invalid("must be text, a number, or true or false")


Setting = Annotated[Any, AfterValidator(_setting)]
"""A value whose meaning the document or file knows: text, a number, or true or false."""
