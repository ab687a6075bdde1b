"""Reports by name every element or attribute of an MJCF that our robot model cannot represent."""

from collections.abc import Collection, Iterable, Iterator, Mapping
from typing import Any

import mujoco
import numpy as np

from stages.fetch.mjcf.keyframes import left_of_keyframes
from stages.fetch.mjcf.textures import Textures
from stages.fetch.mjcf.unsupported_fields import (
    Omission,
    of_elements,
    of_options,
    of_the_file,
    of_the_viewer,
    touches,
)
from stages.robot.errors import Diagnostic

_SOLID = (
    mujoco.mjtGeom.mjGEOM_BOX,
    mujoco.mjtGeom.mjGEOM_SPHERE,
    mujoco.mjtGeom.mjGEOM_CYLINDER,
    mujoco.mjtGeom.mjGEOM_CAPSULE,
    mujoco.mjtGeom.mjGEOM_MESH,
)

_SHOWN = 5
"""The most names of each kind that are reported."""


def left_out(
    model: Any,
    spec: Any,
    kept: Collection[int],
    textures: Textures,
    where: str,
    driven: Collection[int] = (),
    measured: Collection[int] = (),
) -> Iterator[Diagnostic]:
    """W-MJCF-LEFT for omissions that affect motion or contact, I-MJCF-LEFT for the rest.

    `spec`: the spec from which `model` was compiled. `kept`: the bodies that become links. `textures`: those
    that are carried over; `driven` and `measured`: the actuators and sensors that are.
    """
    equalities = [eq for eq in range(model.neq) if carried(model, eq, kept)]
    found = [
        *_bodies(model, kept),
        *_joints(model, kept),
        *_ties(model, kept, equalities),
        *_geoms(model, kept),
        *of_elements(model, kept, equalities, textures.materials, driven, measured),
        *of_options(model),
        *_elements(model, {"texture": textures.carried, "actuator": driven, "sensor": measured}),
        *left_of_keyframes(model, driven),
        *of_the_viewer(model),
        *of_the_file(spec),
    ]
    affects_motion = [_text(one) for one in found if one.affects_motion]
    if affects_motion:
        text = f"not carried over, so the robot may move differently: {'; '.join(affects_motion)}"
        yield Diagnostic("W-MJCF-LEFT", text, where, "check whether the robot needs it")
    beside = [_text(one) for one in found if not one.affects_motion]
    if beside:
        text = f"not carried over (not part of the mechanism): {'; '.join(beside)}"
        yield Diagnostic("I-MJCF-LEFT", text, where)


def _text(left: Omission) -> str:
    """The omitted attribute, its number, and the names of the first elements."""
    if not left.names:
        return left.words
    shown = [name for name in left.names if name][:_SHOWN]
    more = ", ..." if shown and len(shown) < len(left.names) else ""
    return f"{len(left.names)} × {left.words}" + (f" ({', '.join(shown)}{more})" if shown else "")


def carried(model: Any, eq: int, kept: Collection[int]) -> bool:
    """Whether our robot model can represent an equality: a connect, a weld, or a joint that follows another
    in proportion, between bodies that are kept."""
    kind, first, second = (int(model.eq_type[eq]), int(model.eq_obj1id[eq]), int(model.eq_obj2id[eq]))
    if not model.eq_active0[eq]:
        return False
    if kind == mujoco.mjtEq.mjEQ_JOINT:
        straight = second >= 0 and model.eq_data[eq][1] != 0 and not model.eq_data[eq][2:5].any()
        return straight and all(int(model.jnt_bodyid[joint]) in kept for joint in (first, second))
    if kind not in (mujoco.mjtEq.mjEQ_CONNECT, mujoco.mjtEq.mjEQ_WELD):
        return False
    if model.eq_objtype[eq] == mujoco.mjtObj.mjOBJ_SITE:
        first, second = int(model.site_bodyid[first]), int(model.site_bodyid[second])
    return first in kept and second in kept


def _some(words: str, affects_motion: bool, names: Iterable[str]) -> Iterator[Omission]:
    """The omissions that occur."""
    every = tuple(names)
    if every:
        yield Omission(words, affects_motion, every)


def _bodies(model: Any, kept: Collection[int]) -> Iterator[Omission]:
    """Mocap bodies, and how bodies sleep."""
    yield from _some("body mocap", True, (model.body(b).name for b in range(model.nbody) if b not in kept))
    policies = getattr(model, "tree_sleep_policy", ())  # of MuJoCo 3.4 and later
    trees = (tree for tree, policy in enumerate(policies) if "AUTO" not in mujoco.mjtSleepPolicy(policy).name)
    yield from _some("body sleep", False, (model.body(int(model.tree_bodyadr[tree])).name for tree in trees))


def _joints(model: Any, kept: Collection[int]) -> Iterator[Omission]:
    """Springs with another rest value, ranges that are not limits, and attributes of a free joint."""
    joints = [joint for joint in range(model.njnt) if int(model.jnt_bodyid[joint]) in kept]
    of = {kind: [joint for joint in joints if model.jnt_type[joint] == kind] for kind in range(4)}
    scalar = [*of[mujoco.mjtJoint.mjJNT_HINGE], *of[mujoco.mjtJoint.mjJNT_SLIDE]]
    balls, afloat = of[mujoco.mjtJoint.mjJNT_BALL], of[mujoco.mjtJoint.mjJNT_FREE]

    def named(words: str, found: Iterable[int]) -> Iterator[Omission]:
        return _some(words, True, (model.joint(joint).name for joint in sorted(found)))

    rest = model.qpos_spring[model.jnt_qposadr]
    yield from named("joint springref", (joint for joint in scalar if rest[joint]))
    yield from named("joint range of a ball", (joint for joint in balls if model.jnt_limited[joint]))
    uneven = ~np.isclose(-model.jnt_actfrcrange[:, 0], model.jnt_actfrcrange[:, 1])
    bounded = (joint for joint in joints if model.jnt_actfrclimited[joint])
    uneven_bounds = (joint for joint in bounded if uneven[joint] or joint not in scalar)
    yield from named("joint actuatorfrcrange that is not symmetric", uneven_bounds)
    for word in ("damping", "armature", "frictionloss"):
        values = getattr(model, f"dof_{word}")
        acting = (joint for joint in afloat if values[model.jnt_dofadr[joint] :][:6].any())
        yield from named(f"joint {word} of a free joint", acting)


def _ties(model: Any, kept: Collection[int], carried_over: Collection[int]) -> Iterator[Omission]:
    """Equalities, tendons and deformable bodies."""
    lost = (model.equality(eq).name for eq in range(model.neq) if eq not in carried_over)
    yield from _some("equality", True, lost)
    welds = (eq for eq in carried_over if model.eq_type[eq] == mujoco.mjtEq.mjEQ_WELD)
    torques = (model.equality(eq).name for eq in welds if model.eq_data[eq][10] != 1)
    yield from _some("weld torquescale", True, torques)
    yield from _some("tendon", True, (model.tendon(tendon).name for tendon in range(model.ntendon)))
    yield from _some("flex", True, _names(model, mujoco.mjtObj.mjOBJ_FLEX, model.nflex))


def _geoms(model: Any, kept: Collection[int]) -> Iterator[Omission]:
    """Geoms that are left out, and combined attributes of the other geoms."""
    every = range(model.ngeom)
    own = [geom for geom in every if model.geom_bodyid[geom] and int(model.geom_bodyid[geom]) in kept]
    solid = [geom for geom in own if int(model.geom_type[geom]) in _SOLID]

    def named(geoms: Iterable[int]) -> Iterator[str]:
        return (model.geom(geom).name for geom in geoms)

    yield from _some("geom type (ellipsoid, field, plane, ...)", True, named(set(own) - set(solid)))
    bits = (
        g for g in solid if touches(model, g) and (model.geom_contype[g], model.geom_conaffinity[g]) != (1, 1)
    )
    yield from _some("geom contype, conaffinity", False, named(bits))
    unseen = (geom for geom in solid if not touches(model, geom) and not _alpha(model, geom))
    yield from _some("geom that is neither visible nor collides", False, named(unseen))
    yield from _some("geom name", False, (name for name in named(solid) if name))
    yield from _some("site without a name", False, ("" for s in range(model.nsite) if not model.site(s).name))
    yield from _some("geom of the world", False, named(geom for geom in every if not model.geom_bodyid[geom]))


def _alpha(model: Any, geom: int) -> float:
    material = int(model.geom_matid[geom])
    own = model.geom_rgba[geom]
    plain = np.array_equal(own, np.array((0.5, 0.5, 0.5, 1), dtype=own.dtype))
    return float(model.mat_rgba[material][3] if plain and material >= 0 else own[3])


_KINDS = {
    "sensor": ("mjOBJ_SENSOR", "nsensor"),
    "camera": ("mjOBJ_CAMERA", "ncam"),
    "light": ("mjOBJ_LIGHT", "nlight"),
    "contact pair": ("mjOBJ_PAIR", "npair"),
    "contact exclude": ("mjOBJ_EXCLUDE", "nexclude"),
    "texture": ("mjOBJ_TEXTURE", "ntex"),
    "height field": ("mjOBJ_HFIELD", "nhfield"),
    "skin": ("mjOBJ_SKIN", "nskin"),
    "custom numeric": ("mjOBJ_NUMERIC", "nnumeric"),
    "custom text": ("mjOBJ_TEXT", "ntext"),
    "custom tuple": ("mjOBJ_TUPLE", "ntuple"),
    "plugin": ("mjOBJ_PLUGIN", "nplugin"),
}
"""Elements that are left out as a whole: MuJoCo's name of each, and the field with its number."""


def _elements(model: Any, carried_over: Mapping[str, Collection[int]]) -> Iterator[Omission]:
    """Elements of each kind but for those that are carried over, by their numbers."""
    every = {
        words: _names(model, getattr(mujoco.mjtObj, kind), getattr(model, count))
        for words, (kind, count) in _KINDS.items()
    }
    every["actuator"] = _names(model, mujoco.mjtObj.mjOBJ_ACTUATOR, len(model.actuator_trntype))
    for words, names in every.items():
        lost = (name for number, name in enumerate(names) if number not in carried_over.get(words, ()))
        yield from _some(words, False, lost)


def _names(model: Any, kind: Any, count: int) -> list[str]:
    return [mujoco.mj_id2name(model, kind, number) or "" for number in range(count)]
