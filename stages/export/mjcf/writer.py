"""MJCF: the robot, and a scene around it, for MuJoCo."""

from linkwright.stages.export.mjcf.section import MjcfFormatSection
from linkwright.stages.export.writer import FormatFiles, WriterInput


class MjcfWriter:
    """`<name>.xml`, the robot alone, and `scene.xml`, which includes it."""

    section = MjcfFormatSection
    reads: tuple[str, ...] = ()
    modules: tuple[str, ...] = ("linkwright.stages.export.mjcf.model", "linkwright.stages.export.mjcf.scene")

    def write(self, given: WriterInput) -> FormatFiles:
        # Late: the table of writers is read by builds that write nothing.
        from linkwright.stages.export.mjcf.build import write

        return write(given)
