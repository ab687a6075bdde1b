"""Converts between glTF's conventions and ours: colours in linear light, and the mark of a file of ours."""

from collections.abc import Mapping
from typing import Any

SUFFIX = ".glb"

GENERATOR = "linkwright"
"""The generator in the `asset` of a file of ours. Such a file is in the frame of its link, apart from the
turn of its node."""


def is_own(root: Mapping[str, Any]) -> bool:
    """Tells whether the JSON of a glTF is that of a file of ours."""
    asset = root.get("asset")
    return isinstance(asset, Mapping) and asset.get("generator") == GENERATOR


def srgb_from_linear(linear: float) -> float:
    """Converts a channel in linear light to sRGB, as screens show it; values outside of 0..1 are clamped."""
    value = min(max(float(linear), 0.0), 1.0)
    return round(12.92 * value if value <= 0.0031308 else 1.055 * value ** (1 / 2.4) - 0.055, 6)


def linear_from_srgb(srgb: float) -> float:
    """Converts a channel in sRGB, as screens show it, to linear light."""
    value = srgb / 12.92 if srgb <= 0.04045 else ((srgb + 0.055) / 1.055) ** 2.4
    # Powers differ in their last digit from one machine to the next.
    return float(round(value, 9))
