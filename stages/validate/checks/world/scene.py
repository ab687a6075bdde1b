"""Checks that nothing in the scene changes the robot of the MJCF."""

from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import mujoco
import numpy as np

from linkwright.stages.mujoco.compile import NotCompiled, compiled_file
from linkwright.stages.mujoco.names import actuator_count, controls_of, count_of, index_of, name_of
from linkwright.stages.mujoco.warnings import deprecations
from linkwright.stages.robot.check import Check, Finding
from linkwright.stages.validate.compiled import CompiledModel
from linkwright.stages.validate.findings import differs, few, named
from linkwright.stages.validate.model.coordinates import ENGINE_TOLERANCE
from linkwright.stages.validate.model.equalities import bodies, sites

OBJ = mujoco.mjtObj

FIELDS_BY_ELEMENT = {
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
"""(tag, MuJoCo's type) → (attribute, field of the compiled model) of the numbers that a scene must leave
unchanged."""

DOF_FIELDS = (("damping", "dof_damping"), ("frictionloss", "dof_frictionloss"), ("armature", "dof_armature"))
"""(attribute, field of the compiled model) of the numbers of a joint's dofs."""


def check(compiled: CompiledModel) -> Iterator[Check]:
    """Compares a scene with the MJCF of the robot, if that compiles."""
    mjcf = compiled.path.with_name(f"{compiled.robot.name}.xml")
    if (
        not mjcf.exists()
        or mjcf == compiled.path
        or compiled.written.amendments.changes_of(compiled.path.name)
    ):
        return
    robot = _compiled_or_none(mjcf)
    if robot is None:
        return
    findings = few((*_changed_numbers(robot, compiled.model), *_added_elements(robot, compiled.model)))
    detail = f"the robot is that of {mjcf.name}"
    if findings:
        elements = ", ".join(finding.element for finding in findings)
        detail = f"the scene changes the robot of {mjcf.name}: {elements}"
    yield compiled.within("robot in the scene", float(len(findings)), 0.0, detail, findings)


def _compiled_or_none(path: Path) -> Any:
    """Returns the compiled model of an MJCF; None if it does not compile, which other checks report."""
    with deprecations([]):
        try:
            return compiled_file(path)
        except NotCompiled:
            return None


def _changed_numbers(robot: Any, scene: Any) -> Iterator[Finding]:
    """Compares the numbers of the named elements that are in both the robot's model and the scene's."""
    for (tag, kind), rows in FIELDS_BY_ELEMENT.items():
        for name, first, second in _common_elements(robot, scene, int(kind)):
            for attribute, numbers in rows:
                yield from _number_difference(
                    named(tag, name),
                    attribute,
                    _numbers_of(scene, numbers, second),
                    _numbers_of(robot, numbers, first),
                )
            if tag == "joint":
                for attribute, numbers in DOF_FIELDS:
                    robot_dof, scene_dof = int(robot.jnt_dofadr[first]), int(scene.jnt_dofadr[second])
                    yield from _number_difference(
                        named(tag, name),
                        attribute,
                        getattr(scene, numbers)[scene_dof],
                        getattr(robot, numbers)[robot_dof],
                    )


def _numbers_of(model: Any, array: str, index: int) -> Any:
    """Returns the numbers of an element; in an array of controls those of all controls of the actuator."""
    values = getattr(model, array)
    return np.ravel(values[controls_of(model, index)]) if array.startswith("actuator_ctrl") else values[index]


def _number_difference(element: str, attribute: str, value: Any, expected: Any) -> Iterator[Finding]:
    if not np.array_equal(value, expected) and not np.allclose(
        value, expected, rtol=ENGINE_TOLERANCE, atol=ENGINE_TOLERANCE**2
    ):
        yield differs(element, attribute, value, expected)


def _common_elements(robot: Any, scene: Any, kind: int) -> Iterator[tuple[str, int, int]]:
    """Yields (name, index in the MJCF, index in the scene) of the named elements that are in both."""
    for index in range(count_of(robot, kind)):
        name = name_of(robot, kind, index)
        in_scene = index_of(scene, kind, name) if name else -1
        if in_scene >= 0 and name != "world":
            yield name, index, in_scene


def _added_elements(robot: Any, scene: Any) -> Iterator[Finding]:
    """Yields elements of the scene that connect, drive or exclude the robot's bodies and joints, and that the
    MJCF does not have."""
    links = {robot.body(index).name for index in range(1, robot.nbody)}
    before = Counter(_ties(robot))
    for (tag, attribute, names), number in (Counter(_ties(scene)) - before).items():
        if set(names) <= links:
            message = f"for {' and '.join(names)} the scene has {number} more than the robot's own file"
            yield Finding(tag, attribute, message)


def _ties(model: Any) -> Iterator[tuple[str, str, tuple[str, ...]]]:
    """Yields (element, attribute, bodies) of elements that tie or drive bodies, or decide whether they
    collide."""
    for index in range(model.neq):
        kind = mujoco.mjtEq(int(model.eq_type[index]))
        if kind in (mujoco.mjtEq.mjEQ_CONNECT, mujoco.mjtEq.mjEQ_WELD):
            yield "equality", "", _names(model, *bodies(model, index))
        elif kind == mujoco.mjtEq.mjEQ_JOINT:
            joints = (joint for joint in sites(model, index) if joint >= 0)
            yield "equality", "", _names(model, *(model.jnt_bodyid[joint] for joint in joints))
    for index in range(actuator_count(model)):
        if model.actuator_trntype[index] == mujoco.mjtTrn.mjTRN_JOINT:
            yield "actuator", "joint", _names(model, model.jnt_bodyid[model.actuator_trnid[index][0]])
    for signature in model.exclude_signature:
        yield "exclude", "body1, body2", _names(model, int(signature) >> 16, int(signature) & 0xFFFF)
    for pair in zip(model.pair_geom1, model.pair_geom2, strict=True):
        yield "pair", "geom1, geom2", _names(model, *(model.geom_bodyid[geom] for geom in pair))


def _names(model: Any, *bodies: Any) -> tuple[str, ...]:
    return tuple(sorted(model.body(int(body)).name for body in bodies))
