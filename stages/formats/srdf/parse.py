"""Reads an SRDF, by the element rules of srdfdom, MoveIt's own reader; names are those of the URDF."""

import math
from collections import Counter
from dataclasses import dataclass

from linkwright.stages.formats.xml import Element, Malformed, parse, tag

MOST = 100_000
"""A text with more elements is not read: humanoids have some thousand."""


@dataclass(frozen=True, slots=True)
class SrdfGroup:
    """`chains`: (base, tip) links; `groups`: the names of those whose joints it has too."""

    name: str
    joints: tuple[str, ...]
    links: tuple[str, ...]
    chains: tuple[tuple[str, str], ...]
    groups: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class SrdfState:
    """A pose of a group: joint → its values, one of a turn or slide."""

    name: str
    group: str
    values: tuple[tuple[str, tuple[float, ...]], ...]


@dataclass(frozen=True, slots=True)
class SrdfEndEffector:
    name: str
    group: str
    parent_link: str
    parent_group: str


@dataclass(frozen=True, slots=True)
class SrdfVirtualJoint:
    name: str
    type: str
    parent_frame: str
    child_link: str


@dataclass(frozen=True, slots=True)
class Srdf:
    """`disabled`: (link, link, reason), "" for no reason; `disabled_links`: those whose collisions with every
    link are disabled, but for the pairs in `enabled`. `left_out`: what is not read, in words."""

    groups: tuple[SrdfGroup, ...]
    states: tuple[SrdfState, ...]
    end_effectors: tuple[SrdfEndEffector, ...]
    virtual_joints: tuple[SrdfVirtualJoint, ...]
    passive: tuple[str, ...]
    disabled: tuple[tuple[str, str, str], ...]
    disabled_links: tuple[str, ...]
    enabled: tuple[tuple[str, str], ...]
    left_out: tuple[str, ...]


READ = frozenset(
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
    """What a text says; Malformed where it is not an SRDF."""
    root = parse(data)
    if tag(root) != "robot":
        raise Malformed("its root element is not <robot>")
    if sum(1 for _ in root.iter()) > MOST:
        raise Malformed(f"it has more than {MOST} elements")
    unread = Counter(tag(node) for node in root if tag(node) not in READ)
    left_out = [f"<{name}>" + (f" ({number} times)" if number > 1 else "") for name, number in unread.items()]
    states = [_state(node, left_out) for node in root.iterchildren("group_state")]
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
            (first, second, reason)
            for first, second, reason in (
                _texts(node, "link1", "link2", "reason") for node in root.iterchildren("disable_collisions")
            )
        ),
        disabled_links=tuple(
            str(node.get("link", "")) for node in root.iterchildren("disable_default_collisions")
        ),
        enabled=tuple(
            (first, second)
            for first, second in (
                _texts(node, "link1", "link2") for node in root.iterchildren("enable_collisions")
            )
        ),
        left_out=tuple(left_out),
    )


def _group(node: Element) -> SrdfGroup:
    chains = [_texts(chain, "base_link", "tip_link") for chain in node.iterchildren("chain")]
    return SrdfGroup(
        str(node.get("name", "")),
        _names(node, "joint"),
        _names(node, "link"),
        tuple((base, tip) for base, tip in chains),
        _names(node, "group"),
    )


def _state(node: Element, left_out: list[str]) -> SrdfState:
    name, group = _texts(node, "name", "group")
    values = []
    for joint in node.iterchildren("joint"):
        numbers = _numbers(joint.get("value", ""))
        if numbers:
            values.append((str(joint.get("name", "")), numbers))
        else:
            left_out.append(
                f"the value of {joint.get('name', '')} in the state {name}, which is not a number"
            )
    return SrdfState(name, group, tuple(values))


def _numbers(text: str) -> tuple[float, ...]:
    try:
        numbers = tuple(float(word) for word in text.split())
    except ValueError:
        return ()
    return numbers if all(map(math.isfinite, numbers)) else ()


def _names(node: Element, kind: str) -> tuple[str, ...]:
    return tuple(str(inner.get("name", "")) for inner in node.iterchildren(kind))


def _texts(node: Element, *keys: str) -> tuple[str, ...]:
    return tuple(str(node.get(key, "")) for key in keys)
