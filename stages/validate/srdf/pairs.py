"""The pairs of links that an SRDF keeps from colliding, against the robot."""

from collections.abc import Iterator

from linkwright.stages.formats.urdf.contacts import Reason, known_pairs
from linkwright.stages.formats.xml import Element
from linkwright.stages.robot.check import Finding
from linkwright.stages.robot.model.geometry import Geometry
from linkwright.stages.validate.findings import differs, named
from linkwright.stages.validate.srdf.known import ReadSrdf, pair

Links = frozenset[str]
"""Of a pair."""

NEVER = "Never"

ALWAYS = ("Default", "Always")
"""Words of MoveIt's assistant for a pair that touches: at the start, and in all poses."""


def pairs(read: ReadSrdf) -> Iterator[Finding]:
    """Each pair that the robot keeps from colliding is there, with its reason; of others only those that
    never meet: as far as that is known, else as far as the robot does not say that they touch. Nothing where
    its shapes are unknown."""
    geometry = read.written.geometry
    if geometry is None:
        return
    given, _ = known_pairs(read.written)
    expected = {frozenset(one): reason for one, reason in given.items()}
    touching, srdf = _touching(read, geometry), read.written.srdf_form
    never = None if srdf is None else {frozenset(links) for links in srdf.never}
    known, seen = {*read.chains.links}, set[Links]()
    for node in read.root.findall("disable_collisions"):
        links = frozenset((node.get("link1", ""), node.get("link2", "")))
        if not links <= known:
            continue  # unknown, or of the user's own XML
        if links in seen:
            yield Finding(pair(node), "", "is there twice")
        else:
            apart = never is None or links in never
            yield from _otherwise(node, expected.get(links), links in touching, apart)
        seen.add(links)
    wanted = given if srdf is None else dict.fromkeys(sorted(srdf.never), NEVER) | given
    for one, reason in wanted.items():
        if frozenset(one) not in seen:
            element = named("disable_collisions", '" "'.join(one))
            yield Finding(element, "reason", f"there is none of these links, expected {reason}")
    for node in read.root.findall("disable_default_collisions"):
        element = named("disable_default_collisions", node.get("link", ""))
        yield Finding(element, "link", "lets all pass through the link, which the robot does not")


def _otherwise(node: Element, expected: Reason | None, touches: bool, never: bool) -> Iterator[Finding]:
    """What is wrong with a pair. `expected`: the robot's reason to keep it from colliding, None where it can
    only be that they never meet; `never`: whether it may be that."""
    reason = node.get("reason", "")
    if node.get("link1") == node.get("link2"):
        yield Finding(pair(node), "link2", "is the same link as link1")
    elif expected is not None:
        if reason != expected and not {reason, expected} <= {*ALWAYS}:
            yield differs(pair(node), "reason", reason, expected)
    elif reason != NEVER:
        words = f'is "{reason}", but nothing in the robot keeps these links from colliding'
        yield Finding(pair(node), "reason", words)
    elif touches:
        yield Finding(pair(node), "reason", f"is {NEVER}, but these links touch at home")
    elif not never:
        yield Finding(pair(node), "reason", f"is {NEVER}, but in some pose these links may meet")


def _touching(read: ReadSrdf, geometry: Geometry) -> set[Links]:
    """The links of the URDF that touch at `home`."""
    held = read.written.as_urdf.held
    return {frozenset((held[one.link_a][0], held[one.link_b][0])) for one in geometry.touching}
