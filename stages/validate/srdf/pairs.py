"""Compares the pairs of links that an SRDF keeps from colliding with the robot's."""

from collections.abc import Iterator

from linkwright.stages.formats.urdf.contacts import Reason, excluded_pairs
from linkwright.stages.formats.xml import Element
from linkwright.stages.robot.check import Finding
from linkwright.stages.robot.model.geometry import Geometry
from linkwright.stages.validate.findings import differs, named
from linkwright.stages.validate.srdf.read_srdf import ReadSrdf, title_of_pair

Links = frozenset[str]
"""The two links of a pair."""

NEVER = "Never"
"""MoveIt's word for a pair that touches in no pose."""

TOUCH_REASONS = ("Default", "Always")
"""MoveIt's words for a pair that touches: at the start, and in all poses."""


def pair_findings(read: ReadSrdf) -> Iterator[Finding]:
    """Checks that each pair that the robot keeps from colliding is listed, with its reason.

    Further pairs must never meet, as far as that is known; otherwise they must not touch in the robot. Robots
    without known shapes are skipped.
    """
    geometry = read.written.geometry
    if geometry is None:
        return
    reasons, _ = excluded_pairs(read.written)
    expected = {frozenset(links): reason for links, reason in reasons.items()}
    touching, srdf = _touching(read, geometry), read.written.srdf_form
    # None: it is not known which pairs never meet.
    never_pairs = None if srdf is None else {frozenset(links) for links in srdf.never}
    link_names, listed_pairs = {*read.chains.links}, set[Links]()
    for node in read.root.findall("disable_collisions"):
        links = frozenset((node.get("link1", ""), node.get("link2", "")))
        if not links <= link_names:
            continue  # unknown, or of the user's own XML
        if links in listed_pairs:
            yield Finding(title_of_pair(node), "", "exists twice")
        else:
            may_be_never = never_pairs is None or links in never_pairs
            yield from _pair_differences(node, expected.get(links), links in touching, may_be_never)
        listed_pairs.add(links)
    required_pairs = reasons if srdf is None else dict.fromkeys(sorted(srdf.never), NEVER) | reasons
    for names, reason in required_pairs.items():
        if frozenset(names) not in listed_pairs:
            element = named("disable_collisions", '" "'.join(names))
            yield Finding(element, "reason", f"is missing, expected {reason}")
    for node in read.root.findall("disable_default_collisions"):
        element = named("disable_default_collisions", node.get("link", ""))
        yield Finding(element, "link", "lets everything pass through the link, which the robot does not")


def _pair_differences(
    node: Element, expected: Reason | None, touches: bool, may_be_never: bool
) -> Iterator[Finding]:
    """Yields the errors of a pair. `expected`: the robot's reason to keep it from colliding, None without a
    reason; `touches`: whether it touches at `home`; `may_be_never`: whether no pose is known in which it may
    meet."""
    reason = node.get("reason", "")
    if node.get("link1") == node.get("link2"):
        yield Finding(title_of_pair(node), "link2", "is the same link as link1")
    elif expected is not None:
        if reason != expected and not {reason, expected} <= {*TOUCH_REASONS}:
            yield differs(title_of_pair(node), "reason", reason, expected)
    elif reason != NEVER:
        message = f'is "{reason}", but nothing in the robot keeps these links from colliding'
        yield Finding(title_of_pair(node), "reason", message)
    elif touches:
        yield Finding(title_of_pair(node), "reason", f"is {NEVER}, but these links touch at home")
    elif not may_be_never:
        yield Finding(title_of_pair(node), "reason", f"is {NEVER}, but in some pose these links may meet")


def _touching(read: ReadSrdf, geometry: Geometry) -> set[Links]:
    """Returns the pairs of links of the URDF that touch at `home`."""
    holders = read.written.as_urdf.held
    return {frozenset((holders[touch.link_a][0], holders[touch.link_b][0])) for touch in geometry.touching}
