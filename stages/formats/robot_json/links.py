"""Links of robot.json: mass properties, CAD's parts, and the user's own shapes."""

import numpy as np

from stages.formats.robot_json.fields import Fields
from stages.robot.model import Array, Inertial, Link, Part, Primitive, frozen

MIRROR = np.diag([1.0, 1.0, -1.0, 1.0])
"""What takes the right-handed pose that is written of a mirrored part to its own (4, 4)."""

KINDS = ("box", "sphere", "cylinder", "capsule", "ellipsoid")


def link_of(record: Fields) -> Link:
    inertial = inertial_of(record)
    cad = record.inside("cad") if record.has("cad") else None
    return Link(
        name=record.text("name"),
        inertial=inertial,
        parts=tuple(_part(one) for one in record.records("parts")),
        path=() if cad is None else cad.texts("path"),
        given=inertial if record.truth("given") else None,
        shapes=tuple(_shape(one) for one in record.records("shapes")),
    )


def inertial_of(record: Fields) -> Inertial:
    return Inertial(record.number("mass"), record.vector("com"), record.tensor("inertia"))


def primitive_of(
    record: Fields,
    colour: tuple[float, float, float, float] | None = None,
    visual: bool = True,
    collision: bool = True,
) -> Primitive:
    kind = record.one_of("kind", *KINDS)
    return Primitive(kind, record.numbers("size"), record.pose("pose"), colour, visual, collision)


def colour_of(record: Fields) -> tuple[float, float, float, float] | None:
    """RGBA."""
    if not record.has("colour"):
        return None
    red, green, blue, alpha = record.numbers("colour", 4)
    return red, green, blue, alpha


def _shape(record: Fields) -> Primitive:
    return primitive_of(record, colour_of(record), record.truth("visual"), record.truth("collision"))


def _part(record: Fields) -> Part:
    """Its mesh is not known."""
    mirrored = record.truth("mirrored")
    return Part(
        path=record.texts("path"),
        name=record.text("name"),
        part_id=record.text("part"),
        mesh=None,
        link_from_part=_pose(record, "pose", mirrored),
        world_from_part=_pose(record, "world", mirrored),
        inertial=inertial_of(record),
        volume=record.number("volume"),
        collides=record.truth("collision"),
        seen=record.truth("visual"),
        standard=record.truth("standard"),
        estimated=record.truth("estimated"),
    )


def _pose(record: Fields, key: str, mirrored: bool) -> Array:
    pose = record.pose(key)
    return frozen(pose @ MIRROR) if mirrored else pose
