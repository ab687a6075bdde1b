"""What only an MJCF has, in a robot.json."""

from stages.formats.robot_json.fields import Fields, RobotJsonError
from stages.formats.robot_json.scene import setting_of
from stages.robot.mjcf_extras import (
    Attributes,
    MjcfAttributes,
    MjcfBodyFrame,
    MjcfElement,
    MjcfExtras,
    MjcfKeyframe,
    MjcfMounted,
)

DEEPEST = 200
"""Elements in each other that are read."""


def extras_of(record: Fields) -> MjcfExtras | None:
    """None for a robot of another source."""
    if not record.has("mjcf"):
        return None
    table = record.inside("mjcf")
    order, option = table.inside("order"), table.inside("option")
    return MjcfExtras(
        bodies=tuple(_body(one) for one in table.records("bodies")),
        attributes=tuple(
            MjcfAttributes(one.text("kind"), one.text("name"), texts_of(one, "attributes"))
            for one in table.records("attributes")
        ),
        mounted=tuple(
            MjcfMounted(one.text("link"), one.pose("pose"), _element(one.inside("element")))
            for one in table.records("mounted")
        ),
        sections=tuple(_element(one) for one in table.records("sections")),
        order=tuple((section, order.texts(section)) for section in order.table),
        scene=tuple(_element(one) for one in table.records("scene")),
        scene_qpos=table.numbers("scene_qpos"),
        keyframes=tuple(
            MjcfKeyframe(one.text("name"), one.numbers("root", 0, 7), one.numbers("scene"))
            for one in table.records("keyframes")
        ),
        has_ground=table.truth("has_ground"),
        option=tuple((name, setting_of(option, name)) for name in option.table),
        flag=texts_of(table, "flag"),
    )


def _body(record: Fields) -> MjcfBodyFrame:
    axes = record.tensor("inertial_axes") if record.has("inertial_axes") else None
    return MjcfBodyFrame(record.text("link"), record.pose("pose"), axes)


def texts_of(record: Fields, key: str) -> Attributes:
    """The pairs of a table of texts."""
    table = record.inside(key)
    return tuple((name, table.text(name)) for name in table.table)


def _element(record: Fields, depth: int = 0) -> MjcfElement:
    if depth > DEEPEST:
        msg = f"{record.place[:60]}...: elements are more than {DEEPEST} deep in each other"
        raise RobotJsonError(msg)
    names = record.inside("names")
    return MjcfElement(
        record.text("tag"),
        texts_of(record, "attributes"),
        tuple((attribute, *_name(names, attribute)) for attribute in names.table),
        tuple(_element(one, depth + 1) for one in record.records("children")),
    )


def _name(names: Fields, attribute: str) -> tuple[str, str]:
    """The kind and the name of what an attribute names."""
    pair = names.texts(attribute)
    if len(pair) != 2:
        msg = f"{names.place}.{attribute}: expected a kind and a name, found {len(pair)} texts"
        raise RobotJsonError(msg)
    return pair[0], pair[1]
