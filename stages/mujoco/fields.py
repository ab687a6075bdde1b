"""Attributes of elements: which array of MuJoCo's model has each, and how it is written.

An attribute is written where its value differs from that in a model that sets nothing. Arrays that an older
MuJoCo lacks are left out there.
"""

from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any

import mujoco
import numpy as np

from linkwright.stages.formats.numbers import exact
from linkwright.stages.robot.model.mjcf_extras import Attributes

_BARE = """<mujoco><worldbody><light/><camera/><geom name="floor" size="1"/>
<body name="a"><joint name="a"/><geom name="a" size="1"/><site name="a"/></body>
<body name="b"><joint name="b"/><geom name="b" size="1"/></body></worldbody>
<equality><weld body1="a" body2="b"/></equality><asset><material name="a"/></asset>
<contact><pair geom1="a" geom2="b"/></contact>
<tendon><fixed><joint joint="a" coef="1"/></fixed></tendon>
<actuator><general joint="a"/></actuator><sensor><clock/></sensor></mujoco>"""
"""A model that sets nothing but what is required; the element of each kind is the last."""


@cache
def bare() -> Any:
    return mujoco.MjModel.from_xml_string(_BARE)


@dataclass(frozen=True, slots=True)
class CompiledField:
    """An attribute and the array that has it. `words`: of an enumeration, MuJoCo's number → word; `limited`:
    the array that says whether the attribute counts. `more`: an array with numbers that follow."""

    attribute: str
    array: str
    words: Mapping[int, str] | None = None
    limited: str = ""
    more: str = ""


def _words(enum: str, prefix: str, only: Collection[str] | None = None) -> dict[int, str]:
    members: Mapping[str, Any] = getattr(mujoco, enum).__members__
    named = {int(value): name.removeprefix(prefix).lower() for name, value in members.items()}
    return {value: word for value, word in named.items() if only is None or word in only}


_SWITCH = {0: "false", 1: "true"}
_MODES = _words("mjtCamLight", "mjCAMLIGHT_")
GEOM_TYPES = _words("mjtGeom", "mjGEOM_")

JOINT = (
    CompiledField("stiffness", "jnt_stiffness", more="jnt_stiffnesspoly"),
    CompiledField("springyield", "jnt_springyield"),
    CompiledField("damping", "dof_damping", more="dof_dampingpoly"),
    CompiledField("frictionloss", "dof_frictionloss"),
    CompiledField("armature", "dof_armature"),
    CompiledField("actuatorfrcrange", "jnt_actfrcrange", limited="jnt_actfrclimited"),
    CompiledField("margin", "jnt_margin"),
    CompiledField("solreflimit", "jnt_solref"),
    CompiledField("solimplimit", "jnt_solimp"),
    CompiledField("solreffriction", "dof_solref"),
    CompiledField("solimpfriction", "dof_solimp"),
    CompiledField("actuatorgravcomp", "jnt_actgravcomp", _SWITCH),
    CompiledField("group", "jnt_group"),
    CompiledField("user", "jnt_user"),
)
"""Of a joint, but for its type, place, range and references."""

BODY = (CompiledField("gravcomp", "body_gravcomp"), CompiledField("user", "body_user"))

SITE = (
    CompiledField("type", "site_type", GEOM_TYPES),
    CompiledField("size", "site_size"),
    CompiledField("rgba", "site_rgba"),
    CompiledField("group", "site_group"),
    CompiledField("user", "site_user"),
)

CONTACT = (
    CompiledField("contype", "geom_contype"),
    CompiledField("conaffinity", "geom_conaffinity"),
    CompiledField("condim", "geom_condim"),
    CompiledField("priority", "geom_priority"),
    CompiledField("friction", "geom_friction"),
    CompiledField("solmix", "geom_solmix"),
    CompiledField("solref", "geom_solref"),
    CompiledField("solimp", "geom_solimp"),
    CompiledField("margin", "geom_margin"),
    CompiledField("gap", "geom_gap"),
)

GEOM = (
    CompiledField("adhesion", "geom_adhesion"),
    CompiledField("surfacevel", "geom_surfacevel"),
    CompiledField("castshadow", "geom_castshadow", _SWITCH),
    CompiledField("user", "geom_user"),
)
"""Of a geom, but for its shape, contact and looks."""

EQUALITY = (CompiledField("solref", "eq_solref"), CompiledField("solimp", "eq_solimp"))

CAMERA = (
    CompiledField("mode", "cam_mode", _MODES),
    CompiledField("fovy", "cam_fovy"),
    CompiledField("ipd", "cam_ipd"),
    CompiledField("orthographic", "cam_orthographic", _SWITCH),
    CompiledField("projection", "cam_projection", {0: "perspective", 1: "orthographic"}),
    CompiledField("resolution", "cam_resolution"),
    CompiledField("user", "cam_user"),
)

LIGHT = (
    CompiledField("mode", "light_mode", _MODES),
    CompiledField("type", "light_type", _words("mjtLightType", "mjLIGHT_")),
    CompiledField("castshadow", "light_castshadow", _SWITCH),
    CompiledField("bulbradius", "light_bulbradius"),
    CompiledField("intensity", "light_intensity"),
    CompiledField("range", "light_range"),
    CompiledField("active", "light_active", _SWITCH),
    CompiledField("attenuation", "light_attenuation"),
    CompiledField("cutoff", "light_cutoff"),
    CompiledField("exponent", "light_exponent"),
    CompiledField("softness", "light_softness"),
    CompiledField("ambient", "light_ambient"),
    CompiledField("diffuse", "light_diffuse"),
    CompiledField("specular", "light_specular"),
)

TENDON = (
    CompiledField("range", "tendon_range", limited="tendon_limited"),
    CompiledField("actuatorfrcrange", "tendon_actfrcrange", limited="tendon_actfrclimited"),
    CompiledField("stiffness", "tendon_stiffness", more="tendon_stiffnesspoly"),
    CompiledField("springyield", "tendon_springyield"),
    CompiledField("damping", "tendon_damping", more="tendon_dampingpoly"),
    CompiledField("frictionloss", "tendon_frictionloss"),
    CompiledField("armature", "tendon_armature"),
    CompiledField("margin", "tendon_margin"),
    CompiledField("solreflimit", "tendon_solref_lim"),
    CompiledField("solimplimit", "tendon_solimp_lim"),
    CompiledField("solreffriction", "tendon_solref_fri"),
    CompiledField("solimpfriction", "tendon_solimp_fri"),
    CompiledField("group", "tendon_group"),
    CompiledField("user", "tendon_user"),
)

SPATIAL = (CompiledField("width", "tendon_width"), CompiledField("rgba", "tendon_rgba"))
"""What a spatial tendon has beside what each has."""

PAIR = (
    CompiledField("condim", "pair_dim"),
    CompiledField("friction", "pair_friction"),
    CompiledField("solref", "pair_solref"),
    CompiledField("solreffriction", "pair_solreffriction"),
    CompiledField("solimp", "pair_solimp"),
    CompiledField("margin", "pair_margin"),
    CompiledField("gap", "pair_gap"),
    CompiledField("adhesion", "pair_adhesion"),
)

DYN = ("none", "integrator", "filter", "filterexact", "muscle", "user")
GAIN = ("fixed", "affine", "muscle", "user")
BIAS = ("none", "affine", "muscle", "user")
"""The words of `general` that every MuJoCo has."""

ACTUATOR = (
    CompiledField("damping", "actuator_damping", more="actuator_dampingpoly"),
    CompiledField("armature", "actuator_armature"),
    CompiledField("group", "actuator_group"),
    CompiledField("user", "actuator_user"),
)
"""What an actuator of each type has."""

GENERAL = (
    CompiledField("dyntype", "actuator_dyntype", _words("mjtDyn", "mjDYN_", DYN)),
    CompiledField("gaintype", "actuator_gaintype", _words("mjtGain", "mjGAIN_", GAIN)),
    CompiledField("biastype", "actuator_biastype", _words("mjtBias", "mjBIAS_", BIAS)),
    CompiledField("gear", "actuator_gear"),
    CompiledField("cranklength", "actuator_cranklength"),
    CompiledField("ctrlrange", "actuator_ctrlrange", limited="actuator_ctrllimited"),
    CompiledField("forcerange", "actuator_forcerange", limited="actuator_forcelimited"),
    CompiledField("actrange", "actuator_actrange", limited="actuator_actlimited"),
    CompiledField("dynprm", "actuator_dynprm"),
    CompiledField("gainprm", "actuator_gainprm"),
    CompiledField("biasprm", "actuator_biasprm"),
    CompiledField("actearly", "actuator_actearly", _SWITCH),
    *ACTUATOR,
)

SENSOR = (
    CompiledField("noise", "sensor_noise"),
    CompiledField("cutoff", "sensor_cutoff"),
    CompiledField("user", "sensor_user"),
)

ARRAYS = frozenset(
    array
    for fields in (
        *(JOINT, BODY, SITE, CONTACT, GEOM, EQUALITY, CAMERA, LIGHT),
        *(TENDON, SPATIAL, PAIR, GENERAL, SENSOR),
    )
    for field in fields
    for array in (field.array, field.more)
)
"""The arrays of MuJoCo's model that are read."""


def attributes(
    model: Any, fields: Sequence[CompiledField], index: int, always: Collection[str] = ()
) -> Attributes:
    """The attributes of an element that are not MuJoCo's default, and those `always` written. `index`: its
    row in the arrays; of a joint's, see `joint_attributes`."""
    return tuple(_written(model, fields, lambda array: index, always))


def joint_attributes(model: Any, joint: int, always: Collection[str] = ()) -> Attributes:
    """Those of a joint, whose dynamics are in the arrays of its degrees of freedom."""
    dof = int(model.jnt_dofadr[joint])
    return tuple(_written(model, JOINT, lambda array: dof if array.startswith("dof_") else joint, always))


def _written(
    model: Any, fields: Sequence[CompiledField], row: Any, always: Collection[str]
) -> Iterator[tuple[str, str]]:
    for field in fields:
        if not hasattr(model, field.array) or (
            field.limited and not getattr(model, field.limited)[row(field.limited)]
        ):
            continue
        values = _numbers(model, field, row(field.array))
        usual = _numbers(bare(), field, -1)
        same = np.array_equal(values, usual) if values.shape == usual.shape else not values.any()
        if not same or field.limited or field.attribute in always:
            text = _text(field, values, getattr(model, field.array).dtype == np.float32)
            if text is not None:
                yield field.attribute, text


def _numbers(model: Any, field: CompiledField, index: int) -> Any:
    values = np.ravel(getattr(model, field.array)[index])
    if field.more and hasattr(model, field.more):
        more = np.ravel(getattr(model, field.more)[index])
        last = np.flatnonzero(more)
        values = np.concatenate([values, more[: last[-1] + 1]]) if len(last) else values
    return values


def _text(field: CompiledField, values: Any, single: bool) -> str | None:
    """None for a word that not every MuJoCo has."""
    if field.words is not None:
        return field.words.get(int(values[0]))
    # Single precision as it is typed: 0.8, not 0.800000011920929.
    return exact(float(str(value)) if single else float(value) for value in values)
