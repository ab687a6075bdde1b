"""Writes the section <contact> of an MJCF: pairs of bodies that are excluded from contact, and pairs of their
geoms that collide nevertheless.

A pair does not inherit the properties of its geoms. It is written with the properties that MuJoCo would
compute for their contact (its documentation, "Computation", on contact parameters): those of the geom with
the higher priority; with equal priority the larger `condim` and `friction`, and the mean of `solref` and
`solimp`, or the smaller `solref` if one of them is direct (not above 0). Margins add up, as in MuJoCo since
3.5; without a pair, older versions use the larger margin.
"""

from collections.abc import Mapping

from linkwright.stages.export.mjcf.contact.filters import Filters, Geom
from linkwright.stages.formats.numbers import spaced
from linkwright.stages.formats.xml import Element, element
from linkwright.stages.robot.model.geom_form import ContactProperties

Vector = tuple[float, ...]
"""The numbers of a contact attribute."""

GEOM_DEFAULTS: Mapping[str, Vector] = {
    "friction": (1.0, 0.005, 0.0001),
    "condim": (3.0,),
    "solref": (0.02, 1.0),
    "solimp": (0.9, 0.95, 0.001, 0.5, 2.0),
    "margin": (0.0,),
    "priority": (0.0,),
}
"""MuJoCo's defaults for the properties of a geom."""


def write_contacts(
    root: Element,
    contact_filters: Filters,
    names: Mapping[Geom, str],
    contacts: Mapping[Geom, ContactProperties | None],
) -> None:
    """Writes the excluded bodies and the colliding pairs. `names`, `contacts`: collider → its name, and its
    contact properties."""
    if not contact_filters.excluded_pairs:
        return
    contact = element(root, "contact")
    for first, second in contact_filters.colliding_geoms:
        properties = _pair_attributes(contacts[first], contacts[second])
        element(contact, "pair", geom1=names[first], geom2=names[second], **properties)
    for link, other_link in contact_filters.excluded_pairs:
        element(contact, "exclude", body1=link, body2=other_link)


def _pair_attributes(
    first_contact: ContactProperties | None, second_contact: ContactProperties | None
) -> dict[str, str]:
    """Returns the attributes of a pair of geoms, for the properties that either of them sets."""
    properties = [{} if contact is None else _vectors(contact) for contact in (first_contact, second_contact)]
    first, second = ({**GEOM_DEFAULTS, **geom_properties} for geom_properties in properties)
    set_keys = properties[0].keys() | properties[1].keys()
    mixed = {key: _mixed_value(key, first, second) for key in GEOM_DEFAULTS if key in set_keys}
    if "friction" in mixed:
        # A pair has friction for two tangents and two rolling axes.
        sliding, torsional, rolling = mixed["friction"]
        mixed["friction"] = (sliding, sliding, torsional, rolling, rolling)
    return {key: spaced(value) for key, value in mixed.items() if key != "priority"}


def _vectors(contact: ContactProperties) -> dict[str, Vector]:
    """Returns the properties that are set, each as a vector."""
    return {key: value if isinstance(value, tuple) else (value,) for key, value in contact.given().items()}


def _mixed_value(key: str, first: Mapping[str, Vector], second: Mapping[str, Vector]) -> Vector:
    """Returns the value of an attribute that MuJoCo computes for the contact of two geoms, from the
    attributes of both."""
    first_value, second_value = first[key], second[key]
    if key == "margin":
        return (first_value[0] + second_value[0],)
    if first["priority"] != second["priority"]:
        return first_value if first["priority"] > second["priority"] else second_value
    pairs = list(zip(first_value, second_value, strict=True))
    if key in ("condim", "friction"):
        return tuple(max(pair) for pair in pairs)
    if key == "solref" and min(first_value[0], second_value[0]) <= 0:
        return tuple(min(pair) for pair in pairs)
    return tuple(sum(pair) / 2 for pair in pairs)
