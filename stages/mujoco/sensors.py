"""Converts sensors of a compiled model back to MJCF."""

from collections.abc import Collection, Iterator
from typing import Any

import mujoco

from linkwright.stages.mujoco.elements import TAG_BY_OBJECT_TYPE, Reference, reference
from linkwright.stages.mujoco.fields import SENSOR, attributes
from linkwright.stages.mujoco.names import OBJ, name_of
from linkwright.stages.robot.model.mjcf_extras import Attributes, MjcfElement

_TAGS = {
    "jointactfrc": "jointactuatorfrc",
    "tendonactfrc": "tendonactuatorfrc",
    "geomdist": "distance",
    "geomnormal": "normal",
    "geomfromto": "fromto",
}
"""MuJoCo's name of a sensor in code → its tag, where these differ."""

_OF_TWO = ("distance", "normal", "fromto", "contact")
"""Sensors whose two targets have numbered attributes: geom1, body2."""

_UNSUPPORTED = ("plugin", "tactile")
"""Sensors that are not converted."""

_REDUCE = ("none", "mindist", "maxforce", "netforce")


def tag_of(model: Any, index: int) -> str:
    """Returns the tag of a sensor's type."""
    raw = str(mujoco.mjtSensor(int(model.sensor_type[index])).name).removeprefix("mjSENS_").lower()
    return _TAGS.get(raw, raw)


def sensor(model: Any, index: int) -> MjcfElement | None:
    """Returns a sensor as an MJCF element, without its name. Returns None for a type that is not converted,
    and for a target without a name."""
    tag = tag_of(model, index)
    ends = [
        (int(model.sensor_objtype[index]), int(model.sensor_objid[index])),
        (int(model.sensor_reftype[index]), int(model.sensor_refid[index])),
    ]
    if tag in _UNSUPPORTED or any(
        number >= 0 and not _has_name(model, kind, number) for kind, number in ends
    ):
        return None
    attributes_of_type, names = _attributes_and_targets(model, index, tag, ends)
    return MjcfElement(tag, (*attributes_of_type, *attributes(model, SENSOR, index)), tuple(names))


def sensor_attributes(model: Any, index: int) -> Attributes:
    """Returns the attributes of a sensor of any type besides its noise and cutoff."""
    return attributes(model, [field for field in SENSOR if field.attribute == "user"], index)


def _has_name(model: Any, kind: int, number: int) -> bool:
    return kind in TAG_BY_OBJECT_TYPE and bool(name_of(model, kind, number))


def _object_word(kind: int) -> str:
    return "xbody" if kind == OBJ.mjOBJ_XBODY else TAG_BY_OBJECT_TYPE[kind]


def _attributes_and_targets(
    model: Any, index: int, tag: str, ends: list[tuple[int, int]]
) -> tuple[list[tuple[str, str]], list[Reference]]:
    """Returns the attributes that only this type has, and those that refer to its targets."""
    (kind, index_of_target), (reference_kind, reference_index) = ends
    if tag in _OF_TWO:
        return (_of_contact(model, index) if tag == "contact" else []), [*_numbered(model, ends)]
    if tag.startswith("frame") or tag in ("insidesite", "user"):
        attributes_of_type = [("objtype", _object_word(kind))] if index_of_target >= 0 else []
        names = [reference(model, "objname", kind, index_of_target)] if index_of_target >= 0 else []
        if tag == "insidesite":
            names.append(reference(model, "site", reference_kind, reference_index))
            attributes_of_type += [("enclosed", "true")] if model.sensor_intprm[index][0] else []
        elif reference_index >= 0:
            attributes_of_type.append(("reftype", _object_word(reference_kind)))
            names.append(reference(model, "refname", reference_kind, reference_index))
        if tag == "user":
            attributes_of_type += _of_user(model, index)
        return attributes_of_type, names
    names = [reference(model, TAG_BY_OBJECT_TYPE[kind], kind, number) for kind, number in ends if number >= 0]
    attributes_of_type = []
    if tag == "rangefinder" and int(model.sensor_intprm[index][0]) not in (0, 1):
        attributes_of_type.append(("data", " ".join(_data(model, index, "mjtRayDataField", "mjRAYDATA_"))))
    return attributes_of_type, names


def _numbered(model: Any, ends: Collection[tuple[int, int]]) -> Iterator[Reference]:
    for position, (kind, number) in enumerate(ends, 1):
        if number >= 0:
            word = "subtree" if kind == OBJ.mjOBJ_XBODY else TAG_BY_OBJECT_TYPE[kind]
            yield reference(model, word if word == "site" else f"{word}{position}", kind, number)


def _of_contact(model: Any, index: int) -> list[tuple[str, str]]:
    _, reduce, count = (int(number) for number in model.sensor_intprm[index])
    data = " ".join(_data(model, index, "mjtConDataField", "mjCONDATA_"))
    return [("data", data), ("reduce", _REDUCE[reduce]), ("num", str(count))]


def _of_user(model: Any, index: int) -> list[tuple[str, str]]:
    data = mujoco.mjtDataType(int(model.sensor_datatype[index])).name.removeprefix("mjDATATYPE_").lower()
    stage = mujoco.mjtStage(int(model.sensor_needstage[index])).name.removeprefix("mjSTAGE_").lower()
    return [("dim", str(int(model.sensor_dim[index]))), ("datatype", data), ("needstage", stage)]


def _data(model: Any, index: int, enum: str, prefix: str) -> Iterator[str]:
    """Yields the words of the bits of a sensor's data."""
    bits = int(model.sensor_intprm[index][0])
    for name, member in getattr(mujoco, enum).__members__.items():
        if name.startswith(prefix) and bits & (1 << int(member)):
            yield name.removeprefix(prefix).lower()
