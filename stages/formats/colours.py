"""Reads colours from CAD's appearances, which come in several encodings."""

import base64
import binascii
from collections.abc import Mapping, Sequence
from typing import Any

from linkwright.stages.robot.model.geometry import Colour

NEUTRAL: Colour = (0.7, 0.7, 0.7, 1.0)
"""The colour of parts without a colour in CAD."""


def colour_of(*appearances: Any) -> Colour:
    """Returns RGBA in 0..1 of the first appearance that has a colour, or else the neutral grey.

    An appearance has `color` (or `rgbaColor`): a list of numbers or of their texts, base64 of three or four
    bytes, a packed ARGB integer or a mapping of red, green and blue; and maybe `opacity` (0..255), which
    overrides the colour's own alpha. Unreadable colours are ignored.
    """
    for appearance in appearances:
        if isinstance(appearance, Mapping):
            for key in ("color", "rgbaColor"):
                channels = _channels(appearance.get(key))
                if channels is not None:
                    return _colour(channels, appearance.get("opacity"))
    return NEUTRAL


def _colour(channels: Sequence[int], opacity: Any) -> Colour:
    red, green, blue = channels[:3]
    alpha = channels[3] if len(channels) == 4 else 255
    if isinstance(opacity, int | float) and 0 <= opacity <= 255:
        alpha = int(opacity)
    return (_unit(red), _unit(green), _unit(blue), _unit(alpha))


def _unit(channel: int) -> float:
    return round(channel / 255, 6)


def _channels(value: Any) -> list[int] | None:
    """Returns three or four channels in 0..255; None if `value` is not a colour."""
    try:
        if isinstance(value, Mapping):
            channels = [value["red"], value["green"], value["blue"]]
        elif isinstance(value, int):
            channels = _unpacked(value)
        elif isinstance(value, str):
            channels = _unpacked(int(value)) if value.lstrip("-").isdigit() else list(_bytes(value))
        elif isinstance(value, list):
            channels = [_channel(item) for item in value]
        else:
            return None
        # A signed byte, as Java writes it, is the same byte.
        channels = [int(item) & 0xFF if -128 <= item < 0 else int(item) for item in channels]
    except (KeyError, TypeError, ValueError):
        return None
    if len(channels) not in (3, 4) or not all(0 <= item <= 255 for item in channels):
        return None
    return channels


def _channel(item: Any) -> int:
    if isinstance(item, str) and not item.lstrip("-").isdigit():
        (byte,) = _bytes(item)
        return byte
    return int(item)


def _unpacked(value: int) -> list[int]:
    red, green, blue = (value >> 16) & 0xFF, (value >> 8) & 0xFF, value & 0xFF
    alpha = (value >> 24) & 0xFF
    return [red, green, blue, alpha or 255]


def _bytes(text: str) -> bytes:
    try:
        return base64.b64decode(text + "=" * (-len(text) % 4), validate=True)
    except binascii.Error as error:
        raise ValueError(str(error)) from None
