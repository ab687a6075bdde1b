"""What drives the robot that is written, and the armatures with which its simulation holds."""

from dataclasses import replace
from typing import TYPE_CHECKING

from linkwright.stages.export.actuators.actuate import actuate
from linkwright.stages.export.actuators.gravity import gravity_of
from linkwright.stages.export.ground.footing import supports
from linkwright.stages.export.stability.compiled_trial import compiled_trial
from linkwright.stages.export.stability.steadied import steadied
from linkwright.stages.export.writer import WriterInput
from linkwright.stages.export.writers import WRITERS
from linkwright.stages.formats.written import Written
from linkwright.stages.robot.dynamics.statics import GroundSupport
from linkwright.stages.robot.errors import Diagnostic
from linkwright.stages.robot.model.actuation import Actuation
from linkwright.stages.robot.model.geometry import Geometry
from linkwright.stages.robot.model.robot import Configuration, Robot

if TYPE_CHECKING:
    from linkwright.stages.export.ground.standing import Stance
    from linkwright.stages.export.section import ExportSections
    from linkwright.stages.mujoco.trial import Trial

LARGE = 200
"""Dofs beyond which a robot without loops and relations is not simulated."""

FORMAT = "mjcf"
"""The format whose files are simulated."""


def driven(
    written: Written, keys: "ExportSections", standing: "Stance"
) -> tuple[Actuation, tuple[Diagnostic, ...]]:
    """The actuation of the robot, by the configuration and, where an MJCF is written, by its trial run; an
    MJCF source whose actuators nobody changes stays as it is."""
    robot, geometry = written.robot, written.shapes
    place, gravity = standing.world_from_root, gravity_of(keys.scene.option)
    up = -place[:3, :3].T @ gravity

    def carried(q: Configuration) -> tuple[GroundSupport, ...]:
        return supports(robot, geometry, standing.placed(q), keys.ground, q, up)

    timestep = keys.scene.option.timestep
    actuation, found = actuate(
        robot, keys.actuators, timestep, place, gravity, keys.motors, carried, keys.optional
    )
    found = (*found, *_idle_motors(keys))
    as_it_is = robot.mjcf is not None and not keys.actuators
    if FORMAT not in keys.export.chosen or as_it_is or not _worth_a_trial(robot):
        return actuation, found
    solid = _solid(geometry)

    def run(built: Robot, with_what: Actuation, margin: float) -> "Trial | None":
        tried = replace(written, robot=built, geometry=solid, actuation=with_what)
        files = WRITERS[FORMAT].write(WriterInput(tried, keys, standing)).files
        return compiled_trial(files[f"{robot.name}.xml"], solid.files, margin)

    steady, more = steadied(robot, actuation, run)
    return steady, (*found, *more)


def _idle_motors(keys: "ExportSections") -> list[Diagnostic]:
    """I-IDLE-KEY for each motor that no entry of `actuators` names."""
    named = {entry.motor for entry in keys.actuators.values()}
    hint = "name it: actuators: {elbow: {motor: ...}}"
    return [
        Diagnostic("I-IDLE-KEY", "no entry of `actuators` names this motor", f"motors.{name}", hint)
        for name in keys.motors
        if name not in named
    ]


def _worth_a_trial(robot: Robot) -> bool:
    """Whether the robot moves, and is not a large one without loops, which would take long and hold."""
    return bool(robot.dofs) and (len(robot.dofs) <= LARGE or bool(robot.loops or robot.relations))


def _solid(geometry: Geometry) -> Geometry:
    """What collides: the rest does not move a robot, and takes most of the time to compile."""
    shapes = tuple(shape for shape in geometry.shapes if shape.role == "collision")
    used = {shape.file for shape in shapes}
    return replace(
        geometry,
        shapes=shapes,
        files={name: data for name, data in geometry.files.items() if name in used},
    )
