"""A humanoid as a URDF of boxes, balls and cylinders: 21 turns, 1.3 m, standing upright at zero."""

import math
from itertools import chain

DENSITY = 600.0
"""[kg/m³]"""

Size = tuple[float, ...]
"""The size of a box (x, y, z), a cylinder (radius, length) or a ball (radius), in m."""


def humanoid():
    parts = [_link("pelvis", (0.16, 0.26, 0.14))]
    parts += _limb("pelvis", "waist", "torso", (0, 0, 0.07), "z", (0.16, 0.28, 0.36), (0, 0, 0.2), 1.0)
    parts += _limb("torso", "neck", "head", (0, 0, 0.38), "z", (0.09,), (0, 0, 0.12), 1.2)
    parts += chain(_arm("left", 1), _arm("right", -1), _leg("left", 1), _leg("right", -1))
    return f'<robot name="humanoid">\n{"".join(parts)}</robot>\n'


def _arm(side, left):
    upper, lower = f"{side}_upper_arm", f"{side}_forearm"
    shoulder = (0, left * 0.2, 0.32)
    return [
        *_limb("torso", f"{side}_shoulder_pitch", f"{side}_shoulder", shoulder, "y", (0.05,), (0, 0, 0), 2.0),
        *_limb(
            f"{side}_shoulder",
            f"{side}_shoulder_roll",
            upper,
            (0, left * 0.06, 0),
            "x",
            (0.035, 0.2),
            (0, 0, -0.14),
            1.5,
        ),
        *_limb(upper, f"{side}_elbow", lower, (0, 0, -0.28), "y", (0.03, 0.2), (0, 0, -0.14), 1.5),
    ]


def _leg(side, left):
    yaw, hip, thigh, shank, ankle, foot = (
        f"{side}_{name}" for name in ("hip_yaw_link", "hip", "thigh", "shank", "ankle", "foot")
    )
    aside, sole = (0, left * 0.09, -0.09), (0.22, 0.1, 0.03)
    return [
        *_limb("pelvis", f"{side}_hip_yaw", yaw, aside, "z", (0.04,), (0, 0, 0), 0.6),
        *_limb(yaw, f"{side}_hip_roll", hip, (0, 0, -0.05), "x", (0.04,), (0, 0, 0), 0.5),
        *_limb(hip, f"{side}_hip_pitch", thigh, (0, 0, -0.02), "y", (0.055, 0.24), (0, 0, -0.17), 1.5),
        *_limb(thigh, f"{side}_knee", shank, (0, 0, -0.35), "y", (0.045, 0.22), (0, 0, -0.16), 2.0),
        *_limb(shank, f"{side}_ankle_pitch", ankle, (0, 0, -0.33), "y", (0.03,), (0, 0, 0), 0.8),
        *_limb(ankle, f"{side}_ankle_roll", foot, (0, 0, -0.02), "x", sole, (0.03, 0, -0.035), 0.4),
    ]


def _limb(parent, joint, link, place, axis, size, center, reach):
    """A link and the turn to it, which goes `reach` [rad] to both sides. `center`: of its solid."""
    turn = {"x": "1 0 0", "y": "0 1 0", "z": "0 0 1"}[axis]
    return [
        _link(link, size, center),
        f'<joint name="{joint}" type="revolute"><parent link="{parent}"/><child link="{link}"/>'
        f'<origin xyz="{_text(place)}"/><axis xyz="{turn}"/>'
        f'<limit lower="{-reach}" upper="{reach}" effort="120" velocity="15"/>'
        '<dynamics damping="0.5"/></joint>\n',
    ]


def _link(name, size, center=(0, 0, 0)):
    shape, mass, inertia = _solid(size)
    origin = f'<origin xyz="{_text(center)}"/>'
    ixx, iyy, izz = (f"{mass * moment:.9g}" for moment in inertia)
    return (
        f'<link name="{name}"><inertial>{origin}<mass value="{mass:.9g}"/>'
        f'<inertia ixx="{ixx}" iyy="{iyy}" izz="{izz}" ixy="0" ixz="0" iyz="0"/></inertial>'
        f"<visual>{origin}<geometry>{shape}</geometry></visual>"
        f"<collision>{origin}<geometry>{shape}</geometry></collision></link>\n"
    )


def _solid(size):
    """Its element, its mass and its moments for each kg."""
    if len(size) == 3:
        x, y, z = (side**2 / 12 for side in size)
        box = size[0] * size[1] * size[2]
        return f'<box size="{_text(size)}"/>', DENSITY * box, (y + z, x + z, x + y)
    if len(size) == 2:
        radius, length = size
        across = radius**2 / 4 + length**2 / 12
        mass = DENSITY * math.pi * radius**2 * length
        return f'<cylinder radius="{radius}" length="{length}"/>', mass, (across, across, radius**2 / 2)
    (radius,) = size
    mass = DENSITY * 4 / 3 * math.pi * radius**3
    return f'<sphere radius="{radius}"/>', mass, (0.4 * radius**2,) * 3


def _text(numbers):
    return " ".join(f"{number:g}" for number in numbers)
