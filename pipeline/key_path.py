"""Converts the path of a value in the configuration to the full key that users type."""

import re
from collections.abc import Iterable

Place = tuple[int | str, ...]
"""Path of a value in the tree: keys of mappings and indices of lists, from the root."""


def key_of(place: Iterable[int | str]) -> str:
    """Returns the full key of a path: `joints.elbow.limits[0]`, `joints["a.b"].damping`."""
    text = ""
    for part in place:
        if isinstance(part, int):
            text += f"[{part}]"
        elif re.search(r'[.\[\]"]', part):
            text += f'["{part}"]'
        else:
            text += f".{part}" if text else part
    return text
