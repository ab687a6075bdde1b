"""Colours of a USD."""

from linkwright.stages.robot.model.geometry import Colour

ROUGHNESS = 0.5
"""Of every surface."""


def linear(colour: Colour) -> tuple[float, float, float]:
    """The colour as renderers add it up (sRGB's transfer function, IEC 61966-2-1)."""
    red, green, blue = (
        value / 12.92 if value <= 0.04045 else ((value + 0.055) / 1.055) ** 2.4 for value in colour[:3]
    )
    return red, green, blue
