"""The place of a value in the configuration, and its full key as users type it."""

import re
from collections.abc import Iterable

Place = tuple[int | str, ...]
"""The way to a value: names of mappings and indices of lists."""


def key_of(place: Iterable[int | str]) -> str:
    """The full key of a place: `joints.elbow.limits[0]`, `joints["a.b"].damping`."""
    text = ""
    for part in place:
        if isinstance(part, int):
            text += f"[{part}]"
        elif re.search(r'[.\[\]"]', part):
            text += f'["{part}"]'
        else:
            text += f".{part}" if text else part
    return text
