"""Declares the format URDF: the tree of links and joints in one file, with the SRDF for MoveIt beside it."""

from linkwright.stages.export.urdf.section import UrdfFormatSection
from linkwright.stages.export.writer import FormatFiles, WriterInput


class UrdfWriter:
    """The writer of `<name>.urdf` and `<name>.srdf`."""

    section = UrdfFormatSection
    reads: tuple[str, ...] = ()
    modules: tuple[str, ...] = (
        "linkwright.stages.export.urdf.model",
        "linkwright.stages.export.urdf.srdf.model",
    )

    def write(self, inputs: WriterInput) -> FormatFiles:
        # Late: the table of writers is read by builds that write nothing.
        from linkwright.stages.export.urdf.build import write

        return write(inputs)
