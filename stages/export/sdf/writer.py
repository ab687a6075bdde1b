"""Declares the format SDF: the model, and the file by which Gazebo finds it."""

from linkwright.stages.export.sdf.section import SdfFormatSection
from linkwright.stages.export.writer import FormatFiles, WriterInput


class SdfWriter:
    """The writer of `<name>.sdf` and `model.config`."""

    section = SdfFormatSection
    reads: tuple[str, ...] = ()
    modules: tuple[str, ...] = ("linkwright.stages.export.sdf.model",)

    def write(self, inputs: WriterInput) -> FormatFiles:
        # Late: the table of writers is read by builds that write nothing.
        from linkwright.stages.export.sdf.build import write

        return write(inputs)
