"""The elements and attributes of URDF: those of ROS's reference, and what later readers add."""

Known = tuple[frozenset[str] | None, frozenset[str] | None]
"""The attributes and the children of an element; None: any."""

_TABLE = """
robot: name version | link joint material
link: name type | inertial visual collision
inertial: | origin mass inertia
mass: value |
inertia: ixx ixy ixz iyy iyz izz |
origin: xyz rpy quat_xyzw |
visual: name group | origin geometry material
collision: name group | origin geometry
geometry: | box cylinder sphere capsule mesh
box: size |
cylinder: radius length |
sphere: radius |
capsule: radius length |
mesh: filename scale |
material: name | color texture
color: rgba |
texture: filename |
joint: name type dont_collapse | origin parent child axis limit dynamics mimic safety_controller calibration
parent: link |
child: link |
axis: xyz |
limit: lower upper effort velocity acceleration deceleration jerk |
dynamics: damping friction rotorInertia rotor_inertia armature |
mimic: joint multiplier offset |
safety_controller: soft_lower_limit soft_upper_limit k_position k_velocity |
calibration: rising falling reference_position |
"""

_OPEN = frozenset(
    (
        *("gazebo", "ros2_control", "transmission", "mujoco", "sensor", "contact", "verbose"),
        "self_collision_checking",
    )
)
"""Elements that may be anywhere and have anything in them: other programs read them."""


def _read() -> dict[str, Known]:
    found: dict[str, Known] = {}
    for line in _TABLE.strip().splitlines():
        tag, _, rest = line.partition(":")
        attributes, _, children = rest.partition("|")
        found[tag] = frozenset(attributes.split()), frozenset(children.split()) | _OPEN
    return found


_KNOWN = _read()


def known(way: tuple[str, ...]) -> Known:
    """What an element may have, by the tags from the root to it."""
    if any(tag in _OPEN or ":" in tag for tag in way):
        return None, None
    return _KNOWN.get(way[-1], (None, None))
