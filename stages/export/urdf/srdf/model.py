"""SRDF: groups, poses, and pairs of links that are not checked for collisions.

Element rules are those of srdfdom, MoveIt's own reader; names are those of the URDF.
"""

from collections.abc import Mapping
from dataclasses import dataclass

from linkwright.stages.export.urdf.srdf.disabled import Disabled, disabled_pairs
from linkwright.stages.export.urdf.srdf.distant_links import POSES
from linkwright.stages.export.urdf.srdf.groups import Groups, groups_of
from linkwright.stages.export.urdf.srdf.source_groups import source_groups
from linkwright.stages.export.urdf.srdf.states import states_of
from linkwright.stages.formats.robot_json.files import SrdfRecord
from linkwright.stages.formats.urdf.names import urdf_names
from linkwright.stages.formats.written import Written
from linkwright.stages.formats.xml import Element, comment, element, to_bytes
from linkwright.stages.robot.dynamics.passive import passive_dofs
from linkwright.stages.robot.model.robot import Robot
from linkwright.stages.robot.text.names import free

WORLD = "world"
"""What the base is fixed to, or flies in."""


@dataclass(frozen=True, slots=True)
class SrdfPlan:
    """What an SRDF says of a robot. `states`: by pose and joint of the URDF, the text of its value;
    `passive`: joints of the URDF; `loops`: whose links the URDF does not hold together."""

    groups: Groups
    states: Mapping[str, Mapping[str, str]]
    disabled: Disabled
    passive: tuple[str, ...]
    loops: tuple[str, ...]

    @property
    def record(self) -> SrdfRecord:
        """What robot.json tells of the SRDF."""
        never: dict[str, tuple[str, ...]] = {}
        for (one, other), reason in self.disabled.pairs:
            if reason == "Never":
                never[one] = (*never.get(one, ()), other)
        return SrdfRecord(never, tuple(one.name for one in self.groups.grippers))


def plan_of(written: Written) -> SrdfPlan:
    """What the SRDF beside the URDF says."""
    robot, described, names = written.robot, written.as_urdf.robot, written.urdf_names
    passive = passive_dofs(robot, described, written.actuation)
    return SrdfPlan(
        source_groups(written) if robot.semantics.groups else groups_of(described, passive),
        states_of(robot, names),
        disabled_pairs(written),
        tuple(name for dof in passive for name in names.turns.get(dof, (dof,))),
        tuple(loop.name for loop in robot.loops if loop.name not in written.urdf_form.closed),
    )


def write_srdf(robot: Robot, plan: SrdfPlan) -> bytes:
    """The robot's SRDF."""
    root = element(None, "robot", name=robot.name)
    _base(root, robot)
    for group in plan.groups.groups:
        node = element(root, "group", name=group.name)
        if group.tip:
            element(node, "chain", base_link=group.base, tip_link=group.tip)
        else:
            for joint in group.joints:
                element(node, "joint", name=joint)
    # Readers that know no groups keep one state of a name: that of the group with the most joints.
    for group in sorted(plan.groups.groups, key=lambda one: -len(one.joints)):
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
        where = ", where the source does not say so" if robot.semantics.disabled else ""
        told = f"Never{where}: apart in each of {POSES} seeded poses, with room for what lies between them"
        comment(root, told)
    for (one, other), reason in plan.disabled.pairs:
        element(root, "disable_collisions", link1=one, link2=other, reason=reason or None)
    return to_bytes(root)


def _base(root: Element, robot: Robot) -> None:
    """The joint by which the robot is in the world; a root link that is the world needs none."""
    if robot.root.name == WORLD:
        return
    taken = {joint.name for joint in robot.joints} | {dof.name for dof in robot.dofs}
    taken |= set(urdf_names(robot).holders.values())
    own = robot.semantics.virtual_joint
    element(
        root,
        "virtual_joint",
        name=free(own.name if own else "world_joint", taken),
        type="fixed" if robot.base.fixed else "floating",
        parent_frame=own.parent_frame if own else WORLD,
        child_link=robot.root.name,
    )
