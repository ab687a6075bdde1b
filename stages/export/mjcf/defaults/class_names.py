"""Names default classes: after a motor, or after the words that the elements of a class share."""

import re
from collections.abc import Collection, Mapping, Sequence

WORD_PATTERN = re.compile(r"[^\W\d_]+")
"""Matches the words of a name, without its numbers, which only count copies."""


def shared_name(
    names: Sequence[str], all_names: Collection[str], ignored: Collection[str] = ()
) -> str | None:
    """Returns the words that these names share, joined by "_", such as `hip_pitch` for left_hip_pitch and
    right_hip_pitch. Returns None if they share no word, or if another name in `all_names` has all these
    words. `ignored`: words that do not count."""
    words = [word for word in dict.fromkeys(_words(names[0])) if word not in ignored]
    shared_words = [word for word in words if all(word in _words(name) for name in names)]
    other_names = [name for name in all_names if name not in names]
    if not shared_words or any(set(shared_words) <= set(_words(name)) for name in other_names):
        return None
    return "_".join(shared_words)


def motor_of_joints(names: Sequence[str], motors: Mapping[str, str]) -> str | None:
    """Returns the motor that all these joints have, and no other joint; None if there is no such motor.
    `motors`: joint → its motor."""
    motors_of_names = {motors.get(name) for name in names}
    if len(motors_of_names) != 1:
        return None
    (motor,) = motors_of_names
    joints_with_motor = {name for name, other_motor in motors.items() if other_motor == motor}
    return motor if joints_with_motor <= set(names) else None


def _words(name: str) -> list[str]:
    """Returns the words of a name, without its numbers."""
    return WORD_PATTERN.findall(name)
