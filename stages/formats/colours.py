"""Reads colours from CAD's appearances, which come in several encodings."""

import base64
import binascii
from collections.abc import Mapping, Sequence
from typing import Any

from linkwright.stages.robot.model.geometry import NEUTRAL, Colour


def colour_of(*appearances: Any) -> Colour:
    """Returns RGBA in 0..1 of the first appearance that has a colour, or else the neutral grey.

    An appearance has `color` (or `rgbaColor`): a list of three or four numbers or of their texts, base64 of
    three or four bytes, a packed ARGB integer or its text, or a mapping of red, green and blue; and maybe
    `opacity`, which overrides the colour's own alpha. Numbers are bytes (0..255, or signed). Unreadable
    colours are ignored.
    """
    for appearance in appearances:
        if isinstance(appearance, Mapping):
            for key in ("color", "rgbaColor"):
                channels = _channels(appearance.get(key))
                if channels is not None:
                    return _colour(channels, appearance.get("opacity"))
    return NEUTRAL


def _colour(channels: Sequence[int], opacity: Any) -> Colour:
    """Returns RGBA in 0..1 of three or four channels in 0..255."""
    red, green, blue = channels[:3]
    alpha = channels[3] if len(channels) == 4 else 255
    if isinstance(opacity, int | float) and 0 <= opacity <= 255:
        alpha = int(opacity)
    return (_share(red), _share(green), _share(blue), _share(alpha))


def _share(channel: int) -> float:
    """Returns a channel in 0..1, in the digits that files have."""
    return round(channel / 255, 6)


def _channels(value: Any) -> list[int] | None:
    """Returns three or four channels in 0..255; None if `value` is not a colour."""
    try:
        if isinstance(value, Mapping):
            channels = [value["red"], value["green"], value["blue"]]
        elif isinstance(value, int):
            channels = _unpack_argb(value)
        elif isinstance(value, str):
            channels = _unpack_argb(int(value)) if _is_whole(value) else list(_decode_base64(value))
        elif isinstance(value, list):
            channels = [_channel(item) for item in value]
        else:
            return None
        # A signed byte, as Java writes it, is the same byte.
        channels = [int(item) & 0xFF if -128 <= item < 0 else int(item) for item in channels]
    except (KeyError, OverflowError, TypeError, ValueError):
        return None
    if len(channels) not in (3, 4) or not all(0 <= item <= 255 for item in channels):
        return None
    return channels


def _channel(item: Any) -> int:
    """Returns the channel in an item of a list: a number, its text, or base64 of a byte."""
    if isinstance(item, str) and not _is_whole(item):
        (byte,) = _decode_base64(item)
        return byte
    return int(item)


def _is_whole(text: str) -> bool:
    """Tells whether a text is a whole number; such a text is never read as base64."""
    return text.lstrip("-").isdigit()


def _unpack_argb(value: int) -> list[int]:
    """Returns red, green, blue and alpha of a packed ARGB integer."""
    red, green, blue = (value >> 16) & 0xFF, (value >> 8) & 0xFF, value & 0xFF
    alpha = (value >> 24) & 0xFF
    # RGB without an alpha has 0 in its place: no part is invisible.
    return [red, green, blue, alpha or 255]


def _decode_base64(text: str) -> bytes:
    """Returns the bytes in base64, also without its padding. Raises ValueError for other texts."""
    try:
        return base64.b64decode(text + "=" * (-len(text) % 4), validate=True)
    except binascii.Error as error:
        raise ValueError(str(error)) from None
