"""Writes the SRDF of a robot: groups, poses, and pairs of links that are not checked for collisions.

Element rules are those of srdfdom, MoveIt's own reader; names are those of the URDF.
"""

from collections.abc import Mapping
from dataclasses import dataclass

from linkwright.stages.export.urdf.srdf.disabled import DisabledPairs, disabled_pairs
from linkwright.stages.export.urdf.srdf.distant_links import POSE_COUNT
from linkwright.stages.export.urdf.srdf.groups import Groups, groups_of
from linkwright.stages.export.urdf.srdf.source_groups import source_groups
from linkwright.stages.export.urdf.srdf.states import states_of
from linkwright.stages.formats.robot_json.files import SrdfRecord
from linkwright.stages.formats.urdf.names import urdf_names
from linkwright.stages.formats.written import Written
from linkwright.stages.formats.xml import Element, comment, element, to_bytes
from linkwright.stages.robot.dynamics.passive import passive_dofs
from linkwright.stages.robot.model.robot import Robot
from linkwright.stages.robot.text.names import free_name

WORLD = "world"
"""Name of the frame to which the base is fixed, or in which it floats."""


@dataclass(frozen=True, slots=True)
class SrdfPlan:
    """The content of an SRDF, by the names of the URDF."""

    groups: Groups

    states: Mapping[str, Mapping[str, str]]
    """Pose → joint of the URDF → the text of its value."""

    disabled: DisabledPairs

    passive: tuple[str, ...]
    """The joints of the URDF that nothing drives."""

    loops: tuple[str, ...]
    """The loops whose links the URDF does not hold together."""

    @property
    def record(self) -> SrdfRecord:
        """Returns the entry of the SRDF in robot.json."""
        never: dict[str, tuple[str, ...]] = {}
        for (first, second), reason in self.disabled.pairs:
            if reason == "Never":
                never[first] = (*never.get(first, ()), second)
        return SrdfRecord(never, tuple(gripper.name for gripper in self.groups.grippers))


def plan_of(written: Written) -> SrdfPlan:
    """Returns the content of the SRDF beside the URDF."""
    robot, urdf_robot, names = written.robot, written.as_urdf.robot, written.urdf_names
    passive = passive_dofs(robot, urdf_robot, written.actuation)
    return SrdfPlan(
        source_groups(written) if robot.semantics.groups else groups_of(urdf_robot, passive),
        states_of(robot, names),
        disabled_pairs(written),
        tuple(name for dof in passive for name in names.turns.get(dof, (dof,))),
        tuple(loop.name for loop in robot.loops if loop.name not in written.urdf_form.closed),
    )


def write_srdf(robot: Robot, plan: SrdfPlan) -> bytes:
    """Returns the robot's SRDF."""
    root = element(None, "robot", name=robot.name)
    _write_virtual_joint(root, robot)
    for group in plan.groups.groups:
        node = element(root, "group", name=group.name)
        if group.tip:
            element(node, "chain", base_link=group.base, tip_link=group.tip)
        else:
            for joint in group.joints:
                element(node, "joint", name=joint)
    # Readers that ignore groups keep the first state of each name, so the group with the most joints is
    # first.
    for group in sorted(plan.groups.groups, key=lambda candidate: -len(candidate.joints)):
        for name, values in plan.states.items():
            state = element(root, "group_state", name=name, group=group.name)
            for joint in group.joints:
                element(state, "joint", name=joint, value=values[joint])
    for gripper in plan.groups.grippers:
        element(
            root,
            "end_effector",
            name=gripper.name,
            parent_link=gripper.parent_link,
            group=gripper.group,
            parent_group=gripper.arm or None,
        )
    for joint in plan.passive:
        element(root, "passive_joint", name=joint)
    if any(reason == "Never" for _, reason in plan.disabled.pairs):
        # The source's SRDF may name pairs that never meet: sampled poses are no reason for these.
        where = ", where the source does not say so" if robot.semantics.disabled else ""
        text = (
            f"Never{where}: apart in each of {POSE_COUNT} seeded poses, with room for what lies between them"
        )
        comment(root, text)
    for (first, second), reason in plan.disabled.pairs:
        element(root, "disable_collisions", link1=first, link2=second, reason=reason or None)
    return to_bytes(root)


def _write_virtual_joint(root: Element, robot: Robot) -> None:
    """Writes the joint that connects the robot to the world, unless its root link is the world."""
    if robot.root.name == WORLD:
        return
    joint_names = {joint.name for joint in robot.joints} | {dof.name for dof in robot.dofs}
    joint_names |= set(urdf_names(robot).holders.values())
    virtual_joint = robot.semantics.virtual_joint
    element(
        root,
        "virtual_joint",
        name=free_name(virtual_joint.name if virtual_joint else "world_joint", joint_names),
        type="fixed" if robot.base.fixed else "floating",
        parent_frame=virtual_joint.parent_frame if virtual_joint else WORLD,
        child_link=robot.root.name,
    )
