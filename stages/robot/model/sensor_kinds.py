"""Tells the number of values of each kind of MuJoCo sensor, and their units."""

from collections.abc import Mapping

DIMENSIONS: Mapping[str, int] = {
    **dict.fromkeys(("touch", "rangefinder", "jointpos", "jointvel", "jointactuatorfrc", "jointlimitpos"), 1),
    **dict.fromkeys(("jointlimitvel", "jointlimitfrc", "actuatorpos", "actuatorvel", "actuatorfrc"), 1),
    **dict.fromkeys(("tendonpos", "tendonvel", "tendonactuatorfrc", "tendonlimitpos", "tendonlimitvel"), 1),
    **dict.fromkeys(("tendonlimitfrc", "e_potential", "e_kinetic", "clock", "insidesite", "distance"), 1),
    **dict.fromkeys(("camprojection",), 2),
    **dict.fromkeys(("accelerometer", "velocimeter", "gyro", "force", "torque", "magnetometer"), 3),
    **dict.fromkeys(("ballangvel", "framepos", "framexaxis", "frameyaxis", "framezaxis", "framelinvel"), 3),
    **dict.fromkeys(("frameangvel", "framelinacc", "frameangacc", "subtreecom", "subtreelinvel"), 3),
    **dict.fromkeys(("subtreeangmom", "normal"), 3),
    **dict.fromkeys(("ballquat", "framequat"), 4),
    "fromto": 6,
}
"""Element → the number of its values; other elements depend on their attributes."""

QUATERNION = "quaternion (w, x, y, z)"

_ALWAYS: Mapping[str, str] = {
    **dict.fromkeys(("touch", "force"), "N"),
    **dict.fromkeys(("rangefinder", "distance", "framepos", "subtreecom", "fromto"), "m"),
    **dict.fromkeys(("velocimeter", "framelinvel", "subtreelinvel"), "m/s"),
    **dict.fromkeys(("accelerometer", "framelinacc"), "m/s²"),
    **dict.fromkeys(("gyro", "ballangvel", "frameangvel"), "rad/s"),
    **dict.fromkeys(("ballquat", "framequat"), QUATERNION),
    **dict.fromkeys(("framexaxis", "frameyaxis", "framezaxis", "normal", "insidesite"), "-"),
    **dict.fromkeys(("e_potential", "e_kinetic"), "J"),
    "frameangacc": "rad/s²",
    "torque": "N m",
    "magnetometer": "T",
    "subtreeangmom": "kg m²/s",
    "camprojection": "pixel",
    "clock": "s",
}

_OF_A_DOF: Mapping[str, str] = {"pos": "{}", "vel": "{}/s", "frc": "{force}"}
"""Ending of the name of a sensor of a joint or actuator → its unit."""

LENGTHS: Mapping[str, tuple[str, str]] = {"turn": ("rad", "N m"), "slide": ("m", "N")}
"""Kind of dof → units of its value and of its force."""


def unit_of(kind: str, dof: str) -> str | None:
    """Returns the unit of a sensor of MJCF's type `kind`, on a dof of the kind `dof` ("" for none); None
    where it is not known."""
    if kind in _ALWAYS:
        return _ALWAYS[kind]
    if not kind.startswith(("joint", "actuator")) or dof not in LENGTHS:
        return None
    value, force = LENGTHS[dof]
    return _OF_A_DOF[kind[-3:]].format(value, force=force)
