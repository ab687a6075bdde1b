"""The package by which MoveIt plans for a robot: the SRDF in the names of the ROS package, and what goes with
its groups and joints.

MoveItConfigsBuilder of moveit_configs_utils finds its files by their names.
"""

import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import chain as following

from linkwright.stages.export.ros2.description import Description
from linkwright.stages.export.ros2.names import legal_names
from linkwright.stages.formats.xml import Element, parse, to_bytes

ENOUGH = 6
"""Joints that a chain needs to reach any pose: with fewer only the place of its tip is asked for."""

LEAST = 3
"""Joints that a chain needs to reach any place; with fewer there is no inverse kinematics."""

TO_FULL_SPEED = 0.5
"""s: in which a joint reaches its full speed; nothing that a robot has says so."""

_LINKS = ("base_link", "tip_link", "child_link", "parent_link", "link1", "link2")
_GROUPS = ("group", "parent_group")


@dataclass(frozen=True, slots=True, eq=False)
class Semantics:
    """`root`: the SRDF in the names of the package. `chains`: by group, the joints that move of themselves,
    and None where nothing drives one of them. `joints`: by group, its joints. `grippers`: the groups that are
    end effectors, `arms`: those that carry one."""

    root: Element
    chains: Mapping[str, int | None]
    joints: Mapping[str, tuple[str, ...]]
    grippers: tuple[str, ...]
    arms: frozenset[str]
    world: str

    @property
    def groups(self) -> tuple[str, ...]:
        return tuple(self.joints)


def semantics_of(srdf: bytes, description: Description) -> Semantics:
    """The SRDF of a robot for its package."""
    root = parse(srdf, large=True)
    names = description.names
    groups, effectors = (
        legal_names([str(node.get("name")) for node in root.iterchildren(kind)], kind)
        for kind in ("group", "end_effector")
    )
    for node in root.iter(tag="*"):
        for key in _LINKS:
            if node.get(key):
                node.set(key, names.links.get(node.get(key), node.get(key)))
        for key in _GROUPS:
            if node.get(key):
                node.set(key, groups[node.get(key)])
        if node.tag == "group":
            node.set("name", groups[node.get("name")])
        elif node.tag == "end_effector":
            node.set("name", effectors[node.get("name")])
        elif node.tag in ("joint", "passive_joint"):
            node.set("name", names.joints.get(node.get("name"), node.get("name")))
    passive = {str(one.get("name")) for one in root.iterchildren("passive_joint")}
    chains = {
        str(group.get("name")): _own(_chain(description.root, chain), passive)
        for group in root.iterchildren("group")
        for chain in group.iterchildren("chain")
    }
    held = root.find("virtual_joint")
    joints = {
        str(group.get("name")): _joints(description.root, group) for group in root.iterchildren("group")
    }
    hands = list(root.iterchildren("end_effector"))
    # Some files have the arm itself as the group of its end effector.
    arms = {node.get("group") for node in hands if _moves(description.root, node, joints)}
    return Semantics(
        root,
        chains,
        joints,
        tuple(dict.fromkeys(node.get("group") for node in hands if node.get("group") not in arms)),
        frozenset(arms | {node.get("parent_group") for node in hands if node.get("parent_group")}),
        "" if held is None else held.get("parent_frame"),
    )


def semantic_files(
    name: str, semantics: Semantics, description: Description, trajectories: Mapping[str, Sequence[str]]
) -> Iterator[tuple[str, bytes]]:
    """(path in the package, bytes) of what MoveIt knows of a robot of this name. `trajectories`: the joints
    of each controller that follows trajectories."""
    yield f"config/{name}.srdf", to_bytes(semantics.root)
    yield "config/kinematics.yaml", _kinematics(semantics)
    yield "config/joint_limits.yaml", _joint_limits(semantics, description)
    yield "config/pilz_cartesian_limits.yaml", _CARTESIAN.encode()
    if trajectories:
        yield "config/moveit_controllers.yaml", _controllers(trajectories)


def setup_assistant(name: str, package: str, maintainer: str, email: str) -> bytes:
    """`.setup_assistant`, by which MoveIt's tools find the URDF, which is in `package`, and the SRDF."""
    lines = [
        "moveit_setup_assistant_config:",
        "  urdf:",
        f"    package: {json.dumps(package)}",
        f"    relative_path: {json.dumps(f'urdf/{name}.urdf.xacro')}",
        "  srdf:",
        f"    relative_path: {json.dumps(f'config/{name}.srdf')}",
        "  package_settings:",
        f"    author_name: {json.dumps(maintainer)}",
        f"    author_email: {json.dumps(email)}",
        "    generated_timestamp: 0",
    ]
    return _text(lines)


def _chain(urdf: Element, chain: Element) -> list[Element]:
    """The joints of the URDF from the tip of a chain up to its base."""
    return _above(urdf, chain.get("tip_link"), chain.get("base_link"))


def _above(urdf: Element, link: str, base: str = "") -> list[Element]:
    """The joints of the URDF above a link, up to the root or to another link."""
    above = {one.find("child").get("link"): one for one in urdf.iterchildren("joint")}
    joints: list[Element] = []
    while link != base and link in above:
        joints.append(above[link])
        link = above[link].find("parent").get("link")
    return joints


def _moves(urdf: Element, effector: Element, joints: Mapping[str, Sequence[str]]) -> bool:
    """Whether the group of an end effector moves the link that carries it."""
    group = joints[effector.get("group")]
    return any(joint.get("name") in group for joint in _above(urdf, effector.get("parent_link")))


def _joints(urdf: Element, group: Element) -> tuple[str, ...]:
    """The joints of a group, those of a chain from its base on."""
    chains = [_chain(urdf, chain)[::-1] for chain in group.iterchildren("chain")]
    joints = (*group.iterchildren("joint"), *following.from_iterable(chains))
    return tuple(dict.fromkeys(str(joint.get("name")) for joint in joints))


def _own(joints: Sequence[Element], passive: set[str]) -> int | None:
    """How many joints of a chain move of themselves; None where one is passive."""
    moving = [one for one in joints if one.get("type") != "fixed" and one.find("mimic") is None]
    return None if any(one.get("name") in passive for one in moving) else len(moving)


def _kinematics(semantics: Semantics) -> bytes:
    lines = [
        "# KDL solves any chain; other solvers (TRAC-IK, pick_ik, IKFast) are plugins of the same kind.",
    ]
    for group, count in semantics.chains.items():
        if count is None:
            lines.append(f"# {group}: no inverse kinematics, since a joint of the chain is passive.")
        elif count < LEAST:
            lines.append(f"# {group}: no inverse kinematics, since {count} joints reach too few places.")
        else:
            lines += [
                f"{json.dumps(group)}:",
                "  kinematics_solver: kdl_kinematics_plugin/KDLKinematicsPlugin",
                "  kinematics_solver_search_resolution: 0.005",
                "  kinematics_solver_timeout: 0.05",
            ]
            if count < ENOUGH:
                lines += ["  # Fewer than 6 joints reach no given orientation.", "  position_only_ik: true"]
    if not any(count is not None and count >= LEAST for count in semantics.chains.values()):
        lines.append("{}")
    return _text(lines)


def _joint_limits(semantics: Semantics, description: Description) -> bytes:
    passive = {str(one.get("name")) for one in semantics.root.iterchildren("passive_joint")}
    lines = [
        "# Speeds are those of the URDF. Nothing in the robot's model limits accelerations, so these are a",
        f"# default: a joint reaches its full speed in {TO_FULL_SPEED:g} s. Set what your hardware can do.",
        "default_velocity_scaling_factor: 0.1",
        "default_acceleration_scaling_factor: 0.1",
        "joint_limits:",
    ]
    for joint in description.moving:
        if joint.find("mimic") is None and joint.get("name") not in passive:
            speed = float(joint.find("limit").get("velocity"))
            lines += [
                f"  {json.dumps(joint.get('name'))}:",
                "    has_velocity_limits: true",
                f"    max_velocity: {_real(speed)}",
                "    has_acceleration_limits: true",
                f"    max_acceleration: {_real(speed / TO_FULL_SPEED)}",
            ]
    if lines[-1] == "joint_limits:":
        lines[-1] = "joint_limits: {}"
    return _text(lines)


_CARTESIAN = """# For Pilz' planner of straight lines and arcs: speeds of the tip [m/s, rad/s]. All of
# these are defaults of the assistant of MoveIt, and nothing that the robot has.
cartesian_limits:
  max_trans_vel: 1.0
  max_trans_acc: 2.25
  max_trans_dec: -5.0
  max_rot_vel: 1.57
"""


def _controllers(trajectories: Mapping[str, Sequence[str]]) -> bytes:
    lines = [
        "# The controllers of these names in controllers.yaml; each also takes a part of its joints.",
        "moveit_controller_manager: moveit_simple_controller_manager/MoveItSimpleControllerManager",
        "moveit_simple_controller_manager:",
        f"  controller_names: [{', '.join(trajectories)}]",
    ]
    for name, joints in trajectories.items():
        lines += [
            f"  {name}:",
            "    type: FollowJointTrajectory",
            "    action_ns: follow_joint_trajectory",
            "    default: true",
            f"    joints: {json.dumps(list(joints))}",
        ]
    return _text(lines)


def _real(value: float) -> str:
    """A number that YAML 1.1 and ROS take for a real one: with a point."""
    mantissa, _, power = repr(float(f"{value:.12g}")).partition("e")
    whole = mantissa if "." in mantissa else f"{mantissa}.0"
    return f"{whole}e{power}" if power else whole


def _text(lines: Sequence[str]) -> bytes:
    return ("\n".join(lines) + "\n").encode()
