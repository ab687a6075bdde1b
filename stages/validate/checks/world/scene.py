"""The scene has the robot of the MJCF as that has it: nothing that the scene says changes it."""

from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import mujoco
import numpy as np

from linkwright.stages.mujoco.compile import NotCompiled, compiled_file
from linkwright.stages.mujoco.names import index_of, name_of
from linkwright.stages.mujoco.warnings import deprecations
from linkwright.stages.robot.check import Check, Finding
from linkwright.stages.validate.compiled import CompiledModel
from linkwright.stages.validate.findings import differs, few, named
from linkwright.stages.validate.model.coordinates import SAME
from linkwright.stages.validate.model.equalities import bodies, sites

OBJ = mujoco.mjtObj

ARRAYS = {
    ("body", OBJ.mjOBJ_BODY): (
        ("inertial mass", "body_mass"),
        ("inertial diaginertia", "body_inertia"),
        ("inertial pos", "body_ipos"),
        ("pos", "body_pos"),
        ("quat", "body_quat"),
        ("gravcomp", "body_gravcomp"),
    ),
    ("joint", OBJ.mjOBJ_JOINT): (
        ("pos", "jnt_pos"),
        ("axis", "jnt_axis"),
        ("range", "jnt_range"),
        ("range", "jnt_limited"),
        ("actuatorfrcrange", "jnt_actfrcrange"),
        ("stiffness", "jnt_stiffness"),
    ),
    ("geom", OBJ.mjOBJ_GEOM): (
        ("size", "geom_size"),
        ("pos", "geom_pos"),
        ("contype", "geom_contype"),
        ("conaffinity", "geom_conaffinity"),
        ("friction", "geom_friction"),
    ),
    ("equality", OBJ.mjOBJ_EQUALITY): (
        ("active", "eq_active0"),
        ("solref", "eq_solref"),
        ("polycoef", "eq_data"),
    ),
    ("actuator", OBJ.mjOBJ_ACTUATOR): (
        ("gear", "actuator_gear"),
        ("gainprm", "actuator_gainprm"),
        ("biasprm", "actuator_biasprm"),
        ("ctrlrange", "actuator_ctrlrange"),
        ("forcerange", "actuator_forcerange"),
    ),
}
"""What has a name in a model, and the numbers that a scene must leave as they are."""

NUMBERS = {
    OBJ.mjOBJ_BODY: "nbody",
    OBJ.mjOBJ_JOINT: "njnt",
    OBJ.mjOBJ_GEOM: "ngeom",
    OBJ.mjOBJ_EQUALITY: "neq",
    OBJ.mjOBJ_ACTUATOR: "nu",
}
"""How many a model has of each."""

DOFS = (("damping", "dof_damping"), ("frictionloss", "dof_frictionloss"), ("armature", "dof_armature"))
"""The numbers of a joint's degrees of freedom."""


def check(compiled: CompiledModel) -> Iterator[Check]:
    """Of a scene that has an MJCF of the robot beside it, which compiles."""
    own = compiled.path.with_name(f"{compiled.robot.name}.xml")
    if not own.exists() or own == compiled.path or compiled.written.amendments.of(compiled.path.name):
        return
    robot = _compiled(own)
    if robot is None:
        return
    findings = few((*_changed(robot, compiled.model), *_added(robot, compiled.model)))
    detail = f"the robot is that of {own.name}"
    if findings:
        detail = (
            f"what the scene changes of the robot of {own.name}: {', '.join(one.element for one in findings)}"
        )
    yield compiled.within("robot in the scene", float(len(findings)), 0.0, detail, findings)


def _compiled(path: Path) -> Any:
    with deprecations([]):
        try:
            return compiled_file(path)
        except NotCompiled:
            return None


def _changed(robot: Any, scene: Any) -> Iterator[Finding]:
    for (tag, kind), rows in ARRAYS.items():
        for name, first, second in _both(robot, scene, int(kind)):
            for attribute, numbers in rows:
                yield from _differs(
                    named(tag, name),
                    attribute,
                    getattr(scene, numbers)[second],
                    getattr(robot, numbers)[first],
                )
            if tag == "joint":
                for attribute, numbers in DOFS:
                    at, other = int(robot.jnt_dofadr[first]), int(scene.jnt_dofadr[second])
                    yield from _differs(
                        named(tag, name),
                        attribute,
                        getattr(scene, numbers)[other],
                        getattr(robot, numbers)[at],
                    )


def _differs(element: str, attribute: str, found: Any, wanted: Any) -> Iterator[Finding]:
    if not np.array_equal(found, wanted) and not np.allclose(found, wanted, rtol=SAME, atol=SAME * SAME):
        yield differs(element, attribute, found, wanted)


def _both(robot: Any, scene: Any, kind: int) -> Iterator[tuple[str, int, int]]:
    """(name, in the MJCF, in the scene) of what has a name and is in both."""
    for index in range(getattr(robot, NUMBERS[mujoco.mjtObj(kind)])):
        name = name_of(robot, kind, index)
        found = index_of(scene, kind, name) if name else -1
        if found >= 0 and name != "world":
            yield name, index, found


def _added(robot: Any, scene: Any) -> Iterator[Finding]:
    """What connects, drives or takes out of contact the robot's own bodies and joints only in the scene."""
    own = {robot.body(index).name for index in range(1, robot.nbody)}
    before = Counter(_ties(robot))
    for (tag, attribute, names), number in (Counter(_ties(scene)) - before).items():
        if set(names) <= own:
            message = f"the scene has {number} of {' and '.join(names)} more than the robot's own file"
            yield Finding(tag, attribute, message)


def _ties(model: Any) -> Iterator[tuple[str, str, tuple[str, ...]]]:
    """(element, attribute, bodies) of what ties bodies, drives them or says what of them collides."""
    for index in range(model.neq):
        kind = mujoco.mjtEq(int(model.eq_type[index]))
        if kind in (mujoco.mjtEq.mjEQ_CONNECT, mujoco.mjtEq.mjEQ_WELD):
            yield "equality", "", _names(model, *bodies(model, index))
        elif kind == mujoco.mjtEq.mjEQ_JOINT:
            joints = (one for one in sites(model, index) if one >= 0)
            yield "equality", "", _names(model, *(model.jnt_bodyid[one] for one in joints))
    for index in range(model.nu):
        if model.actuator_trntype[index] == mujoco.mjtTrn.mjTRN_JOINT:
            yield "actuator", "joint", _names(model, model.jnt_bodyid[model.actuator_trnid[index][0]])
    for signature in model.exclude_signature:
        yield "exclude", "body1, body2", _names(model, int(signature) >> 16, int(signature) & 0xFFFF)
    for pair in zip(model.pair_geom1, model.pair_geom2, strict=True):
        yield "pair", "geom1, geom2", _names(model, *(model.geom_bodyid[one] for one in pair))


def _names(model: Any, *bodies: Any) -> tuple[str, ...]:
    return tuple(sorted(model.body(int(body)).name for body in bodies))
