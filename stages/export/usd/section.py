"""Configuration of the USD writer."""

from typing import Literal

from linkwright.stages.export.configuration.format_section import FormatSection


class UsdFormatSection(FormatSection):
    """The USD."""

    files = ("<name>.usda", "<name>_meshes.usd")

    geometry: Literal["binary", "text"] = "binary"
    """Encoding of the layer `<name>_meshes.usd`, which has the points of all meshes. binary: small, and quick
    to load; text: for reading and comparing, five times as large."""
