"""Checks that every link, joint and group that an SRDF names exists."""

from collections.abc import Iterator

from linkwright.stages.formats.xml import Element, tag
from linkwright.stages.robot.check import Finding
from linkwright.stages.robot.text.globs import did_you_mean
from linkwright.stages.validate.findings import named
from linkwright.stages.validate.srdf.read_srdf import ReadSrdf, title_of_pair, title_of_state

REFERENCES = (
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
"""Path of an element that names something, the attribute, and the kind of thing: a link or joint of the URDF,
or a group of the SRDF."""

OPTIONAL_ATTRIBUTES = ("parent_group",)
"""Attributes that may be missing."""


def reference_findings(read: ReadSrdf) -> Iterator[Finding]:
    """Yields the names of links, joints and groups that do not exist, with the nearest name that does."""
    names = {"link": read.links, "joint": read.joints, "group": frozenset(read.groups)}
    for path, attribute, kind in REFERENCES:
        for node in read.root.iterfind(path):
            name = node.get(attribute, "")
            if name not in names[kind] and (name or attribute not in OPTIONAL_ATTRIBUTES):
                nearest = did_you_mean(name, sorted(names[kind]))
                hint = f"; {nearest}" if nearest else ""
                is_inner = "/" in path
                element = _title(node.getparent() if is_inner else node)
                title = f"{tag(node)} {attribute}" if is_inner else attribute
                yield Finding(element, title, f'there is no {kind} "{name}"{hint}')


def _title(node: Element) -> str:
    """Returns the title of an element of the SRDF in findings."""
    if tag(node) == "group_state":
        return title_of_state(node)
    if node.get("link1") is not None:
        return title_of_pair(node)
    return named(tag(node), node.get("name") or node.get("link") or "")
