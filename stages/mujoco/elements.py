"""Cameras, lights, sites, geoms, tendons, actuators, sensors, pairs and equalities of a compiled model."""

from collections.abc import Iterator, Sequence
from typing import Any

import mujoco
import numpy as np

from linkwright.stages.formats.numbers import exact
from linkwright.stages.mujoco.fields import (
    ACTUATOR,
    CAMERA,
    CONTACT,
    EQUALITY,
    GENERAL,
    GEOM,
    GEOM_TYPES,
    LIGHT,
    PAIR,
    SITE,
    SPATIAL,
    TENDON,
    attributes,
    bare,
)
from linkwright.stages.mujoco.names import OBJ, name_of
from linkwright.stages.robot.model.mjcf_extras import Attributes, MjcfElement
from linkwright.stages.robot.model.poses import rotation_from_quat

KINDS = {
    int(OBJ.mjOBJ_BODY): "body",
    int(OBJ.mjOBJ_XBODY): "body",
    int(OBJ.mjOBJ_JOINT): "joint",
    int(OBJ.mjOBJ_GEOM): "geom",
    int(OBJ.mjOBJ_SITE): "site",
    int(OBJ.mjOBJ_CAMERA): "camera",
    int(OBJ.mjOBJ_TENDON): "tendon",
    int(OBJ.mjOBJ_ACTUATOR): "actuator",
}
"""What an element may name: MuJoCo's number of the kind → tag."""

Name = tuple[str, str, str]


def named(model: Any, attribute: str, kind: Any, index: int) -> Name:
    """An attribute that names the thing of this kind and number."""
    return attribute, KINDS[int(kind)], name_of(model, kind, index)


def _titled(model: Any, kind: Any, index: int) -> Attributes:
    name = name_of(model, kind, index)
    return (("name", name),) if name else ()


def camera(model: Any, index: int) -> MjcfElement:
    """A camera without its place."""
    own = attributes(model, CAMERA, index)
    if model.cam_sensorsize[index].any():
        lens = [float(number) for number in model.cam_intrinsic[index]]
        own = tuple(one for one in own if one[0] not in ("fovy", "sensorsize"))
        size = exact(float(number) for number in model.cam_sensorsize[index])
        own += (("sensorsize", size), ("focal", exact(lens[:2])), ("principal", exact(lens[2:])))
    target = int(model.cam_targetbodyid[index])
    names = () if target < 0 else (named(model, "target", OBJ.mjOBJ_BODY, target),)
    return MjcfElement("camera", (*_titled(model, OBJ.mjOBJ_CAMERA, index), *own), names)


def light(model: Any, index: int) -> MjcfElement:
    """A light without its place, which is its `dir` too."""
    target = int(model.light_targetbodyid[index])
    names = () if target < 0 else (named(model, "target", OBJ.mjOBJ_BODY, target),)
    own = (*_titled(model, OBJ.mjOBJ_LIGHT, index), *attributes(model, LIGHT, index))
    return MjcfElement("light", own, names)


def site(model: Any, index: int) -> MjcfElement:
    """A site without its place."""
    return MjcfElement("site", (*_titled(model, OBJ.mjOBJ_SITE, index), *site_attributes(model, index)))


def site_attributes(model: Any, index: int) -> Attributes:
    """Its shape and looks; a material is its colour."""
    found = attributes(model, SITE, index)
    material = int(model.site_matid[index])
    plain = np.array_equal(model.site_rgba[index], bare().site_rgba[-1])
    return (*found, ("rgba", _short(model.mat_rgba[material]))) if material >= 0 and plain else found


def geom(model: Any, index: int) -> MjcfElement:
    """A geom without its place and mass; a mesh and a height field without the name of their data."""
    kind = int(model.geom_type[index])
    shape = [("type", GEOM_TYPES[kind])]
    if kind not in (mujoco.mjtGeom.mjGEOM_MESH, mujoco.mjtGeom.mjGEOM_HFIELD):
        shape.append(("size", exact(float(number) for number in model.geom_size[index])))
    material = int(model.geom_matid[index])
    plain = np.array_equal(model.geom_rgba[index], bare().geom_rgba[-1])
    rgba = model.mat_rgba[material] if plain and material >= 0 else model.geom_rgba[index]
    looks = [("rgba", _short(rgba))] if not np.array_equal(rgba, bare().geom_rgba[-1]) else []
    group = int(model.geom_group[index])
    looks += [("group", str(group))] if group else []
    touch = attributes(model, CONTACT, index)
    own = (*_titled(model, OBJ.mjOBJ_GEOM, index), *shape, *touch, *geom_attributes(model, index), *looks)
    return MjcfElement("geom", own)


def geom_attributes(model: Any, index: int) -> Attributes:
    """What a geom has beside its shape, contact and looks: how a fluid acts on it, and more."""
    fluid = model.geom_fluid[index]
    coefficients = exact(float(number) for number in fluid[1:6])
    more = (("fluidshape", "ellipsoid"), ("fluidcoef", coefficients)) if fluid[0] > 0 else ()
    return (*attributes(model, GEOM, index), *more)


def _short(rgba: Any) -> str:
    return exact(float(str(value)) for value in rgba)


def tendon(model: Any, index: int) -> MjcfElement:
    """A tendon, with its path."""
    wraps = range(int(model.tendon_adr[index]), int(model.tendon_adr[index] + model.tendon_num[index]))
    fixed = int(model.wrap_type[wraps[0]]) == mujoco.mjtWrap.mjWRAP_JOINT
    own = list(attributes(model, TENDON, index))
    spring = [float(length) for length in model.tendon_lengthspring[index]]
    own.append(("springlength", exact(spring if spring[0] != spring[1] else spring[:1])))
    if not fixed:
        own += attributes(model, SPATIAL, index)
        material = int(model.tendon_matid[index])
        if material >= 0 and "rgba" not in dict(own):
            own.append(("rgba", _short(model.mat_rgba[material])))
    title = _titled(model, OBJ.mjOBJ_TENDON, index)
    path = tuple(_wrap(model, one) for one in wraps)
    return MjcfElement("fixed" if fixed else "spatial", (*title, *own), children=path)


def _wrap(model: Any, index: int) -> MjcfElement:
    kind, on, value = (getattr(model, f"wrap_{name}")[index] for name in ("type", "objid", "prm"))
    if kind == mujoco.mjtWrap.mjWRAP_JOINT:
        names = (named(model, "joint", OBJ.mjOBJ_JOINT, on),)
        return MjcfElement("joint", (("coef", exact([float(value)])),), names)
    if kind == mujoco.mjtWrap.mjWRAP_PULLEY:
        return MjcfElement("pulley", (("divisor", exact([float(value)])),))
    if kind == mujoco.mjtWrap.mjWRAP_SITE:
        return MjcfElement("site", (), (named(model, "site", OBJ.mjOBJ_SITE, on),))
    side = round(float(value))
    sites = (named(model, "sidesite", OBJ.mjOBJ_SITE, side),) if side >= 0 else ()
    return MjcfElement("geom", (), (named(model, "geom", OBJ.mjOBJ_GEOM, on), *sites))


_BY_TRANSMISSION = {
    int(mujoco.mjtTrn.mjTRN_JOINT): (("joint", OBJ.mjOBJ_JOINT),),
    int(mujoco.mjtTrn.mjTRN_JOINTINPARENT): (("jointinparent", OBJ.mjOBJ_JOINT),),
    int(mujoco.mjtTrn.mjTRN_TENDON): (("tendon", OBJ.mjOBJ_TENDON),),
    int(mujoco.mjtTrn.mjTRN_SITE): (("site", OBJ.mjOBJ_SITE), ("refsite", OBJ.mjOBJ_SITE)),
    int(mujoco.mjtTrn.mjTRN_BODY): (("body", OBJ.mjOBJ_BODY),),
    int(mujoco.mjtTrn.mjTRN_SLIDERCRANK): (("cranksite", OBJ.mjOBJ_SITE), ("slidersite", OBJ.mjOBJ_SITE)),
}
"""By MuJoCo's number: the attributes of what an actuator acts on."""


_TYPES = ("dyntype", "gaintype", "biastype")


def actuator(model: Any, index: int) -> MjcfElement | None:
    """An actuator as `<general>`, without a name; None of a plug-in, or with types that not every MuJoCo
    has."""
    ends = _BY_TRANSMISSION.get(int(model.actuator_trntype[index]))
    own = (*attributes(model, GENERAL, index, always=_TYPES), *_more_of_actuator(model, index))
    if ends is None or model.actuator_plugin[index] >= 0 or _controls(model, index) != 1:
        return None
    if not {*_TYPES} <= {name for name, _ in own}:
        return None
    numbers = (int(number) for number in model.actuator_trnid[index])
    names = tuple(
        named(model, attribute, kind, number)
        for (attribute, kind), number in zip(ends, numbers, strict=False)
        if number >= 0
    )
    return MjcfElement("general", own, names)


def _controls(model: Any, index: int) -> int:
    return int(model.actuator_ctrlnum[index]) if hasattr(model, "actuator_ctrlnum") else 1


def _more_of_actuator(model: Any, index: int) -> Iterator[tuple[str, str]]:
    """Ranges of lengths, which MuJoCo finds for muscles, and numbers of states of a user's own dynamics."""
    lengths = [float(length) for length in model.actuator_lengthrange[index]]
    if any(lengths):
        yield "lengthrange", exact(lengths)
    if int(model.actuator_dyntype[index]) == mujoco.mjtDyn.mjDYN_USER:
        yield "actdim", str(int(model.actuator_actnum[index]))


def actuator_attributes(model: Any, index: int) -> Attributes:
    """What an actuator of any type has beside its gains and ranges."""
    return attributes(model, ACTUATOR, index)


def pair(model: Any, index: int) -> MjcfElement:
    """Two geoms that collide, whatever their bits say."""
    geoms = (("geom1", model.pair_geom1[index]), ("geom2", model.pair_geom2[index]))
    names = tuple(named(model, attribute, OBJ.mjOBJ_GEOM, one) for attribute, one in geoms)
    # Without these they would be those of the two geoms.
    always = ("condim", "friction", "solref", "solimp", "margin", "gap")
    own = attributes(model, PAIR, index, always)
    return MjcfElement("pair", (*_titled(model, OBJ.mjOBJ_PAIR, index), *own), names)


def _relpose(data: Sequence[float]) -> list[float]:
    """The pose of the second body of a weld in the first: MuJoCo has its anchor in both bodies, the second's
    first, and the turn between them."""
    turn = rotation_from_quat(np.array(data[6:10]))
    return [*map(float, np.array(data[3:6]) - turn @ data[:3]), *data[6:10]]


def exclude(model: Any, index: int) -> MjcfElement:
    """Two bodies that do not collide."""
    signature = int(model.exclude_signature[index])
    bodies = (("body1", signature >> 16), ("body2", signature & 0xFFFF))
    names = tuple(named(model, attribute, OBJ.mjOBJ_BODY, one) for attribute, one in bodies)
    return MjcfElement("exclude", _titled(model, OBJ.mjOBJ_EXCLUDE, index), names)


def equality(model: Any, index: int) -> MjcfElement | None:
    """A constraint; None of a kind that is not of bodies, sites, joints or tendons."""
    kind = mujoco.mjtEq(int(model.eq_type[index]))
    ends = [int(number) for number in (model.eq_obj1id[index], model.eq_obj2id[index])]
    data = [float(number) for number in model.eq_data[index]]
    own: list[tuple[str, str]] = []
    if kind in (mujoco.mjtEq.mjEQ_JOINT, mujoco.mjtEq.mjEQ_TENDON):
        tag = kind.name.removeprefix("mjEQ_").lower()
        on = OBJ.mjOBJ_JOINT if tag == "joint" else OBJ.mjOBJ_TENDON
        own.append(("polycoef", exact(data[:5])))
    elif kind in (mujoco.mjtEq.mjEQ_CONNECT, mujoco.mjtEq.mjEQ_WELD):
        by_sites = int(model.eq_objtype[index]) == OBJ.mjOBJ_SITE
        tag, on = ("site", OBJ.mjOBJ_SITE) if by_sites else ("body", OBJ.mjOBJ_BODY)
        if kind == mujoco.mjtEq.mjEQ_WELD:
            own.append(("torquescale", exact(data[10:11])))
            own += [] if by_sites else [("anchor", exact(data[:3])), ("relpose", exact(_relpose(data)))]
        elif not by_sites:
            own.append(("anchor", exact(data[:3])))
    else:
        return None
    names = tuple(
        named(model, f"{tag}{place}", on, number) for place, number in enumerate(ends, 1) if number >= 0
    )
    own += [] if model.eq_active0[index] else [("active", "false")]
    own += attributes(model, EQUALITY, index, always=("solref", "solimp"))
    title = _titled(model, OBJ.mjOBJ_EQUALITY, index)
    return MjcfElement(kind.name.removeprefix("mjEQ_").lower(), (*title, *own), names)
