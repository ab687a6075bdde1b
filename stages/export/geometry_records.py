"""What robot.json says of the shapes that the mesh stage made, and of which of them touch."""

from collections import Counter
from collections.abc import Iterator
from typing import Any

from stages.export.json_values import as_float, short
from stages.export.link_records import colour_record, primitive_record
from stages.robot.codec import plain
from stages.robot.geom_form import ContactProperties
from stages.robot.geometry import Geometry, Shape


def geometry_records(geometry: Geometry) -> dict[str, Any]:
    """The tables `shapes`, `colliders`, `excludes` and `touching`, and `self_contact`."""
    numbers: Counter[tuple[str, str]] = Counter()
    shapes = []
    for shape in geometry.shapes:
        shapes.append(_shape(shape, numbers[shape.link, shape.role]))
        numbers[shape.link, shape.role] += 1
    return {
        "shapes": shapes,
        "colliders": list(_colliders(geometry)),
        "self_contact": geometry.self_contact,
        "excludes": [{**plain(one), "depth": short(one.depth)} for one in geometry.excludes],
        "touching": [{**plain(one), "depth": short(one.depth)} for one in geometry.touching],
    }


def _colliders(geometry: Geometry) -> Iterator[dict[str, Any]]:
    numbers: Counter[str] = Counter()
    for one in geometry.colliders:
        own = {"link": one.link, "number": numbers[one.link], "parts": list(one.parts)}
        yield own | {"made": one.rung, "reason": one.reason}
        numbers[one.link] += 1


def _shape(shape: Shape, number: int) -> dict[str, Any]:
    return {
        "link": shape.link,
        "role": shape.role,
        "number": number,
        "file": shape.file,
        "primitive": None if shape.primitive is None else primitive_record(shape.primitive),
        "colour": colour_record(shape.colour),
        "texture": shape.texture,
        "vertices": shape.vertices,
        "faces": shape.faces,
        "area": short(shape.area),
        "volume": short(shape.volume),
        "contact": None if shape.contact is None else _contact(shape.contact),
        "collider": shape.collider,
        "bounds": [short(one) for one in shape.bounds] or None,
        **_of_source(shape),
    }


def _of_source(shape: Shape) -> dict[str, Any]:
    """What an MJCF source says of the shape."""
    form, table = shape.form, dict[str, Any]()
    if form.name or form.attributes:
        table["geom"] = {"name": form.name, "attributes": dict(form.attributes)}
    if shape.ellipsoid is not None:
        table["ellipsoid"] = primitive_record(shape.ellipsoid)
    return table


def _contact(contact: ContactProperties) -> dict[str, Any]:
    return {
        key: [as_float(one) for one in value] if isinstance(value, tuple) else value
        for key, value in contact.given().items()
    }
