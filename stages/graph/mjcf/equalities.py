"""Turns equalities that connect two bodies into connections that close loops; a pair can form a hinge."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from linkwright.stages.formats.mjcf.model import MjcfClosure
from linkwright.stages.graph.dofs import residual
from linkwright.stages.graph.mechanism import Connection
from linkwright.stages.robot.model.poses import inverse, quat_from_rotation
from linkwright.stages.robot.model.robot import (
    Array,
    Dof,
    DofKind,
    Dynamics,
    JointType,
    Limits,
    MateRef,
    Value,
    frozen,
)
from linkwright.stages.robot.motion.kinematics import chain

SECOND_POINT = "_axis"
"""Suffix of the sites of a hinge's second point."""


@dataclass(frozen=True, slots=True, eq=False)
class Closing:
    """A closure, or two that form a hinge."""

    closure: MjcfClosure
    axis: Array | None = None
    """Axis of the hinge (3,), the same in both its frames; None without a hinge."""


def closings(closures: Sequence[MjcfClosure]) -> tuple[Closing, ...]:
    """Returns the closures, where each pair of connects that forms a hinge is a single closing: `name`
    between sites `a`, `b` and `name_axis` between `a_axis`, `b_axis`, as our own files have them."""
    by_sites = {
        closure.sites: closure for closure in closures if closure.type == "connect" and all(closure.sites)
    }
    merged, spent = [], set[int]()
    for closure in closures:
        other = by_sites.get((closure.sites[0] + SECOND_POINT, closure.sites[1] + SECOND_POINT))
        is_pair = other is not None and other.name == closure.name + SECOND_POINT
        alike = other is not None and closure.attributes == other.attributes and closure.type == "connect"
        axis = _axis(closure, other) if other is not None and is_pair and alike else None
        if axis is not None:
            spent.add(id(other))
        merged.append(Closing(closure, axis))
    return tuple(closing for closing in merged if id(closing.closure) not in spent)


def _axis(first: MjcfClosure, second: MjcfClosure) -> Array | None:
    """Returns the axis of the hinge that two connects form; None where they do not form a hinge."""
    if first.bodies != second.bodies:
        return None
    ends = ((first.a_from_frame, second.a_from_frame), (first.b_from_frame, second.b_from_frame))
    along = [(inverse(first) @ second)[:3, 3] for first, second in ends]
    reach = float(np.linalg.norm(along[1]))
    if reach == 0 or float(np.linalg.norm(along[0] - along[1])) > 1e-9 * max(1.0, reach):
        return None
    return frozen(along[1] / reach)


def closing_sites(closings: Sequence[Closing]) -> frozenset[str]:
    """Returns the sites that exist only for a closure, by their names: `<name>_a`, `<name>_b` and those of a
    hinge's second point, as in our own files, where the exporter makes them again."""
    hidden: set[str] = set()
    for closing in closings:
        sites = closing.closure.sites
        if closing.closure.name and sites == (f"{closing.closure.name}_a", f"{closing.closure.name}_b"):
            hidden |= {*sites, *(() if closing.axis is None else (site + SECOND_POINT for site in sites))}
    return frozenset(hidden)


def connections(
    named_closings: Iterable[tuple[Closing, str, str]],
    numbers: Mapping[int, int],
    world_from_body: Mapping[int, Array],
) -> Iterator[Connection]:
    """Yields the closures as connections: a connect is a ball, a weld is fixed, a hinge's two connects are a
    turn.

    `named_closings`: each with its own name and that of its dof.
    """
    for closing, name, dof_name in named_closings:
        a, b = closing.closure.bodies
        first = world_from_body[a] @ closing.closure.a_from_frame
        second = world_from_body[b] @ closing.closure.b_from_frame
        relative = inverse(second) @ first
        kind, dofs = _joint(closing, dof_name, relative)
        explained = chain(dofs, {dof.name: dof.saved for dof in dofs})
        yield Connection(
            name=name,
            type=kind,
            bodies=(numbers[a], numbers[b]),
            world_from_frames=(frozen(first), frozen(second)),
            dofs=dofs,
            residual=residual(relative, explained),
            ref=MateRef((), name, closing.closure.name or name, closing.closure.type),
            title=name,
            closes=True,
            solref=_solref(closing.closure),
        )


def _solref(closure: MjcfClosure) -> tuple[float, float] | None:
    numbers = [float(number) for number in dict(closure.attributes).get("solref", "").split()]
    return (numbers[0], numbers[1]) if len(numbers) == 2 else None


def _joint(closing: Closing, name: str, relative: Array) -> tuple[JointType, tuple[Dof, ...]]:
    """Returns the type of joint that an equality represents, and its dof at the pose `relative` (4, 4)."""
    if closing.closure.type == "weld":
        return "fixed", ()
    quat = quat_from_rotation(relative[:3, :3])
    if closing.axis is None:
        w, x, y, z = (float(number) for number in quat)
        return "ball", (_dof(name, "ball", frozen(np.zeros(3)), (w, x, y, z)),)
    angle = 2.0 * float(np.arctan2(quat[1:] @ closing.axis, quat[0]))
    return "revolute", (_dof(name, "turn", closing.axis, angle),)


def _dof(name: str, kind: DofKind, axis: Array, saved: Value) -> Dof:
    return Dof(name, kind, axis, frozen(np.eye(4)), Limits(), Dynamics(), saved)
