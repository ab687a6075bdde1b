"""What is reported of links whose colliders touch where the links do not."""

from collections.abc import Iterator, Sequence

from linkwright.stages.mesh.by_contact.request import FalsePair
from linkwright.stages.robot.errors import Diagnostic
from linkwright.stages.robot.text.globs import as_key


def false_contacts(pairs: Sequence[FalsePair]) -> Iterator[Diagnostic]:
    """W-FALSE-CONTACT for each link of such pairs, with the pairs that no link before it named."""
    told: dict[str, list[FalsePair]] = {}
    for pair in pairs:
        told.setdefault(pair.one if pair.one in told or pair.other not in told else pair.other, []).append(
            pair
        )
    for link, own in told.items():
        said = "; ".join(_said(link, pair) for pair in own)
        lines = ", ".join(f"[{as_key(pair.one)}, {as_key(pair.other)}]" for pair in own)
        yield Diagnostic(
            "W-FALSE-CONTACT",
            f"the collider of {link} touches where the link does not: {said}",
            link,
            f"to let them pass through each other: `contact: {{exclude: [{lines}]}}`; or a collider by hand "
            "in mesh.colliders",
        )


def _said(link: str, pair: FalsePair) -> str:
    where = "at home" if pair.home else f"in {100 * pair.share:.2g} % of poses"
    return f"{pair.beside(link)}, {where}, by up to {1e3 * pair.depth:.2g} mm"
