"""Names of default classes: that of the motor, or the words that the elements of a class share."""

import re
from collections.abc import Collection, Mapping, Sequence

WORD = re.compile(r"[^\W\d_]+")
"""Of a name; its numbers count copies, and say nothing of what these are."""


def named_after(names: Sequence[str], every: Collection[str], dull: Collection[str] = ()) -> str | None:
    """The words that these names share and no other of `every` has all of, as `hip_pitch` for left_hip_pitch
    and right_hip_pitch; None where there are none. `dull`: words that do not count."""
    words = [one for one in dict.fromkeys(_words(names[0])) if one not in dull]
    shared = [word for word in words if all(word in _words(name) for name in names)]
    others = [name for name in every if name not in names]
    if not shared or any(set(shared) <= set(_words(name)) for name in others):
        return None
    return "_".join(shared)


def motor_of(names: Sequence[str], motors: Mapping[str, str]) -> str | None:
    """The motor that all of these joints have, and no other; None without one."""
    own = {motors.get(name, "") for name in names}
    motor = own.pop()
    others = {name for name, other in motors.items() if other == motor}
    return motor if motor and not own and others <= set(names) else None


def _words(name: str) -> list[str]:
    return WORD.findall(name)
