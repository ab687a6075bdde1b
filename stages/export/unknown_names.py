"""Reports entries of `actuators`, `sensors`, `scene.cameras` and `variants` that match nothing of the robot.

This needs no meshes, so it comes before any is made.
"""

from typing import TYPE_CHECKING

from linkwright.stages.export.actuators.choices import choose_actuators
from linkwright.stages.export.mjcf.sensing.cameras import unknown_frames
from linkwright.stages.export.sensors.mounts import mounts_of, report_unknown_mount
from linkwright.stages.export.sensors.of_dofs import joint_sensors, report_unmatched
from linkwright.stages.export.variants.names import possible_quantities
from linkwright.stages.export.variants.shares import quantities_by_glob
from linkwright.stages.robot.diagnostics import Diagnostics
from linkwright.stages.robot.errors import Diagnostic
from linkwright.stages.robot.model.robot import Robot

if TYPE_CHECKING:
    from linkwright.stages.export.section import ExportSections


def unknown_names(robot: Robot, keys: "ExportSections") -> list[Diagnostic]:
    """Returns problems with entries that do not fit the joints, links and frames of the robot (E-GLOB,
    E-FRAME, E-ACTUATOR, E-MOTOR, E-SENSOR)."""
    log = Diagnostics(optional=keys.optional)
    choose_actuators(robot, keys.actuators, keys.motors, log)
    _check_sensors(robot, keys, log)
    log.add(unknown_frames(robot, keys.scene.cameras))
    if keys.has_variants and not keys.elements:  # with elements only the finished file says what there is
        quantities_by_glob(keys.variants.ranges, possible_quantities(robot), log)
    return log.problems


def _check_sensors(robot: Robot, keys: "ExportSections", log: Diagnostics) -> None:
    mounts = mounts_of(robot)
    drivable = [*(dof.name for dof in robot.dofs), *(actuator.name for actuator in robot.actuators)]
    for name, sensor in keys.sensors.items():
        where = f"sensors.{name}"
        if sensor.type == "joint":
            # The sensors themselves are not needed: making them reports what is unknown.
            list(joint_sensors(name, sensor, robot, log))
        elif sensor.type == "actuator":
            # Which of the joints are driven is only known after their loads are computed.
            report_unmatched(sensor.actuators or "*", "actuator", drivable, f"{where}.actuators", log)
        else:
            frames = [("frame", sensor.frame or name), ("relative_to", sensor.relative_to)]
            frames += (("sees", frame) for frame in sensor.sees)
            for key, frame in frames:
                if frame is not None and frame not in mounts:
                    report_unknown_mount(frame, f"{where}.{key}", mounts, log)
