"""The section <contact> of an MJCF: bodies that do not collide, and those of their geoms that do.

A pair has none of the properties of its geoms, but MuJoCo's defaults; so it is given those with which MuJoCo
would let the two collide (its documentation, "Computation", on contact parameters): those of the geom with
the higher priority; of equal priority the larger `condim` and `friction`, the mean of `solref` and `solimp`,
or the smaller `solref` where one is direct (not above 0). Margins add up, as in MuJoCo since 3.5; before, the
larger counts where there is no pair.
"""

from collections.abc import Mapping

from linkwright.stages.export.mjcf.contact.filters import Filters, Geom
from linkwright.stages.formats.numbers import spaced
from linkwright.stages.formats.xml import Element, element
from linkwright.stages.robot.model.geom_form import ContactProperties

Vector = tuple[float, ...]

DEFAULT: Mapping[str, Vector] = {
    "friction": (1.0, 0.005, 0.0001),
    "condim": (3.0,),
    "solref": (0.02, 1.0),
    "solimp": (0.9, 0.95, 0.001, 0.5, 2.0),
    "margin": (0.0,),
    "priority": (0.0,),
}
"""MuJoCo's own for what a geom does not say."""


def write_contacts(
    root: Element,
    kept_apart: Filters,
    names: Mapping[Geom, str],
    contacts: Mapping[Geom, ContactProperties | None],
) -> None:
    """`names`, `contacts`: of the geoms that collide."""
    if not kept_apart.pairs:
        return
    contact = element(root, "contact")
    for one, other in kept_apart.kept:
        properties = _together(contacts[one], contacts[other])
        element(contact, "pair", geom1=names[one], geom2=names[other], **properties)
    for link, other_link in kept_apart.pairs:
        element(contact, "exclude", body1=link, body2=other_link)


def _together(one: ContactProperties | None, other: ContactProperties | None) -> dict[str, str]:
    """The attributes of a pair of geoms with these properties, as far as one of them has some."""
    given = [{} if contact is None else _vectors(contact) for contact in (one, other)]
    first, second = ({**DEFAULT, **own} for own in given)
    mixed = {key: _mixed(key, first, second) for key in DEFAULT if key in given[0] | given[1]}
    if "friction" in mixed:
        sliding, torsional, rolling = mixed["friction"]
        mixed["friction"] = (sliding, sliding, torsional, rolling, rolling)
    return {key: spaced(value) for key, value in mixed.items() if key != "priority"}


def _vectors(contact: ContactProperties) -> dict[str, Vector]:
    return {key: value if isinstance(value, tuple) else (value,) for key, value in contact.given().items()}


def _mixed(key: str, first: Mapping[str, Vector], second: Mapping[str, Vector]) -> Vector:
    one, other = first[key], second[key]
    if key == "margin":
        return (one[0] + other[0],)
    if first["priority"] != second["priority"]:
        return one if first["priority"] > second["priority"] else other
    pairs = list(zip(one, other, strict=True))
    if key in ("condim", "friction"):
        return tuple(max(pair) for pair in pairs)
    if key == "solref" and min(one[0], other[0]) <= 0:
        return tuple(min(pair) for pair in pairs)
    return tuple(sum(pair) / 2 for pair in pairs)
