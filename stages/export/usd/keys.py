"""Configuration of the USD writer."""

from typing import Literal

from stages.robot.keys import Keys


class UsdFormatKeys(Keys):
    """The USD."""

    geometry: Literal["binary", "text"] = "binary"
    """Encoding of the layer `<name>_meshes.usd`, which has the points of all meshes. binary: small, and quick
    to load; text: for reading and comparing, five times as large."""


KEYS = UsdFormatKeys
"""The section of the configuration."""
