"""The shapes of a robot.json, without the files of the meshes."""

from typing import Any, get_args

from stages.formats.robot_json.fields import Fields
from stages.formats.robot_json.links import colour_of, primitive_of
from stages.formats.robot_json.mjcf import texts_of
from stages.robot.geom_form import PLAIN, ContactProperties, GeomForm
from stages.robot.geometry import Exclude, ExcludeReason, Geometry, Role, Shape, Touch

ROLES, REASONS = get_args(Role), get_args(ExcludeReason)


def geometry_of(record: Fields) -> Geometry | None:
    """None where a build ended before it made shapes."""
    if not record.has("shapes"):
        return None
    return Geometry(
        shapes=tuple(_shape(one) for one in record.records("shapes")),
        files={},
        self_contact=record.truth("self_contact"),
        excludes=tuple(_exclude(one) for one in record.records("excludes")),
        touching=tuple(
            Touch(one.text("link_a"), one.text("link_b"), one.number("depth"))
            for one in record.records("touching")
        ),
    )


def _shape(record: Fields) -> Shape:
    primitive = primitive_of(record.inside("primitive")) if record.has("primitive") else None
    return Shape(
        link=record.text("link"),
        role=record.one_of("role", *ROLES),
        file=record.text("file") if record.has("file") else None,
        colour=colour_of(record),
        vertices=record.whole("vertices"),
        faces=record.whole("faces"),
        area=record.number("area"),
        volume=record.number("volume"),
        primitive=primitive,
        contact=_contact(record.inside("contact")) if record.has("contact") else None,
        texture=record.text("texture") if record.has("texture") else None,
        collider=record.whole("collider") if record.has("collider") else None,
        bounds=record.numbers("bounds", 6) if record.has("bounds") else (),
        form=_form(record.inside("geom")) if record.has("geom") else PLAIN,
        ellipsoid=primitive_of(record.inside("ellipsoid")) if record.has("ellipsoid") else None,
    )


def _contact(record: Fields) -> ContactProperties:
    lengths = {"friction": 3, "solref": 2, "solimp": 5}
    found: dict[str, Any] = {
        key: record.numbers(key, count) for key, count in lengths.items() if record.has(key)
    }
    wholes = ("condim", "priority", "contype", "conaffinity")
    found |= {key: record.whole(key) for key in wholes if record.has(key)}
    found |= {key: record.number(key) for key in ("margin", "solmix", "gap") if record.has(key)}
    return ContactProperties(**found)


def _form(record: Fields) -> GeomForm:
    return GeomForm(record.text("name"), attributes=texts_of(record, "attributes"))


def _exclude(record: Fields) -> Exclude:
    links = record.text("link_a"), record.text("link_b")
    pairs = [(int(first), int(second)) for first, second in record.pairs("geoms")]
    return Exclude(*links, record.one_of("reason", *REASONS), record.number("depth"), tuple(pairs))
