"""Lists the elements and attributes of URDF, from ROS's reference and from later readers."""

Allowed = tuple[frozenset[str] | None, frozenset[str] | None]
"""The attributes and the children of an element; None means any."""

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
"""A line for each element: `tag: attributes | children`. Attributes that ROS's reference lacks, such as
`quat_xyzw` and `rotorInertia`, are those of other readers."""

_ANYWHERE = frozenset(
    (
        *("gazebo", "ros2_control", "transmission", "mujoco", "sensor", "contact", "verbose"),
        "self_collision_checking",
    )
)
"""Elements that may be anywhere with any content, since other programs read them."""


def _parsed_table() -> dict[str, Allowed]:
    """Returns the table of elements: tag → the attributes and children that it may have."""
    table: dict[str, Allowed] = {}
    for line in _TABLE.strip().splitlines():
        tag, _, contents = line.partition(":")
        attributes, _, children = contents.partition("|")
        table[tag] = frozenset(attributes.split()), frozenset(children.split()) | _ANYWHERE
    return table


_ALLOWED = _parsed_table()


def allowed(path: tuple[str, ...]) -> Allowed:
    """Returns the attributes and children that an element may have. `path`: the tags from the root to it."""
    if any(tag in _ANYWHERE or ":" in tag for tag in path):
        return None, None
    # An element that the table lacks may have any content: it is itself reported as an unknown child.
    return _ALLOWED.get(path[-1], (None, None))
