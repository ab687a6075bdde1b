"""Builds the actuation of the written robot, with armatures that keep its simulation stable."""

from dataclasses import replace
from typing import TYPE_CHECKING

from linkwright.stages.export.actuators.actuate import actuate
from linkwright.stages.export.actuators.gravity import gravity_of
from linkwright.stages.export.ground.footing import ground_supports
from linkwright.stages.export.stability.armatures import with_armatures
from linkwright.stages.export.stability.compiled_trial import compiled_trial
from linkwright.stages.export.writer import WriterInput
from linkwright.stages.export.writers import WRITERS
from linkwright.stages.formats.written import Written
from linkwright.stages.robot.dynamics.statics import GroundSupport
from linkwright.stages.robot.errors import Diagnostic
from linkwright.stages.robot.model.actuation import Actuation
from linkwright.stages.robot.model.geometry import Geometry
from linkwright.stages.robot.model.robot import Configuration, Robot

if TYPE_CHECKING:
    from linkwright.stages.export.ground.standing import Placement
    from linkwright.stages.export.section import ExportSections
    from linkwright.stages.mujoco.trial import Trial

MAX_TREE_DOFS = 200
"""Largest number of dofs with which a robot without loops and relations is simulated."""

TRIAL_FORMAT = "mjcf"
"""The format whose files are simulated."""


def stable_actuation(
    written: Written, keys: "ExportSections", standing: "Placement"
) -> tuple[Actuation, tuple[Diagnostic, ...]]:
    """Returns the actuation of the robot and diagnostics. The configuration decides it; if an MJCF is chosen,
    a trial simulation adds armatures. An MJCF source whose actuators the configuration does not change gets
    no trial."""
    robot, geometry = written.robot, written.shapes
    world_from_root, gravity = standing.world_from_root, gravity_of(keys.scene.option)
    up = -world_from_root[:3, :3].T @ gravity

    def supports_at(lightened_robot: Robot, q: Configuration) -> tuple[GroundSupport, ...]:
        return ground_supports(lightened_robot, geometry, standing.placed(q), keys.ground, q, up)

    timestep = keys.scene.option.timestep
    actuation, diagnostics = actuate(
        robot, keys.actuators, timestep, world_from_root, gravity, keys.motors, supports_at, keys.optional
    )
    diagnostics = (*diagnostics, *_idle_motors(keys))
    unchanged = robot.mjcf is not None and not keys.actuators
    if TRIAL_FORMAT not in keys.export.chosen or unchanged or not _needs_trial(robot):
        return actuation, diagnostics
    colliders = _colliders(geometry)

    def run_trial(trial_robot: Robot, trial_actuation: Actuation, margin: float) -> "Trial | None":
        trial = replace(written, robot=trial_robot, geometry=colliders, actuation=trial_actuation)
        files = WRITERS[TRIAL_FORMAT].write(WriterInput(trial, keys, standing)).files
        return compiled_trial(files[f"{robot.name}.xml"], colliders.files, margin)

    with_stable_armatures, trial_diagnostics = with_armatures(robot, actuation, run_trial)
    return with_stable_armatures, (*diagnostics, *trial_diagnostics)


def _idle_motors(keys: "ExportSections") -> list[Diagnostic]:
    """Reports each motor that no entry of `actuators` names (I-IDLE-KEY)."""
    named = {entry.motor for entry in keys.actuators.values()}
    hint = "name it: actuators: {elbow: {motor: ...}}"
    return [
        Diagnostic("I-IDLE-KEY", "no entry of `actuators` names this motor", f"motors.{name}", hint)
        for name in keys.motors
        if name not in named
    ]


def _needs_trial(robot: Robot) -> bool:
    """Returns whether the robot moves, and has loops, relations or few dofs. A large tree is stable without a
    trial, which would take long."""
    return bool(robot.dofs) and (len(robot.dofs) <= MAX_TREE_DOFS or bool(robot.loops or robot.relations))


def _colliders(geometry: Geometry) -> Geometry:
    """Returns only the colliders: other shapes do not move a robot, and take most of the time to compile."""
    shapes = tuple(shape for shape in geometry.shapes if shape.role == "collision")
    used = {shape.file for shape in shapes}
    return replace(
        geometry,
        shapes=shapes,
        files={name: data for name, data in geometry.files.items() if name in used},
    )
