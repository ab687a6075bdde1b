"""The package by which MoveIt plans for a robot: the SRDF in the names of the ROS package, and what goes with
its groups and joints.

MoveItConfigsBuilder of moveit_configs_utils finds its files by their names.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import chain as following

from linkwright.stages.export.ros2.description import Description
from linkwright.stages.export.ros2.files import filled
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
    solved = [count for count in semantics.chains.values() if count is not None and count >= LEAST]
    yield (
        "config/kinematics.yaml",
        filled("kinematics.yaml", chains=semantics.chains, solved=solved, least=LEAST, enough=ENOUGH),
    )
    limits = {
        joint: (_real(speed), _real(speed / TO_FULL_SPEED))
        for joint, speed in _speeds(semantics, description).items()
    }
    yield "config/joint_limits.yaml", filled("joint_limits.yaml", limits=limits, seconds=TO_FULL_SPEED)
    yield "config/pilz_cartesian_limits.yaml", filled("pilz_cartesian_limits.yaml")
    if trajectories:
        yield (
            "config/moveit_controllers.yaml",
            filled("moveit_controllers.yaml", trajectories=trajectories),
        )


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


def _speeds(semantics: Semantics, description: Description) -> dict[str, float]:
    """The speed limit [rad/s or m/s] of each joint that MoveIt moves."""
    passive = {str(one.get("name")) for one in semantics.root.iterchildren("passive_joint")}
    return {
        str(joint.get("name")): float(joint.find("limit").get("velocity"))
        for joint in description.moving
        if joint.find("mimic") is None and joint.get("name") not in passive
    }


def _real(value: float) -> str:
    """A number that YAML 1.1 and ROS take for a real one: with a point."""
    mantissa, _, power = repr(float(f"{value:.12g}")).partition("e")
    whole = mantissa if "." in mantissa else f"{mantissa}.0"
    return f"{whole}e{power}" if power else whole
