"""Converts colours for a USD."""

from linkwright.stages.robot.model.geometry import Colour

ROUGHNESS = 0.5
"""The roughness of every surface."""


def to_linear_rgb(colour: Colour) -> tuple[float, float, float]:
    """Returns red, green and blue of a colour in linear light, as renderers use it (sRGB's transfer function,
    IEC 61966-2-1)."""
    red, green, blue = (
        value / 12.92 if value <= 0.04045 else ((value + 0.055) / 1.055) ** 2.4 for value in colour[:3]
    )
    return red, green, blue
