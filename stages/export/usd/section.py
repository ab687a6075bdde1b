"""Configuration of the USD writer."""

from typing import Literal

from linkwright.stages.robot.section import Section


class UsdFormatSection(Section):
    """The USD."""

    geometry: Literal["binary", "text"] = "binary"
    """Encoding of the layer `<name>_meshes.usd`, which has the points of all meshes. binary: small, and quick
    to load; text: for reading and comparing, five times as large."""


SECTION = UsdFormatSection
"""The section of the configuration."""
