"""Attributes and options of an MJCF that our robot model cannot represent, found in MuJoCo's compiled model.

The compiled model is compared with an empty model of the same MuJoCo, so it does not matter where a value
comes from (a default, an include), and values equal to MuJoCo's default are not reported. Fields that a later
MuJoCo adds are reported too, until they are listed here as carried over.
"""

from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any

import mujoco
import numpy as np

_PLAIN = """<mujoco><asset><material name="m"/></asset><worldbody>
<body name="a"><joint name="a"/><geom size="1"/><site/></body><body name="b"><joint/><geom size="1"/></body>
</worldbody><equality><weld body1="a" body2="b"/></equality><actuator><general joint="a"/></actuator>
<sensor><clock/></sensor></mujoco>"""
"""A model that sets nothing but what is required."""


@dataclass(frozen=True, slots=True)
class Omission:
    """An attribute or option that is not carried over: `words` name it as an MJCF does, and `names` are the
    elements that set it ("" for an element without a name; empty for an option of the whole model).
    `affects_motion`: without it the robot may move differently."""

    words: str
    affects_motion: bool
    names: tuple[str, ...] = ()


_CARRIED: Mapping[str, Collection[str]] = {
    "jnt": ("type", "pos", "axis", "limited", "range", "actfrclimited", "actfrcrange"),
    "dof": ("frictionloss", "armature", "damping", "M0", "length"),
    "body": (
        *("pos", "quat", "ipos", "iquat", "mass", "inertia", "subtreemass", "simple", "sameframe"),
        *("conaffinity", "contype", "margin", "plugin"),
    ),
    "geom": (
        *("type", "pos", "quat", "size", "rgba", "matid", "dataid", "group", "contype", "conaffinity"),
        *("aabb", "rbound", "sameframe", "plugin"),
    ),
    "site": ("pos", "quat", "sameframe"),
    "eq": ("type", "objtype", "data", "active0"),
    "mat": ("rgba",),
    "actuator": (
        *("trntype", "dyntype", "gaintype", "biastype", "dynprm", "gainprm", "biasprm", "gear"),
        *("ctrllimited", "ctrlrange", "forcelimited", "forcerange", "actlimited", "actrange", "actearly"),
        *("length0", "acc0", "lengthrange", "ctrlspec"),
    ),
    "sensor": ("type", "datatype", "needstage", "objtype", "reftype", "dim", "noise", "cutoff", "intprm"),
}
"""Fields that are carried over, that follow from such fields, or that `unsupported` reports."""

_PLACES = ("id", "adr", "num", "invweight0")
_NO_PLACES = ("fluid", "texid", "matid", "dataid")
"""Endings of the names of fields that are only indices or derived values; and the exceptions."""

_WORDS: Mapping[str, str] = {
    "jnt_stiffnesspoly": "joint stiffness",
    "jnt_solref": "joint solreflimit",
    "jnt_solimp": "joint solimplimit",
    "jnt_actgravcomp": "joint actuatorgravcomp",
    "dof_solref": "joint solreffriction",
    "dof_solimp": "joint solimpfriction",
    "dof_dampingpoly": "joint damping (polynomial)",
    "geom_fluid": "geom fluidshape, fluidcoef",
    "mat_texid": "material texture",
    "site_matid": "site material",
    "site_dataid": "site mesh",
}
"""Field of MuJoCo's model → the attribute of an MJCF, where their names differ."""

_ELEMENTS = {"jnt": "joint", "dof": "joint", "eq": "equality", "mat": "material"}

_OF_CONTACT = (
    *("geom_condim", "geom_friction", "geom_priority", "geom_solref", "geom_solimp", "geom_solmix"),
    *("geom_margin", "geom_gap", "geom_adhesion", "geom_surfacevel"),
)
"""Fields that matter only for geoms that can collide."""

_LIGHT = (
    *("jnt_group", "jnt_user", "body_user", "geom_user", "geom_castshadow", *_OF_CONTACT),
    *("actuator_group", "actuator_user", "sensor_"),
    *("site_", "mat_"),
)
"""Fields, or beginnings of their names, that do not change how the robot itself moves."""

_WORLD = ("gravity", "wind", "density", "viscosity")
"""Options that act on every body."""

_FLAGS = (
    *("constraint", "equality", "frictionloss", "limit", "contact", "passive", "spring", "damper"),
    *("gravity", "clampctrl", "actuation", "filterparent", "override"),
)
"""Flags that change how the robot moves."""

_NEAR = 0.01
"""Largest difference of gravity [m/s²] from MuJoCo's that is not reported: 9.8 and 9.80665 mean the same."""


@cache
def _plain() -> Any:
    return mujoco.MjModel.from_xml_string(_PLAIN)


def of_elements(
    model: Any,
    kept: Collection[int],
    carried: Collection[int],
    textured: Collection[int],
    driven: Collection[int] = (),
    measured: Collection[int] = (),
) -> Iterator[Omission]:
    """The omissions of the elements on the bodies `kept`, of the equalities `carried`, of the materials, and
    of the actuators and sensors that are carried over (`driven`, `measured`); the materials that are
    `textured` keep their textures."""
    rows: Mapping[str, Sequence[int]] = {
        "jnt": [n for n in range(model.njnt) if int(model.jnt_bodyid[n]) in kept],
        "dof": [n for n in range(model.nv) if int(model.dof_bodyid[n]) in kept],
        "body": [n for n in sorted(kept) if n],
        "geom": [n for n in range(model.ngeom) if _on_a_robot(int(model.geom_bodyid[n]), kept)],
        "site": [n for n in range(model.nsite) if _on_a_robot(int(model.site_bodyid[n]), kept)],
        "eq": sorted(carried),
        "mat": range(model.nmat),
        "actuator": sorted(driven),
        "sensor": sorted(measured),
    }
    found: dict[str, Omission] = {}
    for kind, numbers in rows.items():
        for field in _fields(kind):
            whole = f"{kind}_{field}"
            concerned = [n for n in numbers if whole not in _OF_CONTACT or touches(model, n)]
            if whole == "mat_texid":
                concerned = [n for n in concerned if n not in textured]
            names = [_NAMES[kind](model, n) for n in _differing(model, whole, concerned)]
            if names:
                words = _WORDS.get(whole, f"{_ELEMENTS.get(kind, kind)} {field}")
                before = found[words].names if words in found else ()
                every = before + tuple(name for name in names if not name or name not in before)
                found[words] = Omission(words, not whole.startswith(_LIGHT), every)
    yield from found.values()


def _on_a_robot(body: int, kept: Collection[int]) -> bool:
    return body > 0 and body in kept


def touches(model: Any, geom: int) -> bool:
    """Whether another geom can collide with this one."""
    return bool(model.geom_contype[geom] or model.geom_conaffinity[geom])


@cache
def _fields(kind: str) -> tuple[str, ...]:
    """The fields of a kind of element that are not carried over, in the order of their names."""
    names = (name.removeprefix(f"{kind}_") for name in dir(_plain()) if name.startswith(f"{kind}_"))
    return tuple(
        name
        for name in names
        if name not in _CARRIED[kind] and (name in _NO_PLACES or not name.endswith(_PLACES))
    )


def _differing(model: Any, field: str, numbers: Sequence[int]) -> list[int]:
    """The elements whose value of the field differs from that in an empty model."""
    if not numbers:
        return []
    values = getattr(model, field)[list(numbers)].reshape(len(numbers), -1)
    usual = np.ravel(getattr(_plain(), field)[0])
    if values.shape[1] != usual.size:  # the length of `user` differs between models
        usual = np.zeros(1)
    differs = ~np.isclose(values, usual, rtol=1e-6, atol=1e-12).all(axis=1)
    return [number for number, is_set in zip(numbers, differs, strict=True) if is_set]


def _named(kind: Any) -> Callable[[Any, int], str]:
    return lambda model, number: mujoco.mj_id2name(model, kind, number) or ""


def _of_dof(model: Any, dof: int) -> str:
    return mujoco.mj_id2name(model, mujoco.mjtObj.mjOBJ_JOINT, int(model.dof_jntid[dof])) or ""


_NAMES: Mapping[str, Callable[[Any, int], str]] = {
    "jnt": _named(mujoco.mjtObj.mjOBJ_JOINT),
    "dof": _of_dof,
    "body": _named(mujoco.mjtObj.mjOBJ_BODY),
    "geom": _named(mujoco.mjtObj.mjOBJ_GEOM),
    "site": _named(mujoco.mjtObj.mjOBJ_SITE),
    "eq": _named(mujoco.mjtObj.mjOBJ_EQUALITY),
    "mat": _named(mujoco.mjtObj.mjOBJ_MATERIAL),
    "actuator": _named(mujoco.mjtObj.mjOBJ_ACTUATOR),
    "sensor": _named(mujoco.mjtObj.mjOBJ_SENSOR),
}


def of_options(model: Any) -> Iterator[Omission]:
    """Options and flags that differ from MuJoCo's defaults."""
    for field in _members(model.opt):
        value, usual = (np.atleast_1d(getattr(one.opt, field)) for one in (model, _plain()))
        if field.endswith("flags"):
            yield from _flags(field, int(value[0]), int(usual[0]))
        elif not np.allclose(value, usual, rtol=1e-6, atol=_NEAR if field == "gravity" else 1e-15):
            yield Omission(f"option {_OPTIONS.get(field, field)}{_value(field, value)}", field in _WORLD)


_OPTIONS = {"disableactuator": "actuatorgroupdisable"}

_CHOICES: Mapping[str, Any] = {
    "cone": mujoco.mjtCone,
    "integrator": mujoco.mjtIntegrator,
    "jacobian": mujoco.mjtJacobian,
    "solver": mujoco.mjtSolver,
}


def _value(field: str, value: Any) -> str:
    """An option's value as an MJCF writes it; "" where MuJoCo's model stores it in another form."""
    if field in _CHOICES:
        return f'="{_CHOICES[field](int(value[0])).name.split("_", 1)[1].lower()}"'
    return "" if field in _OPTIONS else f'="{_text(value)}"'


def _flags(field: str, value: int, usual: int) -> Iterator[Omission]:
    kinds = mujoco.mjtDisableBit if field == "disableflags" else mujoco.mjtEnableBit
    for name, flag in kinds.__members__.items():
        bit = int(flag)
        if bit.bit_count() == 1 and not name.startswith("mjN") and (value ^ usual) & bit:
            word = name.split("_", 1)[1].lower()
            on = bool(value & bit) == (field == "enableflags")
            yield Omission(f'flag {word}="{"enable" if on else "disable"}"', word in _FLAGS)


def of_the_viewer(model: Any) -> Iterator[Omission]:
    """The parts of <visual> that are set, and their attributes."""
    for part in _members(model.vis):
        mine, plain = getattr(model.vis, part), getattr(_plain().vis, part)
        names = [n for n in _members(mine) if not np.array_equal(getattr(mine, n), getattr(plain, n))]
        if names:
            yield Omission(f"visual {part.removesuffix('_')}", False, tuple(names))


_SIZES = ("memory", "nconmax", "njmax", "nkey", "nuser")
"""Beginnings of the attributes of <size>."""


def of_the_file(spec: Any) -> Iterator[Omission]:
    """What <size> and <statistic> set; the compiled model does not separate these from derived values."""
    fresh = mujoco.MjSpec()
    for name in (name for name in dir(fresh) if name.startswith(_SIZES)):
        if getattr(spec, name) != getattr(fresh, name):
            yield Omission(f'size {name}="{getattr(spec, name)}"', False)
    for name in _members(spec.stat):
        value, usual = (np.atleast_1d(getattr(one.stat, name)).astype(float) for one in (spec, fresh))
        if not np.array_equal(value, usual, equal_nan=True):
            yield Omission(f'statistic {name}="{_text(value)}"', False)


def _members(struct: Any) -> list[str]:
    return [name for name in dir(struct) if not name.startswith("_") and not callable(getattr(struct, name))]


def _text(value: Any) -> str:
    return " ".join(f"{float(one):g}" for one in value)
