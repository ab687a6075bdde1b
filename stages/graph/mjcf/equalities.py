"""Equalities that connect two bodies: they close loops, and a pair of connects can form a hinge."""

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
    """One closure, or two that are a hinge about `axis` (3,), the same in both its frames."""

    closure: MjcfClosure
    axis: Array | None = None


def closings(closures: Sequence[MjcfClosure]) -> tuple[Closing, ...]:
    """The closures, with each pair of connects that makes a hinge as one: `name` between sites `a`, `b` and
    `name_axis` between `a_axis`, `b_axis`, as our own files have them."""
    by_sites = {one.sites: one for one in closures if one.type == "connect" and all(one.sites)}
    found, spent = [], set[int]()
    for one in closures:
        other = by_sites.get((one.sites[0] + SECOND_POINT, one.sites[1] + SECOND_POINT))
        named = other is not None and other.name == one.name + SECOND_POINT
        alike = other is not None and one.attributes == other.attributes and one.type == "connect"
        axis = _axis(one, other) if other is not None and named and alike else None
        if axis is not None:
            spent.add(id(other))
        found.append(Closing(one, axis))
    return tuple(one for one in found if id(one.closure) not in spent)


def _axis(one: MjcfClosure, other: MjcfClosure) -> Array | None:
    """The axis of the hinge that two connects form; None where they do not form a hinge."""
    if one.bodies != other.bodies:
        return None
    ends = ((one.a_from_frame, other.a_from_frame), (one.b_from_frame, other.b_from_frame))
    along = [(inverse(first) @ second)[:3, 3] for first, second in ends]
    reach = float(np.linalg.norm(along[1]))
    if reach == 0 or float(np.linalg.norm(along[0] - along[1])) > 1e-9 * max(1.0, reach):
        return None
    return frozen(along[1] / reach)


def own_sites(found: Sequence[Closing]) -> frozenset[str]:
    """The sites that exist only for a closure, by their names: `<name>_a`, `<name>_b` and those of a
    hinge's second point, as in our own files, where the exporter makes them again."""
    own: set[str] = set()
    for one in found:
        sites = one.closure.sites
        if one.closure.name and sites == (f"{one.closure.name}_a", f"{one.closure.name}_b"):
            own |= {*sites, *(() if one.axis is None else (site + SECOND_POINT for site in sites))}
    return frozenset(own)


def connections(
    found: Iterable[tuple[Closing, str, str]],
    numbers: Mapping[int, int],
    world_from_body: Mapping[int, Array],
) -> Iterator[Connection]:
    """The closures as connections: a connect is a ball, a weld is fixed, a hinge's two connects are a turn.

    `found`: each with its own name and that of its dof.
    """
    for one, name, dof_name in found:
        a, b = one.closure.bodies
        first = world_from_body[a] @ one.closure.a_from_frame
        second = world_from_body[b] @ one.closure.b_from_frame
        relative = inverse(second) @ first
        kind, dofs = _joint(one, dof_name, relative)
        explained = chain(dofs, {dof.name: dof.saved for dof in dofs})
        yield Connection(
            name=name,
            type=kind,
            bodies=(numbers[a], numbers[b]),
            world_from_frames=(frozen(first), frozen(second)),
            dofs=dofs,
            residual=residual(relative, explained),
            ref=MateRef((), name, one.closure.name or name, one.closure.type),
            title=name,
            closes=True,
            solref=_solref(one.closure),
        )


def _solref(closure: MjcfClosure) -> tuple[float, float] | None:
    numbers = [float(number) for number in dict(closure.attributes).get("solref", "").split()]
    return (numbers[0], numbers[1]) if len(numbers) == 2 else None


def _joint(one: Closing, name: str, relative: Array) -> tuple[JointType, tuple[Dof, ...]]:
    """The type of joint that an equality stands for, and its dof at the pose `relative` (4, 4)."""
    if one.closure.type == "weld":
        return "fixed", ()
    quat = quat_from_rotation(relative[:3, :3])
    if one.axis is None:
        w, x, y, z = (float(number) for number in quat)
        return "ball", (_dof(name, "ball", frozen(np.zeros(3)), (w, x, y, z)),)
    angle = 2.0 * float(np.arctan2(quat[1:] @ one.axis, quat[0]))
    return "revolute", (_dof(name, "turn", one.axis, angle),)


def _dof(name: str, kind: DofKind, axis: Array, saved: Value) -> Dof:
    return Dof(name, kind, axis, frozen(np.eye(4)), Limits(), Dynamics(), saved)
