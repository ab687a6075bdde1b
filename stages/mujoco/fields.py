"""Reads attributes of elements from the arrays of MuJoCo's model.

An attribute is read only if its value differs from that in a model with required attributes alone. Arrays
that the installed MuJoCo lacks are skipped.
"""

from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any

import mujoco
import numpy as np

from linkwright.stages.formats.numbers import exact
from linkwright.stages.mujoco.names import controls_of
from linkwright.stages.robot.model.mjcf_extras import Attributes

_BARE = """<mujoco><worldbody><light/><camera/><geom name="floor" size="1"/>
<body name="a"><joint name="a"/><geom name="a" size="1"/><site name="a"/></body>
<body name="b"><joint name="b"/><geom name="b" size="1"/></body></worldbody>
<equality><weld body1="a" body2="b"/></equality><asset><material name="a"/></asset>
<contact><pair geom1="a" geom2="b"/></contact>
<tendon><fixed><joint joint="a" coef="1"/></fixed></tendon>
<actuator><general joint="a"/></actuator><sensor><clock/></sensor></mujoco>"""
"""A model with required attributes only. The last element of each kind has MuJoCo's defaults."""


@cache
def bare() -> Any:
    """Returns the model with required attributes only, which holds MuJoCo's defaults."""
    return mujoco.MjModel.from_xml_string(_BARE)


@dataclass(frozen=True, slots=True)
class CompiledField:
    """An attribute of MJCF, and the array of MuJoCo's model that holds its values."""

    attribute: str
    array: str

    words: Mapping[int, str] | None = None
    """Value → word in MJCF, for an enumeration; None for numbers."""

    limited: str = ""
    """The array that tells whether the attribute has an effect; "" if it always has."""

    more: str = ""
    """The array with further numbers of the attribute; "" without such an array."""


def _words(enum: str, prefix: str, only: Collection[str] | None = None) -> dict[int, str]:
    """Returns value → word of an enumeration of MuJoCo whose members begin with `prefix`; `only`: the words
    that are kept, None for all."""
    members: Mapping[str, Any] = getattr(mujoco, enum).__members__
    words = {int(value): name.removeprefix(prefix).lower() for name, value in members.items()}
    return {value: word for value, word in words.items() if only is None or word in only}


_BOOLEANS = {0: "false", 1: "true"}
_MODES = _words("mjtCamLight", "mjCAMLIGHT_")
"""Value → word of the mode of a camera or light."""

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
    CompiledField("actuatorgravcomp", "jnt_actgravcomp", _BOOLEANS),
    CompiledField("group", "jnt_group"),
    CompiledField("user", "jnt_user"),
)
"""Fields of a joint, except its type, place, range and references."""

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
    CompiledField("castshadow", "geom_castshadow", _BOOLEANS),
    CompiledField("user", "geom_user"),
)
"""Fields of a geom, except its shape, contact and looks."""

EQUALITY = (CompiledField("solref", "eq_solref"), CompiledField("solimp", "eq_solimp"))

CAMERA = (
    CompiledField("mode", "cam_mode", _MODES),
    CompiledField("fovy", "cam_fovy"),
    CompiledField("ipd", "cam_ipd"),
    CompiledField("orthographic", "cam_orthographic", _BOOLEANS),
    CompiledField("projection", "cam_projection", {0: "perspective", 1: "orthographic"}),
    CompiledField("resolution", "cam_resolution"),
    CompiledField("user", "cam_user"),
)

LIGHT = (
    CompiledField("mode", "light_mode", _MODES),
    CompiledField("type", "light_type", _words("mjtLightType", "mjLIGHT_")),
    CompiledField("castshadow", "light_castshadow", _BOOLEANS),
    CompiledField("bulbradius", "light_bulbradius"),
    CompiledField("intensity", "light_intensity"),
    CompiledField("range", "light_range"),
    CompiledField("active", "light_active", _BOOLEANS),
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
"""Fields that only spatial tendons have."""

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

DYN_WORDS = ("none", "integrator", "filter", "filterexact", "muscle", "user")
GAIN_WORDS = ("fixed", "affine", "muscle", "user")
BIAS_WORDS = ("none", "affine", "muscle", "user")
"""Words of the types of <general> that all versions of MuJoCo have."""

ACTUATOR = (
    CompiledField("damping", "actuator_damping", more="actuator_dampingpoly"),
    CompiledField("armature", "actuator_armature"),
    CompiledField("group", "actuator_group"),
    CompiledField("user", "actuator_user"),
)
"""Fields that actuators of all types have."""

GENERAL = (
    CompiledField("dyntype", "actuator_dyntype", _words("mjtDyn", "mjDYN_", DYN_WORDS)),
    CompiledField("gaintype", "actuator_gaintype", _words("mjtGain", "mjGAIN_", GAIN_WORDS)),
    CompiledField("biastype", "actuator_biastype", _words("mjtBias", "mjBIAS_", BIAS_WORDS)),
    CompiledField("gear", "actuator_gear"),
    CompiledField("cranklength", "actuator_cranklength"),
    CompiledField("ctrlrange", "actuator_ctrlrange", limited="actuator_ctrllimited"),
    CompiledField("forcerange", "actuator_forcerange", limited="actuator_forcelimited"),
    CompiledField("actrange", "actuator_actrange", limited="actuator_actlimited"),
    CompiledField("dynprm", "actuator_dynprm"),
    CompiledField("gainprm", "actuator_gainprm"),
    CompiledField("biasprm", "actuator_biasprm"),
    CompiledField("actearly", "actuator_actearly", _BOOLEANS),
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
"""All arrays of MuJoCo's model that hold values of these fields, and "" for fields without a second array."""


def attributes(
    model: Any, fields: Sequence[CompiledField], index: int, always: Collection[str] = ()
) -> Attributes:
    """Returns the attributes of an element that differ from MuJoCo's defaults, and those in `always`.
    `index`: the row of the element in all arrays. For joints use `joint_attributes`, and for the types of
    actuators `general_attributes`."""
    return tuple(_attributes(model, fields, lambda array: index, always))


def joint_attributes(model: Any, joint: int, always: Collection[str] = ()) -> Attributes:
    """Returns the attributes of a joint, whose dynamics are in the arrays of its degrees of freedom."""
    dof = int(model.jnt_dofadr[joint])
    return tuple(_attributes(model, JOINT, lambda array: dof if array.startswith("dof_") else joint, always))


def general_attributes(model: Any, actuator: int, always: Collection[str] = ()) -> Attributes:
    """Returns the attributes of an actuator as <general>, with the range of its first control."""
    control = controls_of(model, actuator).start

    def row(array: str) -> int:
        return control if array.startswith("actuator_ctrl") else actuator

    return tuple(_attributes(model, GENERAL, row, always))


def _attributes(
    model: Any, fields: Sequence[CompiledField], row: Callable[[str], int], always: Collection[str]
) -> Iterator[tuple[str, str]]:
    """Yields the attributes of an element. `row`: tells the element's row in an array of this name."""
    for field in fields:
        if not hasattr(model, field.array) or (
            field.limited and not getattr(model, field.limited)[row(field.limited)]
        ):
            continue
        values = _numbers(model, field, row(field.array))
        default = _numbers(bare(), field, -1)
        # Values of another length than the default, such as `user`, are default if all are 0.
        is_default = np.array_equal(values, default) if values.shape == default.shape else not values.any()
        if not is_default or field.limited or field.attribute in always:
            text = _text(field, values, getattr(model, field.array).dtype == np.float32)
            if text is not None:
                yield field.attribute, text


def _numbers(model: Any, field: CompiledField, index: int) -> Any:
    """Returns the numbers of a field in a row of its array, then those of its array `more` up to the last
    that is not 0."""
    values = np.ravel(getattr(model, field.array)[index])
    if field.more and hasattr(model, field.more):
        further = np.ravel(getattr(model, field.more)[index])
        nonzero = np.flatnonzero(further)
        values = np.concatenate([values, further[: nonzero[-1] + 1]]) if len(nonzero) else values
    return values


def _text(field: CompiledField, values: Any, is_single: bool) -> str | None:
    """Returns the text of values; None for a value without a word. `is_single`: whether they are float32."""
    if field.words is not None:
        return field.words.get(int(values[0]))
    # The shortest text of a float32 is 0.8, and that of the same double 0.800000011920929.
    return exact(float(str(value)) if is_single else float(value) for value in values)
