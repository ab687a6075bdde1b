"""Writes the package by which MoveIt plans for a robot: the SRDF in the names of the ROS package, and
settings of its groups and joints.

MoveItConfigsBuilder of moveit_configs_utils finds its files by their names.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import chain as chain_iterables

from linkwright.stages.export.ros2.description import Description
from linkwright.stages.export.ros2.files import fill_template
from linkwright.stages.export.ros2.names import legal_names
from linkwright.stages.formats.xml import Element, parse, to_bytes

MIN_POSE_JOINTS = 6
"""Smallest number of joints with which a chain reaches any pose: with fewer, only the position of its tip is
solved for."""

MIN_POSITION_JOINTS = 3
"""Smallest number of joints with which a chain reaches any position: with fewer, there is no inverse
kinematics."""

ACCELERATION_TIME = 0.5
"""Time [s] in which a joint reaches its full speed. It is an assumption, since a robot's files do not tell
it."""

_LINK_ATTRIBUTES = ("base_link", "tip_link", "child_link", "parent_link", "link1", "link2")
"""Attributes of an SRDF that name a link."""

_GROUP_ATTRIBUTES = ("group", "parent_group")
"""Attributes of an SRDF that name a group."""


@dataclass(frozen=True, slots=True, eq=False)
class Semantics:
    """The SRDF of a robot, in the names of its ROS package."""

    root: Element
    """The root element of the SRDF."""

    chains: Mapping[str, int | None]
    """Group that is a chain → the number of its driven joints; None if nothing drives one of its joints."""

    joints: Mapping[str, tuple[str, ...]]
    """Group → its joints."""

    grippers: tuple[str, ...]
    """The groups that are end effectors."""

    arms: frozenset[str]
    """The groups that carry an end effector."""

    world: str
    """The parent frame of the virtual joint; "" if the root link is the world."""

    @property
    def groups(self) -> tuple[str, ...]:
        """Returns the names of the groups."""
        return tuple(self.joints)


def semantics_of(srdf: bytes, description: Description) -> Semantics:
    """Returns the SRDF of a robot in the names of its package."""
    root = parse(srdf, large=True)
    _rename(root, description)
    passive_joints = _passive_joints(root)
    chains = {
        str(group.get("name")): _driven_joint_count(_joints_of_chain(description.root, chain), passive_joints)
        for group in root.iterchildren("group")
        for chain in group.iterchildren("chain")
    }
    virtual_joint = root.find("virtual_joint")
    joints = {
        str(group.get("name")): _joints_of_group(description.root, group)
        for group in root.iterchildren("group")
    }
    end_effectors = list(root.iterchildren("end_effector"))
    # Some files name the arm itself as the group of its end effector.
    own_groups = {
        node.get("group") for node in end_effectors if _moves_its_carrier(description.root, node, joints)
    }
    effector_groups = [node.get("group") for node in end_effectors if node.get("group") not in own_groups]
    parent_groups = {node.get("parent_group") for node in end_effectors if node.get("parent_group")}
    return Semantics(
        root=root,
        chains=chains,
        joints=joints,
        grippers=tuple(dict.fromkeys(effector_groups)),
        arms=frozenset(own_groups | parent_groups),
        world="" if virtual_joint is None else virtual_joint.get("parent_frame"),
    )


def _rename(root: Element, description: Description) -> None:
    """Gives the elements of an SRDF the names of the package."""
    names = description.names
    group_names, effector_names = (
        legal_names([str(node.get("name")) for node in root.iterchildren(kind)], kind)
        for kind in ("group", "end_effector")
    )
    for node in root.iter(tag="*"):
        for key in _LINK_ATTRIBUTES:
            if node.get(key):
                node.set(key, names.links.get(node.get(key), node.get(key)))
        for key in _GROUP_ATTRIBUTES:
            if node.get(key):
                node.set(key, group_names[node.get(key)])
        if node.tag == "group":
            node.set("name", group_names[node.get("name")])
        elif node.tag == "end_effector":
            node.set("name", effector_names[node.get("name")])
        elif node.tag in ("joint", "passive_joint"):
            node.set("name", names.joints.get(node.get("name"), node.get("name")))


def _passive_joints(root: Element) -> set[str]:
    """Returns the joints of an SRDF that nothing drives."""
    return {str(joint.get("name")) for joint in root.iterchildren("passive_joint")}


def semantic_files(
    name: str, semantics: Semantics, description: Description, trajectories: Mapping[str, Sequence[str]]
) -> Iterator[tuple[str, bytes]]:
    """Yields (path in the package, bytes) of MoveIt's settings for a robot of this name. `trajectories`: name
    of each controller that follows trajectories → its joints."""
    yield f"config/{name}.srdf", to_bytes(semantics.root)
    any_solved = any(
        count is not None and count >= MIN_POSITION_JOINTS for count in semantics.chains.values()
    )
    yield (
        "config/kinematics.yaml",
        fill_template(
            "kinematics.yaml",
            chains=semantics.chains,
            any_solved=any_solved,
            position_joints=MIN_POSITION_JOINTS,
            pose_joints=MIN_POSE_JOINTS,
        ),
    )
    limits = {
        joint: (_real_text(speed), _real_text(speed / ACCELERATION_TIME))
        for joint, speed in _speeds(semantics, description).items()
    }
    yield (
        "config/joint_limits.yaml",
        fill_template("joint_limits.yaml", limits=limits, seconds=ACCELERATION_TIME),
    )
    yield "config/pilz_cartesian_limits.yaml", fill_template("pilz_cartesian_limits.yaml")
    if trajectories:
        yield (
            "config/moveit_controllers.yaml",
            fill_template("moveit_controllers.yaml", trajectories=trajectories),
        )


def _joints_of_chain(urdf: Element, chain: Element) -> list[Element]:
    """Returns the joints of the URDF from the tip of a chain up to its base."""
    return _joints_above(urdf, chain.get("tip_link"), chain.get("base_link"))


def _joints_above(urdf: Element, link: str, base: str = "") -> list[Element]:
    """Returns the joints of the URDF above a link, from the link up to `base` or to the root."""
    joint_by_child = {joint.find("child").get("link"): joint for joint in urdf.iterchildren("joint")}
    joints: list[Element] = []
    while link != base and link in joint_by_child:
        joints.append(joint_by_child[link])
        link = joint_by_child[link].find("parent").get("link")
    return joints


def _moves_its_carrier(urdf: Element, effector: Element, joints: Mapping[str, Sequence[str]]) -> bool:
    """Tells whether the group of an end effector moves the link that carries the end effector. `joints`:
    group → its joints."""
    joints_of_group = joints[effector.get("group")]
    joints_above = _joints_above(urdf, effector.get("parent_link"))
    return any(joint.get("name") in joints_of_group for joint in joints_above)


def _joints_of_group(urdf: Element, group: Element) -> tuple[str, ...]:
    """Returns the joints of a group, those of a chain from its base on."""
    chains = [_joints_of_chain(urdf, chain)[::-1] for chain in group.iterchildren("chain")]
    joints = (*group.iterchildren("joint"), *chain_iterables.from_iterable(chains))
    return tuple(dict.fromkeys(str(joint.get("name")) for joint in joints))


def _driven_joint_count(joints: Sequence[Element], passive_joints: set[str]) -> int | None:
    """Returns the number of the driven joints of a chain, which are those that move and follow no other
    joint; None if one of these is passive."""
    moving = [joint for joint in joints if joint.get("type") != "fixed" and joint.find("mimic") is None]
    return None if any(joint.get("name") in passive_joints for joint in moving) else len(moving)


def _speeds(semantics: Semantics, description: Description) -> dict[str, float]:
    """Returns the speed limit [rad/s or m/s] of each joint that MoveIt moves."""
    passive_joints = _passive_joints(semantics.root)
    return {
        str(joint.get("name")): float(joint.find("limit").get("velocity"))
        for joint in description.moving
        if joint.find("mimic") is None and joint.get("name") not in passive_joints
    }


def _real_text(value: float) -> str:
    """Returns the text of a number with a point, so that YAML 1.1 and ROS read a real number."""
    mantissa, _, exponent = repr(float(f"{value:.12g}")).partition("e")
    decimal = mantissa if "." in mantissa else f"{mantissa}.0"
    return f"{decimal}e{exponent}" if exponent else decimal
