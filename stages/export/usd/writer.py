"""Declares the format USD: the robot, and the meshes that it refers to."""

from linkwright.stages.export.usd.section import UsdFormatSection
from linkwright.stages.export.writer import FormatFiles, WriterInput


class UsdWriter:
    """The writer of `<name>.usda`, of the layer `<name>_meshes.usd` that it refers to, and of a thumbnail."""

    section = UsdFormatSection
    reads: tuple[str, ...] = ()
    modules: tuple[str, ...] = ()

    def write(self, inputs: WriterInput) -> FormatFiles:
        # Late: the table of writers is read by builds that write nothing.
        from linkwright.stages.export.usd.build import write

        return write(inputs)
