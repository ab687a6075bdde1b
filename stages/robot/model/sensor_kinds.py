"""Lists the number of values of each kind of MuJoCo sensor, and their units."""

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
"""Element of MJCF → the number of its values. For elements that are not listed, and for a rangefinder with a
camera or `data`, the number depends on the attributes."""

QUATERNION = "quaternion (w, x, y, z)"
"""The unit of a rotation."""

_FIXED_UNITS: Mapping[str, str] = {
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

_UNITS_BY_ENDING: Mapping[str, str] = {"pos": "{}", "vel": "{}/s", "frc": "{force}"}
"""Last three letters of an element for a joint or actuator → its unit, as a pattern with the units of the
value and of the force."""

LENGTHS: Mapping[str, tuple[str, str]] = {"turn": ("rad", "N m"), "slide": ("m", "N")}
"""Kind of dof → units of its value and of its force."""


def unit_of(element: str, dof_kind: str) -> str | None:
    """Returns the unit of a sensor; None if it is unknown. `element`: the sensor's element of MJCF;
    `dof_kind`: the kind of its dof, "" without a dof."""
    if element in _FIXED_UNITS:
        return _FIXED_UNITS[element]
    if not element.startswith(("joint", "actuator")) or dof_kind not in LENGTHS:
        return None
    value, force = LENGTHS[dof_kind]
    return _UNITS_BY_ENDING[element[-3:]].format(value, force=force)
