"""Names default classes: after a motor, or after the words that the elements of a class share."""

import re
from collections.abc import Collection, Mapping, Sequence

WORD = re.compile(r"[^\W\d_]+")
"""Matches the words of a name, without its numbers, which only count copies."""


def named_after(
    names: Sequence[str], all_names: Collection[str], ignored: Collection[str] = ()
) -> str | None:
    """Returns the words that these names share and that no other name in `all_names` has together, such as
    `hip_pitch` for left_hip_pitch and right_hip_pitch; None if there are no such words. `ignored`: words that
    do not count."""
    words = [part for part in dict.fromkeys(_words(names[0])) if part not in ignored]
    shared = [word for word in words if all(word in _words(name) for name in names)]
    other_names = [name for name in all_names if name not in names]
    if not shared or any(set(shared) <= set(_words(name)) for name in other_names):
        return None
    return "_".join(shared)


def motor_of(names: Sequence[str], motors: Mapping[str, str]) -> str | None:
    """Returns the motor that exactly these joints have, or None."""
    motors_of_joints = {motors.get(name, "") for name in names}
    motor = motors_of_joints.pop()
    with_motor = {name for name, other in motors.items() if other == motor}
    return motor if motor and not motors_of_joints and with_motor <= set(names) else None


def _words(name: str) -> list[str]:
    return WORD.findall(name)
