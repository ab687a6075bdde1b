"""What an MJCF says that a robot of ours does not hold: told by name, never dropped in silence."""

from collections.abc import Collection, Iterator, Mapping, Sequence
from typing import Any

import mujoco
import numpy as np

from stages.robot.errors import Diagnostic

_SOLID = (
    mujoco.mjtGeom.mjGEOM_BOX,
    mujoco.mjtGeom.mjGEOM_SPHERE,
    mujoco.mjtGeom.mjGEOM_CYLINDER,
    mujoco.mjtGeom.mjGEOM_CAPSULE,
    mujoco.mjtGeom.mjGEOM_MESH,
)

_USUAL: Mapping[str, Sequence[float]] = {
    "geom_friction": (1.0, 0.005, 0.0001),
    "geom_condim": (3,),
    "geom_priority": (0,),
    "geom_solref": (0.02, 1.0),
    "geom_solimp": (0.9, 0.95, 0.001, 0.5, 2.0),
    "geom_margin": (0.0,),
    "geom_gap": (0.0,),
    "geom_solmix": (1.0,),
}
"""MuJoCo's own defaults of how geoms touch."""


def left_out(model: Any, kept: Collection[int], where: str) -> Iterator[Diagnostic]:
    """W-MJCF-LEFT for what changes how the robot moves or what it touches, I-MJCF-LEFT for the rest.

    `kept`: the bodies that are not left out.
    """
    weighty = _listed(_weighty(model, kept))
    if weighty:
        text = f"not carried over, though the robot moves otherwise without: {weighty}"
        yield Diagnostic("W-MJCF-LEFT", text, where, "look whether the robot can do without")
    beside = _listed(_beside(model))
    if beside:
        text = f"not carried over, as it is no part of the mechanism: {beside}"
        yield Diagnostic("I-MJCF-LEFT", text, where)


def carried(model: Any, eq: int, kept: Collection[int]) -> bool:
    """Whether a robot of ours holds an equality: a connect, a weld, or a joint that follows another in
    proportion; among bodies that are kept."""
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


def _weighty(model: Any, kept: Collection[int]) -> Mapping[str, list[str]]:
    bodies, joints = range(1, model.nbody), range(model.njnt)
    ball = mujoco.mjtJoint.mjJNT_BALL
    stiff = [j for j in joints if model.jnt_stiffness[j] or model.jnt_stiffnesspoly[j].any()]
    curved = [j for j in joints if model.dof_dampingpoly[model.jnt_dofadr[j]].any()]
    shapes = [
        g
        for g in range(model.ngeom)
        if int(model.geom_type[g]) not in _SOLID and int(model.geom_bodyid[g]) in kept
    ]
    found = {
        "posed body": [model.body(b).name for b in bodies if b not in kept],
        "spring": [model.joint(j).name for j in stiff],
        "uneven damping": [model.joint(j).name for j in curved],
        "range of a ball": [
            model.joint(j).name for j in joints if model.jnt_type[j] == ball and model.jnt_limited[j]
        ],
        "gravity compensation": [model.body(b).name for b in bodies if model.body_gravcomp[b]],
        "shape (ellipsoid, field or plane)": [model.geom(g).name for g in shapes if model.geom_bodyid[g]],
        "equality": [model.equality(e).name for e in range(model.neq) if not carried(model, e, kept)],
        "tendon": [model.tendon(t).name for t in range(model.ntendon)],
        "flexible body": _names(model, mujoco.mjtObj.mjOBJ_FLEX, model.nflex),
    }
    if not np.allclose(model.opt.gravity, (0.0, 0.0, -9.81), atol=0.01):
        found["gravity"] = [" ".join(f"{value:g}" for value in model.opt.gravity)]
    return found


def _beside(model: Any) -> Mapping[str, list[str]]:
    kinds = {
        "actuator": (mujoco.mjtObj.mjOBJ_ACTUATOR, model.nactuator),
        "sensor": (mujoco.mjtObj.mjOBJ_SENSOR, model.nsensor),
        "keyframe": (mujoco.mjtObj.mjOBJ_KEY, model.nkey),
        "camera": (mujoco.mjtObj.mjOBJ_CAMERA, model.ncam),
        "light": (mujoco.mjtObj.mjOBJ_LIGHT, model.nlight),
        "contact pair": (mujoco.mjtObj.mjOBJ_PAIR, model.npair),
        "contact exclude": (mujoco.mjtObj.mjOBJ_EXCLUDE, model.nexclude),
        "texture": (mujoco.mjtObj.mjOBJ_TEXTURE, model.ntex),
        "skin": (mujoco.mjtObj.mjOBJ_SKIN, model.nskin),
        "custom number": (mujoco.mjtObj.mjOBJ_NUMERIC, model.nnumeric),
        "custom text": (mujoco.mjtObj.mjOBJ_TEXT, model.ntext),
        "tuple": (mujoco.mjtObj.mjOBJ_TUPLE, model.ntuple),
        "plugin": (mujoco.mjtObj.mjOBJ_PLUGIN, model.nplugin),
    }
    found = {kind: _names(model, of, count) for kind, (of, count) in kinds.items()}
    geoms = range(model.ngeom)
    found["shape of the world"] = [model.geom(g).name for g in geoms if not model.geom_bodyid[g]]
    found["way of touching (friction, condim, solref ...)"] = [
        model.geom(g).name
        for g in geoms
        if model.geom_bodyid[g]
        and (model.geom_contype[g] or model.geom_conaffinity[g])
        and any(not np.allclose(getattr(model, name)[g], usual) for name, usual in _USUAL.items())
    ]
    return found


def _names(model: Any, kind: Any, count: int) -> list[str]:
    return [mujoco.mj_id2name(model, kind, number) or "" for number in range(count)]


def _listed(found: Mapping[str, list[str]]) -> str:
    """Kinds, each with its number and the names of the first few."""
    texts = []
    for kind, names in found.items():
        if not names:
            continue
        shown = [name for name in names if name][:5]
        more = ", ..." if shown and len(shown) < len(names) else ""
        texts.append(f"{len(names)} × {kind}" + (f" ({', '.join(shown)}{more})" if shown else ""))
    return "; ".join(texts)
