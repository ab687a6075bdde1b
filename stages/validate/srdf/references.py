"""Every link, joint and group that an SRDF names is there."""

from collections.abc import Iterator

from linkwright.stages.formats.xml import Element, tag
from linkwright.stages.robot.check import Finding
from linkwright.stages.robot.text.globs import did_you_mean
from linkwright.stages.validate.findings import named
from linkwright.stages.validate.srdf.known import ReadSrdf, pair, state

WHERE = (
    ("virtual_joint", "child_link", "link"),
    ("group/link", "name", "link"),
    ("group/joint", "name", "joint"),
    ("group/chain", "base_link", "link"),
    ("group/chain", "tip_link", "link"),
    ("group/group", "name", "group"),
    ("group_state", "group", "group"),
    ("group_state/joint", "name", "joint"),
    ("end_effector", "parent_link", "link"),
    ("end_effector", "group", "group"),
    ("end_effector", "parent_group", "group"),
    ("passive_joint", "name", "joint"),
    ("disable_collisions", "link1", "link"),
    ("disable_collisions", "link2", "link"),
    ("enable_collisions", "link1", "link"),
    ("enable_collisions", "link2", "link"),
    ("disable_default_collisions", "link", "link"),
    ("link_sphere_approximation", "link", "link"),
)
"""The elements below the root that name something: by what attribute, and what that is: of the URDF, or a
group of the SRDF."""

OPTIONAL = ("parent_group",)
"""Attributes that may be missing."""


def references(read: ReadSrdf) -> Iterator[Finding]:
    """What is named and is not there, with the nearest name that is."""
    known = {"link": read.links, "joint": read.joints, "group": frozenset(read.groups)}
    for path, attribute, kind in WHERE:
        for node in read.root.iterfind(path):
            name = node.get(attribute, "")
            if name not in known[kind] and (name or attribute not in OPTIONAL):
                near = did_you_mean(name, sorted(known[kind]))
                hint = f"; {near}" if near else ""
                inner = f"{tag(node)} " if "/" in path else ""
                element = _called(node.getparent() if inner else node)
                yield Finding(element, f"{inner}{attribute}", f'there is no {kind} "{name}"{hint}')


def _called(node: Element) -> str:
    if tag(node) == "group_state":
        return state(node)
    if node.get("link1") is not None:
        return pair(node)
    return named(tag(node), node.get("name") or node.get("link") or "")
