"""Random URDFs: any tree, all types of joints with one value, any axis, mimic chains, dummies, odd names."""

import math

import numpy as np
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

NAMES = ("{0}", "Link{0}", "arm/{0}", "l.{0}", "grüße {0}", "L-{0}")
ANGLES = (0.0, math.pi / 2, -math.pi / 2, math.pi, 0.3, -1.234567890123)
LENGTHS = (0.0, 0.1, -0.25, 1.0, 1e-3, 0.123456789012345)
AXES = ((1, 0, 0), (0, 1, 0), (0, 0, 1), (0, 0, -1), (1, 1, 0), (0.3, -2, 0.7), (1e-9, 0, 1))


@st.composite
def urdfs(draw, most=8):
    """The text of a URDF whose moving links all have mass, or carry one that has."""
    count = draw(st.integers(1, most))
    style = draw(st.sampled_from(NAMES))
    clash = draw(st.booleans())
    names = [style.format(f"b{i}") for i in range(count)]
    if draw(st.booleans()):
        names[0] = "world"
    parents = [draw(st.integers(0, i - 1)) for i in range(1, count)]
    types = [draw(st.sampled_from(("fixed", "revolute", "continuous", "prismatic"))) for _ in parents]
    # A dummy is a leaf on a fixed joint, or has children that are fixed or moving: all of these merge.
    dummy = [False, *(kind == "fixed" and draw(st.booleans()) for kind in types)]
    lines = [_link(names[0], None if draw(st.booleans()) and count > 1 and names[0] == "world" else draw)]
    lines += [_link(name, None if dummy[i] else draw) for i, name in enumerate(names[1:], start=1)]
    joints = [name if clash else f"{name}_j" for name in names[1:]]
    movers = []
    for i, (parent, kind) in enumerate(zip(parents, types, strict=True)):
        mimic = draw(st.sampled_from(movers)) if movers and kind != "fixed" and draw(st.booleans()) else ""
        lines.append(_joint(draw, joints[i], kind, names[parent], names[i + 1], mimic))
        if kind != "fixed":
            movers.append(joints[i])
    if draw(st.booleans()):
        lines.reverse()
    return "\n".join(['<robot name="any">', *lines, "</robot>"])


def _pose(draw):
    xyz = [draw(st.sampled_from(LENGTHS)) for _ in range(3)]
    rpy = [draw(st.sampled_from(ANGLES)) for _ in range(3)]
    return f'<origin xyz="{_text(xyz)}" rpy="{_text(rpy)}"/>'


def _text(numbers):
    return " ".join(repr(float(number)) for number in numbers)  # type: ignore[attr-defined]


def _link(name, draw):
    if draw is None:
        return f'<link name="{name}"/>'
    mass = draw(st.sampled_from((0.01, 1.0, 12.5)))
    second = np.diag([draw(st.sampled_from((0.02, 0.3, 1.0))) for _ in range(3)]) * mass
    turn = Rotation.from_euler("xyz", [draw(st.sampled_from(ANGLES)) for _ in range(3)]).as_matrix()
    i = turn @ (np.trace(second) * np.eye(3) - second) @ turn.T
    numbers = {"ixx": i[0, 0], "ixy": i[0, 1], "ixz": i[0, 2], "iyy": i[1, 1], "iyz": i[1, 2], "izz": i[2, 2]}
    inertia = " ".join(f'{key}="{float(value)!r}"' for key, value in numbers.items())
    body = f'<mass value="{mass}"/><inertia {inertia}/>'
    return f'<link name="{name}"><inertial>{_pose(draw)}{body}</inertial></link>'


def _joint(draw, name, kind, parent, child, mimic):
    inside = [_pose(draw), f'<parent link="{parent}"/><child link="{child}"/>']
    if kind != "fixed":
        axis = np.array(draw(st.sampled_from(AXES)), dtype=float)
        inside.append(f'<axis xyz="{_text(axis / np.linalg.norm(axis))}"/>')
        low = draw(st.sampled_from((-2.5, -0.1, 0.0)))
        high = low + draw(st.sampled_from((0.5, 3.0)))
        span = "" if kind == "continuous" else f'lower="{low}" upper="{high}" '
        inside.append(f'<limit {span}effort="{draw(st.sampled_from((1, 7.5)))}" velocity="2"/>')
        if draw(st.booleans()):
            inside.append('<dynamics damping="0.1" friction="0.02"/>')
    if mimic:
        factor, offset = draw(st.sampled_from((1.0, -0.5, 3.0))), draw(st.sampled_from((0.0, 0.25, -4.0)))
        inside.append(f'<mimic joint="{mimic}" multiplier="{factor}" offset="{offset}"/>')
    return f'<joint name="{name}" type="{kind}">{"".join(inside)}</joint>'
