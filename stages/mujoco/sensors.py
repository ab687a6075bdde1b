"""Converts sensors of a compiled model back to MJCF."""

from collections.abc import Collection, Iterator
from typing import Any

import mujoco

from linkwright.stages.mujoco.elements import TAG_BY_OBJECT_TYPE, Reference, reference
from linkwright.stages.mujoco.fields import SENSOR, attributes
from linkwright.stages.mujoco.names import OBJ, name_of
from linkwright.stages.robot.model.mjcf_extras import Attributes, MjcfElement

_TAG_BY_NAME = {
    "jointactfrc": "jointactuatorfrc",
    "tendonactfrc": "tendonactuatorfrc",
    "geomdist": "distance",
    "geomnormal": "normal",
    "geomfromto": "fromto",
}
"""Name of a sensor's type in `mjtSensor` → its tag, if the two differ."""

_TWO_TARGET_TAGS = ("distance", "normal", "fromto", "contact")
"""Tags of sensors whose two targets have numbered attributes, such as geom1 and body2."""

_UNSUPPORTED_TAGS = ("plugin", "tactile")
"""Tags of sensors that are not converted."""

_REDUCE_WORDS = ("none", "mindist", "maxforce", "netforce")
"""Words of the attribute `reduce` of a contact sensor, by their numbers."""


def tag_of(model: Any, index: int) -> str:
    """Returns the tag of a sensor's type."""
    name = str(mujoco.mjtSensor(int(model.sensor_type[index])).name).removeprefix("mjSENS_").lower()
    return _TAG_BY_NAME.get(name, name)


def sensor(model: Any, index: int) -> MjcfElement | None:
    """Returns a sensor as an MJCF element, without its name; None for a type that is not converted, and for a
    target without a name."""
    tag = tag_of(model, index)
    ends = [
        (int(model.sensor_objtype[index]), int(model.sensor_objid[index])),
        (int(model.sensor_reftype[index]), int(model.sensor_refid[index])),
    ]
    if tag in _UNSUPPORTED_TAGS or any(
        number >= 0 and not _has_name(model, kind, number) for kind, number in ends
    ):
        return None
    attributes_of_type, names = _attributes_and_targets(model, index, tag, ends)
    return MjcfElement(tag, (*attributes_of_type, *attributes(model, SENSOR, index)), tuple(names))


def sensor_attributes(model: Any, index: int) -> Attributes:
    """Returns the attributes of a sensor of any type besides its noise and cutoff."""
    return attributes(model, [field for field in SENSOR if field.attribute == "user"], index)


def _has_name(model: Any, kind: int, number: int) -> bool:
    """Returns whether a target of a sensor, by its kind (`mjtObj`) and index, can be referred to by a
    name."""
    return kind in TAG_BY_OBJECT_TYPE and bool(name_of(model, kind, number))


def _object_word(kind: int) -> str:
    """Returns the word of `objtype` or `reftype` for a kind of element."""
    return "xbody" if kind == OBJ.mjOBJ_XBODY else TAG_BY_OBJECT_TYPE[kind]


def _attributes_and_targets(
    model: Any, index: int, tag: str, ends: list[tuple[int, int]]
) -> tuple[list[tuple[str, str]], list[Reference]]:
    """Returns the attributes that only this type of sensor has, and its references to targets. `ends`: (kind,
    index) of the object and of the reference, the index -1 for none."""
    (kind, index_of_target), (reference_kind, reference_index) = ends
    if tag in _TWO_TARGET_TAGS:
        attributes_of_type = _contact_attributes(model, index) if tag == "contact" else []
        return attributes_of_type, [*_numbered_references(model, ends)]
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
            attributes_of_type += _user_attributes(model, index)
        return attributes_of_type, names
    names = [reference(model, TAG_BY_OBJECT_TYPE[kind], kind, number) for kind, number in ends if number >= 0]
    attributes_of_type = []
    # 0 and 1 mean the distance alone, the default.
    if tag == "rangefinder" and int(model.sensor_intprm[index][0]) not in (0, 1):
        attributes_of_type.append(("data", " ".join(_data(model, index, "mjtRayDataField", "mjRAYDATA_"))))
    return attributes_of_type, names


def _numbered_references(model: Any, ends: Collection[tuple[int, int]]) -> Iterator[Reference]:
    """Yields the references to the targets of a sensor with two targets."""
    for position, (kind, number) in enumerate(ends, 1):
        if number >= 0:
            word = "subtree" if kind == OBJ.mjOBJ_XBODY else TAG_BY_OBJECT_TYPE[kind]
            yield reference(model, word if word == "site" else f"{word}{position}", kind, number)


def _contact_attributes(model: Any, index: int) -> list[tuple[str, str]]:
    _, reduce, count = (int(number) for number in model.sensor_intprm[index])
    data = " ".join(_data(model, index, "mjtConDataField", "mjCONDATA_"))
    return [("data", data), ("reduce", _REDUCE_WORDS[reduce]), ("num", str(count))]


def _user_attributes(model: Any, index: int) -> list[tuple[str, str]]:
    data = mujoco.mjtDataType(int(model.sensor_datatype[index])).name.removeprefix("mjDATATYPE_").lower()
    stage = mujoco.mjtStage(int(model.sensor_needstage[index])).name.removeprefix("mjSTAGE_").lower()
    return [("dim", str(int(model.sensor_dim[index]))), ("datatype", data), ("needstage", stage)]


def _data(model: Any, index: int, enum: str, prefix: str) -> Iterator[str]:
    """Yields the words of the attribute `data` of a sensor, one for each bit of its number. `enum`: MuJoCo's
    enumeration of the bits, whose members begin with `prefix`."""
    bits = int(model.sensor_intprm[index][0])
    for name, member in getattr(mujoco, enum).__members__.items():
        if name.startswith(prefix) and bits & (1 << int(member)):
            yield name.removeprefix(prefix).lower()
