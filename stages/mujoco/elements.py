"""Converts elements of a compiled model back to MJCF: cameras, lights, sites, geoms, tendons, actuators,
pairs, excluded pairs and equalities."""

from collections.abc import Iterable, Iterator, Sequence
from typing import Any

import mujoco
import numpy as np

from linkwright.stages.formats.numbers import exact
from linkwright.stages.mujoco.fields import (
    ACTUATOR,
    CAMERA,
    CONTACT,
    EQUALITY,
    GEOM,
    GEOM_TYPES,
    LIGHT,
    PAIR,
    SITE,
    SPATIAL,
    TENDON,
    attributes,
    bare,
    general_attributes,
)
from linkwright.stages.mujoco.names import OBJ, controls_of, name_of
from linkwright.stages.robot.model.mjcf_extras import Attributes, MjcfElement
from linkwright.stages.robot.model.poses import rotation_from_quat

TAG_BY_OBJECT_TYPE = {
    int(OBJ.mjOBJ_BODY): "body",
    int(OBJ.mjOBJ_XBODY): "body",
    int(OBJ.mjOBJ_JOINT): "joint",
    int(OBJ.mjOBJ_GEOM): "geom",
    int(OBJ.mjOBJ_SITE): "site",
    int(OBJ.mjOBJ_CAMERA): "camera",
    int(OBJ.mjOBJ_TENDON): "tendon",
    int(OBJ.mjOBJ_ACTUATOR): "actuator",
}
"""Kind of element (`mjtObj`) → its tag, for the kinds that other elements may refer to."""

Reference = tuple[str, str, str]
"""(attribute, tag of the element that it refers to, name of that element)."""


def reference(model: Any, attribute: str, kind: Any, index: int) -> Reference:
    """Returns the reference of an attribute to the element of this kind (`mjtObj`) and index."""
    return attribute, TAG_BY_OBJECT_TYPE[int(kind)], name_of(model, kind, index)


def _name_attribute(model: Any, kind: Any, index: int) -> Attributes:
    name = name_of(model, kind, index)
    return (("name", name),) if name else ()


def camera(model: Any, index: int) -> MjcfElement:
    """Returns a camera as an MJCF element, without its pose."""
    rows = attributes(model, CAMERA, index)
    # MuJoCo derives the field of view of a camera with a sensor from its size and the focal length.
    if model.cam_sensorsize[index].any():
        intrinsics = [float(number) for number in model.cam_intrinsic[index]]
        rows = tuple(row for row in rows if row[0] not in ("fovy", "sensorsize"))
        size = _exact(model.cam_sensorsize[index])
        rows += (("sensorsize", size), ("focal", exact(intrinsics[:2])), ("principal", exact(intrinsics[2:])))
    target = int(model.cam_targetbodyid[index])
    references = () if target < 0 else (reference(model, "target", OBJ.mjOBJ_BODY, target),)
    return MjcfElement("camera", (*_name_attribute(model, OBJ.mjOBJ_CAMERA, index), *rows), references)


def light(model: Any, index: int) -> MjcfElement:
    """Returns a light as an MJCF element, without its position and `dir`."""
    target = int(model.light_targetbodyid[index])
    references = () if target < 0 else (reference(model, "target", OBJ.mjOBJ_BODY, target),)
    rows = (*_name_attribute(model, OBJ.mjOBJ_LIGHT, index), *attributes(model, LIGHT, index))
    return MjcfElement("light", rows, references)


def site(model: Any, index: int) -> MjcfElement:
    """Returns a site as an MJCF element, without its pose."""
    return MjcfElement(
        "site", (*_name_attribute(model, OBJ.mjOBJ_SITE, index), *site_attributes(model, index))
    )


def site_attributes(model: Any, index: int) -> Attributes:
    """Returns the attributes of a site except its name and pose. The colour of its material becomes its
    own."""
    rows = attributes(model, SITE, index)
    material = int(model.site_matid[index])
    has_default_colour = np.array_equal(model.site_rgba[index], bare().site_rgba[-1])
    return (
        (*rows, ("rgba", _shortest(model.mat_rgba[material])))
        if material >= 0 and has_default_colour
        else rows
    )


def geom(model: Any, index: int) -> MjcfElement:
    """Returns a geom as an MJCF element, without its pose, its mass and the name of its mesh or height
    field."""
    kind = int(model.geom_type[index])
    shape = [("type", GEOM_TYPES[kind])]
    if kind not in (mujoco.mjtGeom.mjGEOM_MESH, mujoco.mjtGeom.mjGEOM_HFIELD):
        shape.append(("size", _exact(model.geom_size[index])))
    material = int(model.geom_matid[index])
    has_default_colour = np.array_equal(model.geom_rgba[index], bare().geom_rgba[-1])
    rgba = model.mat_rgba[material] if has_default_colour and material >= 0 else model.geom_rgba[index]
    appearance = [("rgba", _shortest(rgba))] if not np.array_equal(rgba, bare().geom_rgba[-1]) else []
    group = int(model.geom_group[index])
    appearance += [("group", str(group))] if group else []
    contact = attributes(model, CONTACT, index)
    rows = (
        *_name_attribute(model, OBJ.mjOBJ_GEOM, index),
        *shape,
        *contact,
        *geom_attributes(model, index),
        *appearance,
    )
    return MjcfElement("geom", rows)


def geom_attributes(model: Any, index: int) -> Attributes:
    """Returns the attributes of a geom besides its shape, contact and appearance, such as its model of fluid
    forces."""
    fluid = model.geom_fluid[index]
    coefficients = _exact(fluid[1:6])
    fluid_attributes = (("fluidshape", "ellipsoid"), ("fluidcoef", coefficients)) if fluid[0] > 0 else ()
    return (*attributes(model, GEOM, index), *fluid_attributes)


def _exact(values: Iterable[Any]) -> str:
    """Returns numbers as a text with as many digits as their values need."""
    return exact(float(value) for value in values)


def _shortest(rgba: Any) -> str:
    # The shortest text of a float32 is 0.2, and that of the same double 0.20000000298.
    return exact(float(str(value)) for value in rgba)


def tendon(model: Any, index: int) -> MjcfElement:
    """Returns a tendon as an MJCF element, with its path."""
    wraps = range(int(model.tendon_adr[index]), int(model.tendon_adr[index] + model.tendon_num[index]))
    fixed = int(model.wrap_type[wraps[0]]) == mujoco.mjtWrap.mjWRAP_JOINT
    rows = list(attributes(model, TENDON, index))
    spring = [float(length) for length in model.tendon_lengthspring[index]]
    rows.append(("springlength", exact(spring if spring[0] != spring[1] else spring[:1])))
    if not fixed:
        rows += attributes(model, SPATIAL, index)
        material = int(model.tendon_matid[index])
        if material >= 0 and "rgba" not in dict(rows):
            rows.append(("rgba", _shortest(model.mat_rgba[material])))
    name = _name_attribute(model, OBJ.mjOBJ_TENDON, index)
    path = tuple(_wrap(model, wrap) for wrap in wraps)
    return MjcfElement("fixed" if fixed else "spatial", (*name, *rows), children=path)


def _wrap(model: Any, index: int) -> MjcfElement:
    """Returns an element of a tendon's path. Its number `wrap_prm` is the coefficient of a joint, the divisor
    of a pulley, or the index of a geom's side site (-1 without one)."""
    kind, target, value = (getattr(model, f"wrap_{name}")[index] for name in ("type", "objid", "prm"))
    if kind == mujoco.mjtWrap.mjWRAP_JOINT:
        references = (reference(model, "joint", OBJ.mjOBJ_JOINT, target),)
        return MjcfElement("joint", (("coef", _exact([value])),), references)
    if kind == mujoco.mjtWrap.mjWRAP_PULLEY:
        return MjcfElement("pulley", (("divisor", _exact([value])),))
    if kind == mujoco.mjtWrap.mjWRAP_SITE:
        return MjcfElement("site", (), (reference(model, "site", OBJ.mjOBJ_SITE, target),))
    side = round(float(value))
    sites = (reference(model, "sidesite", OBJ.mjOBJ_SITE, side),) if side >= 0 else ()
    return MjcfElement("geom", (), (reference(model, "geom", OBJ.mjOBJ_GEOM, target), *sites))


_TARGETS_BY_TRANSMISSION = {
    int(mujoco.mjtTrn.mjTRN_JOINT): (("joint", OBJ.mjOBJ_JOINT),),
    int(mujoco.mjtTrn.mjTRN_JOINTINPARENT): (("jointinparent", OBJ.mjOBJ_JOINT),),
    int(mujoco.mjtTrn.mjTRN_TENDON): (("tendon", OBJ.mjOBJ_TENDON),),
    int(mujoco.mjtTrn.mjTRN_SITE): (("site", OBJ.mjOBJ_SITE), ("refsite", OBJ.mjOBJ_SITE)),
    int(mujoco.mjtTrn.mjTRN_BODY): (("body", OBJ.mjOBJ_BODY),),
    int(mujoco.mjtTrn.mjTRN_SLIDERCRANK): (("cranksite", OBJ.mjOBJ_SITE), ("slidersite", OBJ.mjOBJ_SITE)),
}
"""Transmission of an actuator (`mjtTrn`) → its attributes that refer to targets, and the kinds of these."""

_TYPE_ATTRIBUTES = ("dyntype", "gaintype", "biastype")
"""Attributes of an actuator that are written even if they are MuJoCo's defaults."""


def actuator(model: Any, index: int) -> MjcfElement | None:
    """Returns an actuator as <general>, without a name; None for a plug-in, for several controls, and for
    types that only some versions of MuJoCo have."""
    targets = _TARGETS_BY_TRANSMISSION.get(int(model.actuator_trntype[index]))
    if targets is None or model.actuator_plugin[index] >= 0 or len(controls_of(model, index)) != 1:
        return None
    rows = (
        *general_attributes(model, index, always=_TYPE_ATTRIBUTES),
        *_length_range_and_states(model, index),
    )
    if not {*_TYPE_ATTRIBUTES} <= {name for name, _ in rows}:
        return None
    numbers = (int(number) for number in model.actuator_trnid[index])
    references = tuple(
        reference(model, attribute, kind, number)
        for (attribute, kind), number in zip(targets, numbers, strict=False)
        if number >= 0
    )
    return MjcfElement("general", rows, references)


def _length_range_and_states(model: Any, index: int) -> Iterator[tuple[str, str]]:
    """Yields the range of lengths, which MuJoCo computes for muscles, and for dynamics of the type `user` the
    number of states."""
    lengths = [float(length) for length in model.actuator_lengthrange[index]]
    if any(lengths):
        yield "lengthrange", exact(lengths)
    if int(model.actuator_dyntype[index]) == mujoco.mjtDyn.mjDYN_USER:
        yield "actdim", str(int(model.actuator_actnum[index]))


def actuator_attributes(model: Any, index: int) -> Attributes:
    """Returns the attributes that actuators of all types have, besides gains and ranges."""
    return attributes(model, ACTUATOR, index)


def pair(model: Any, index: int) -> MjcfElement:
    """Returns a <pair> of geoms, which collide whatever their contype and conaffinity are."""
    geoms = (("geom1", model.pair_geom1[index]), ("geom2", model.pair_geom2[index]))
    references = tuple(reference(model, attribute, OBJ.mjOBJ_GEOM, number) for attribute, number in geoms)
    # MuJoCo would derive these from the two geoms if they were missing.
    always = ("condim", "friction", "solref", "solimp", "margin", "gap")
    rows = attributes(model, PAIR, index, always)
    return MjcfElement("pair", (*_name_attribute(model, OBJ.mjOBJ_PAIR, index), *rows), references)


def _relpose(data: Sequence[float]) -> list[float]:
    """Returns the position and quaternion of the second body of a weld in the first, from its `eq_data`: the
    anchor in the second body, the anchor in the first, and the quaternion of the second body in the first."""
    first_from_second = rotation_from_quat(np.array(data[6:10]))
    return [*map(float, np.array(data[3:6]) - first_from_second @ data[:3]), *data[6:10]]


def exclude(model: Any, index: int) -> MjcfElement:
    """Returns an <exclude> of two bodies, which do not collide."""
    signature = int(model.exclude_signature[index])
    # MuJoCo stores both indices in a single number, the first in the upper bits.
    bodies = (("body1", signature >> 16), ("body2", signature & 0xFFFF))
    references = tuple(reference(model, attribute, OBJ.mjOBJ_BODY, number) for attribute, number in bodies)
    return MjcfElement("exclude", _name_attribute(model, OBJ.mjOBJ_EXCLUDE, index), references)


def equality(model: Any, index: int) -> MjcfElement | None:
    """Returns an equality as an MJCF element; None unless it is a connect, weld, joint or tendon."""
    kind = mujoco.mjtEq(int(model.eq_type[index]))
    target_indices = [int(number) for number in (model.eq_obj1id[index], model.eq_obj2id[index])]
    data = [float(number) for number in model.eq_data[index]]
    rows: list[tuple[str, str]] = []
    if kind in (mujoco.mjtEq.mjEQ_JOINT, mujoco.mjtEq.mjEQ_TENDON):
        tag = kind.name.removeprefix("mjEQ_").lower()
        target_kind = OBJ.mjOBJ_JOINT if tag == "joint" else OBJ.mjOBJ_TENDON
        rows.append(("polycoef", exact(data[:5])))
    elif kind in (mujoco.mjtEq.mjEQ_CONNECT, mujoco.mjtEq.mjEQ_WELD):
        by_sites = int(model.eq_objtype[index]) == OBJ.mjOBJ_SITE
        tag, target_kind = ("site", OBJ.mjOBJ_SITE) if by_sites else ("body", OBJ.mjOBJ_BODY)
        if kind == mujoco.mjtEq.mjEQ_WELD:
            # `eq_data` of a weld: see `_relpose`; then the torque scale.
            rows.append(("torquescale", exact(data[10:11])))
            rows += [] if by_sites else [("anchor", exact(data[:3])), ("relpose", exact(_relpose(data)))]
        elif not by_sites:
            rows.append(("anchor", exact(data[:3])))
    else:
        return None
    references = tuple(
        reference(model, f"{tag}{position}", target_kind, number)
        for position, number in enumerate(target_indices, 1)
        if number >= 0
    )
    rows += [] if model.eq_active0[index] else [("active", "false")]
    rows += attributes(model, EQUALITY, index, always=("solref", "solimp"))
    name = _name_attribute(model, OBJ.mjOBJ_EQUALITY, index)
    return MjcfElement(kind.name.removeprefix("mjEQ_").lower(), (*name, *rows), references)
