"""Defines the files that variants add to a robot."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from linkwright.stages.robot.errors import Diagnostic

if TYPE_CHECKING:
    from linkwright.stages.formats.robot_json.files import VariantsRecord


@dataclass(frozen=True, slots=True)
class VariantFiles:
    """The variants of a robot as a file, with its entries in robot.json and in the report."""

    files: Mapping[str, bytes] = field(default_factory=dict)
    """Path → content; empty if no variant is made."""

    record: Mapping[str, "VariantsRecord"] = field(default_factory=dict)
    """The entry in robot.json, by its key."""

    diagnostics: tuple[Diagnostic, ...] = ()

    summary: Mapping[str, Any] = field(default_factory=dict)
    """The entry in the report."""


NO_VARIANTS = VariantFiles()
