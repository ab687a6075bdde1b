"""Describes the robot in tables of texts, which a page shows as they are."""

import json
import math
from collections.abc import Iterator, Mapping

from linkwright.stages.robot.model.robot import Dof, Joint, Robot
from linkwright.stages.robot.text.plural import count
from linkwright.stages.robot.text.printable import printable
from linkwright.stages.show.graph_view.labels import (
    base_line,
    decimal,
    frames_on,
    kilograms,
    leaf,
    limits,
    mobility,
    rules,
    value,
)

Rows = list[list[str]]

_JOINT = ("joint", "coordinate", "type", "parent", "child", "axis", "range", "saved", "follows")
_DYNAMICS = ("effort", "velocity", "damping", "friction", "armature")


def tables(robot: Robot) -> bytes:
    """Returns the tables as JSON: a list of {title, header, rows}, in which each cell is a text. Tables
    without rows are left out."""
    all_tables: list[tuple[str, list[str], Rows]] = [
        ("Mobility", ["what", "value"], _mobility(robot)),
        (
            "Joints",
            [*_JOINT, "CAD"],
            list(_joints(robot)),
        ),
        ("Dynamics", ["coordinate", *_DYNAMICS], list(_dynamics(robot))),
        (
            "Loops",
            ["loop", "type", "mate", "first link", "second link", "open by", "redundant conditions"],
            _loops(robot),
        ),
        ("Masses", ["link", "mass", "share", "parts", "frames"], _masses(robot)),
    ]
    plain = [{"title": title, "header": header, "rows": rows} for title, header, rows in all_tables if rows]
    return json.dumps(plain, indent=1, ensure_ascii=False).encode()


def _mobility(robot: Robot) -> Rows:
    return [
        ["base", base_line(robot)],
        ["motion", mobility(robot)],
        ["coordinates of the tree", str(robot.mobility.coordinates)],
        ["degrees of freedom by Grübler", str(robot.mobility.gruebler)],
        ["degrees of freedom by rank", str(robot.mobility.dof)],
        ["redundant loop conditions", str(sum(number for _, number in robot.mobility.redundant))],
    ]


def _joints(robot: Robot) -> Iterator[list[str]]:
    rule_of_dof = rules(robot)
    for joint in robot.joints:
        yield from _joint(joint, rule_of_dof)


def _joint(joint: Joint, rule_of_dof: Mapping[str, str]) -> Iterator[list[str]]:
    """Yields a row for each dof, and a row for a joint without dofs."""
    joint_cells = [joint.type, joint.parent, joint.child]
    mate = "" if joint.mate is None else printable(joint.mate.name)
    if not joint.dofs:
        yield [joint.name, "", *joint_cells, *[""] * 4, mate]
    for dof in joint.dofs:
        rule = rule_of_dof.get(dof.name, "")
        name = "" if dof.name == joint.name else dof.name
        yield [joint.name, name, *joint_cells, _axis(dof), limits(dof), _saved(dof), rule, mate]


def _axis(dof: Dof) -> str:
    """Formats the axis in the frame of the joint; "" for a dof without an axis."""
    return " ".join(decimal(entry) for entry in dof.axis) if dof.kind in ("turn", "slide") else ""


def _saved(dof: Dof) -> str:
    if isinstance(dof.saved, tuple):
        return " ".join(decimal(entry) for entry in dof.saved)
    return value(dof, dof.saved)


def _dynamics(robot: Robot) -> Iterator[list[str]]:
    """Yields a row for each dof with dynamics."""
    for dof in robot.dofs:
        cells = _dynamics_cells(dof)
        if any(cells):
            yield [dof.name, *cells]


def _dynamics_cells(dof: Dof) -> list[str]:
    """Returns effort, velocity, damping, friction and armature of a dof as texts with units; "" for unset
    values."""
    turns = dof.kind != "slide"
    dynamics = dof.dynamics
    speed = None if dynamics.velocity is None else dynamics.velocity * (math.degrees(1.0) if turns else 1e3)
    quantities = (
        (dynamics.effort, "N m" if turns else "N"),
        (speed, "deg/s" if turns else "mm/s"),
        (dynamics.damping, "N m s/rad" if turns else "N s/m"),
        (dynamics.friction, "N m" if turns else "N"),
        (dynamics.armature, "kg m²" if turns else "kg"),
    )
    return ["" if amount is None else f"{decimal(amount)} {unit}" for amount, unit in quantities]


def _loops(robot: Robot) -> Rows:
    redundant = dict(robot.mobility.redundant)
    return [
        [
            loop.name,
            loop.type,
            printable(loop.mate.name),
            loop.link_a,
            loop.link_b,
            f"{loop.residual:.2g} m or rad",
            str(redundant.get(loop.name, 0)),
        ]
        for loop in robot.loops
    ]


def _masses(robot: Robot) -> Rows:
    """Returns a row for each link, and a row for the robot."""
    frames = frames_on(robot)
    total = sum(link.inertial.mass for link in robot.links)
    rows = [
        [
            link.name,
            kilograms(link.inertial.mass) + (" (given)" if link.given else ""),
            _share(link.inertial.mass, total),
            ", ".join(printable(leaf(part.name)) for part in link.parts),
            ", ".join(frames.get(link.name, [])),
        ]
        for link in robot.links
    ]
    parts = sum(len(link.parts) for link in robot.links)
    return [*rows, ["total", kilograms(total), _share(total, total), count(parts, "part"), ""]]


def _share(mass: float, total: float) -> str:
    return f"{100.0 * mass / total:.1f} %" if total > 0.0 else ""
