"""Registers the writer of MJCF: the robot, and a scene around it, for MuJoCo."""

from linkwright.stages.export.mjcf.section import MjcfFormatSection
from linkwright.stages.export.writer import FormatFiles, WriterInput


class MjcfWriter:
    """Writes `<name>.xml`, the robot alone, and `scene.xml`, which includes it."""

    section = MjcfFormatSection
    reads: tuple[str, ...] = ()
    modules: tuple[str, ...] = ("linkwright.stages.export.mjcf.model", "linkwright.stages.export.mjcf.scene")

    def write(self, inputs: WriterInput) -> FormatFiles:
        # Imported late: builds that write nothing also read the table of writers.
        from linkwright.stages.export.mjcf.build import write

        return write(inputs)
