"""Declares the format ROS 2: a folder that `colcon build` accepts."""

from linkwright.stages.export.ros2.section import Ros2FormatSection
from linkwright.stages.export.writer import FormatFiles, WriterInput


class Ros2Writer:
    """The writer of `ros2/<package>/`, and of MoveIt's package beside it."""

    section = Ros2FormatSection
    reads: tuple[str, ...] = ("urdf",)
    modules: tuple[str, ...] = (
        "linkwright.stages.export.ros2.xacro_files",
        "linkwright.stages.export.ros2.files",
        "linkwright.stages.export.ros2.moveit",
    )

    def write(self, inputs: WriterInput) -> FormatFiles:
        # Late: the table of writers is read by builds that write nothing.
        from linkwright.stages.export.ros2.build import write

        return write(inputs)
