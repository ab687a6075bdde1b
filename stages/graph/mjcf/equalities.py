"""Turns equalities that connect two bodies into connections that close loops; two connects can form a
hinge."""

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

SECOND_POINT_SUFFIX = "_axis"
"""Suffix of the names of a hinge's second connect and of its sites, in files that Linkwright wrote."""

MAX_SECOND_POINT_DISTANCE = 1e-9
"""Largest distance [m] between the second points of a hinge, one on each of its bodies; for an axis longer
than 1 m, as a share of its length."""


@dataclass(frozen=True, slots=True, eq=False)
class ClosureJoint:
    """The joint that a closure represents, or a hinge that two connects represent together."""

    closure: MjcfClosure
    """The closure; for a hinge, its first connect."""

    axis: Array | None = None
    """Axis of the hinge, a unit vector (3,), the same in both frames of the closure; None without a hinge."""


def joints_of_closures(closures: Sequence[MjcfClosure]) -> tuple[ClosureJoint, ...]:
    """Returns the joints that closures represent, in the order of the file.

    In files that Linkwright wrote, a hinge is two connects: `name` between the sites `a` and `b`, and
    `name_axis` between the sites `a_axis` and `b_axis`.
    """
    connects_by_sites = {
        closure.sites: closure for closure in closures if closure.type == "connect" and all(closure.sites)
    }
    joints, second_connect_ids = [], set[int]()
    for closure in closures:
        first_site, second_site = closure.sites
        partner = connects_by_sites.get((first_site + SECOND_POINT_SUFFIX, second_site + SECOND_POINT_SUFFIX))
        axis = None if partner is None else _hinge_axis(closure, partner)
        if axis is not None:
            second_connect_ids.add(id(partner))
        joints.append(ClosureJoint(closure, axis))
    return tuple(joint for joint in joints if id(joint.closure) not in second_connect_ids)


def _hinge_axis(first: MjcfClosure, second: MjcfClosure) -> Array | None:
    """Returns the axis (3,) of the hinge that two connects form; None if they do not form a hinge. `second`
    is a connect, `first` any closure."""
    if (
        first.type != "connect"
        or second.name != first.name + SECOND_POINT_SUFFIX
        or second.attributes != first.attributes
        or second.bodies != first.bodies
    ):
        return None
    # The second point in the frame of the first, on each body.
    second_point_on_a = (inverse(first.a_from_frame) @ second.a_from_frame)[:3, 3]
    second_point_on_b = (inverse(first.b_from_frame) @ second.b_from_frame)[:3, 3]
    length = float(np.linalg.norm(second_point_on_b))
    distance = float(np.linalg.norm(second_point_on_a - second_point_on_b))
    if length == 0 or distance > MAX_SECOND_POINT_DISTANCE * max(1.0, length):
        return None
    return frozen(second_point_on_b / length)


def closing_sites(closure_joints: Sequence[ClosureJoint]) -> frozenset[str]:
    """Returns the names of the sites that exist only for a closure, and that the exporter makes again.

    These are `<name>_a` and `<name>_b` of a closure `name`, as Linkwright writes them, and the sites of a
    hinge's second point.
    """
    names: set[str] = set()
    for joint in closure_joints:
        sites = joint.closure.sites
        if joint.closure.name and sites == (f"{joint.closure.name}_a", f"{joint.closure.name}_b"):
            names |= {*sites}
            if joint.axis is not None:
                names |= {site + SECOND_POINT_SUFFIX for site in sites}
    return frozenset(names)


def connections(
    named_joints: Iterable[tuple[ClosureJoint, str, str]],
    index_of: Mapping[int, int],
    world_from_body: Mapping[int, Array],
) -> Iterator[Connection]:
    """Yields the joints of closures as connections: a weld is fixed, a hinge turns, a single connect is a
    ball.

    `named_joints`: (joint, its name, the name of its dof). `index_of`: body of the MJCF → its index
    among the mechanism's bodies. `world_from_body`: body of the MJCF → its pose (4, 4).
    """
    for joint, name, dof_name in named_joints:
        closure = joint.closure
        body_a, body_b = closure.bodies
        world_from_frame_a = world_from_body[body_a] @ closure.a_from_frame
        world_from_frame_b = world_from_body[body_b] @ closure.b_from_frame
        frame_b_from_frame_a = inverse(world_from_frame_b) @ world_from_frame_a
        joint_type, dofs = _type_and_dofs(joint, dof_name, frame_b_from_frame_a)
        frame_b_from_frame_a_by_dofs = chain(dofs, {dof.name: dof.saved for dof in dofs})
        yield Connection(
            name=name,
            type=joint_type,
            bodies=(index_of[body_a], index_of[body_b]),
            world_from_frames=(frozen(world_from_frame_a), frozen(world_from_frame_b)),
            dofs=dofs,
            residual=residual(frame_b_from_frame_a, frame_b_from_frame_a_by_dofs),
            ref=MateRef((), name, closure.name or name, closure.type),
            title=name,
            closes=True,
            solref=_solref(closure),
        )


def _solref(closure: MjcfClosure) -> tuple[float, float] | None:
    """Returns MuJoCo's `solref` of a closure; None unless the file has both of its numbers."""
    numbers = [float(number) for number in dict(closure.attributes).get("solref", "").split()]
    return (numbers[0], numbers[1]) if len(numbers) == 2 else None


def _type_and_dofs(
    joint: ClosureJoint, dof_name: str, frame_b_from_frame_a: Array
) -> tuple[JointType, tuple[Dof, ...]]:
    """Returns the type of the joint of a closure, and its dofs. Their saved values follow from the pose
    `frame_b_from_frame_a` (4, 4) of the closure's frames on its bodies a and b."""
    if joint.closure.type == "weld":
        return "fixed", ()
    quat = quat_from_rotation(frame_b_from_frame_a[:3, :3])
    if joint.axis is None:
        w, x, y, z = (float(number) for number in quat)
        return "ball", (_dof(dof_name, "ball", frozen(np.zeros(3)), (w, x, y, z)),)
    # A turn by the angle t about the unit axis u is the quaternion (cos t/2, u sin t/2).
    angle = 2.0 * float(np.arctan2(quat[1:] @ joint.axis, quat[0]))
    return "revolute", (_dof(dof_name, "turn", joint.axis, angle),)


def _dof(name: str, kind: DofKind, axis: Array, saved: Value) -> Dof:
    return Dof(name, kind, axis, frozen(np.eye(4)), Limits(), Dynamics(), saved)
