"""Sensors of a compiled model."""

from collections.abc import Collection, Iterator
from typing import Any

import mujoco

from linkwright.stages.mujoco.elements import KINDS, Name, named
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
"""Name in MuJoCo's code → element, where they differ."""

_OF_TWO = ("distance", "normal", "fromto", "contact")
"""Sensors that number what they are on: geom1, body2."""

_LOST = ("plugin", "tactile")

_REDUCE = ("none", "mindist", "maxforce", "netforce")


def tag_of(model: Any, index: int) -> str:
    """The element of a sensor's type."""
    raw = str(mujoco.mjtSensor(int(model.sensor_type[index])).name).removeprefix("mjSENS_").lower()
    return _TAGS.get(raw, raw)


def sensor(model: Any, index: int) -> MjcfElement | None:
    """A sensor without its name; None of a type that is not carried over, or on what has no name."""
    tag = tag_of(model, index)
    ends = [
        (int(model.sensor_objtype[index]), int(model.sensor_objid[index])),
        (int(model.sensor_reftype[index]), int(model.sensor_refid[index])),
    ]
    if tag in _LOST or any(number >= 0 and not _has_name(model, kind, number) for kind, number in ends):
        return None
    more, names = _parts(model, index, tag, ends)
    return MjcfElement(tag, (*more, *attributes(model, SENSOR, index)), tuple(names))


def sensor_attributes(model: Any, index: int) -> Attributes:
    """What a sensor of any type has beside its noise and cutoff."""
    return attributes(model, [field for field in SENSOR if field.attribute == "user"], index)


def _has_name(model: Any, kind: int, number: int) -> bool:
    return kind in KINDS and bool(name_of(model, kind, number))


def _word(kind: int) -> str:
    return "xbody" if kind == OBJ.mjOBJ_XBODY else KINDS[kind]


def _parts(
    model: Any, index: int, tag: str, ends: list[tuple[int, int]]
) -> tuple[list[tuple[str, str]], list[Name]]:
    """The attributes that a type has of its own, and those that name what it is on."""
    (kind, on), (other, of) = ends
    if tag in _OF_TWO:
        return (_of_contact(model, index) if tag == "contact" else []), [*_numbered(model, ends)]
    if tag.startswith("frame") or tag in ("insidesite", "user"):
        more = [("objtype", _word(kind))] if on >= 0 else []
        names = [named(model, "objname", kind, on)] if on >= 0 else []
        if tag == "insidesite":
            names.append(named(model, "site", other, of))
            more += [("enclosed", "true")] if model.sensor_intprm[index][0] else []
        elif of >= 0:
            more.append(("reftype", _word(other)))
            names.append(named(model, "refname", other, of))
        if tag == "user":
            more += _of_user(model, index)
        return more, names
    names = [named(model, KINDS[kind], kind, number) for kind, number in ends if number >= 0]
    more = []
    if tag == "rangefinder" and int(model.sensor_intprm[index][0]) not in (0, 1):
        more.append(("data", " ".join(_data(model, index, "mjtRayDataField", "mjRAYDATA_"))))
    return more, names


def _numbered(model: Any, ends: Collection[tuple[int, int]]) -> Iterator[Name]:
    for place, (kind, number) in enumerate(ends, 1):
        if number >= 0:
            word = "subtree" if kind == OBJ.mjOBJ_XBODY else KINDS[kind]
            yield named(model, word if word == "site" else f"{word}{place}", kind, number)


def _of_contact(model: Any, index: int) -> list[tuple[str, str]]:
    _, reduce, count = (int(number) for number in model.sensor_intprm[index])
    data = " ".join(_data(model, index, "mjtConDataField", "mjCONDATA_"))
    return [("data", data), ("reduce", _REDUCE[reduce]), ("num", str(count))]


def _of_user(model: Any, index: int) -> list[tuple[str, str]]:
    data = mujoco.mjtDataType(int(model.sensor_datatype[index])).name.removeprefix("mjDATATYPE_").lower()
    stage = mujoco.mjtStage(int(model.sensor_needstage[index])).name.removeprefix("mjSTAGE_").lower()
    return [("dim", str(int(model.sensor_dim[index]))), ("datatype", data), ("needstage", stage)]


def _data(model: Any, index: int, enum: str, prefix: str) -> Iterator[str]:
    """The words of the bits of what a sensor gives."""
    bits = int(model.sensor_intprm[index][0])
    for name, member in getattr(mujoco, enum).__members__.items():
        if name.startswith(prefix) and bits & (1 << int(member)):
            yield name.removeprefix(prefix).lower()
