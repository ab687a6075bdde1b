"""Parses an SRDF, by the element rules of srdfdom, MoveIt's own reader; names are those of the URDF."""

import math
from collections import Counter
from dataclasses import dataclass

from linkwright.stages.formats.xml import Element, Malformed, parse, tag

MAX_ELEMENTS = 100_000
"""Largest number of elements of a text that is read: humanoids have some thousand."""


@dataclass(frozen=True, slots=True)
class SrdfGroup:
    """A group of joints."""

    name: str
    joints: tuple[str, ...]
    links: tuple[str, ...]
    chains: tuple[tuple[str, str], ...]
    """(base, tip) links."""

    groups: tuple[str, ...]
    """The names of groups whose joints it includes."""


@dataclass(frozen=True, slots=True)
class SrdfState:
    """A pose of a group."""

    name: str
    group: str
    values: tuple[tuple[str, tuple[float, ...]], ...]
    """Joint → its values, a single value for a turn or slide."""


@dataclass(frozen=True, slots=True)
class SrdfEndEffector:
    """An end effector: a group of joints on a link of another group."""

    name: str
    group: str
    parent_link: str
    parent_group: str


@dataclass(frozen=True, slots=True)
class SrdfVirtualJoint:
    """A joint between a frame outside of the robot and a link."""

    name: str
    type: str
    parent_frame: str
    child_link: str


@dataclass(frozen=True, slots=True)
class Srdf:
    """The content of an SRDF."""

    groups: tuple[SrdfGroup, ...]
    states: tuple[SrdfState, ...]
    end_effectors: tuple[SrdfEndEffector, ...]
    virtual_joints: tuple[SrdfVirtualJoint, ...]
    passive: tuple[str, ...]
    """The joints that nothing drives."""

    disabled: tuple[tuple[str, str, str], ...]
    """(link, link, reason); the reason may be ""."""

    disabled_links: tuple[str, ...]
    """The links whose collisions with every link are disabled, except the pairs in `enabled`."""

    enabled: tuple[tuple[str, str], ...]
    """(link, link) that may collide although `disabled_links` has one of them."""

    left_out: tuple[str, ...]
    """The content that is not read, in words."""


_READ_TAGS = frozenset(
    (
        "group",
        "group_state",
        "end_effector",
        "virtual_joint",
        "passive_joint",
        "disable_collisions",
        "disable_default_collisions",
        "enable_collisions",
    )
)
"""The elements below the root that are read."""


def parse_srdf(data: bytes) -> Srdf:
    """Returns the content of an SRDF. Raises Malformed if it is not XML, its root is not <robot>, or it has
    too many elements."""
    root = parse(data)
    if tag(root) != "robot":
        raise Malformed("its root element is not <robot>")
    if sum(1 for _ in root.iter()) > MAX_ELEMENTS:
        raise Malformed(f"it has more than {MAX_ELEMENTS} elements")
    unread = Counter(tag(node) for node in root if tag(node) not in _READ_TAGS)
    left_out = [f"<{name}>" + (f" ({count} times)" if count > 1 else "") for name, count in unread.items()]
    states = []
    for node in root.iterchildren("group_state"):
        state, faults = _state(node)
        states.append(state)
        left_out += faults
    return Srdf(
        groups=tuple(map(_group, root.iterchildren("group"))),
        states=tuple(states),
        end_effectors=tuple(
            SrdfEndEffector(*_texts(node, "name", "group", "parent_link", "parent_group"))
            for node in root.iterchildren("end_effector")
        ),
        virtual_joints=tuple(
            SrdfVirtualJoint(*_texts(node, "name", "type", "parent_frame", "child_link"))
            for node in root.iterchildren("virtual_joint")
        ),
        passive=_names(root, "passive_joint"),
        disabled=tuple(
            (*_pair(node, "link1", "link2"), str(node.get("reason", "")))
            for node in root.iterchildren("disable_collisions")
        ),
        disabled_links=tuple(
            str(node.get("link", "")) for node in root.iterchildren("disable_default_collisions")
        ),
        enabled=tuple(_pair(node, "link1", "link2") for node in root.iterchildren("enable_collisions")),
        left_out=tuple(left_out),
    )


def _group(node: Element) -> SrdfGroup:
    return SrdfGroup(
        name=str(node.get("name", "")),
        joints=_names(node, "joint"),
        links=_names(node, "link"),
        chains=tuple(_pair(chain, "base_link", "tip_link") for chain in node.iterchildren("chain")),
        groups=_names(node, "group"),
    )


def _state(node: Element) -> tuple[SrdfState, list[str]]:
    """Returns a pose of a group, and its values that are not numbers, in words."""
    name, group = _pair(node, "name", "group")
    values = []
    left_out = []
    for joint in node.iterchildren("joint"):
        numbers = _numbers(joint.get("value", ""))
        if numbers:
            values.append((str(joint.get("name", "")), numbers))
        else:
            left_out.append(
                f"the value of {joint.get('name', '')} in the state {name}, which is not a number"
            )
    return SrdfState(name, group, tuple(values)), left_out


def _numbers(text: str) -> tuple[float, ...]:
    """Returns the finite numbers in a text; () if it has anything else."""
    try:
        numbers = tuple(float(word) for word in text.split())
    except ValueError:
        return ()
    return numbers if all(map(math.isfinite, numbers)) else ()


def _names(node: Element, kind: str) -> tuple[str, ...]:
    """Returns the names of the elements of this tag in an element."""
    return tuple(str(inner.get("name", "")) for inner in node.iterchildren(kind))


def _pair(node: Element, first_key: str, second_key: str) -> tuple[str, str]:
    """Returns two attributes of an element, "" for those that are missing."""
    return str(node.get(first_key, "")), str(node.get(second_key, ""))


def _texts(node: Element, *keys: str) -> tuple[str, ...]:
    """Returns the attributes of an element, "" for those that are missing."""
    return tuple(str(node.get(key, "")) for key in keys)
