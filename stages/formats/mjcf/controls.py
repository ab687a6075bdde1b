"""Counts the controls of an MJCF's actuators, from their text."""

_DEFAULT_PID_INPUTS = "pos vel"
"""Default of the attribute `input` of MuJoCo's pid: the names of its controls."""


def control_count(tag: str, inputs: str | None) -> int:
    """Returns the number of controls of an actuator with this tag and attribute `input`: one for each input,
    and for an orientation servo its three or, as a quaternion, four numbers."""
    if tag == "orientation":
        return 4 if inputs == "quat" else 3
    if inputs == "none":
        return 0
    if tag == "pid":
        inputs = inputs or _DEFAULT_PID_INPUTS
    return len(inputs.split()) if inputs else 1
