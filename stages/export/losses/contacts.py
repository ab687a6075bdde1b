"""Lists losses of contacts: properties, and pairs of links that do or do not collide."""

from collections.abc import Iterable, Iterator
from typing import TYPE_CHECKING, Any

from linkwright.stages.export.losses.loss import Loss
from linkwright.stages.export.mjcf.contact.filters import MAX_CLASSES
from linkwright.stages.export.sdf.contacts import DEFAULT_BITS, MASK_BITS
from linkwright.stages.export.urdf.srdf.disabled import MAX_LINKS
from linkwright.stages.export.writer import Case
from linkwright.stages.robot.motion.adjacency import Pair
from linkwright.stages.robot.text.globs import name_list

if TYPE_CHECKING:
    from linkwright.stages.export.urdf.srdf.model import SrdfPlan


def _contact_properties(case: Case[Any]) -> Iterator[str]:
    """Yields, by link, the contact properties of its colliders that a format lacks. SDF and USD have
    friction; SDF has only sliding friction."""
    properties_of_link: dict[str, dict[str, None]] = {}
    for shape in case.written.shapes.shapes:
        if shape.contact is not None and shape.role == "collision":
            properties = [
                name for name in shape.contact.given() if case.format == "urdf" or name != "friction"
            ]
            friction = shape.contact.friction
            if case.format == "sdf" and friction is not None and any(friction[1:]):
                properties.insert(0, "friction (torsional, rolling)")
            if properties:
                properties_of_link.setdefault(shape.link, {}).update(dict.fromkeys(properties))
    return (f"{link}: {', '.join(properties)}" for link, properties in properties_of_link.items())


def _pairs(pairs: Iterable[Pair]) -> list[str]:
    return [f"{link_a} and {link_b}" for link_a, link_b in pairs]


def _touching_at_home(case: "Case[SrdfPlan]") -> list[str]:
    disabled = {pair for pair, _ in case.plan.disabled.pairs}
    touching = [(contact.link_a, contact.link_b) for contact in case.written.shapes.touching]
    return _pairs(pair for pair in touching if pair not in disabled)


def _no_self_contact(case: Case[Any]) -> bool:
    shapes = case.written.shapes
    return not shapes.self_contact and any(shape.role == "collision" for shape in shapes.shapes)


CONTACTS = (
    Loss(
        {"mjcf": "W-WIDE-EXCLUDE"},
        lambda case: _pairs(case.plan.widened_pairs),
        f"MuJoCo distinguishes {MAX_CLASSES} classes of the world's colliders, and more are needed, so these "
        "links collide with nothing of the world, although only some colliders should be excluded: {}",
        "use fewer colliders in `world`, or exclude other pairs in contact.exclude",
    ),
    Loss(
        {"urdf": "I-URDF-CONTACT"},
        _contact_properties,
        "URDF has no contact properties, so these are left out: {}",
        "use the MJCF",
        "; ".join,
    ),
    Loss(
        {"sdf": "I-SDF-CONTACT", "usd": "I-USD-CONTACT"},
        _contact_properties,
        "{format} has no such contact properties, so these are left out: {}",
        "use the MJCF",
        "; ".join,
    ),
    Loss(
        {"sdf": "I-SDF-SELF"},
        lambda case: case.written.shapes.self_contact and not case.plan.contacts.collides,
        f"{DEFAULT_BITS} bits of a mask do not suffice for the pairs of links that must not collide, so "
        "the SDF's links do not collide with each other at all",
        "use the MJCF where they must",
    ),
    Loss(
        {"sdf": "I-SDF-SELF"},
        lambda case: _pairs(case.plan.contacts.lost),
        f"{MASK_BITS} bits of a mask do not suffice to exclude only the pairs of links that must not "
        "collide, so these do not collide either: {}",
        "use the MJCF where they must",
        name_list,
    ),
    Loss(
        {"srdf": "I-SRDF-SELF"},
        _no_self_contact,
        "the links do not collide with each other (contact.self: none), so it is unknown which pairs always "
        "or never touch: MoveIt checks all pairs that no joint connects",
        "contact.self=auto finds them",
    ),
    Loss(
        {"srdf": "I-SRDF-MANY"},
        lambda case: not case.plan.disabled.has_distant_pairs,
        f"more than {MAX_LINKS} links collide, too many to find out which of them never meet: MoveIt checks "
        "all pairs that no joint connects",
    ),
    Loss(
        {"srdf": "I-SRDF-PARTLY"},
        lambda case: _pairs(case.plan.disabled.partial_pairs),
        "an SRDF can only exclude whole links, so these do not collide at all, although some of their "
        "colliders do in the MJCF: {}",
        "the MJCF excludes single colliders",
        "; ".join,
    ),
    Loss(
        {"srdf": "I-SRDF-TOUCH"},
        _touching_at_home,
        "these touch at home, where MoveIt refuses to plan from: {}",
        "choose another pose (`keyframes: {home: ...}`), or exclude them (`contact: {exclude: ...}`)",
        "; ".join,
    ),
)
