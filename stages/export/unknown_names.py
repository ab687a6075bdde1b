"""What `actuators`, `sensors` and `scene.cameras` ask of a robot that it does not have. The robot alone says
so: it is found before any mesh is made."""

from typing import TYPE_CHECKING

from linkwright.stages.export.actuators.choices import wanted_of
from linkwright.stages.export.mjcf.sensing.cameras import unknown_frames
from linkwright.stages.export.sensors.mounts import mounts_of, report_unknown
from linkwright.stages.export.sensors.of_dofs import joint_sensors, report_unmatched
from linkwright.stages.robot.diagnostics import Diagnostics
from linkwright.stages.robot.errors import Diagnostic
from linkwright.stages.robot.model.robot import Robot

if TYPE_CHECKING:
    from linkwright.stages.export.section import ExportSections


def unknown_names(robot: Robot, keys: "ExportSections") -> list[Diagnostic]:
    """E-GLOB, E-FRAME, E-ACTUATOR, E-MOTOR and E-SENSOR for entries that do not fit the joints, links and
    frames of the robot."""
    log = Diagnostics(optional=keys.optional)
    wanted_of(robot, keys.actuators, keys.motors, log)
    _judge_sensors(robot, keys, log)
    log.add(unknown_frames(robot, keys.scene.cameras))
    return log.problems


def _judge_sensors(robot: Robot, keys: "ExportSections", log: Diagnostics) -> None:
    mounts = mounts_of(robot)
    drivable = [*(dof.name for dof in robot.dofs), *(actuator.name for actuator in robot.actuators)]
    for name, sensor in keys.sensors.items():
        where = f"sensors.{name}"
        if sensor.type == "joint":
            list(joint_sensors(name, sensor, robot, log))
        elif sensor.type == "actuator":
            # Which of the joints are driven is known only when their loads are.
            report_unmatched(sensor.actuators or "*", "actuator", drivable, f"{where}.actuators", log)
        else:
            asked = [("frame", sensor.frame or name), ("relative_to", sensor.relative_to)]
            asked += (("sees", frame) for frame in sensor.sees)
            for key, frame in asked:
                if frame is not None and frame not in mounts:
                    report_unknown(frame, f"{where}.{key}", mounts, log)
