"""Lists units of length and angle, by the names that users of Onshape write, with their sizes in SI.

The inch is 0.0254 m exactly (international yard and pound agreement, 1959).
"""

import math
from collections.abc import Mapping
from typing import Literal

Measure = Literal["length", "angle"]
"""The quantity that a unit measures."""

SI: Mapping[Measure, str] = {"length": "m", "angle": "rad"}
"""Measure → its unit in SI, which is the unit of numbers without a unit."""

# Size in SI → names of the unit.
_LENGTHS = {
    1e-9: ("nm", "nanometer", "nanometers", "nanometre", "nanometres"),
    1e-6: ("um", "µm", "micrometer", "micrometers", "micron", "microns"),
    1e-3: ("mm", "millimeter", "millimeters", "millimetre", "millimetres"),
    2.54e-5: ("thou", "mil", "mils"),
    1e-2: ("cm", "centimeter", "centimeters", "centimetre", "centimetres"),
    1e-1: ("dm", "decimeter", "decimeters", "decimetre", "decimetres"),
    1.0: ("m", "meter", "meters", "metre", "metres"),
    1e3: ("km", "kilometer", "kilometers", "kilometre", "kilometres"),
    0.0254: ("in", "inch", "inches", '"', "″"),
    0.3048: ("ft", "foot", "feet", "'", "′"),
    0.9144: ("yd", "yard", "yards"),
    1609.344: ("mi", "mile", "miles"),
}
_ANGLES = {
    math.pi / 180: ("deg", "degree", "degrees", "°"),
    1.0: ("rad", "radian", "radians"),
    2 * math.pi: ("rev", "revolution", "revolutions"),
}

UNITS: Mapping[str, tuple[float, Measure]] = {
    **{name: (factor, "length") for factor, names in _LENGTHS.items() for name in names},
    **{name: (factor, "angle") for factor, names in _ANGLES.items() for name in names},
}
"""Name of a unit → (its size in m or rad, its measure)."""
